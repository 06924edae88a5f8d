"""The command `brace-drake effects`: the library of effects."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from brace_drake.cli.library.table import format_table
from brace_drake.cli.options import AddCommand, AddJson, PrintJson
from brace_drake.core.errors import CampaignError, quoted, suggest

if TYPE_CHECKING:
    from brace_drake.effects.card import Effect, EffectParameter

_EPILOG = """\
example:
  brace-drake effects --device "bench stage 2"

One line for each effect: its name, with its form in parentheses where there
are several, its block, its parameters with limits and units, and what it is.
With --json also equations, sources and what tells it from others. Effects of
installed packages are among them.
"""
# An effect with more parameters tells how many there are.
_MOST_SHOWN = 6


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `effects`."""
    parser = AddCommand(
        subparsers,
        "effects",
        Run,
        help="list the effects that a diagnosis searches",
        description="Lists the library of effects.",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "--device",
        metavar="D",
        help="those that this device can have, as campaign.yaml names it"
        " (default: all)",
    )
    AddJson(parser)


def Run(args: argparse.Namespace) -> int:
    """Prints the effects."""
    cards = _cards(args.device)
    if args.json:
        PrintJson({"effects": [describe_effect(c) for c in cards]})
        return 0
    rows = [
        (c.key, c.block, parameters_text(c.parameters), c.title) for c in cards
    ]
    print(format_table(("effect", "block", "parameters", "title"), rows))
    return 0


def _cards(device: str | None) -> list[Effect]:
    from brace_drake.effects.registry import all_effects, effects_for
    from brace_drake.recording.columns import DEVICES

    if device is None:
        return list(all_effects().values())
    if device not in DEVICES:
        hint = suggest(device, DEVICES)
        there = " There" if hint else "; there"
        raise CampaignError(
            f"no device {quoted(device)}{hint}{there} are {', '.join(DEVICES)}"
        )
    found: dict[str, Effect] = {}
    for place in _places(device):
        found |= effects_for(place)
    return list(found.values())


def _places(device: str) -> Sequence[str]:
    """Where the effects of a device sit; some devices have several places."""
    from brace_drake.recording.columns import AXIS, DIAGRAM
    from brace_drake.scenario.axis.cards import BEHIND_MOTOR, COMMANDED
    from brace_drake.scenario.diagram.cards import COMMAND, JOINT, READING

    several = {
        AXIS: (AXIS, COMMANDED, BEHIND_MOTOR),
        DIAGRAM: (JOINT, COMMAND, READING),
    }
    return several.get(device, (device,))


def parameters_text(parameters: Sequence[EffectParameter]) -> str:
    """Parameters with limits and units: coulomb_N 0 to 60 N."""
    if len(parameters) > _MOST_SHOWN:
        first = _parameter_text(parameters[0])
        return f"{len(parameters)}, such as {first}"
    return ", ".join(map(_parameter_text, parameters)) or "none"


def _parameter_text(p: EffectParameter) -> str:
    if p.choices:
        return f"{p.name} {' or '.join(_choices(p))}"
    unit = "" if p.unit == "1" else p.unit
    return f"{p.name} {p.lower:g} to {p.upper:g} {unit}".rstrip()


def _choices(p: EffectParameter) -> Iterable[str]:
    return p.words or (f"{value:g}" for value in p.choices)


def describe_effect(card: Effect) -> dict:
    """A card in plain types."""
    return {
        "effect": card.key,
        "name": card.name,
        "form": card.variant,
        "block": card.block,
        "title": card.title,
        "equation": card.equation,
        "source": card.source,
        "parameters": [_describe(p) for p in card.parameters],
        "run_parameters": [_describe(p) for p in card.run_parameters],
        "signature": card.signature,
        "impostors": dict(card.impostors),
        "experiment": card.experiment,
        "remedy": card.remedy,
    }


def _describe(p: EffectParameter) -> dict:
    return {
        "name": p.name,
        "unit": p.unit,
        "lower": p.lower,
        "upper": p.upper,
        "choices": list(p.choices),
        "words": list(p.words),
        "meaning": p.meaning,
    }
