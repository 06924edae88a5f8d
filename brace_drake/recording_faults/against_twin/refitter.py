"""The twin fitted anew to runs as they would have been without a fault."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from brace_drake.devices.declaration import Device
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.identification.prepare import prepare_runs
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.against_twin.alike import moves_alike
from brace_drake.recording_faults.against_twin.misfit import (
    SubjectFit,
    fit_subject_to,
    make_evaluator,
    misfit_of,
)
from brace_drake.recording_faults.against_twin.subjects import TIMES
from brace_drake.recording_faults.against_twin.undone import (
    Suspect,
    is_usable,
)

# No misfit is told from less, in noise variances.
LEAST = 0.05
# Squares of noise beyond which a run shows something.
_SHOWN = 10.0
# Trust in a sample's motion from which on its difference tells a zero.
_KNOWN = 0.5


class Readings(NamedTuple):
    """What accused runs read beside what the twin of other runs expects.

    Attributes:
        gain: Recorded over expected, in all that is compared.
        off: Recorded less expected by channel, of each run (N,).
    """

    gain: float
    off: Mapping[str, tuple[np.ndarray, ...]]


def _as_known(off: np.ndarray, trust: np.ndarray | float) -> np.ndarray:
    """Differences (N, C) as they are where the motion is known, by straight
    lines where it is not; `trust` (N, 1), or a number.
    """
    weight = np.broadcast_to(trust, (len(off), 1))[:, 0]
    (at,) = np.nonzero(weight > _KNOWN)
    if not len(at):
        return off
    rows = np.arange(len(off))
    known = off[at] / weight[at, None]
    return np.column_stack([np.interp(rows, at, c) for c in known.T])


class Refitter:
    """Fits the subject of a device to runs as they would have been.

    Args:
        device: Of the runs.
        sound: Runs that are taken as they are.
        accused: Runs in which a fault is sought.
        subject: To start from.
        uses: Effects that are there, held.
        jobs: As of `Evaluator`.
    """

    def __init__(
        self,
        device: Device,
        sound: Sequence[PreparedRun],
        accused: Sequence[PreparedRun],
        subject: np.ndarray,
        uses: Sequence[Use],
        jobs,
    ):
        self.sound, self.accused = tuple(sound), tuple(accused)
        self._device, self.jobs = device, jobs
        self._subject, self._uses = subject, uses
        recorded = {n for p in accused for n in p.run.channels}
        self.channels = device.twin.channels
        self.names = [n for n in device.twin.channels if n in recorded]

    def misfit(self, suspect: Suspect | None = None) -> float:
        """Mean square beyond noise, in noise variances; inf where nothing is
        left to be fitted.
        """
        accused = self.accused if suspect is None else self.undone(suspect)
        fit = self.fit((*self.sound, *accused)) if accused else None
        return np.inf if fit is None else fit.misfit

    def undone(self, suspect: Suspect) -> tuple[PreparedRun, ...]:
        """The accused runs with a fault undone; none where nothing is left."""
        runs = [suspect.hypothesis.undone(p.run) for p in self.accused]
        if not all(map(is_usable, runs)):
            return ()
        pairs = zip(self.accused, runs, strict=True)
        return tuple(self._prepared(p, run) for p, run in pairs)

    def shows(self, suspect: Suspect) -> bool:
        """Whether a scale, undone, leaves more than noise of what is compared:
        of next to nothing any twin would be right.
        """
        if "scale" not in suspect.hypothesis.parameters:
            return True
        powers = [
            np.mean(p.weigh(p.measured - p.measured.mean(axis=0)) ** 2)
            for p in self.undone(suspect)
        ]
        return max(powers, default=0.0) > _SHOWN

    def fit(self, runs: Sequence[PreparedRun]) -> SubjectFit | None:
        """The subject of some runs; None where the twin breaks down."""
        runs = [replace(p, index=i) for i, p in enumerate(runs)]
        evaluator = make_evaluator(
            self._device, runs, self._subject, self._uses, self.jobs
        )
        return fit_subject_to(evaluator, self._subject, self._uses)

    def _prepared(self, prepared: PreparedRun, run: Run) -> PreparedRun:
        (found,) = prepare_runs(
            self._device.twin,
            [run],
            {run.contact: prepared.floor},
            self._device.rate,
            prepared.seed,
        )
        return found

    @property
    def share(self) -> float:
        """Part of the accused runs in all that is compared."""
        mine = sum(p.count for p in self.accused)
        return mine / (mine + sum(p.count for p in self.sound))

    @cached_property
    def level(self) -> float:
        """Misfit that the other runs leave by themselves, at least `LEAST`; inf
        where the twin breaks down.
        """
        fit = self._of_sound
        return np.inf if fit is None else max(LEAST, fit.misfit)

    def apart(self) -> float | None:
        """Misfit of all runs, with a subject of its own in the accused ones;
        None where the twin breaks down.
        """
        one, other = self._of_sound, self.fit(self.accused)
        if one is None or other is None:
            return None
        return one.misfit + self.share * (other.misfit - one.misfit)

    def has_witness(self, new: Sequence[PreparedRun] = ()) -> bool:
        """Whether a run that moves as an accused one does is like the others:
        one of them, or one of these that their twin fits.
        """

        def way(prepared):
            motion = self._device.motion_signals(prepared, self._subject)
            return motion.position

        accused = [way(p) for p in self.accused]
        return any(
            any(moves_alike(way(p), w) for w in accused)
            and self._of_sound is not None
            and self._left_by(self._of_sound, p) < TIMES * self.level
            for p in (*self.sound, *new)
        )

    @cached_property
    def _of_sound(self) -> SubjectFit | None:
        """The subject of the other runs; None where the twin breaks down."""
        return self.fit(self.sound)

    def _left_by(self, fit: SubjectFit, prepared: PreparedRun) -> float:
        """Misfit of one run beside the subject of others."""
        one = make_evaluator(
            self._device, [prepared], fit.subject, self._uses, self.jobs
        )
        found = misfit_of(one, fit.subject, self._uses)
        return np.inf if found is None else found

    def left_in(self, files: Container[str]) -> float:
        """Misfit of those of the accused runs in some files, in the mean, with
        one subject in all runs; inf where the twin breaks down.
        """
        fit = self.fit((*self.sound, *self.accused))
        if fit is None:
            return np.inf
        few = [p for p in self.accused if p.run.file in files]
        return float(np.mean([self._left_by(fit, p) for p in few]))

    def readings(self) -> Readings | None:
        """Those of the accused runs beside the twin of the others; None where
        that breaks down.
        """
        fit = self._of_sound
        if fit is None:
            return None
        twin = self._device.twin
        recorded, expected, off = [], [], []
        for p in self.accused:
            x = fit.evaluator.simulate(p, fit.subject, self._uses)
            recorded.append(p.weigh(p.measured))
            expected.append(p.weigh(x))
            off.append(_as_known(p.measured - x, twin.trust(p.motion)))
        x, y = np.concatenate(expected), np.concatenate(recorded)
        gain = float(x @ y / (x @ x)) if x @ x > 0.0 else 1.0
        columns = zip(*(o.T for o in off), strict=True)
        return Readings(gain, dict(zip(self.channels, columns, strict=True)))
