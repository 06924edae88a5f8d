"""Reads a campaign folder once: its content if sound, and every problem.

The manifest says which runs there are and what their device records; each
run's table is parsed and checked by the declarations of its channels; repeats
are compared; what few samples were lost is filled.
"""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from posixpath import normpath

import numpy as np

from brace_drake.core.errors import CampaignError, ReadError, quoted
from brace_drake.core.places import real_path
from brace_drake.core.reading import ReadBytes
from brace_drake.recording.columns import (
    DEVICES,
    LEG_BENCH,
    Channel,
    near_misses,
    split_unit,
)
from brace_drake.recording.dropouts import fill_dropouts, lost_rows
from brace_drake.recording.findings import Problem, counted, error, warning
from brace_drake.recording.forces import check_forces
from brace_drake.recording.manifest import (
    MANIFEST,
    parse_manifest,
)
from brace_drake.recording.recording import Campaign, Run
from brace_drake.recording.samples import (
    TELLING_ROWS,
    Limits,
    check_channel,
    check_time,
    since_first_row,
    without_rounding,
)
from brace_drake.recording.table import Columns, parse_table
from brace_drake.recording.ways import check_ways

# Less shows no motion, and cannot be fitted.
LEAST_ROWS = 10
_MOST_SCENARIO_MB = 4


def LoadCampaign(path: str | Path) -> Campaign:
    """Reads and checks a campaign folder.

    Args:
        path: The folder that holds campaign.yaml.

    Returns:
        The campaign; `warnings` holds what the check found suspicious.

    Raises:
        CampaignError: The campaign has errors. The message is one line: the
            first error and how many more there are.
    """
    campaign, problems = ExamineCampaign(path)
    if campaign is not None:
        return campaign
    errors = [p for p in problems if p.severity == "error"]
    message = str(errors[0]).removeprefix("error: ")
    if not message.startswith(str(path)):
        message = f"{path}: {message}"
    if len(errors) > 1:
        command = f"brace-drake check {shlex.quote(str(path))}"
        message += f" (and {len(errors) - 1} more; run `{command}`)"
    raise CampaignError(message)


def CheckCampaign(
    path: str | Path, limits: Limits | None = None
) -> list[Problem]:
    """Finds every problem of a campaign folder.

    Args:
        path: The folder.
        limits: Where commands and force readings are clipped; the bench's
            and, for a leg bench, those of its `control` by default.

    Returns:
        Errors and warnings, campaign.yaml first, then file by file; at most
        one per file, column and kind.
    """
    return ExamineCampaign(path, limits)[1]


def ExamineCampaign(
    path: str | Path, limits: Limits | None = None
) -> tuple[Campaign | None, list[Problem]]:
    """A campaign, None where it has errors, and everything wrong with it.

    Args:
        path, limits: As of `CheckCampaign`.
    """
    path = Path(path)
    try:
        campaign, problems = parse_manifest(ReadBytes(path / MANIFEST, 4))
    except ReadError as e:
        return None, [_explain_absence(path, e)]
    if campaign is None:
        return None, problems
    scenario = campaign.scenario
    if scenario is not None:
        try:
            file = path / scenario.name
            # Its neighbours may share it; nothing else is theirs to read.
            if not real_path(file).is_relative_to(real_path(path).parent):
                raise ReadError(
                    "cannot be read: it is neither in the campaign's folder"
                    " nor beside it"
                )
            data = ReadBytes(file, _MOST_SCENARIO_MB)
            scenario = replace(scenario, data=data)
        except ReadError as e:
            where = f"scenario: {scenario.name} {e}"
            problems.append(error(MANIFEST, where))
    channels = campaign.known_channels
    limits = limits or _default_limits(campaign)
    spoilt = {p.file for p in problems if p.severity == "error"}
    runs: dict[str, Run] = {}
    for run in campaign.runs:
        if run.file and run.file not in spoilt:
            columns, found = _read_run(path, run, campaign, channels, limits)
            runs[normpath(run.file)] = replace(run, channels=columns)
            problems += found
    if campaign.device in DEVICES:
        # What cannot be taken apart has been told.
        own = {r.file: r.channels for r in runs.values() if r.channels}
        ways = DEVICES[campaign.device].ways
        problems += check_ways(ways, own, MANIFEST)
    spoilt = {p.file for p in problems if p.severity == "error"}
    for run in runs.values():
        original = runs.get(normpath(run.repeat_of or ""), run)
        if original is not run and not {run.file, original.file} & spoilt:
            problems += _compare_repeat(run, original, channels)
    if spoilt:
        return None, problems
    filled = tuple(
        replace(run, channels=fill_dropouts(run.channels, channels))
        for run in runs.values()
    )
    campaign = replace(
        campaign,
        path=path.absolute(),
        runs=filled,
        warnings=tuple(problems),
        scenario=scenario,
    )
    return campaign, problems


def _explain_absence(path: Path, why: ReadError) -> Problem:
    """Why a folder has no campaign.yaml to read."""
    if not path.exists():
        return error(str(path), "no such folder")
    if not path.is_dir():
        return error(str(path), "is a file, not a campaign's folder")
    names = sorted(item.name for item in path.iterdir())
    if MANIFEST in names:
        return error(MANIFEST, str(why))
    if not names:
        return error(str(path), "the folder is empty")
    found = ", ".join(names[:3]) + (", ..." if len(names) > 3 else "")
    return error(str(path), f"no {MANIFEST} in this folder (it holds {found})")


def _default_limits(campaign: Campaign) -> Limits | None:
    """Limits of the device, None for a drive without feedback.

    A drive that is commanded open loop may be driven with square waves,
    which look like a clipped command.
    """
    if campaign.device != LEG_BENCH:
        return Limits()
    if not campaign.control:
        return None
    return Limits(command=campaign.control.get("force_limit_N"))


def _read_run(
    path: Path,
    run: Run,
    campaign: Campaign,
    channels: dict[str, Channel],
    limits: Limits | None,
) -> tuple[Columns, list[Problem]]:
    """Columns of one run and everything wrong with them."""
    file = run.file
    try:
        data = ReadBytes(path / file)
    except ReadError as e:
        if isinstance(e.__cause__, FileNotFoundError):
            return {}, [error(file, "no such file in the campaign's folder")]
        return {}, [error(file, str(e))]
    columns, problems = parse_table(data, file, {"time_s", *channels})
    if not columns:
        return columns, problems
    missing = [
        name
        for name, channel in channels.items()
        if name not in columns and not channel.is_optional
    ]
    if missing:
        problems += _describe_missing(
            missing, columns, channels, campaign, file
        )
    rows = len(next(iter(columns.values())))
    if rows < LEAST_ROWS:
        message = f"{counted(rows, 'data row')}; allowed: {LEAST_ROWS} or more"
        return columns, [*problems, error(file, message)]
    if rows < TELLING_ROWS:
        message = (
            f"{rows} data rows; in fewer than {TELLING_ROWS} no fault of the"
            " recording shows"
        )
        problems.append(warning(file, message))
    if "time_s" in columns:
        problems += check_time(columns["time_s"], campaign.rate_hz, file)
    there = {n: columns[n] for n in channels if n in columns}
    for name in there:
        problems += check_channel(
            columns, channels[name], run.contact, limits, file
        )
    if "time_s" in columns:
        time = without_rounding(columns["time_s"])
        columns["time_s"] = since_first_row(time)
    if there and not missing:
        there = {name: columns[name] for name in there}
        problems += check_forces(campaign.device, there, run.contact, file)
    return columns, problems


def _describe_missing(
    missing: list[str],
    columns: Columns,
    channels: dict[str, Channel],
    campaign: Campaign,
    file: str,
) -> list[Problem]:
    """One problem per missing column, or one for all of a wrong device."""
    wanted = sum(not channel.is_optional for channel in channels.values())
    extra = [name for name in columns if name not in channels]
    hints = near_misses(missing, extra)
    if len(missing) > wanted / 2 and not any(hints.values()):
        message = (
            f"{len(missing)} missing columns, is this a {campaign.device}"
            f" recording? {', '.join(missing)}"
        )
        return [error(file, message)]
    problems = []
    for name, hint in hints.items():
        if hint is not None:
            message = f"missing column; did you mean {quoted(hint)}?"
            # In another unit it is there; what only looks alike may not be.
            own, other = (split_unit(n)[0].lower() for n in (name, hint))
            is_sure = channels[name].required or own == other
            tell = error if is_sure else warning
            problems.append(tell(file, message, name))
        elif channels[name].required:
            problems.append(error(file, "missing column", name))
        else:
            message = "missing column; what it would show stays unknown"
            problems.append(warning(file, message, name))
    return problems


def _compare_repeat(
    run: Run, original: Run, channels: dict[str, Channel]
) -> list[Problem]:
    """Warns about a repeat that cannot tell noise."""
    repeat, first = run.channels, original.channels
    shared = [n for n in channels if n in repeat and n in first]
    rows = min((len(c[n]) for n in shared for c in (repeat, first)), default=0)
    if rows == 0:
        return []
    differ = [
        name
        for name in shared
        if not np.array_equal(
            repeat[name][:rows], first[name][:rows], equal_nan=True
        )
    ]
    if not differ:
        message = f"a copy of {run.repeat_of}: it shows no noise"
        return [warning(run.file, message)]
    if any(lost_rows(c["time_s"]).any() for c in (repeat, first)):
        return []
    message = f"differs from {run.repeat_of}, which it should repeat"
    return [
        warning(run.file, message, name)
        for name in differ
        if channels[name].is_input
    ]
