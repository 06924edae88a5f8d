"""What a fit may move, and which effects a search may try.

All is free and all is tried, unless a caller or the block `estimation` of a
scenario file says otherwise, see `nominal_scenario.parse_choice`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

from brace_drake.core.errors import (
    EffectError,
    FitError,
    quoted,
    suggest,
)
from brace_drake.devices.subject import SubjectParameter
from brace_drake.effects.card import Effect, EffectParameter

# Standard deviations that a prior is off by chance once in 400 cases.
_FAR = 3.0
# A tissue may be ten times another's, or a start a mere guess; what is farther
# from the scenario's than this is of another unit, or no number of a machine.
_MOST_TIMES = 1e3


@dataclass(frozen=True)
class Choice:
    """Which effects are searched, and which of the subject's parameters move.

    Attributes:
        effects: Names or keys of those to search; None: all of the device.
        without: Names or keys that are left out.
        free: Parameters that are fitted; None: all that are not fixed.
        fixed: Parameters that are held, in SI units; None in place of a value:
            at the scenario's.
        bounds: Lower and upper limit of parameters, in SI units: of the
            subject by name, of an effect as EFFECT.NAME.
        priors: Value and tolerance of the subject's parameters, in SI units:
            mean and standard deviation of a normal prior.
    """

    effects: tuple[str, ...] | None = None
    without: tuple[str, ...] = ()
    free: tuple[str, ...] | None = None
    fixed: Mapping[str, float | None] = field(default_factory=dict)
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    priors: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def contradicted(self, values: Mapping[str, float]) -> list[str]:
        """Priors that lie far from what was fitted, each in words.

        Args:
            values: Fitted parameters by name, in SI units.
        """
        found = []
        for name, (value, tolerance) in self.priors.items():
            off = abs(values[name] - value) / tolerance
            if off > _FAR:
                found.append(
                    f"{name} is {off:.1f} standard deviations of its prior,"
                    f" {value:g} +- {tolerance:g}, off: one of both is wrong"
                )
        return found

    @property
    def limits_search(self) -> bool:
        """Whether some effects are not searched."""
        return self.effects is not None or bool(self.without)

    def over(self, other: Choice) -> Choice:
        """This choice where it says something, else the other."""
        mine = {*self.fixed, *self.bounds, *self.priors, *(self.free or ())}
        fixed = {n: v for n, v in other.fixed.items() if n not in mine}
        bounds, priors = (
            {n: v for n, v in of.items() if n not in self.fixed}
            for of in (other.bounds, other.priors)
        )
        return Choice(
            other.effects if self.effects is None else self.effects,
            self.without or other.without,
            other.free if self.free is None else self.free,
            {**fixed, **self.fixed},
            {**bounds, **self.bounds},
            {**priors, **self.priors},
        )

    def describe(self) -> dict:
        """What was chosen in plain types; empty where nothing was."""
        rows = {
            "effects": None if self.effects is None else list(self.effects),
            "without": list(self.without),
            "free": None if self.free is None else list(self.free),
            "fixed": dict(self.fixed),
            "bounds": {n: list(b) for n, b in self.bounds.items()},
            "priors": {n: list(p) for n, p in self.priors.items()},
        }
        return {name: row for name, row in rows.items() if row}

    def effects_of(self, twin) -> list[Effect]:
        """The effects of a twin that are searched, within their bounds.

        Raises:
            EffectError: One is unknown there, or none is left; or bounds that
                are not allowed.
        """
        cards = twin.effects()
        wanted = _keys(self.effects, cards, twin.device)
        unwanted = _keys(self.without, cards, twin.device)
        left = [
            card
            for key, card in cards.items()
            if (self.effects is None or key in wanted) and key not in unwanted
        ]
        if self.limits_search and not left:
            raise EffectError("no effect is left to search")
        for name, bounds in self.bounds.items():
            effect, dot, parameter = name.rpartition(".")
            if dot:
                keys = _keys([effect], cards, twin.device)
                left = _bounded(left, keys, parameter, bounds)
        return left

    def limit_subject(self, twin) -> None:
        """Holds and bounds the subject's parameters of a twin, with priors.

        Raises:
            FitError: One line: a parameter that is not there, a value that is
                not allowed, or nothing is left to fit.
        """
        subject = twin.subject
        names = [p.name for p in subject]
        own = [n for n in self.bounds if "." not in n]
        for name in (*(self.free or ()), *self.fixed, *own, *self.priors):
            if name not in names:
                hint = suggest(name, names)
                there = " There" if hint else "; there"
                raise FitError(
                    f"no subject parameter {quoted(name)}{hint}{there} are"
                    f" {', '.join(names) or 'none'}"
                )
        self._refuse_contradictions()
        limited = tuple(self._limited(p) for p in subject)
        if subject and all(p.is_fixed for p in limited):
            raise FitError("all subject parameters are held, none is fitted")
        twin.subject = limited

    def _refuse_contradictions(self) -> None:
        both = [n for n in self.fixed if n in self.bounds]
        if both:
            raise FitError(f"{both[0]} is held, and has bounds; allowed: one")
        both = [n for n in self.fixed if n in self.priors]
        if both:
            raise FitError(f"{both[0]} is held, and has a prior; allowed: one")
        both = [n for n in self.fixed if n in (self.free or ())]
        if both:
            raise FitError(f"{both[0]} is held, and free; allowed: one")

    def _limited(self, p: SubjectParameter) -> SubjectParameter:
        scale = p.unit_step
        if p.name in self.bounds:
            low, high = self.bounds[p.name]
            _check_value(p, low, "the lower bound")
            _check_value(p, high, "the upper bound")
            if not low < high:
                raise FitError(
                    f"bounds of {p.name} are {low:g} to {high:g} {p.unit};"
                    " allowed: the lower one first"
                )
            start = min(max(p.nominal, low), high)
            limits = {"nominal": start, "lower": low, "upper": high}
            p = replace(p, **limits, scale=scale)
        if p.name in self.priors:
            p = replace(_with_prior(p, *self.priors[p.name]), scale=scale)
        is_free = self.free is None or p.name in self.free
        if is_free and p.name not in self.fixed:
            return p
        given = self.fixed.get(p.name)
        value = p.nominal if given is None else float(given)
        _check_value(p, value, "the value")
        limits = {"nominal": value, "lower": value, "upper": value}
        return replace(p, **limits, scale=scale, deviation=0.0)


def _with_prior(
    p: SubjectParameter, value: float, tolerance: float
) -> SubjectParameter:
    if not p.lower <= value <= p.upper:
        raise FitError(
            f"{p.name}: the prior's value is {value:g}; allowed: {p.lower:g}"
            f" to {p.upper:g} {p.unit}, or other bounds"
        )
    if not (math.isfinite(tolerance) and tolerance > 0.0):
        raise FitError(
            f"{p.name}: the prior's tolerance is {tolerance:g}; allowed: above"
            f" 0 {p.unit}"
        )
    return replace(p, nominal=value, deviation=tolerance)


def _bounded(
    cards: Iterable[Effect],
    keys: Collection[str],
    name: str,
    bounds: tuple[float, float],
) -> list[Effect]:
    """Cards, those of some keys with bounds of one parameter.

    Raises:
        EffectError: None has the parameter, or not within such bounds.
    """
    found, names = [], []
    for card in cards:
        mine = card.parameters if card.key in keys else ()
        names += [p.name for p in mine]
        if any(p.name == name for p in mine):
            limited = [
                _with_bounds(card, p, *bounds) if p.name == name else p
                for p in mine
            ]
            card = replace(card, parameters=tuple(limited))
        found.append(card)
    if name not in names:
        hint = suggest(name, names) if names else ""
        there = ", ".join(dict.fromkeys(names)) or "none, it is not searched"
        raise EffectError(
            f"bounds: no parameter {quoted(name)} of {min(keys)}{hint};"
            f" allowed: {there}"
        )
    return found


def _with_bounds(
    card: Effect, p: EffectParameter, low: float, high: float
) -> EffectParameter:
    """A parameter of an effect within closer limits."""
    is_within = p.lower <= low < high <= p.upper
    if p.choices or not is_within:
        allowed = f"two numbers within {p.lower:g} to {p.upper:g} {p.unit}"
        if p.choices:
            allowed = "none, it is no continuous number"
        raise EffectError(
            f"bounds of {card.name}.{p.name} are {low:g} to {high:g};"
            f" allowed: {allowed}, the lower one first"
        )
    starts = tuple(s for s in p.starts if low < s < high)
    starts = starts or (0.5 * (low + high),)
    return replace(p, lower=low, upper=high, starts=starts)


def _check_value(p: SubjectParameter, value: float, what: str) -> None:
    """The sign of a parameter is part of the physics, and so is its size."""
    most = _MOST_TIMES * max(abs(p.nominal), p.scale) or math.inf
    least, allowed = -most, "a finite number"
    if p.lower > 0.0:
        least, allowed = abs(p.nominal) / _MOST_TIMES, f"above 0 {p.unit}"
    elif p.lower == 0.0:
        least, allowed = 0.0, f"0 {p.unit} or more"
    least, most = min(least, p.lower), max(most, p.upper)
    if not (math.isfinite(value) and least <= value <= most):
        raise FitError(
            f"{p.name}: {what} is {value:g}; allowed: {allowed}, from"
            f" {least:g} to {most:g}"
        )


def _keys(
    names: Iterable[str] | None, cards: Mapping[str, Effect], device: str
) -> set[str]:
    """Keys of the cards that names stand for: of one form, or of all."""
    found: set[str] = set()
    for name in names or ():
        own = {key for key, e in cards.items() if name in (key, e.name)}
        if not own:
            known = dict.fromkeys([*(e.name for e in cards.values()), *cards])
            hint = suggest(name, known)
            there = " There" if hint else "; there"
            all_names = dict.fromkeys(e.name for e in cards.values())
            raise EffectError(
                f"no effect {quoted(name)} of a {device}{hint}{there} are"
                f" {', '.join(all_names)}"
            )
        found |= own
    return found
