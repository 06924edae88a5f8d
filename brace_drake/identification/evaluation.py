"""Weighted residuals of a twin over runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from brace_drake.core.cosine_transform import to_frequency
from brace_drake.core.errors import BraceError
from brace_drake.core.parallel import Workers, open_workers
from brace_drake.core.parallel.together import ask, together
from brace_drake.devices.replay_tasks import group_runs, share_out
from brace_drake.devices.replays import (
    is_dithered,
    replay,
    replay_each,
    uses_in_run,
)
from brace_drake.devices.tolerances import LinearTolerances
from brace_drake.devices.twin import Request
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.identification.noise_floor import NoiseFloor
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.recording.recording import Run

# Noisy replays averaged for effects on which noise acts as a dither: in a
# comparison that counts, and in one that only ranks.
NUM_DITHERS = 3
_FEW_DITHERS = 1


@dataclass(frozen=True)
class PreparedRun:
    """A run ready for comparison.

    Attributes:
        run: The recording.
        motion: What the twin takes of it.
        measured: Recorded channels (N, C).
        weights: Of the transform up to the highest frequency that counts,
            see `NoiseFloor.weights`; 0 where a channel carries no information.
        floor: Noise floor of this kind of run.
        seed: Of the dithers.
        index: Place among the runs of its evaluator.
        used: Channels that carry information (C,).
        count: Length of what `weigh` returns, and expectation of the noise's
            squares.
    """

    run: Run
    motion: object
    measured: np.ndarray
    weights: np.ndarray
    floor: NoiseFloor
    seed: int
    index: int = 0
    used: np.ndarray = field(init=False)
    count: int = field(init=False)

    def __post_init__(self):
        used = self.weights[1] > 0.0
        size = len(self.weights) * int(used.sum())
        vars(self).update({"used": used, "count": size})

    def weigh(self, residual: np.ndarray) -> np.ndarray:
        """Residual (N, C) as a vector of unit variance for pure noise."""
        transform = to_frequency(residual)[: len(self.weights)]
        return (transform * self.weights)[:, self.used].ravel()


def _residual_of(prepared: PreparedRun, replay: np.ndarray) -> np.ndarray:
    return prepared.weigh(prepared.measured - replay)


class Evaluator:
    """Evaluates a twin on runs, in parallel threads or on a cluster.

    The compiled rollout releases the interpreter lock, so that threads scale
    with cores and share one compiled twin. Results do not depend on their
    number.

    Attributes:
        replays: How many points were evaluated: what a search has cost, the
            same on any machine.
        count: Number of independent values over all runs.
        recorded: Share of the channels that carry information that was
            recorded.
        ends: Where each run's rows of the weighted residual end.
        map: Results of `function(*task)` in order, from (function, tasks).
        tolerances: What numbers within their tolerances change; None where
            all are exact.
    """

    tolerances: LinearTolerances | None = None

    def __init__(
        self,
        twin,
        prepared: Sequence[PreparedRun],
        jobs: int | Workers,
        effects: Sequence[Effect] | None = None,
    ):
        """Takes a twin, runs, workers, and effects to try; None: all."""
        self.twin = twin
        self._effects = effects
        self._twins = {"": twin, "coarse": twin.coarse(), "fine": twin.finer()}
        self.prepared, self.jobs = list(prepared), jobs
        self.replays = 0
        self.count = sum(p.count for p in self.prepared)
        active = sum(twin.active(p.run).sum() for p in self.prepared)
        used = sum(p.used.sum() for p in self.prepared)
        self.recorded = float(used / active) if active else 1.0
        sizes = [p.count for p in self.prepared]
        self.ends = [int(n) for n in np.cumsum(sizes)]
        self.map = open_workers(jobs).map
        self._alike = group_runs(self.prepared)

    @property
    def effects(self) -> list[Effect]:
        """Those that a search may try."""
        if self._effects is None:
            return list(self.twin.effects().values())
        return list(self._effects)

    @property
    def room(self) -> int:
        """How many effects the twin can have beside those it carries."""
        return MAX_EFFECTS - len(self.twin.carried)

    def simulate(
        self,
        prepared: PreparedRun,
        subject: np.ndarray,
        uses: Sequence[Use],
        twin=None,
        dithers: int = NUM_DITHERS,
    ) -> np.ndarray:
        """The twin's expected recording of a run (N, C)."""
        twin, uses = twin or self.twin, uses_in_run(uses, prepared.index)
        noisy = dithers if is_dithered(twin, uses) else 0
        return replay(
            twin, prepared.motion, prepared.seed, subject, uses, noisy
        )

    def weighted_residuals(
        self,
        points: Sequence[tuple[np.ndarray, Sequence[Use]]],
        step: str = "",
    ) -> list[np.ndarray | None]:
        """Weighted residuals of all runs at each point; None where the twin
        broke down.

        Args:
            points: Subject and uses of each.
            step: "coarse" takes the longer plant step of `twin.coarse()` and
                fewer dithers, for differences between points and first
                rankings; "fine" half the plant step; "" the twin's own.
        """
        return ask((points, step), self._answer)

    def together(self, searches: Sequence[Callable[[], Any]]) -> list[Any]:
        """Results of functions that ask for residuals, side by side."""
        return together(searches, self._answer)

    def _answer(self, questions):
        """Weighted residuals at the points of several questions."""
        answers = {}
        for step in dict.fromkeys(step for _, step in questions):
            dithers = _FEW_DITHERS if step == "coarse" else NUM_DITHERS
            mine = [i for i, (_, own) in enumerate(questions) if own == step]
            points = [p for i in mine for p in questions[i][0]]
            noisy = [
                dithers if is_dithered(self.twin, uses) else 0
                for _, uses in points
            ]
            found = self._of_all_runs(_residual_of, points, noisy, step)
            for i in mine:
                size = len(questions[i][0])
                answers[i], found = found[:size], found[size:]
        return [answers[i] for i in range(len(questions))]

    def changes(
        self,
        subject: np.ndarray,
        before: Sequence[Use],
        after: Sequence[Sequence[Use]],
    ) -> list[np.ndarray]:
        """What each of several sets of effects changes of the weighted
        residual, against another set.

        At the coarse plant step; where noise acts as a dither both replays take
        the same noise.

        Raises:
            BraceError: The twin breaks down.
        """
        noisy = [
            _FEW_DITHERS if is_dithered(self.twin, uses) else 0
            for uses in after
        ]
        kinds = sorted(set(noisy))
        points = [(subject, uses) for uses in [before] * len(kinds) + [*after]]

        found = self._of_all_runs(
            PreparedRun.weigh, points, [*kinds, *noisy], "coarse"
        )
        if any(x is None for x in found):
            raise BraceError("the twin breaks down with further effects")
        known = dict(zip(kinds, found, strict=False))
        return [
            np.subtract(known[kind], x, out=x)
            for kind, x in zip(noisy, found[len(kinds) :], strict=True)
        ]

    def _of_all_runs(self, weigh, points, noisy, step):
        """What `weigh` makes of a run and its replay at each point, run after
        run; None at points where one broke down.

        Points go side by side, a few in a task; runs of one motion follow each
        other, as a twin may remember what they have in common.
        """
        order = sorted(range(len(points)), key=lambda k: noisy[k])
        places = share_out(order, self._alike, self.twin.num_lanes)
        tasks = [
            (
                weigh,
                step,
                runs,
                [points[k] for k in own],
                [noisy[k] for k in own],
            )
            for runs, own in places
        ]
        found = {}
        for (runs, own), parts in zip(
            places, self.map(self._replay_few, tasks), strict=True
        ):
            for i, of_run in zip(runs, parts, strict=True):
                found |= {(i, k): x for k, x in zip(own, of_run, strict=True)}
        out = []
        for k in range(len(points)):
            parts = [found.pop((i, k)) for i in range(len(self.prepared))]
            broke = any(x is None for x in parts)
            out.append(None if broke else np.concatenate(parts))
        return out

    def _replay_few(self, weigh, step, runs, points, noisy):
        """What `weigh` makes of a few points of some runs, run by run."""
        mine = [self.prepared[i] for i in runs]
        requests = [
            Request(p.motion, s, uses_in_run(u, p.index), (p.seed,))
            for p in mine
            for s, u in points
        ]
        twin = self._twins[step]
        replays = replay_each(twin, requests, list(noisy) * len(mine))
        weighed = [
            None if x is None else weigh(mine[i // len(points)], x)
            for i, x in enumerate(replays)
        ]
        size = len(points)
        return [weighed[i : i + size] for i in range(0, len(weighed), size)]

    def excess(
        self, rows: np.ndarray, uses: Sequence[Use], coarse: bool = False
    ) -> float:
        """Squares above noise of the weighted residual of all runs (rows,)."""
        return float(rows @ rows) - self.noise_level(uses, coarse) * self.count

    def noise_level(self, uses: Sequence[Use], coarse: bool = False) -> float:
        """Expected square of a weighted residual of noise alone.

        1, and what averaging over few dithers leaves of theirs.
        """
        if not is_dithered(self.twin, uses):
            return 1.0
        return 1.0 + 1.0 / (_FEW_DITHERS if coarse else NUM_DITHERS)
