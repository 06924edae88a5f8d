"""Subjects drawn from ranges, so that one policy serves many patients."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from brace_drake.core.errors import EffectError, ScenarioError
from brace_drake.effects.card import Effect
from brace_drake.effects.registry import find_effect
from brace_drake.effects.stack import Use
from brace_drake.scenario.fields import number, vector


def _range():
    """A field of lowest and highest factor."""
    return vector(1.0, 1.0, least=1e-3, most=1e3)


@dataclass
class EffectRange:
    """An effect of the library that some subjects have.

    `parameters` gives lowest and highest value of each; those left out keep
    the card's own start.
    """

    name: str = ""
    form: str = ""
    probability: float = number(1.0, least=0.0, most=1.0)
    parameters: dict[str, np.ndarray] = field(default_factory=dict)


@dataclass
class SubjectRanges:
    """Factors on the scenario's numbers, uniform; off unless widened.

    The motion's end is scaled as well: displacement of every ring.
    """

    contact_stiffness: np.ndarray = _range()
    contact_damping: np.ndarray = _range()
    preload: np.ndarray = _range()
    posture_stiffness: np.ndarray = _range()
    posture_damping: np.ndarray = _range()
    torso_mass: np.ndarray = _range()
    displacement: np.ndarray = _range()
    effects: list[EffectRange] = field(default_factory=list)


def between_patients() -> SubjectRanges:
    """0.7 to 1.5 times nominal, as subjects of the bench differ."""
    wide = {
        name: np.array([0.7, 1.5])
        for name in (
            "contact_stiffness", "contact_damping", "preload",
            "posture_stiffness", "posture_damping", "torso_mass",
        )
    }  # fmt: skip
    return SubjectRanges(**wide)


FACTORS = tuple(n for n in SubjectRanges.__annotations__ if n != "effects")


@dataclass(frozen=True)
class Subject:
    """One drawn subject: factors by name, and parameters of the effects."""

    factors: dict[str, float]
    effects: tuple[np.ndarray, ...] = ()

    def describe(self) -> dict[str, float]:
        """Numbers for an episode's info."""
        return dict(self.factors)


NOMINAL = Subject(dict.fromkeys(FACTORS, 1.0))


def check_ranges(ranges: SubjectRanges, source: str = "subjects") -> None:
    """Checks ranges and names of effects.

    Raises:
        ScenarioError: A range is not two numbers, lowest first.
        EffectError: No such effect, or no such parameter.
    """
    for name in FACTORS:
        _check_range(f"{source}.{name}", getattr(ranges, name), 1e-3, 1e3)
    for i, use in enumerate(ranges.effects):
        at = f"{source}.effects[{i}]"
        try:
            card = find_card(use)
        except EffectError as error:
            raise EffectError(f"{at}: {error}") from error
        for name, values in use.parameters.items():
            if name not in card.parameter_names:
                raise EffectError(
                    f"{at}.parameters.{name}: no such parameter of {card.key};"
                    f" allowed: {', '.join(card.parameter_names)}"
                )
            p = card.parameters[card.parameter_names.index(name)]
            _check_range(f"{at}.parameters.{name}", values, p.lower, p.upper)


def _check_range(where: str, values, lowest: float, highest=np.inf) -> None:
    a = np.asarray(values, dtype=float)
    good = a.shape == (2,) and np.isfinite(a).all()
    if not (good and lowest <= a[0] <= a[1] <= highest):
        raise ScenarioError(
            f"{where}: {np.asarray(values).tolist()}; allowed: two numbers,"
            f" lowest first, of {lowest:g} to {highest:g}"
        )


def find_card(use: EffectRange) -> Effect:
    """The card that a range names."""
    return find_effect(f"{use.name} ({use.form})" if use.form else use.name)


def draw_subject(
    ranges: SubjectRanges, generator: np.random.Generator
) -> Subject:
    """Draws factors, then the effects' parameters; always as many numbers."""
    factors = {
        name: float(generator.uniform(*getattr(ranges, name)))
        for name in FACTORS
    }
    drawn = [_draw_effect(use, generator) for use in ranges.effects]
    return Subject(factors, tuple(drawn))


def _draw_effect(
    use: EffectRange, generator: np.random.Generator
) -> np.ndarray:
    card, present = find_card(use), generator.random() < use.probability
    off, values = card.off(), []
    for i, p in enumerate(card.parameters):
        start = p.starts[0] if not p.choices else p.choices[0]
        low, high = use.parameters.get(p.name, (start, start))
        value = generator.uniform(low, high)
        values.append(value if present else off[i])
    own = []
    for p in card.run_parameters:
        draw = generator.uniform(-np.pi, np.pi), generator.standard_normal()
        value = draw[0] if p.unit == "rad" else draw[1] * (p.deviation or 0.0)
        own.append(np.clip(value, p.lower, p.upper))
    return np.array([*values, *own])


def uses_of(ranges: SubjectRanges, subject: Subject) -> Sequence[Use]:
    """Effects of a subject as the twin takes them."""
    if not subject.effects:
        cards = [find_card(use) for use in ranges.effects]
        return tuple((c, c.in_run(c.off(), 0)) for c in cards)
    return tuple(
        (find_card(use), values)
        for use, values in zip(ranges.effects, subject.effects, strict=True)
    )
