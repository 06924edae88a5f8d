"""The dictionary: each form at each place, as a card that a twin takes."""

from __future__ import annotations

from functools import cache

import numpy as np

from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.effects.registry import PLACES as KNOWN
from brace_drake.effects.unknown.forms import CODE, STRENGTH, Form, Shape
from brace_drake.effects.unknown.places import PLACES, Place

_PREFIX = "term_"
# Of the strength to begin with.
_MOST = 1e4
_UNITS = {"time": "s", "frequency": "Hz", "angle": "rad"}


def is_term(effect: Effect) -> bool:
    """Whether a card is of this dictionary, and no cause."""
    return effect.name.startswith(_PREFIX)


@cache
def terms_for(device: str) -> dict[str, Effect]:
    """Terms that can act on a device, by name."""
    known = KNOWN.get(device, frozenset())
    cards = (_card(place, form) for place in PLACES for form in place.forms)
    return {c.name: c for c in cards if c.places <= known}


def _card(place: Place, form: Form) -> Effect:
    most = _MOST * place.strength
    strength = EffectParameter(
        STRENGTH,
        place.unit,
        -most,
        most,
        (place.strength,),
        "what it gives where all is as usual",
    )
    shapes = [_shape(place, shape) for shape in form.shapes]
    # Names are told apart.
    shapes += [_none(f"no_shape_{i}") for i in range(len(shapes), 2)]
    code = float(form.code)
    which = EffectParameter(
        CODE, "1", code, code, (code,), "which form", None, (code,)
    )
    return Effect(
        name=f"{_PREFIX}{place.key}_{form.key}",
        block=place.block,
        title=f"{place.words} {_words(place, form)}",
        equation=form.formula,
        source="sparse identification from a dictionary: Brunton, Proctor,"
        " Kutz, PNAS 113, 2016",
        parameters=(strength, *shapes, which),
        laws={place.point: place.law},
        num_states={place.point: place.num_states},
        needs=place.needs,
        signature="none: a description, not a cause",
        impostors={},
        experiment="none",
    )


def _shape(place: Place, shape: Shape) -> EffectParameter:
    unit = _UNITS.get(shape.kind, "1")
    return EffectParameter(
        f"{shape.name}_{unit}" if unit != "1" else shape.name,
        unit,
        shape.lower,
        shape.upper,
        shape.starts,
        f"{shape.name}; a place or a speed in units of what is usual",
        off=None,
    )


def _none(name: str) -> EffectParameter:
    return EffectParameter(name, "1", 0.0, 0.0, (0.0,), "none", None, (0.0,))


def parts_of_term(effect: Effect) -> tuple[Place, Form]:
    """Place and form that a card of this dictionary is made of."""
    for place in PLACES:
        for form in place.forms:
            if effect.name == f"{_PREFIX}{place.key}_{form.key}":
                return place, form
    raise KeyError(effect.name)


def _words(place: Place, form: Form) -> str:
    blanks = {"q": place.variable, "a": "a", "b": "b"}
    return form.words.format(**blanks)


def describe_term(effect: Effect, values: np.ndarray, errors) -> dict:
    """A fitted term in words, as a formula and in units.

    Args:
        effect: Of the dictionary.
        values: Its parameters.
        errors: Standard errors of them, NaN where they are not known.

    Returns:
        `text`, `formula`, `usual`, `block` and `parameters`, each with name,
        value, standard_error and unit.
    """
    place, form = parts_of_term(effect)
    divided = np.prod(np.power(place.scales, form.per))
    unit = _unit_of(place, form)
    rows = [_row("c", values[0] / divided, errors[0] / divided, unit)]
    shown = {"q": place.variable}
    for name, shape, i in zip("ab", form.shapes, (1, 2), strict=False):
        scale, of = _scale(place, shape)
        row = _row(name, values[i] * scale, errors[i] * scale, of)
        rows.append(row)
        shown[name] = _quantity(row["value"], of)
    size = _quantity(*(rows[0][k] for k in ("value", "unit")))
    return {
        "text": f"{place.words}, {size}, {form.words.format(**shown)}",
        "formula": form.formula,
        "usual": "" if place.block == "sensing" else form.usual,
        "block": place.block,
        "parameters": rows,
    }


def _row(name: str, value: float, error: float, unit: str) -> dict:
    return {
        "name": name,
        "value": float(value),
        "standard_error": float(error) if np.isfinite(error) else None,
        "unit": unit,
    }


def _scale(place: Place, shape: Shape) -> tuple[float, str]:
    if shape.kind == "place":
        return place.scales[0], place.units[0]
    if shape.kind == "speed":
        return place.scales[1], place.units[1]
    return 1.0, _UNITS[shape.kind]


def _unit_of(place: Place, form: Form) -> str:
    """Of a strength: what is added, over powers of what it depends on."""
    powers = _powers_of(place.unit)
    for unit, power in zip(place.units, form.per, strict=True):
        for base, exponent in _powers_of(unit).items():
            powers[base] = powers.get(base, 0) - power * exponent
    above = [_power(b, e) for b, e in powers.items() if e > 0]
    below = [_power(b, -e) for b, e in powers.items() if e < 0]
    top = " ".join(above) or "1"
    if not below:
        return top
    bottom = " ".join(below)
    return f"{top}/{bottom}" if len(below) == 1 else f"{top}/({bottom})"


def _powers_of(unit: str) -> dict[str, int]:
    """Exponents of a unit's parts: of "N m/s2" N 1, m 1, s -2."""
    powers: dict[str, int] = {}
    for place, side in enumerate(unit.split("/")):
        for part in side.split():
            base = part.rstrip("0123456789")
            exponent = int(part[len(base) :] or 1)
            if base:
                sign = -1 if place else 1
                powers[base] = powers.get(base, 0) + sign * exponent
    return powers


def _power(base: str, exponent: int) -> str:
    return base if exponent == 1 else f"{base}{exponent}"


def _quantity(value: float, unit: str) -> str:
    if unit == "m":
        value, unit = 1e3 * value, "mm"
    if unit == "m/s":
        value, unit = 1e3 * value, "mm/s"
    # 1200, not 1.2e+03.
    return f"{float(f'{value:.3g}'):g} {unit}".removesuffix(" 1")
