"""What may have begun at an onset: effects ranked by what each would leave.

The search is that of a diagnosis (`selection.search`): each effect is replayed
once from each of its starts, from the onset on, linearised beside the subject's
parameters, and the best are followed a few steps. So is the score: what an
effect leaves, and a cost for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brace_drake.devices.since import OnsetMotion
from brace_drake.devices.twin import HIGHEST_HZ, ReplayTwin
from brace_drake.effects.card import Effect
from brace_drake.identification.evaluation import Evaluator, PreparedRun
from brace_drake.identification.fits import CandidateFit, finish_fit, search
from brace_drake.identification.noise_floor import NoiseFloor
from brace_drake.identification.problem import CandidateProblem
from brace_drake.recording.recording import Run
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.screening import screen, search_best

# So many are searched whatever is predicted: as many as are shown.
_PLACES = 3


@dataclass(frozen=True)
class NamedCause:
    """An effect that may have begun.

    Attributes:
        name, title: Of the effect.
        share: Of the amplitude of the difference that it explains, beside the
            subject's parameters.
        probability: Among all effects, each by its best form; an estimate of
            one motion, less than a diagnosis knows.
        values: Of its parameters, by name.
    """

    name: str
    title: str
    share: float
    probability: float
    values: dict[str, float]


def name_causes(
    twin: ReplayTwin,
    floor: NoiseFloor,
    motion: OnsetMotion,
    residual: np.ndarray,
    effects: Sequence[Effect],
    jobs: int = 1,
    seed: int = 0,
) -> list[NamedCause]:
    """Effects that may have begun at the onset, likeliest first.

    Args:
        twin: From `MakeTwinSince`.
        floor: Noise of the residual.
        motion: From rest to now, with the onset.
        residual: Machine less twin, from the onset on, by the twin's channels
            (N, C).
        effects: To try.
        jobs: Threads.
        seed: Of the noise by which some effects are dithered.

    Raises:
        BraceError: The twin breaks down.
    """
    rate = 1.0 / (motion.ticks_per_sample * twin.numbers.period)
    evaluator = Evaluator(
        twin, [_prepare(twin, floor, motion, residual, rate, seed)], jobs
    )
    usual = np.array([p.nominal for p in twin.subject])
    problem = CandidateProblem(evaluator, ())
    solution = search(problem, usual / problem.scales)
    nominal = finish_fit(problem, solution)
    lines = Linearisation(evaluator, nominal)
    few = [e for e in effects if not e.is_flexible]
    candidates = screen(lines, few)
    search_best(lines, candidates, places=_PLACES)
    criterion = Criterion(nominal, evaluator.count, evaluator.recorded)
    return rank_fits(criterion, [c.fit() for c in candidates])


def rank_fits(
    criterion: Criterion, fits: Sequence[CandidateFit]
) -> list[NamedCause]:
    """One cause for each effect, likeliest first.

    Probabilities are those of `selection`: odds of exp(ODDS x difference of
    scores).

    Args:
        criterion: With the fit of the subject alone.
        fits: Of single effects, in any of their forms.
    """
    best: dict[str, CandidateFit] = {}
    for fit in sorted(fits, key=criterion.score):
        best.setdefault(fit.effects[0].name, fit)
    if not best:
        return []
    scores = np.array([criterion.score(f) for f in best.values()])
    odds = np.exp(-thresholds.ODDS * (scores - scores.min()))
    found = []
    for fit, chance in zip(best.values(), odds / odds.sum(), strict=True):
        (effect,), (values,) = fit.effects, fit.values
        numbers = zip(effect.parameter_names, values.tolist(), strict=False)
        share = float(np.clip(criterion.closed(fit), 0.0, 1.0))
        found.append(
            NamedCause(
                effect.name, effect.title, share, float(chance), dict(numbers)
            )
        )
    return found


def _prepare(twin, floor, motion, residual, rate, seed) -> PreparedRun:
    """The run from the onset on: the nominal replay and the residual."""
    usual = np.array([p.nominal for p in twin.subject])
    measured = twin.simulate(motion, usual) + residual
    time = np.arange(len(measured)) / rate
    run = Run(
        "since.csv", motion.with_torso, "live", None, "fit", {"time_s": time}
    )
    weights = floor.weights(len(measured), rate, HIGHEST_HZ)
    weights = weights * twin.active(run)
    return PreparedRun(run, motion, measured, weights, floor, seed)
