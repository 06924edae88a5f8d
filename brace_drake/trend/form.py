"""What a trend takes of a diagnosis.json, and what each value must be."""

from __future__ import annotations

from brace_drake.recording.fields import (
    HUGE,
    NOT_NEGATIVE,
    TEXT,
    Field,
    number_from,
)

FORMAT = "brace-diagnosis/2"
# No standard error is smaller: far below what an instrument can tell in SI
# units, and its square is far from underflow.
LEAST_ERROR = 1.0 / HUGE

_NUMBER = number_from(-HUGE, HUGE)
_MAYBE = _NUMBER._replace(required=False)
_SHARE = number_from(0.0, 1.0)
_WORD = TEXT._replace(required=True)
_FREE = Field("text", lambda v: isinstance(v, str))
_TRUTH = Field("true or false", lambda v: isinstance(v, bool))
_SIZE = NOT_NEGATIVE._replace(required=False)
_ERROR = Field(
    f"0, or a number from {LEAST_ERROR:g} to {HUGE:g}",
    lambda v: NOT_NEGATIVE.accepts(v) and (v == 0 or v >= LEAST_ERROR),
    required=False,
)
_PAIR = Field(
    "two numbers, the lower one first",
    lambda v: (
        isinstance(v, list)
        and len(v) == 2
        and all(_NUMBER.accepts(x) for x in v)
        and v[0] <= v[1]
    ),
    required=False,
)
_WORDS = Field(
    "a list of words",
    lambda v: isinstance(v, list) and all(isinstance(x, str) for x in v),
)
MAPS = Field(
    "a list of maps",
    lambda v: isinstance(v, list) and all(isinstance(x, dict) for x in v),
)
_MAP = Field("a map of keys", lambda v: isinstance(v, dict))
HEAD = {
    "format": Field(repr(FORMAT), lambda v: v == FORMAT),
    "campaign": _FREE,
    "device": _WORD,
    "subject_name": _FREE,
    "verdict": _MAP,
    "subject": _MAP,
    "provenance": _MAP,
    "shrink": _MAP._replace(required=False),
}
VERDICT = {
    "gap": _TRUTH,
    "effects": _WORDS,
    "supported": MAPS,
    "outside_library": _TRUTH,
    "ambiguous_with": _WORDS,
    "probability": _SHARE,
    "sentence": _FREE,
    "recording": MAPS._replace(required=False),
}
SUPPORTED = {
    "effect": _WORD,
    "title": _FREE,
    "probability": _SHARE,
    "closes": _MAYBE,
    "parameters": MAPS,
}
PARAMETER = {
    "name": _WORD,
    "unit": _FREE,
    "value": _NUMBER,
    "standard_error": _ERROR,
    "lower95": _MAYBE,
    "upper95": _MAYBE,
    "nominal": _MAYBE,
    "at_limit": _TRUTH,
}
SHRINK = {
    "runs": _WORDS,
    "before": _SIZE,
    "before_interval": _PAIR,
    "after": _SIZE,
    "closed": _MAYBE,
    "closed_interval": _PAIR,
}
