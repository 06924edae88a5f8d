"""Examines a campaign folder: every problem, and its content if sound."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from brace_drake.recording.columns import LEG_BENCH, Channel, near_miss
from brace_drake.recording.dropouts import fill_dropouts, lost_rows
from brace_drake.recording.findings import error, quoted, warning
from brace_drake.recording.free_runs import check_free
from brace_drake.recording.manifest import Manifest, parse_manifest
from brace_drake.recording.manifest_runs import (
    MANIFEST,
    RunEntry,
    leaves_folder,
    same_file,
)
from brace_drake.recording.recording import Campaign, Problem, Run
from brace_drake.recording.samples import (
    Limits,
    check_constant,
    check_range,
    check_saturation,
    check_time,
)
from brace_drake.recording.signs import check_signs
from brace_drake.recording.table import Columns, parse_table

_LEAST_ROWS_FOR_SIGNS = 50


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
    """Reads a campaign once: its content, None with errors, and problems."""
    path = Path(path)
    try:
        data = _ReadManifest(path)
    except ValueError as e:
        return None, [error(str(path), str(e))]
    except OSError as e:
        return None, [error(MANIFEST, f"cannot be read: {e.strerror}")]
    manifest, problems = parse_manifest(data)
    if manifest is None:
        return None, problems
    tables: dict[str, Columns] = {}
    for entry in manifest.entries:
        if entry.file is None or entry.file in tables:
            continue
        if not leaves_folder(entry.file):
            columns, found = _ReadRun(path, entry, manifest, limits)
            tables[entry.file] = columns
            problems += found
    spoilt = {p.file for p in problems if p.severity == "error"}
    sound = {f: t for f, t in tables.items() if f not in spoilt}
    problems += _check_repeats(manifest, sound)
    if spoilt:
        return None, problems
    return _assemble(path, manifest, tables, problems), problems


def _ReadManifest(path: Path) -> bytes:
    """Content of campaign.yaml; ValueError when the folder has none."""
    if not path.exists():
        raise ValueError("no such folder")
    if not path.is_dir():
        raise ValueError("is a file, not a campaign's folder")
    names = sorted(item.name for item in path.iterdir())
    if not names:
        raise ValueError("the folder is empty")
    if MANIFEST not in names:
        found = ", ".join(names[:3]) + (", ..." if len(names) > 3 else "")
        raise ValueError(f"no {MANIFEST} in this folder (it holds {found})")
    return (path / MANIFEST).read_bytes()


def _ReadRun(
    path: Path, entry: RunEntry, manifest: Manifest, limits: Limits | None
) -> tuple[Columns, list[Problem]]:
    """Columns of one run and everything wrong with them."""
    file = entry.file
    try:
        data = (path / file).read_bytes()
    except FileNotFoundError:
        return {}, [error(file, "no such file in the campaign's folder")]
    except (OSError, ValueError) as e:
        reason = getattr(e, "strerror", None) or str(e)
        return {}, [error(file, f"cannot be read: {reason}")]
    channels = manifest.channels
    columns, problems = parse_table(data, file, {"time_s", *channels})
    if columns:
        problems += _check_missing(columns, channels, manifest.device, file)
        problems += _check_samples(columns, entry, manifest, limits)
    return columns, problems


def _check_missing(
    columns: Columns,
    channels: dict[str, Channel],
    device: str | None,
    file: str,
) -> list[Problem]:
    """One error per missing column, or one for all of a wrong device."""
    required = [c.name for c in channels.values() if c.required]
    wanted = [c.name for c in channels.values() if not c.is_optional]
    missing = [name for name in wanted if name not in columns]
    extra = [name for name in columns if name not in channels]
    hints = {name: near_miss(name, extra) for name in missing}
    if len(missing) > len(wanted) / 2 and not any(hints.values()):
        message = (
            f"{len(missing)} missing columns, is this a {device} recording? "
            + ", ".join(missing)
        )
        return [error(file, message)]
    problems = []
    for name, hint in hints.items():
        message = "missing column"
        if hint is not None:
            message += f"; did you mean {quoted(hint)}?"
        if name in required or hint is not None:
            problems.append(error(file, message, name))
        else:
            message += "; what it would show stays unknown"
            problems.append(warning(file, message, name))
    return problems


def _check_samples(
    columns: Columns,
    entry: RunEntry,
    manifest: Manifest,
    limits: Limits | None,
) -> list[Problem]:
    """Everything wrong with the values of one run."""
    file = entry.file
    channels = manifest.channels
    problems = []
    rows = len(next(iter(columns.values())))
    if rows < 2:
        return [error(file, "only one data row, no motion to see")]
    if "time_s" in columns:
        problems += check_time(columns["time_s"], manifest.rate_hz, file)
    limits = limits or _default_limits(manifest)
    for name, channel in channels.items():
        if name not in columns:
            continue
        found = check_range(columns[name], channel, file)
        if name != "time_s":
            found += check_constant(columns, channel, entry.contact, file)
        if limits is not None and not found:
            found = check_saturation(columns[name], channel, limits, file)
        problems += found
    return problems + _check_forces(columns, entry, manifest)


def _default_limits(manifest: Manifest) -> Limits | None:
    """Limits of the device, None for a drive without feedback.

    A drive that is commanded open loop may be driven with square waves,
    which look like a clipped command.
    """
    if manifest.device != LEG_BENCH:
        return Limits()
    if not manifest.control:
        return None
    return Limits(command=manifest.control.get("force_limit_N"))


def _check_forces(
    columns: Columns, entry: RunEntry, manifest: Manifest
) -> list[Problem]:
    """Forces against motion and contact, on the rows where every known
    channel has a number.
    """
    channels = manifest.channels
    if any(not c.is_optional and n not in columns for n, c in channels.items()):
        return []
    known = {name: columns[name] for name in channels if name in columns}
    if not known:
        return []
    whole = np.all([np.isfinite(values) for values in known.values()], axis=0)
    if np.count_nonzero(whole) < _LEAST_ROWS_FOR_SIGNS:
        return []
    known = {name: values[whole] for name, values in known.items()}
    period = float(np.median(np.diff(known["time_s"])))
    if period <= 0.0:
        return []
    rate, file = 1.0 / period, entry.file
    found = check_signs(manifest.device, known, rate, entry.contact, file)
    if not entry.contact:
        found += check_free(manifest.device, known, rate, file)
    return found


def _check_repeats(
    manifest: Manifest, tables: dict[str, Columns]
) -> list[Problem]:
    """Warns about a repeat that cannot tell noise."""
    problems = []
    for entry in manifest.entries:
        if entry.repeat_of is None or entry.file not in tables:
            continue
        original = next(
            (f for f in tables if same_file(f, entry.repeat_of)), None
        )
        if original is not None and original != entry.file:
            problems += _compare_repeat(
                tables[entry.file],
                tables[original],
                manifest.channels,
                entry,
            )
    return problems


def _compare_repeat(
    repeat: Columns,
    original: Columns,
    channels: dict[str, Channel],
    entry: RunEntry,
) -> list[Problem]:
    shared = [n for n in channels if n in repeat and n in original]
    rows = min(
        (len(c[n]) for n in shared for c in (repeat, original)), default=0
    )
    if rows == 0:
        return []
    same = {
        name: np.array_equal(
            repeat[name][:rows], original[name][:rows], equal_nan=True
        )
        for name in shared
    }
    if all(same.values()):
        message = f"a copy of {entry.repeat_of}: it shows no noise"
        return [warning(entry.file, message)]
    if any(lost_rows(c["time_s"]).any() for c in (repeat, original)):
        return []
    return [
        warning(
            entry.file,
            f"differs from {entry.repeat_of}, which it should repeat",
            name,
        )
        for name in shared
        if channels[name].is_input and not same[name]
    ]


def _assemble(
    path: Path,
    manifest: Manifest,
    tables: dict[str, Columns],
    problems: list[Problem],
) -> Campaign:
    runs = tuple(
        Run(
            file=entry.file,
            contact=entry.contact,
            motion=entry.motion,
            repeat_of=entry.repeat_of,
            split=entry.split,
            channels=fill_dropouts(
                tables[entry.file], {"time_s", *manifest.channels}
            ),
            settled_s=manifest.settled_s,
        )
        for entry in manifest.entries
    )
    return Campaign(
        path=path.absolute(),
        device=manifest.device,
        rate_hz=manifest.rate_hz,
        subject=manifest.subject,
        runs=runs,
        nominal=manifest.nominal,
        control=manifest.control,
        stages=manifest.stages,
        warnings=tuple(problems),
    )
