"""What a map may say of the files that it names."""

from __future__ import annotations

from brace_drake.core.errors import CampaignError

OPTIONS = ("delimiter", "decimal", "skip_lines", "group")


def check_options(place: str, options: object) -> dict:
    """Options of a reader of tables.

    Raises:
        CampaignError: One line: option, value, what is allowed.
    """
    if not isinstance(options, dict):
        raise CampaignError(f"{place}: options must be a map of names")
    for key, value in options.items():
        if key not in OPTIONS:
            raise CampaignError(
                f"{place}: no option {key!r}; allowed: {', '.join(OPTIONS)}"
            )
        at = f"{place}: options.{key} is {value!r}; allowed:"
        if key in ("delimiter", "decimal") and not _is_sign(value):
            raise CampaignError(f"{at} one character")
        if key == "skip_lines" and not _is_count(value):
            raise CampaignError(f"{at} a whole number, 0 or more")
        if key == "group" and not isinstance(value, str):
            raise CampaignError(f"{at} a name")
    return options


def check_rate(place: str, rate: object) -> float | None:
    """Samples a second that files are brought to, None where it is not said.

    Raises:
        CampaignError: It is no number above 0.
    """
    if rate is None:
        return None
    if isinstance(rate, int | float) and not isinstance(rate, bool):
        if 0.0 < rate <= 1e6:
            return float(rate)
    raise CampaignError(
        f"{place}: rate_hz is {rate!r}; allowed: above 0 up to 1e6"
    )


def check_run(place: str, number: int, run: object) -> None:
    """Kinds of the values of one run of a map.

    Raises:
        CampaignError: One line: run, key, value, what is allowed.
    """
    if not isinstance(run, dict) or not run.get("file"):
        raise CampaignError(f"{place}: run {number} has no file")
    for key, value in run.items():
        kind: type = str
        allowed = "a word"
        if key == "contact":
            kind, allowed = bool, "true or false"
        may_be_absent = key == "repeat_of" and value is None
        if not (isinstance(value, kind) or may_be_absent) or value == "":
            raise CampaignError(
                f"{place}: run {number}: {key} is {value!r}; allowed: {allowed}"
            )
        if isinstance(value, str) and "\0" in value:
            raise CampaignError(f"{place}: run {number}: {key} holds a NUL")


def _is_sign(value: object) -> bool:
    return isinstance(value, str) and len(value) == 1 and value not in '\r\n\0"'


def _is_count(value: object) -> bool:
    return type(value) is int and value >= 0
