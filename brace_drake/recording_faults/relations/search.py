"""Which fault of a run brings commands and readings together again.

Every hypothesis is undone and the law replayed, tens of milliseconds each; no
fit of a subject, an effect or a torso enters.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from brace_drake.recording.recording import Run
from brace_drake.recording_faults.library.channels import (
    moved_zero,
    reversed_sign,
    wrong_scale,
)
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
from brace_drake.recording_faults.relations.time_faults import (
    CLOCKS,
    TimeFault,
    delays,
)
from brace_drake.recording_faults.statistics import (
    has_signal,
    likeliest_lag,
)

# Delays that are tried, samples, before the best is refined.
_DELAYS = (1.0, 3.0, 8.0, 20.0, 50.0)
_LATEST = 200
# Replaying a law tells parts of a sample.
_FINER = 100.0
# Gauss-Newton steps over gain and zero, and the nudges of its differences.
_STEPS, _NUDGE = 4, 1e-4
_UNMOVED = np.array([1.0, 0.0])
# Part of the squares that a channel may leave by its slopes to be looked at,
# and how many channels are.
_PROMISING, _MOST = 0.7, 3
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
        period = float(np.median(np.diff(self._run.time_s)))
        late = delays(period, sorted({*_DELAYS, *self._lag()}))
        searches = (
            (self._affine, singles),
            (partial(self._in_time, late), late_groups),
            (partial(self._in_time, CLOCKS), late_groups),
        )
        for look, groups in searches:
            if any(t.mismatch.is_sound for t in tried):
                break
            names = groups(self._run, self._checker.law)
            tried += look([n for n in names if self._is_possible(n)])
        return sorted(tried, key=lambda t: t.mismatch.total)

    def _discrete(self) -> Iterator[Hypothesis]:
        yield from exchanges(self._run, self._checker.law)
        yield from permutations(self._run)
        for channels in singles(self._run, self._checker.law):
            yield Hypothesis(reversed_sign.CARD, channels, {"zero": 0.0})

    def try_one(self, hypothesis: Hypothesis) -> Tried | None:
        """A hypothesis undone; None where the law breaks down on it."""
        if not set(hypothesis.channels) <= set(self._run.channels):
            return None
        found = self._checker.judge(hypothesis.undone(self._run))
        return None if found is None else Tried(hypothesis, found)

    def _affine(self, groups: Sequence[tuple[str, ...]]) -> list[Tried]:
        """Gain and zero of the channels that could take most of it away.

        The law is linear in commands and force, and nearly so in lengths: one
        difference for each number says what its best value would leave.
        """
        now, promising = self._before, []
        for channels in groups:
            columns = [self._run.channels[n] for n in channels]
            middle = float(np.mean([c.mean() for c in columns]))
            size = float(np.mean([c.std() for c in columns]))
            slopes = self._slopes(channels, middle, size, _UNMOVED, now)
            if size <= 0.0 or slopes is None:
                continue
            step = np.linalg.lstsq(slopes, -now.weighted, rcond=None)[0]
            rest = now.weighted + slopes @ step
            left = float(rest @ rest) / float(now.weighted @ now.weighted)
            if left < _PROMISING:
                promising.append((left, channels, middle, size))
        found = []
        for _, channels, middle, size in sorted(promising)[:_MOST]:
            z = self._solve(channels, middle, size)
            found += self._named(channels, middle, size, z)
        return found

    def _replay(self, channels, middle, size, z) -> Mismatch | None:
        """The mismatch with true = middle + z_0 (recorded - middle) + z_1
        size.
        """
        columns = dict(self._run.channels)
        for n in channels:
            turned = z[0] * (columns[n] - middle) + z[1] * size
            columns[n] = middle + turned
        return self._checker.judge(replace(self._run, channels=columns))

    def _slopes(self, channels, middle, size, z, now) -> np.ndarray | None:
        """Changes of the weighted residual by z (rows, 2)."""
        nudged = [
            self._replay(channels, middle, size, z + _NUDGE * e)
            for e in np.eye(2)
        ]
        if any(n is None for n in nudged):
            return None
        return np.column_stack(
            [(n.weighted - now.weighted) / _NUDGE for n in nudged]
        )

    def _solve(self, channels, middle, size) -> np.ndarray:
        """Gauss-Newton over gain and zero."""
        z, now = _UNMOVED, self._before
        for _ in range(_STEPS):
            slopes = self._slopes(channels, middle, size, z, now)
            if slopes is None:
                break
            step = np.linalg.lstsq(slopes, -now.weighted, rcond=None)[0]
            then = self._replay(channels, middle, size, z + step)
            if then is None or then.total >= now.total:
                break
            gained, z, now = now.total - then.total, z + step, then
            if now.total < _GONE or gained < 1e-3 * now.total:
                break
        return z

    def _named(self, channels, middle, size, z) -> list[Tried]:
        """The faults that a gain and a zero stand for.

        True = gain * recorded + offset; with one number less each is fitted
        anew.
        """
        gain, zero = (float(v) for v in z)
        offset = middle - gain * middle + zero * size
        tried = []
        if abs(gain + 1.0) < _SIGN:
            card = reversed_sign.CARD
            values = [{"zero": 0.0}, {"zero": offset / 2.0}]
            tried += [
                self.try_one(Hypothesis(card, channels, v)) for v in values
            ]
        # Of noise alone no gain is known.
        whole = any(has_signal(self._run.channels[n]) for n in channels)
        if abs(gain - 1.0) < _SIGN or not whole:
            start = -zero * size
            card = moved_zero.CARD
            tried.append(self._refined(card, channels, "offset", start, size))
        if whole and abs(gain) > 1e-6 and abs(gain - 1.0) > _NONE:
            scale, card = 1.0 / gain, wrong_scale.CARD
            fixed = {"scale": scale, "zero": offset / (1.0 - gain)}
            tried.append(self.try_one(Hypothesis(card, channels, fixed)))
            start = middle / (gain * middle + offset) if offset else scale
            for at in {scale, start}:
                found = self._refined(card, channels, "scale", at, abs(at))
                tried.append(found)
        return [t for t in tried if t is not None]

    def _refined(self, card, channels, name, value, unit) -> Tried | None:
        """A fault of one number, that number by Gauss-Newton."""

        def at(value):
            values = (
                {"zero": 0.0, name: value} if name == "scale" else {name: value}
            )
            return self.try_one(Hypothesis(card, channels, values))

        now = at(value) if value else None
        for _ in range(_STEPS):
            if now is None or now.mismatch.total < _GONE:
                break
            nudge = _NUDGE * unit
            near = at(value + nudge)
            if near is None:
                break
            residual = now.mismatch.weighted
            slope = (near.mismatch.weighted - residual) / nudge
            power = float(slope @ slope)
            value -= float(slope @ residual) / power if power > 0.0 else 0.0
            then = at(value)
            if then is None or then.mismatch.total >= now.mismatch.total:
                break
            now = then
        return now

    def _in_time(
        self, fault: TimeFault, groups: Sequence[tuple[str, ...]]
    ) -> list[Tried]:
        """A fault of time in each group: a grid, then a search around the best
        of all.
        """
        tried = [
            (size, t)
            for channels in groups
            for size in fault.signed()
            for t in [self.try_one(fault.of(channels, size))]
            if t is not None
        ]
        tried.sort(key=lambda p: p[1].mismatch.total)
        near, seen = [], set()
        for size, t in tried:
            channels = t.hypothesis.channels
            gone = t.mismatch.total < 0.8 * self._before.total
            if channels in seen or len(seen) == _MOST or not gone:
                continue
            seen.add(channels)
            best = fault.refined(
                size,
                t,
                lambda s, names=channels: self.try_one(fault.of(names, s)),
                lambda t: t.mismatch.total,
                _FINER,
            )
            near.append(best)
        return near + [t for _, t in tried]

    def _lag(self) -> list[float]:
        """Samples by which recomputed outputs resemble the recorded best.

        The noise of the readings goes into the commands: it matches at one lag
        alone, which a grid would miss.
        """
        recorded = self._run.stack(self._checker.law.outputs)
        recomputed = recorded - self._checker.residual(self._run)
        lag = abs(likeliest_lag(recorded, recomputed))
        return [float(lag)] if 0 < lag <= _LATEST else []
