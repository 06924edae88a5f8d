"""What answers and truths of withheld cases hold, as JSON schemas."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jsonschema import Draft202012Validator
from jsonschema.exceptions import best_match

from brace_drake.withheld.faults import SEVERITIES
from brace_drake.withheld.seals import AnswerError

# Of a message: it shows the value, however long.
_LONGEST = 160
_NAMES = {"type": "array", "items": {"type": "string"}, "uniqueItems": True}
_SHARE = {"type": ["number", "null"], "minimum": 0, "maximum": 1}
_MEASURED = {"type": ["number", "null"]}

VERDICT = {
    "type": ["object", "null"],
    "required": ["gap", "effects", "outside_library", "blocks", "probability"],
    "properties": {
        "gap": {"type": "boolean"},
        "effects": _NAMES | {"type": ["array", "null"]},
        "outside_library": {"type": "boolean"},
        "blocks": _NAMES,
        "probability": _SHARE,
        "ambiguous_with": _NAMES,
        "recording": {"type": "array"},
    },
}
ANSWER = {
    "type": "object",
    "required": ["verdict", "closed"],
    "properties": {
        "verdict": VERDICT,
        # A repair may leave less than the noise that was expected.
        "closed": _MEASURED | {"maximum": 2},
        "seconds": _MEASURED | {"minimum": 0},
    },
}
_FLOORS = {
    "type": "object",
    "required": ["refitted"],
    "properties": {"refitted": {"type": "number"}},
}
_TRUTH = {
    "type": "object",
    "required": ["kind", "severity", "effects", "blocks", "floors"],
    "properties": {
        "kind": {"enum": ["none", "single", "pair", "outside"]},
        "severity": {"enum": [None, *SEVERITIES]},
        "effects": _NAMES,
        "blocks": _NAMES,
        "outside": _NAMES,
        "floors": {
            "type": "object",
            "required": ["faults"],
            "properties": {
                "faults": _FLOORS | {"type": ["object", "null"]},
                "beside": {"type": "object", "additionalProperties": _FLOORS},
            },
        },
    },
    "if": {"properties": {"kind": {"const": "outside"}}},
    "then": {
        "required": ["outside"],
        "properties": {"outside": {"minItems": 1}},
    },
}
SEALED = {
    "type": "object",
    "required": ["truth", "salt"],
    "properties": {"truth": _TRUTH, "salt": {"type": "string"}},
}


def check_shape(where: str, document: object, schema: Mapping[str, Any]):
    """Compares a document with its schema.

    Args:
        where: File and place, for the message.
        document: As JSON has it.
        schema: One of this module's.

    Raises:
        AnswerError: It is of another shape; says at which key.
    """
    found = best_match(Draft202012Validator(schema).iter_errors(document))
    if found is not None:
        at = ".".join(str(part) for part in found.absolute_path)
        place = f"{where}: {at}" if at else where
        text = found.message
        if len(text) > _LONGEST:
            text = f"{text[:_LONGEST]}..."
        raise AnswerError(f"{place}: {text}")
