"""The card of an effect: what it is, where it sits, how it is told apart."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from brace_drake.core.errors import EffectError
from brace_drake.laws.hooks import PLUG_POINTS

BLOCKS = ("actuation", "mechanism", "contact", "torso", "sensing")


# Of the range, the typical size of parameters whose search starts at 0.
_SHARE = 0.05


@dataclass(frozen=True)
class EffectParameter:
    """One parameter of an effect.

    Attributes:
        name: With its unit as the last part, as columns have it.
        unit: SI.
        lower, upper: Physical limits; the sign is part of the physics.
        starts: Values to start a fit from, none of them at a limit.
        meaning: One line.
        off: Value at which the effect is not there; None for parameters of
            its shape alone.
        choices: The only values that the parameter takes, where it is not
            continuous: a fit tries each.
        words: What each of the choices stands for, where its number does not
            say it.
        deviation: Standard deviation of its normal prior around 0, where it
            has one.
    """

    name: str
    unit: str
    lower: float
    upper: float
    starts: tuple[float, ...]
    meaning: str
    off: float | None = 0.0
    choices: tuple[float, ...] = ()
    words: tuple[str, ...] = ()
    deviation: float | None = None

    @property
    def typical(self) -> float:
        """A size that is worth a look: of a start, or a part of the range."""
        start = abs(self.starts[len(self.starts) // 2])
        return start if start > 0.0 else _SHARE * self.upper


def _derived():
    """A field that follows from the others."""
    return field(init=False, repr=False, compare=False)


@dataclass(frozen=True)
class Effect:
    """A card: physics, parameters, place in the diagram, confusable effects.

    Attributes:
        name: Identifier as in a diagnosis.
        form: Tells apart several laws of the same effect; a diagnosis tries
            each and answers with the name.
        at: Where of several alike places it acts, such as a joint; empty for
            the only one, or all. Effects at different places are different
            causes.
        block: actuation, mechanism, contact, torso or sensing.
        title: A few words for a reader.
        equation: The law, in plain text.
        source: Where the law is from.
        parameters: In the order of the law's vector p.
        run_parameters: Those that every run has its own of, such as the phase
            of a breath; in p they follow the others.
        laws: Compiled law for each plug point it uses (see `laws.hooks`).
        num_states: States that it keeps at each plug point (default 0).
        modify: For effects that are other numbers of the twin rather than a
            law: (numbers, values) -> numbers.
        constants: What the laws take of the twin's numbers, at the end of p:
            numbers -> values, a row for each stage.
        signature: What it looks like in a recording.
        impostors: Effects that it is confused with, and what tells them
            apart.
        experiment: The motion that shows it best.
        remedy: What to look at or do about it, at the machine or in the twin.
        needs: What a device must have for it beside the plug points of its
            laws, see `places`.
        dithered: Whether the noise in the loop changes the mean motion, as
            with dry friction; the twin then averages over noisy replays.
        spread: For effects of many alike parameters drawn from a common
            normal distribution: name and unit of its standard deviation,
            which is what is reported. None for all others.
        generalises: Names of effects that are special cases of this one.
        contains: Names of effects that are part of it, as dry friction is of
            a drive that sticks behind an elastic joint: none of them is added
            to it.
        on_command: Whether it changes the command on its way to the drive, as
            a gain does: it acts on what the effects before it have left, and
            before those that add a force.
        stage: Of a brace of several moving stages the only one that has it,
            counted from 0, and how many there are; None: all, or the torso.
        variant: Form and place, where there are several.
        key: Name and variant.
        cause: Name and place: what a verdict tells apart.
        parameter_names, lower, upper: Names and limits in order.
        is_continuous: Parameters that a fit moves (n,).
        is_strength: Parameters that vanish with the effect (n,).
        has_several_starts: Parameters that a fit moves from several starts.
        has_either_sign: Whether what vanishes with the effect may all be
            negative too; not where runs have phases of their own, which turn
            it round as well.
        is_flexible: Whether it has parameters by the dozen, held by priors.
        places: What a device has to have for it: the plug points of its laws,
            its other needs, and the brace's numbers where it takes or changes
            them.
    """

    name: str
    block: str
    title: str
    equation: str
    source: str
    parameters: tuple[EffectParameter, ...]
    signature: str
    impostors: Mapping[str, str]
    experiment: str
    remedy: str = ""
    laws: Mapping[str, Callable] = field(default_factory=dict)
    num_states: Mapping[str, int] = field(default_factory=dict)
    modify: Callable | None = None
    constants: Callable | None = None
    needs: tuple[str, ...] = ()
    dithered: bool = False
    spread: tuple[str, str] | None = None
    form: str = ""
    at: str = ""
    run_parameters: tuple[EffectParameter, ...] = ()
    generalises: tuple[str, ...] = ()
    contains: tuple[str, ...] = ()
    on_command: bool = False
    stage: tuple[int, int] | None = None
    variant: str = _derived()
    key: str = _derived()
    cause: str = _derived()
    parameter_names: tuple[str, ...] = _derived()
    lower: np.ndarray = _derived()
    upper: np.ndarray = _derived()
    is_continuous: np.ndarray = _derived()
    is_strength: np.ndarray = _derived()
    has_several_starts: np.ndarray = _derived()
    has_either_sign: bool = _derived()
    is_flexible: bool = _derived()
    places: frozenset[str] = _derived()

    def __post_init__(self):
        if self.block not in BLOCKS:
            raise EffectError(
                f"effect {self.name}: block {self.block!r} is not one of"
                f" {', '.join(BLOCKS)}"
            )
        for point in (*self.laws, *self.num_states):
            if point not in PLUG_POINTS:
                raise EffectError(
                    f"effect {self.name}: no plug point {point!r}; there are"
                    f" {', '.join(PLUG_POINTS)}"
                )
        if not self.laws and self.modify is None:
            raise EffectError(f"effect {self.name} changes nothing")
        parameters = self.parameters
        moved = np.array([not p.choices for p in parameters], dtype=bool)
        several = np.array([len(p.starts) > 1 for p in parameters], dtype=bool)
        vanishes = np.array([p.off == 0.0 for p in parameters], dtype=bool)
        lower = np.array([p.lower for p in parameters])
        signs = lower[moved & vanishes]
        places = [*self.laws, *self.needs, *["command"] * self.on_command]
        if self.modify is not None or self.constants is not None:
            places.append("brace")
        either = bool(signs.size and np.all(signs < 0.0))
        variant = ", ".join(filter(None, (self.form, self.at)))
        derived = {
            "variant": variant,
            "key": f"{self.name} ({variant})" if variant else self.name,
            "cause": f"{self.name} ({self.at})" if self.at else self.name,
            "parameter_names": tuple(p.name for p in parameters),
            "lower": lower,
            "upper": np.array([p.upper for p in parameters]),
            "is_continuous": moved,
            "is_strength": moved & vanishes,
            "has_several_starts": moved & several,
            "has_either_sign": either and not self.run_parameters,
            "is_flexible": bool(self.spread or self.run_parameters),
            "places": frozenset(places),
        }
        vars(self).update(derived)

    def is_alike(self, other: Effect) -> bool:
        """Whether both are forms of one effect, or one holds the other: then
        the two together are no more than the richer one. At two places they
        are two.
        """
        if self.at and other.at and self.at != other.at:
            return False
        return (
            self.name == other.name
            or self.name in (*other.generalises, *other.contains)
            or other.name in (*self.generalises, *self.contains)
        )

    def is_richer_than(self, other: Effect) -> bool:
        """Whether the other one is a special case, in the same form at the
        same place; of forms for single inputs in the same but for these.
        """
        is_there = other.at == self.at
        is_same = other.form in (self.form, self.form.partition(", ")[0])
        return other.name in self.generalises and is_there and is_same

    def in_run(self, values: np.ndarray, index: int) -> np.ndarray:
        """The law's vector p in one run.

        Args:
            values: Parameters, then the run parameters of run after run; or
                the parameters alone, then those of the run are 0.
            index: Of the run.
        """
        shared, own = len(self.parameters), len(self.run_parameters)
        if own == 0:
            return values
        at = shared + index * own
        mine = values[at : at + own] if len(values) > shared else np.zeros(own)
        return np.concatenate([values[:shared], mine])

    def starts(self) -> list[np.ndarray]:
        """Start vectors: all combinations of the parameters' starts."""
        each = [p.choices or p.starts for p in self.parameters]
        return [np.array(v) for v in itertools.product(*each)]

    def scaled(self, values: np.ndarray, factor: float) -> np.ndarray:
        """Values of an effect `factor` times as strong, inside its limits.

        What vanishes with the effect is multiplied, its shape is left alone.
        """
        changed = np.where(self.is_strength, values * factor, values)
        return np.clip(changed, self.lower, self.upper)

    def off(self) -> np.ndarray:
        """Parameter values at which the effect changes nothing."""
        return np.array(
            [
                starts[0] if p.off is None else p.off
                for p, starts in (
                    (p, p.choices or p.starts) for p in self.parameters
                )
            ]
        )

    def vector(self, values: Mapping[str, float]) -> np.ndarray:
        """The law's parameter vector from named values.

        Raises:
            EffectError: A name is unknown or missing, or a value outside its
                limits.
        """
        unknown = set(values) - set(self.parameter_names)
        missing = set(self.parameter_names) - set(values)
        if unknown or missing:
            raise EffectError(
                f"effect {self.name} takes {', '.join(self.parameter_names)};"
                f" got {', '.join(sorted(values)) or 'none'}"
            )
        for p in self.parameters:
            if not p.lower <= values[p.name] <= p.upper:
                raise EffectError(
                    f"effect {self.name}: {p.name} is {values[p.name]:g},"
                    f" allowed {p.lower:g} to {p.upper:g} {p.unit}"
                )
        return np.array([float(values[n]) for n in self.parameter_names])
