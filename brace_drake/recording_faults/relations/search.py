"""Which fault of a run brings commands and readings together again.

Every hypothesis is undone and the law replayed, tens of milliseconds each; no
fit of a subject, an effect or a torso enters.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.recording.recording import Run
from brace_drake.recording_faults.library.channels import (
    moved_zero,
    reversed_sign,
    wrong_scale,
)
from brace_drake.recording_faults.library.time import skewed_channel
from brace_drake.recording_faults.relations.hypotheses import (
    Hypothesis,
    exchanges,
    late_groups,
    permutations,
    singles,
)
from brace_drake.recording_faults.relations.mismatch import (
    LawChecker,
    Mismatch,
)

# Delays that are tried, samples, before the best is refined.
_DELAYS = (0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 13.0, 21.0, 34.0, 55.0)
# Gauss-Newton steps over gain and zero, and the nudges of its differences.
_STEPS, _NUDGE = 4, 1e-4
# A gain this near to -1 is a sign; so near to 1, none.
_SIGN, _NONE = 0.05, 0.003
# A search ends early once so much of the mismatch is gone.
_GONE = 1.05


@dataclass(frozen=True)
class Tried:
    """A hypothesis and the mismatch that it leaves."""

    hypothesis: Hypothesis
    mismatch: Mismatch


class FaultSearch:
    """Tries all faults on one run.

    Args:
        checker: Of its campaign.
        run: That does not follow the law.
        mismatch: By how much.
    """

    def __init__(self, checker: LawChecker, run: Run, mismatch: Mismatch):
        self._checker, self._run, self._before = checker, run, mismatch
        law = checker.law
        recorded = np.isfinite(mismatch.squares)
        well = recorded & ~(mismatch.squares > mismatch.threshold)
        # A fault of an output shows in itself. One of a reading shows in what
        # answers to it: in the virtual position, where that answers to one
        # reading alone, but of six commands some may be well by chance.
        self._acquitted = {
            n for n, w in zip(law.outputs, well, strict=True) if w
        }
        for is_well, names in zip(well, law.by_output, strict=True):
            if is_well and len(names) == 1:
                self._acquitted |= set(names)

    def _is_possible(self, channels: Sequence[str]) -> bool:
        """Whether a fault of channels could make this mismatch."""
        return not set(channels) <= self._acquitted

    def all(self) -> list[Tried]:
        """Hypotheses with what they leave, best first.

        Gains and delays are not tried once an exchange leaves noise alone.
        """
        tried = [
            t
            for h in self._discrete()
            if self._is_possible(h.channels)
            for t in [self.try_one(h)]
            if t is not None
        ]
        outputs = self._checker.law.outputs
        searches = (self._affine, singles), (self._late, late_groups)
        for look, groups in searches:
            if any(t.mismatch.is_sound for t in tried):
                break
            for channels in groups(self._run, outputs):
                if self._is_possible(channels):
                    tried += look(channels)
        return sorted(tried, key=lambda t: t.mismatch.total)

    def _discrete(self) -> Iterator[Hypothesis]:
        yield from exchanges(self._run, self._checker.law.outputs)
        yield from permutations(self._run)

    def try_one(self, hypothesis: Hypothesis) -> Tried | None:
        """A hypothesis undone; None where the law breaks down on it."""
        if not set(hypothesis.channels) <= set(self._run.channels):
            return None
        found = self._checker.judge(hypothesis.undone(self._run))
        return None if found is None else Tried(hypothesis, found)

    def _affine(self, channels: tuple[str, ...]) -> list[Tried]:
        """Gain and zero of channels, from either sign, by least squares."""
        columns = [self._run.channels[n] for n in channels]
        middle = float(np.mean([c.mean() for c in columns]))
        size = float(np.mean([c.std() for c in columns]))
        if size <= 0.0:
            return []
        found = []
        for sign in (1.0, -1.0):
            best = self._solve(channels, middle, size, np.array([sign, 0.0]))
            if best is not None:
                found += self._named(channels, middle, size, best)
        return found

    def _solve(self, channels, middle, size, z):
        """True = middle + z_0 (recorded - middle) + z_1 size."""

        def replay(z):
            columns = dict(self._run.channels)
            for n in channels:
                turned = z[0] * (columns[n] - middle) + z[1] * size
                columns[n] = middle + turned
            return self._checker.judge(replace(self._run, channels=columns))

        now = replay(z)
        if now is None:
            return None
        for _ in range(_STEPS):
            nudged = [replay(z + _NUDGE * e) for e in np.eye(2)]
            if any(n is None for n in nudged):
                break
            jacobian = np.column_stack(
                [(n.weighted - now.weighted) / _NUDGE for n in nudged]
            )
            step = np.linalg.lstsq(jacobian, -now.weighted, rcond=None)[0]
            then = replay(z + step)
            if then is None or then.total >= now.total:
                break
            gained, z = now.total - then.total, z + step
            now = then
            if now.total < _GONE or gained < 1e-3 * now.total:
                break
        return z, now

    def _named(self, channels, middle, size, best) -> list[Tried]:
        """The faults that a gain and a zero stand for, simplest first."""
        gain, zero = best[0]
        offset = middle - gain * middle + zero * size
        # True = gain * recorded + offset.
        options = []
        if abs(gain + 1.0) < _SIGN:
            options.append((reversed_sign.CARD, {"zero": 0.0}))
            options.append((reversed_sign.CARD, {"zero": offset / 2.0}))
        elif abs(gain - 1.0) < 10.0 * _NONE:
            options.append((moved_zero.CARD, {"offset": -offset}))
        if abs(gain) > 1e-6 and abs(gain - 1.0) > _NONE:
            scale = 1.0 / gain
            options.append((wrong_scale.CARD, {"scale": scale, "zero": 0.0}))
            fixed = offset / (1.0 - gain)
            values = {"scale": scale, "zero": fixed}
            options.append((wrong_scale.CARD, values))
        tried = [self.try_one(Hypothesis(c, channels, v)) for c, v in options]
        return [t for t in tried if t is not None]

    def _late(self, channels: tuple[str, ...]) -> list[Tried]:
        """Delays of channels: a grid, then a parabola through the best."""
        h = float(np.median(np.diff(self._run.time_s)))
        card = skewed_channel.CARD

        def at(samples):
            return self.try_one(
                Hypothesis(card, channels, {"delay_s": samples * h})
            )

        grid = [s * d for d in _DELAYS for s in (1.0, -1.0)]
        tried = [(d, at(d)) for d in grid]
        known = [(d, t) for d, t in tried if t is not None]
        if not known:
            return []
        best, found = min(known, key=lambda p: p[1].mismatch.total)
        if found.mismatch.total > 0.7 * self._before.total:
            return []
        width = 0.5 * abs(best)
        for _ in range(6):
            near = [(best + s * width, at(best + s * width)) for s in (-1, 1)]
            near = [(d, t) for d, t in near if t is not None]
            d, t = min(near, key=lambda p: p[1].mismatch.total)
            if t.mismatch.total < found.mismatch.total:
                best, found = d, t
            else:
                width *= 0.5
        return [found]
