"""Writes a campaign folder, whole or not at all."""

from __future__ import annotations

import os
import shutil
import uuid
from pathlib import Path, PurePosixPath

import numpy as np
import yaml

from brace_drake.core.errors import OutputError, is_plain, quoted
from brace_drake.core.places import check_folder, real_path
from brace_drake.recording.columns import split_unit
from brace_drake.recording.manifest import FORMAT, MANIFEST, leaves_folder
from brace_drake.recording.recording import Campaign, Run, ScenarioFile

# Decimals per unit: finer than any sensor of the bench resolves.
DECIMALS = {"s": 6, "m": 8, "m_s": 8, "m_s2": 6, "N": 5}
LABEL = "label.yaml"
_OTHER_UNITS = "%.9g"
# Of a small machine a column keeps at least so many digits.
_DIGITS = 3


def check_new_folder(path: Path) -> None:
    """Checks that a campaign could appear there.

    Raises:
        OutputError: Something is there already, and is no empty folder; or
            none can be made.
    """
    check_folder(path)
    try:
        if path.is_dir() and any(path.iterdir()):
            raise OutputError(
                f"{path}: exists and is not empty; give another"
                " folder, or remove it"
            )
    except OSError as e:
        raise OutputError(f"{path}: cannot be written: {e.strerror}") from e
    # It comes by its name alone, which is its parent's.
    check_folder(real_path(path).parent)


def WriteCampaign(
    campaign: Campaign, path: str | Path, label: dict | None = None
) -> None:
    """Writes campaign.yaml and one CSV file per run.

    The folder appears under its name only when it is complete.

    Args:
        campaign: What to write; its own `path` is not used.
        path: The folder to make; it may exist if it is empty.
        label: What the recorded machine was made with, for label.yaml, which
            no diagnosis reads; None: it is not known.

    Raises:
        OutputError: The folder exists and is not empty, a run's file would
            lie outside it, or the place cannot be written.
    """
    check_new_folder(Path(path))
    # What takes the place of a link would not be where the link leads.
    path = real_path(path)
    outside = [run.file for run in campaign.runs if leaves_folder(run.file)]
    if outside:
        raise OutputError(f"{path}: {outside[0]!r} leaves the folder")
    _check_names(path, campaign)
    draft = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}")
    try:
        draft.mkdir(parents=True)
        _WriteFiles(campaign, draft)
        if label is not None:
            text = yaml.safe_dump(label, sort_keys=False)
            (draft / LABEL).write_text(text, encoding="utf-8")
        os.replace(draft, path)
    except OSError as e:
        raise OutputError(f"{path}: cannot be written: {e.strerror}") from e
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _check_names(path: Path, campaign: Campaign) -> None:
    """Files that would be each other's, and columns that no table can name."""
    for run in campaign.runs:
        if Path(run.file).name in (MANIFEST, LABEL):
            raise OutputError(f"{path}: no run can be {quoted(run.file)}")
        for name in run.channels:
            if not is_plain(name) or set(name) & set(',"'):
                raise OutputError(
                    f"{path}: {quoted(run.file)}: no column can be"
                    f" {quoted(name)}"
                )


def _WriteFiles(campaign: Campaign, folder: Path) -> None:
    text = yaml.safe_dump(
        describe(campaign), sort_keys=False, allow_unicode=True
    )
    (folder / MANIFEST).write_text(text, encoding="utf-8")
    if campaign.scenario is not None:
        name = scenario_name(campaign.scenario)
        (folder / name).write_bytes(campaign.scenario.data)
    for run in campaign.runs:
        file = folder / run.file
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(format_table(run), encoding="utf-8", newline="\n")


def scenario_name(scenario: ScenarioFile) -> str:
    """Under which a campaign keeps the scenario that it names, beside its
    other files.
    """
    name = PurePosixPath(scenario.name.replace("\\", "/")).name
    is_taken = name in (MANIFEST, LABEL) or name.endswith(".csv")
    return "scenario.yaml" if is_taken else name


def describe(campaign: Campaign) -> dict:
    """The content of campaign.yaml, in the order of the format."""
    head = {
        "format": FORMAT,
        "device": campaign.device,
        "rate_hz": float(campaign.rate_hz),
        "subject": campaign.subject,
    }
    if campaign.recorded or campaign.recorder:
        head["recorded"] = campaign.recorded or dict(campaign.recorder)
    for name in ("nominal", "control"):
        values = getattr(campaign, name)
        if values:
            head[name] = {key: float(v) for key, v in values.items()}
    if campaign.ports is not None:
        head["diagram"] = campaign.ports.section()
    if campaign.scenario is not None:
        head["scenario"] = scenario_name(campaign.scenario)
    if campaign.stages:
        head["stages"] = list(campaign.stages)
    settled_s = max((run.settled_s for run in campaign.runs), default=0.0)
    if settled_s > 0.0:
        head["settled_s"] = float(settled_s)
    head["runs"] = [
        {
            "file": run.file,
            "contact": bool(run.contact),
            "motion": run.motion,
            "repeat_of": run.repeat_of,
            "split": run.split,
        }
        for run in campaign.runs
    ]
    return head


def _hides(values: np.ndarray, decimals: int) -> bool:
    """Whether so many decimals are too few for what a column shows."""
    return 0.0 < float(np.ptp(values)) < 10.0 ** (_DIGITS - decimals)


def format_table(run: Run) -> str:
    """A run as CSV text, with decimals that suit each column's unit."""
    formats, columns = [], []
    for name, values in run.channels.items():
        values = np.asarray(values)
        decimals = DECIMALS.get(split_unit(name)[1])
        if values.dtype.kind not in "fiub":
            formats.append("%s")
        elif decimals is None or _hides(values, decimals):
            formats.append(_OTHER_UNITS)
        else:
            formats.append(f"%.{decimals}f")
            # Adding zero turns a rounded -0.0 into 0.0.
            values = np.round(values, decimals) + 0.0
        columns.append(values.tolist())
    row_format = ",".join(formats)
    rows = (row_format % row for row in zip(*columns, strict=True))
    return "\n".join([",".join(run.channels), *rows]) + "\n"
