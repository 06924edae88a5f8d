"""Scaled parameters of subject and effects, and the residual of them."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy

import numpy as np

from brace_drake.devices.replays import without_dither
from brace_drake.devices.stretch import variance_over
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import Evaluator

_SUBJECT_STEP, _SUBJECT_RADIUS = 1e-3, 0.3
_EFFECT_STEP, _EFFECT_RADIUS = 1e-2, 5.0
# Shapes, such as a time constant, and what has a prior move less at a time.
_SHAPE_RADIUS = 0.5
# Where drives stick, a recording answers small changes by fits and starts:
# differences are taken over longer ways, and to both sides.
_ROUGH = 10.0
# So many tolerances are little for drives that stick.
_LITTLE = 4.0
# Spread at which a search over many alike parameters begins.
_FIRST_SPREAD = 2.0


class CandidateProblem:
    """Scaled parameters z of a candidate explanation.

    z holds the subject's parameters in units of their nominal values, then
    each effect's in units of its starts or limits: the continuous ones, then
    its run parameters run by run. A normal prior, of parameters with a
    deviation of their own or with a common spread, adds a row (z_i - m_i) /
    s_i to the residual.

    Attributes:
        num_subject, num_free: Parameters of the subject, and beyond.
        fixed: Places of those of the subject that are held.
        alike: Which parameters have a common spread (n,).
        has_spread: Whether any has.
        is_rough: Whether noise dithers an effect.
        sticks_little: Whether all that it dithers is within tolerances.
        groups: Places of parameters that are differenced at once.
        num_prior: Rows that the prior adds.
        left: Variance of what is left along alike parameters.
        tolerances: Of numbers that the effects do not stand for.
        off: Effects that put those numbers to where they are linearised.

    Args:
        evaluator: Over the fit runs.
        effects: None for the nominal twin.
        values: Parameters of each effect; what is not continuous stays so.
        spread: Standard deviation of parameters that have a common one, where
            it is known; of no account where none has.
    """

    def __init__(
        self,
        evaluator: Evaluator,
        effects: Sequence[Effect],
        values: Sequence[np.ndarray] = (),
        spread: float | None = None,
    ):
        self.evaluator = evaluator
        self.effects = tuple(effects)
        self.is_rough = evaluator.twin.has_loop and any(
            e.dithered for e in effects
        )
        self.tolerances = evaluator.tolerances
        self.off: tuple[Use, ...] = ()
        if self.tolerances is not None:
            self.tolerances = self.tolerances.beside(effects)
            number = len(self.tolerances.uses) + len(effects)
            has_room = number <= evaluator.room
            # Where nothing sticks numbers do not bend, and noise is no dither.
            if not (has_room and self.is_rough):
                self.tolerances = self.tolerances.at_zero
            self.off = self.tolerances.uses
        self._templates, self._moved = [np.array(v, float) for v in values], []
        subject = evaluator.twin.subject
        self.num_subject = len(subject)
        self.fixed = frozenset(i for i, p in enumerate(subject) if p.is_fixed)
        low, high = [p.lower for p in subject], [p.upper for p in subject]
        radius = [_SUBJECT_RADIUS] * len(subject)
        units = [p.unit_step for p in subject]
        known = [(p.nominal, p.deviation) for p in subject]
        groups = [[i] for i in range(len(subject))]
        for effect in effects:
            parameters = self._continuous(effect, groups)
            for p in parameters:
                scale = p.deviation or p.typical
                units.append(scale)
                low.append(p.lower)
                high.append(p.upper)
                known.append((0.0, p.deviation or 0.0))
                radius.append(
                    _SHAPE_RADIUS if p.off is None else _EFFECT_RADIUS
                )
        self.scales = np.array(units)
        self.lower = np.array(low) / self.scales
        self.upper = np.array(high) / self.scales
        means, deviations = np.array(known).reshape(-1, 2).T / self.scales
        self._means, self._weights = means, np.zeros(len(means))
        np.divide(1.0, deviations, self._weights, where=deviations > 0.0)
        self.radius = np.array(radius)
        self.steps = np.full(len(units), _EFFECT_STEP)
        self.steps[: self.num_subject] = _SUBJECT_STEP
        if self.is_rough:
            self.steps *= _ROUGH
        self.groups = groups
        self.num_free = len(units) - self.num_subject
        self.alike = np.zeros(len(units), dtype=bool)
        at = self.num_subject
        for effect, moved in zip(self.effects, self._moved, strict=True):
            if effect.spread is not None:
                self.alike[at : at + len(moved)] = True
            at += len(moved)
        self.has_spread = bool(self.alike.any())
        self.left = 1.0
        self.spread = _FIRST_SPREAD
        if spread is not None and self.has_spread:
            self.spread = spread / self.spread_scale
        self.num_prior = int(np.count_nonzero(self._weights))
        self.sticks_little = self.is_rough and all(
            self._is_little(e, v)
            for e, v in zip(self.effects, self._templates, strict=True)
            if e.dithered
        )

    def _is_little(self, effect: Effect, values: np.ndarray) -> bool:
        """Whether an effect is a number about within its tolerance."""
        known = self.evaluator.tolerances
        numbers = (known.whole or known).nuisances if known else ()
        mine = [n.deviation for n in numbers if n.is_of(effect)]
        strength = values[: len(effect.parameters)][effect.is_strength]
        if not mine or effect.contains:
            return False
        return bool(np.max(strength) <= _LITTLE * max(mine))

    def _continuous(self, effect: Effect, groups: list) -> list:
        """Continuous parameters; notes their places and column groups."""
        runs = len(self.evaluator.prepared)
        moved = np.flatnonzero(effect.is_continuous)
        own = len(effect.run_parameters)
        shared = len(effect.parameters)
        at = groups[-1][-1] + 1
        groups += [[at + i] for i in range(len(moved))]
        at += len(moved)
        groups += [[at + r * own + j for r in range(runs)] for j in range(own)]
        places = np.arange(shared, shared + runs * own)
        self._moved.append(np.concatenate([moved, places]).astype(int))
        return [
            *(effect.parameters[i] for i in moved),
            *list(effect.run_parameters) * runs,
        ]

    def with_numbers(self, off: np.ndarray) -> CandidateProblem:
        """The same with numbers known to a tolerance put off (k,)."""
        other, known = copy(self), self.tolerances.at(off)
        other.tolerances, other.off = known, known.uses
        return other

    def beside_noise(self, noise: float) -> CandidateProblem:
        """The same with those numbers weighed beside another variance."""
        other = copy(self)
        other.tolerances = self.tolerances.beside_noise(noise)
        return other

    @property
    def spread(self) -> float:
        """Scaled standard deviation of alike parameters."""
        return self._spread

    @spread.setter
    def spread(self, value: float) -> None:
        self._spread = value
        self._weights[self.alike] = np.sqrt(self.left) / value

    def weigh_alike(self, excess: float = 0.0) -> None:
        """Weighs the prior of alike parameters beside squares that a fit
        leaves above noise: what the twin has not is not theirs.
        """
        if self.has_spread:
            number = np.count_nonzero(self.alike)
            self.left = variance_over(excess, number)
            self.spread = self._spread

    def is_rough_at(self, place: int) -> bool:
        """Whether noise dithers the effect that a parameter is of."""
        at = self.num_subject
        for effect, moved in zip(self.effects, self._moved, strict=True):
            if at <= place < at + len(moved):
                return effect.dithered
            at += len(moved)
        return False

    def places_in_run(self, effect: Effect, run: int) -> np.ndarray:
        """Places in z of an effect's run parameters of one run."""
        own, at = len(effect.run_parameters), self.num_subject
        for other, moved in zip(self.effects, self._moved, strict=True):
            if other is effect:
                first = at + int(effect.is_continuous.sum()) + run * own
                return np.arange(first, first + own)
            at += len(moved)
        raise ValueError(f"{effect.key} is not part of this candidate")

    @property
    def spread_scale(self) -> float:
        """Scale of the parameters with a common spread."""
        return float(self.scales[self.alike][0])

    def split(self, z: np.ndarray) -> tuple[np.ndarray, tuple[Use, ...]]:
        """Subject values and effect uses of scaled parameters."""
        values = z * self.scales
        uses, at = [], self.num_subject
        for effect, template, moved in zip(
            self.effects, self._templates, self._moved, strict=True
        ):
            full = np.zeros(
                max(len(template), 1 + moved.max() if len(moved) else 0)
            )
            full[: len(template)] = template
            full[moved] = values[at : at + len(moved)]
            uses.append((effect, full))
            at += len(moved)
        return values[: self.num_subject], tuple(uses)

    def join(
        self, subject: np.ndarray, values: Sequence[np.ndarray]
    ) -> np.ndarray:
        """Scaled parameters of values; run parameters not given are 0."""
        parts = [subject]
        for given, moved in zip(values, self._moved, strict=True):
            full = np.zeros(max(len(given), int(moved.max()) + 1))
            full[: len(given)] = given
            parts.append(full[moved])
        z = np.concatenate(parts) / self.scales
        return np.clip(z, self.lower, self.upper)

    def prior_rows(self, z: np.ndarray) -> np.ndarray:
        """The prior's rows of the residual."""
        used = self._weights > 0.0
        return (z - self._means)[used] * self._weights[used]

    def prior_jacobian(self) -> np.ndarray:
        """Derivatives of the prior's rows (num_prior, n)."""
        return np.diag(self._weights)[self._weights > 0.0]

    def batch(
        self,
        points: Sequence[np.ndarray],
        coarse: bool = False,
        fine: bool = False,
        smooth: bool = False,
        white: bool = True,
    ) -> list[np.ndarray | None]:
        """Weighted residuals of all runs at several points at once, with the
        prior's rows below; None where the twin broke down.

        Args:
            points: Scaled parameters.
            coarse, fine: See `Evaluator.weighted_residuals`.
            smooth: Without the effects that noise dithers.
            white: Whether they are whitened of tolerances.
        """
        evaluator = self.evaluator
        step = "coarse" if coarse else "fine" if fine else ""
        split = []
        for z in points:
            subject, uses = self.split(z)
            uses = (
                without_dither(uses, self.off) if smooth else (*uses, *self.off)
            )
            split.append((subject, uses))
        evaluator.replays += len(points)
        found = evaluator.weighted_residuals(split, step)
        if self.tolerances is not None and white:
            went = [rows for rows in found if rows is not None]
            self.tolerances.whiten_in_place(went)
            del went
        for i, z in enumerate(points):
            if found[i] is not None and self.num_prior:
                found[i] = np.append(found[i], self.prior_rows(z))
        return found

    def whitened(self, rows: np.ndarray) -> np.ndarray:
        """Rows of all runs whitened of tolerances; the prior's as they are."""
        if self.tolerances is None:
            return rows
        n = self.evaluator.ends[-1]
        return np.concatenate([self.tolerances.whiten(rows[:n]), rows[n:]])

    def coloured(self, rows: np.ndarray) -> np.ndarray:
        """The inverse of `whitened`."""
        if self.tolerances is None:
            return rows
        n = self.evaluator.ends[-1]
        return np.concatenate([self.tolerances.colour(rows[:n]), rows[n:]])
