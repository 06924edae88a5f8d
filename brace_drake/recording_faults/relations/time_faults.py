"""Channels that are off in time by one number: a delay, or a clock's rate."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import TypeVar

from brace_drake.recording_faults.card import RecordingFault
from brace_drake.recording_faults.library.time import (
    own_clock,
    skewed_channel,
)
from brace_drake.recording_faults.relations.hypotheses import Hypothesis

# Rates of a clock that are tried, and to what they are refined: a crystal is
# better, a clock of the operating system at times worse.
_RATES, _FINEST_RATE = (0.001, 0.003, 0.01, 0.03), 1e-4
# How far beyond the largest that was tried a refined size may go.
_BEYOND = 2.0

T = TypeVar("T")


@dataclass(frozen=True)
class TimeFault:
    """A fault of one number that moves channels in time.

    Attributes:
        fault: Its card.
        parameter: Name of the number.
        sizes: To try, of either sign.
        finest: Step to which it is refined.
    """

    fault: RecordingFault
    parameter: str
    sizes: tuple[float, ...]
    finest: float

    def of(self, channels: tuple[str, ...], size: float) -> Hypothesis:
        """The fault in channels."""
        return Hypothesis(self.fault, channels, {self.parameter: size})

    def signed(self) -> Iterator[float]:
        """Sizes of both signs."""
        for size in self.sizes:
            yield size
            yield -size

    def refined(
        self,
        size: float,
        found: T,
        look: Callable[[float], T | None],
        left: Callable[[T], float],
        parts: float = 1.0,
    ) -> T:
        """What is found with a size near one that leaves least, a multiple of
        the finest step.

        Steps go to both sides, and are halved where neither is better.

        Args:
            size, found: Where it begins, and what was found there.
            look: What is found with a size; None where nothing is.
            left: Of it, to be least.
            parts: Of the finest step that are looked at.
        """
        unit = self.finest / parts
        most = _BEYOND * max(self.sizes) / unit
        place = round(size / unit)
        known: dict[int, T | None] = {place: found}
        step = max(1, abs(place) // 2)
        while step:
            for near in (place - step, place + step):
                if near not in known and abs(near) <= most:
                    known[near] = look(near * unit)
            able = {n: t for n, t in known.items() if t is not None}
            best = min(able, key=lambda n: left(able[n]))
            if best == place:
                step //= 2
            place = best
        return able[place]


def delays(period: float, samples: Sequence[float]) -> TimeFault:
    """Delays by so many samples."""
    sizes = tuple(period * n for n in samples)
    return TimeFault(skewed_channel.CARD, "delay_s", sizes, period)


CLOCKS = TimeFault(own_clock.CARD, "rate", _RATES, _FINEST_RATE)


def refined_best(
    faults: Iterable[TimeFault],
    tried: Sequence[tuple[float, Hypothesis]],
    left: Callable[[Hypothesis], float | None],
) -> list[tuple[float, Hypothesis]]:
    """The best of each fault of time, refined, with what it leaves.

    Args:
        faults: Kinds of them.
        tried: Faults of any kind, with what they leave.
        left: Of one more; None where nothing can be said.
    """
    found = []
    for fault in faults:
        own = [t for t in tried if t[1].fault is fault.fault]
        best = min(own, key=itemgetter(0), default=None)
        if best is None:
            continue
        channels = best[1].channels

        def look(size: float, fault=fault, channels=channels):
            near = fault.of(channels, size)
            value = left(near)
            return None if value is None else (value, near)

        size = best[1].parameters[fault.parameter]
        found.append(fault.refined(size, best, look, itemgetter(0)))
    return found


def size_text(parameters: Mapping[str, float]) -> str:
    """How far channels are off in time, with what parts it from the next words;
    empty for other faults.
    """
    if "delay_s" in parameters:
        late = 1e3 * parameters["delay_s"]
        return f"{abs(late):.3g} ms {'late' if late > 0.0 else 'early'}; "
    if "rate" in parameters:
        rate = 100.0 * parameters["rate"]
        ahead = "ahead of" if rate > 0.0 else "behind"
        return f"{abs(rate):.2g} % {ahead} the others; "
    return ""
