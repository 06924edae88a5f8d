"""References: y of each ring with its derivatives, in runs and in files.

A reference file is CSV with time, position, velocity and acceleration of one
ring or more.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.core.errors import CampaignError, suggest
from brace_drake.core.reading import ReadBytes, in_file
from brace_drake.devices.motions.times import EVEN, check_times
from brace_drake.recording import LoadCampaign, Run
from brace_drake.recording.columns import (
    BENCH_RINGS,
    BRACE,
    BRACE_STAGES,
    device_channels,
)
from brace_drake.recording.manifest import MANIFEST
from brace_drake.recording.samples import check_range, without_rounding
from brace_drake.recording.table import Columns, parse_table
from brace_drake.recording.write import format_table

# How far y' may be from the slope of y: of the largest y', and m/s.
_SPEED_SHARE, _SPEED = 0.1, 5e-4
# Files with this at the start of their names are run without the torso.
_FREE = "free"
# An optional column says it instead: 1 with the torso, 0 without.
_CONTACT = "contact"


def reference_columns(*rings: int) -> tuple[str, ...]:
    """Channels of rings' references: y, m; y', m/s; y'', m/s^2 of each."""
    return tuple(
        f"ring{ring}_{name}"
        for ring in rings
        for name in ("y_desired_m", "vy_desired_m_s", "ay_desired_m_s2")
    )


COLUMNS = reference_columns(*BENCH_RINGS)


def MakeReference(time: np.ndarray, samples: np.ndarray) -> PiecewisePolynomial:
    """Cubic Hermite interpolation of y, y', y'' given at sample times.

    Each of y and y' is interpolated with its own logged derivative; y'' with
    the slopes of its neighbours: a cubic polynomial comes back exactly.

    Args:
        time: Sample times (N,), s, increasing.
        samples: y, y', y'' (N, 3), or of C coordinates (N, 3, C).

    Returns:
        A trajectory of 3 or 3 C rows: y of all coordinates, y', y''.
    """
    slopes = np.roll(samples, -1, axis=1)
    slopes[:, 2] = np.gradient(samples[:, 2], time, axis=0)
    rows = (len(time), -1)
    return PiecewisePolynomial.CubicHermite(
        time, samples.reshape(rows).T, slopes.reshape(rows).T
    )


def MakeBraceReference(
    run: Run, stages: Sequence[int], start: np.ndarray
) -> PiecewisePolynomial:
    """X_d, X_d', X_d'' (18 S rows) from a run's references, time from 0.

    Coordinates without a reference stay at the start.

    Args:
        run: With the references of some of the rings.
        stages: Of the brace, bottom to top; ring i sits above stage i.
        start: Task coordinates at time 0 (6 S,).

    Raises:
        CampaignError: A reference of a ring that is not there, or none.
    """
    found = dict(references_of_rings(run, stages, "scenario"))
    if not found:
        raise CampaignError(f"{run.file}: no reference ({COLUMNS[0]})")
    desired = np.zeros((len(run.time_s), 3, 6 * len(stages)))
    desired[:, 0] = start
    for i, samples in found.items():
        desired[:, :, 6 * i + 1] = samples
    return MakeReference(run.time_s - run.time_s[0], desired)


def reference_at_ticks(
    time: np.ndarray, samples: np.ndarray, rate: float
) -> np.ndarray:
    """The reference at control ticks from the first to the last sample.

    Returns:
        y, y', y'' at each tick, shaped as the samples (ticks, 3) or
        (ticks, 3, C), C order.
    """
    ticks = round((time[-1] - time[0]) * rate) + 1
    at = np.minimum(time[0] + np.arange(ticks) / rate, time[-1])
    values = MakeReference(time, samples).vector_values(at).T
    return np.ascontiguousarray(values).reshape(ticks, *samples.shape[1:])


def references_of_rings(
    run: Run, rings: Sequence[int], owner: str
) -> Iterator[tuple[int, np.ndarray]]:
    """Each ring's index in `rings` with its logged reference (N, 3).

    Rings without a reference are left out.

    Args:
        run: With references of some rings.
        rings: Numbers of the rings that can move, bottom to top.
        owner: What the rings are of, for the message.

    Raises:
        CampaignError: A reference of a ring that cannot move.
    """
    for ring in BRACE_STAGES:
        columns = reference_columns(ring)
        if columns[0] not in run.channels:
            continue
        if ring not in rings:
            raise CampaignError(
                f"{run.file}: {columns[0]} moves ring {ring}; moving rings of"
                f" the {owner}: {', '.join(map(str, rings))}"
            )
        yield list(rings).index(ring), run.stack(columns)


def LoadReference(
    path: str | Path, rings: tuple[int, ...] = BENCH_RINGS
) -> Run:
    """Reads a reference; its run is free where the name begins with "free".

    A column `contact` (1 with the torso, 0 without) tells it otherwise.

    Args:
        path: CSV with time_s and `reference_columns` of the rings, evenly
            sampled; further columns are left out.
        rings: Those whose references are taken, at least one of them.

    Raises:
        CampaignError: One line: file, row or column, and what is wrong.
    """
    path = Path(path)
    with in_file(path, CampaignError):
        data = ReadBytes(path)
    known = ("time_s", *reference_columns(*rings))
    columns, problems = parse_table(data, str(path), known)
    errors = [p for p in problems if p.severity == "error"]
    if errors:
        raise CampaignError(str(errors[0]).removeprefix("error: "))
    moved = [i for i in rings if {*reference_columns(i)} & {*columns}]
    default = BENCH_RINGS if set(BENCH_RINGS) <= {*rings} else rings[:1]
    needed = ("time_s", *reference_columns(*(moved or default)))
    missing = [name for name in needed if name not in columns]
    if missing:
        hint = suggest(missing[0], columns)
        raise CampaignError(f"{path}: no column {missing[0]}{hint}")
    channels = {name: np.asarray(columns[name], float) for name in needed}
    channels["time_s"] = without_rounding(channels["time_s"])
    check_times(path, channels["time_s"])
    for ring in moved:
        _check_motion(path, channels, reference_columns(ring))
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


def _check_motion(
    path: Path, channels: Columns, names: tuple[str, ...]
) -> None:
    """Each column within what a brace can do, and y' the derivative of y."""
    known = device_channels(BRACE)
    for name in names:
        problem = check_range(channels[name], known[name], str(path))
        if problem is not None:
            raise CampaignError(str(problem).removeprefix("error: "))
    time, y, speed = (channels[name] for name in ("time_s", *names[:2]))
    mean = np.diff(y) / np.diff(time)
    # Between two samples y' passes through the mean speed, even at a corner.
    low = np.minimum(speed[:-1], speed[1:])
    high = np.maximum(speed[:-1], speed[1:])
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
        if abs(rate / rates[0] - 1.0) > EVEN:
            raise CampaignError(
                f"{run.file} is sampled at {rate:.4g} Hz, {runs[0].file} at"
                f" {rates[0]:.4g} Hz; a plan needs one rate"
            )
    return round(rates[0], 6)
