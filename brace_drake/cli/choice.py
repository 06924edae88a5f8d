"""Options that choose: effects of a search, parameters of a fit."""

from __future__ import annotations

import argparse

from brace_drake.cli.options import names


def AddChoice(
    parser: argparse.ArgumentParser, has_effects: bool = True
) -> None:
    """Adds --fix, --free, --bounds and --prior, --effects and --without."""
    if has_effects:
        parser.add_argument(
            "--effects",
            type=names,
            metavar="A,B,C",
            help="effects to search (default: all of the device)",
        )
        parser.add_argument(
            "--without",
            type=names,
            metavar="A,B,C",
            help="effects to leave out of the search (default: none)",
        )
    parser.add_argument(
        "--free",
        type=names,
        metavar="A,B,C",
        help="subject parameters to fit, all others are held (default: all)",
    )
    parser.add_argument(
        "--fix",
        metavar="NAME[=VALUE]",
        action="append",
        type=_held,
        help="hold a subject parameter, at the scenario's value without one;"
        " SI units; may be repeated",
    )
    parser.add_argument(
        "--bounds",
        metavar="NAME=LO:HI",
        action="append",
        type=_bounds,
        help="fit a parameter within these limits: the subject's by its name,"
        " an effect's as EFFECT.NAME; SI units; may be repeated",
    )
    parser.add_argument(
        "--prior",
        metavar="NAME=VALUE:TOL",
        action="append",
        type=_prior,
        help="what is known of a subject parameter beforehand: a value and its"
        " standard deviation; SI units; may be repeated",
    )


def choice_options(args: argparse.Namespace) -> dict:
    """What was chosen, as `diagnose` and `fit` of the package take it."""
    found = {
        "free": args.free,
        "fixed": dict(args.fix or ()),
        "bounds": dict(args.bounds or ()),
        "priors": dict(args.prior or ()),
    }
    if hasattr(args, "effects"):
        found |= {"effects": args.effects, "without": args.without}
    return found


def _held(text: str) -> tuple[str, float | None]:
    name, sign, value = text.partition("=")
    if not name or (sign and not value):
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME or NAME=VALUE")
    return name.strip(), _number(value, text) if sign else None


def _bounds(text: str) -> tuple[str, tuple[float, float]]:
    return _two(text, "NAME=LO:HI")


def _prior(text: str) -> tuple[str, tuple[float, float]]:
    return _two(text, "NAME=VALUE:TOL")


def _two(text: str, form: str) -> tuple[str, tuple[float, float]]:
    name, _, numbers = text.partition("=")
    first, colon, second = numbers.partition(":")
    if not name or not colon:
        raise argparse.ArgumentTypeError(f"{text!r} is not {form}")
    return name.strip(), (_number(first, text), _number(second, text))


def _number(value: str, text: str) -> float:
    try:
        return float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{value!r} in {text!r} is not a number"
        ) from None
