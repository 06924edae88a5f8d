"""The campaign.yaml of a campaign: what was recorded, run by run."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from difflib import get_close_matches

import yaml

from brace_drake.recording.columns import (
    BRACE,
    BRACE_STAGES,
    DEVICES,
    LEG_BENCH,
    PAD_BENCH,
    Channel,
    device_channels,
)
from brace_drake.recording.findings import quoted, warning
from brace_drake.recording.manifest_runs import (
    MANIFEST,
    RunEntry,
    manifest_error,
    parse_runs,
    wanted_text,
)
from brace_drake.recording.recording import Problem

FORMAT = "brace-campaign/1"
_KEYS = (
    "format",
    "device",
    "rate_hz",
    "subject",
    "runs",
    "nominal",
    "control",
    "stages",
    "settled_s",
)

_NOMINAL_KEYS = {
    LEG_BENCH: ("mass_kg", "viscous_N_s_m"),
    PAD_BENCH: ("stiffness_N_m", "damping_N_s_m"),
}
_CONTROL_KEYS = ("kp_1_s", "kv_N_s_m", "force_limit_N")


@dataclass(frozen=True)
class Manifest:
    """The usable content of a campaign.yaml.

    Attributes:
        device: A key of DEVICES, None when it was unusable.
        rate_hz: Sampling rate, None when it was unusable.
        subject: Free text.
        entries: The runs, in the file's order.
        nominal: Nominal parameters of the device, SI units in the names.
        control: Parameters of the drive's controller, likewise.
        stages: Of a brace, those recorded; empty: all.
        settled_s: How long the first reference was held before each run.
    """

    device: str | None = None
    rate_hz: float | None = None
    subject: str = ""
    entries: tuple[RunEntry, ...] = ()
    nominal: dict[str, float] = field(default_factory=dict)
    control: dict[str, float] = field(default_factory=dict)
    stages: tuple[int, ...] = ()
    settled_s: float = 0.0

    @property
    def channels(self) -> dict[str, Channel]:
        """What a recording of the device holds."""
        return device_channels(self.device, self.stages)


def parse_manifest(data: bytes) -> tuple[Manifest | None, list[Problem]]:
    """Parses campaign.yaml.

    Returns:
        What could be used of it, None when it is no YAML mapping; and every
        problem found.
    """
    try:
        content = yaml.safe_load(data.decode("utf-8-sig"))
    except UnicodeDecodeError as e:
        line = data[: e.start].count(b"\n") + 1
        return None, [manifest_error(f"line {line}: not UTF-8 text")]
    except yaml.YAMLError as e:
        return None, [manifest_error(_describe_yaml_error(e))]
    except (ValueError, RecursionError) as e:
        # PyYAML lets these through for impossible dates and deep nesting.
        return None, [manifest_error(f"unreadable YAML: {e}")]
    if not isinstance(content, dict):
        return None, [
            manifest_error(
                f"must hold a mapping of keys, found {quoted(content)}"
            )
        ]
    problems = _check_keys(content)
    device = _parse_head(content, problems)
    rate_hz = content.get("rate_hz")
    if not _is_positive(rate_hz):
        problems.append(
            manifest_error(wanted_text("rate_hz", "a positive number", rate_hz))
        )
        rate_hz = None
    manifest = Manifest(
        device=device,
        rate_hz=rate_hz if rate_hz is None else float(rate_hz),
        subject=str(content.get("subject") or ""),
        nominal=_parse_nominal(content, device, problems),
        control=_parse_control(content, device, problems),
        entries=parse_runs(content, problems),
        stages=_parse_stages(content, device, problems),
        settled_s=_parse_settled(content, problems),
    )
    return manifest, problems


def _check_keys(content: dict) -> list[Problem]:
    """A hint for each key that looks like one that is not there."""
    absent = [key for key in _KEYS if key not in content]
    problems = []
    for key in content:
        close = get_close_matches(str(key).lower(), absent, n=1, cutoff=0.75)
        if key not in _KEYS and close:
            message = f"no key {quoted(key)}, did you mean {close[0]}?"
            problems.append(warning(MANIFEST, message))
    return problems


def _describe_yaml_error(e: yaml.YAMLError) -> str:
    mark = getattr(e, "problem_mark", None)
    reason = getattr(e, "problem", None) or str(e)
    reason = " ".join(reason.split())
    if mark is None:
        return f"unreadable YAML: {reason}"
    return f"unreadable YAML in line {mark.line + 1}: {reason}"


def _is_positive(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return 0 < value <= sys.float_info.max


def _parse_head(content: dict, problems: list[Problem]) -> str | None:
    """Checks `format` and returns the device, None when it is unknown."""
    if content.get("format") != FORMAT:
        problems.append(
            manifest_error(
                wanted_text("format", quoted(FORMAT), content.get("format"))
            )
        )
    device = content.get("device")
    if isinstance(device, str) and device in DEVICES:
        return device
    names = "one of " + ", ".join(f"{name!r}" for name in DEVICES)
    problems.append(manifest_error(wanted_text("device", names, device)))
    return None


def _parse_numbers(
    content: dict,
    section: str,
    required: tuple[str, ...],
    optional: tuple[str, ...],
    problems: list[Problem],
) -> dict[str, float]:
    """The positive numbers of one section, with its faults reported."""
    values = content.get(section) or {}
    if not isinstance(values, dict):
        problems.append(
            manifest_error(wanted_text(section, "a mapping", values))
        )
        return {}
    numbers = {}
    for key in (*required, *optional):
        if _is_positive(values.get(key)):
            numbers[key] = float(values[key])
        elif key in required or values.get(key) is not None:
            name = f"{section}.{key}"
            problems.append(
                manifest_error(
                    wanted_text(name, "a positive number", values.get(key))
                )
            )
    return numbers


def _parse_nominal(
    content: dict, device: str | None, problems: list[Problem]
) -> dict[str, float]:
    keys = _NOMINAL_KEYS.get(device, ())
    if device == LEG_BENCH:
        return _parse_numbers(content, "nominal", keys, (), problems)
    return _parse_numbers(content, "nominal", (), keys, problems)


def _parse_settled(content: dict, problems: list[Problem]) -> float:
    value = content.get("settled_s")
    if value is None or value == 0 or _is_positive(value):
        return float(value or 0.0)
    problems.append(
        manifest_error(wanted_text("settled_s", "a number from 0", value))
    )
    return 0.0


def _parse_stages(
    content: dict, device: str | None, problems: list[Problem]
) -> tuple[int, ...]:
    stages = content.get("stages")
    if device != BRACE or stages is None:
        return ()
    if stages and isinstance(stages, list) and type(stages[0]) is int:
        first = stages[0] - 1
        if first >= 0 and stages == [*BRACE_STAGES[first:]][: len(stages)]:
            return tuple(stages)
    wanted = "neighbours of 1, 2, 3, from the lowest up"
    problems.append(manifest_error(wanted_text("stages", wanted, stages)))
    return ()


def _parse_control(
    content: dict, device: str | None, problems: list[Problem]
) -> dict[str, float]:
    if device != LEG_BENCH or content.get("control") is None:
        return {}
    gains, limit = _CONTROL_KEYS[:2], _CONTROL_KEYS[2:]
    return _parse_numbers(content, "control", gains, limit, problems)
