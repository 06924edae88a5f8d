"""References in files: CSV with time, position, velocity, acceleration."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.devices.motions.reference import COLUMNS, reference_columns
from brace_drake.recording.columns import BRACE, device_channels
from brace_drake.recording.manifest import MANIFEST
from brace_drake.recording.read import LoadCampaign
from brace_drake.recording.recording import Run
from brace_drake.recording.samples import check_range
from brace_drake.recording.table import parse_table
from brace_drake.recording.write import format_table

# Deviation of a step from the mean one, relative.
_EVEN = 1e-3
# How far y' may be from the slope of y: of the largest y', and m/s.
_SPEED_SHARE, _SPEED = 0.1, 5e-4
# Files with this at the start of their names are run without the torso.
_FREE = "free"
# An optional column says it instead: 1 with the torso, 0 without.
_CONTACT = "contact"


def LoadReference(path: str | Path, rings: tuple[int, ...] = (2,)) -> Run:
    """Reads a reference; its run is free where the name begins with "free".

    A column `contact` (1 with the torso, 0 without) tells it otherwise.

    Args:
        path: CSV with time_s, ring2_y_desired_m, ring2_vy_desired_m_s and
            ring2_ay_desired_m_s2, evenly sampled; further columns are left
            out. Where other rings are asked for, theirs likewise.
        rings: Those whose references are taken, at least one of them.

    Raises:
        CampaignError: One line: file, row or column, and what is wrong.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise CampaignError(
            f"{path}: cannot be read: {error.strerror}"
        ) from error
    known = ("time_s", *(c for i in rings for c in reference_columns(i)))
    columns, problems = parse_table(data, str(path), known)
    errors = [p for p in problems if p.severity == "error"]
    if errors:
        raise CampaignError(str(errors[0]).removeprefix("error: "))
    moved = [i for i in rings if {*reference_columns(i)} & {*columns}]
    moved = moved or [2 if 2 in rings else rings[0]]
    needed = ("time_s", *(c for i in moved for c in reference_columns(i)))
    missing = [name for name in needed if name not in columns]
    if missing:
        raise CampaignError(f"{path}: no column {missing[0]}")
    channels = {name: np.asarray(columns[name], float) for name in needed}
    _check_time(path, channels["time_s"])
    for i in moved:
        _check_motion(path, channels["time_s"], channels, reference_columns(i))
    contact = not path.name.startswith(_FREE)
    if _CONTACT in columns:
        contact = bool(np.any(columns[_CONTACT] == 1))
    return Run(path.name, contact, path.stem, None, "fit", channels)


def format_reference(run: Run, columns: tuple[str, ...] = COLUMNS) -> str:
    """A run's reference as CSV text, as `LoadReference` reads that of a ring.

    Args:
        run: With a reference.
        columns: Channels of the reference.
    """
    channels = {name: run.channels[name] for name in ("time_s", *columns)}
    channels[_CONTACT] = np.full(len(run.time_s), int(run.contact))
    return format_table(replace(run, channels=channels))


def _check_time(path: Path, time: np.ndarray) -> None:
    steps = np.diff(time)
    if len(time) < 2 or not steps.min() > 0.0:
        raise CampaignError(f"{path}: time_s does not increase strictly")
    if np.abs(steps / steps.mean() - 1.0).max() > _EVEN:
        raise CampaignError(f"{path}: time_s is not evenly sampled")


def _check_motion(
    path: Path,
    time: np.ndarray,
    channels: dict[str, np.ndarray],
    names: tuple[str, str, str],
) -> None:
    """Each column within what a brace can do, and y' the derivative of y."""
    known = device_channels(BRACE)
    for name in names:
        problem = check_range(channels[name], known[name], str(path))
        if problem is not None:
            raise CampaignError(str(problem).removeprefix("error: "))
    y, speed = channels[names[0]], channels[names[1]]
    mean = np.diff(y) / np.diff(time)
    # Between two samples y' passes through the mean speed, even at a corner.
    low, high = (
        np.minimum(speed[:-1], speed[1:]),
        np.maximum(speed[:-1], speed[1:]),
    )
    away = np.maximum(low - mean, mean - high)
    allowed = _SPEED_SHARE * np.abs(speed).max() + _SPEED
    if away.max() > allowed:
        k = int(np.argmax(away > allowed))
        raise CampaignError(
            f"{path}: row {k + 2} (line {k + 3}), {names[1]} is"
            f" {speed[k + 1]:g}, but {names[0]} moves at {mean[k]:.4g} m/s"
            " there; allowed: its derivative"
        )


def LoadReferences(folder: str | Path) -> tuple[Run, ...]:
    """References of a folder.

    Those of the fit runs where it is a campaign, else all its CSV files.

    Raises:
        CampaignError: Nothing there that could be run.
    """
    folder = Path(folder)
    if (folder / MANIFEST).is_file():
        runs = LoadCampaign(folder).split("fit")
        lacking = [r.file for r in runs if COLUMNS[0] not in r.channels]
        if lacking:
            raise CampaignError(f"{folder}: {lacking[0]} has no reference")
    else:
        runs = tuple(LoadReference(f) for f in sorted(folder.glob("*.csv")))
    if not runs:
        raise CampaignError(f"{folder}: no reference there (*.csv)")
    return runs


def common_rate(runs: tuple[Run, ...]) -> float:
    """Sampling rate of references, Hz.

    Raises:
        CampaignError: They differ.
    """
    rates = [1.0 / float(np.median(np.diff(r.time_s))) for r in runs]
    for run, rate in zip(runs, rates, strict=True):
        if abs(rate / rates[0] - 1.0) > _EVEN:
            raise CampaignError(
                f"{run.file} is sampled at {rate:.4g} Hz, {runs[0].file} at"
                f" {rates[0]:.4g} Hz; a plan needs one rate"
            )
    return round(rates[0], 6)
