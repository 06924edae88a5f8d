"""Replays that a twin remembers, by what they depend on.

A repeat asks for the motion of its original, and without the torso a run
depends on nothing that the torso and its contact have: about a third of the
replays of a fit were computed before. What is remembered is exact.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping, Sequence
from threading import Lock

import numpy as np

from brace_drake.devices.bench.rollout import Motion
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.laws.plug_in import PlugIn

# Points at which effects act where there is no torso.
_OF_THE_BRACE = ("drive", "ring", "sensing")
# Logs that are kept: 12 s at 200 Hz take a third of a megabyte each.
_MOST = 64


class RunMemory:
    """The last logs, by their keys. Threads may share one.

    It stays behind where a twin is sent to another process.
    """

    def __init__(self, most: int = _MOST):
        self._most = most
        self._logs: OrderedDict[Hashable, np.ndarray] = OrderedDict()
        self._lock = Lock()

    def __reduce__(self):
        return RunMemory, (self._most,)

    def recall(
        self, key: Hashable, compute: Callable[[], np.ndarray]
    ) -> np.ndarray:
        """The log of a key, computed where it is not known; not writable."""
        return self.recall_each([key], lambda _: [compute()])[0]

    def recall_each(
        self,
        keys: Sequence[Hashable | None],
        compute: Callable[[Sequence[int]], Sequence[np.ndarray | None]],
    ) -> list[np.ndarray | None]:
        """The logs of keys; those not known, each once, are computed at once
        from their places. None where there is none.

        What has None for a key is computed and not kept.
        """
        with self._lock:
            known = {k: self._logs[k] for k in keys if k in self._logs}
        named = [i if key is None else key for i, key in enumerate(keys)]
        places: dict[Hashable, int] = {}
        for place, name in enumerate(named):
            if name not in known:
                places.setdefault(name, place)
        logs = compute(list(places.values())) if places else []
        new = dict(zip(places, logs, strict=True))
        with self._lock:
            for key in known:
                if key in self._logs:
                    self._logs.move_to_end(key)
            for name, log in new.items():
                if log is not None and keys[places[name]] is not None:
                    log.flags.writeable = False
                    self._logs[name] = log
            while len(self._logs) > self._most:
                self._logs.popitem(last=False)
        found = known | new
        return [found[name] for name in named]


def key_of_run(
    numbers: BraceNumbers, motion: Motion, plug_ins: Mapping[str, PlugIn]
) -> Hashable:
    """All that the log of a run with exact readings depends on.

    Args:
        numbers: Of the twin.
        motion: The run.
        plug_ins: Effects, see `stack_effects`.
    """
    arrays = [
        numbers.lower,
        numbers.upper,
        numbers.rest,
        numbers.viscous,
        numbers.control,
        numbers.ring,
    ]
    points = _OF_THE_BRACE
    if motion.with_torso:
        arrays += [numbers.contact, numbers.posture, numbers.torso]
        points = tuple(plug_ins)
    laws = []
    for point in points:
        plug = plug_ins[point]
        for law, parameters, acts in zip(
            plug.laws, plug.parameters, plug.active, strict=True
        ):
            laws.append((law, parameters.tobytes()) if acts else None)
    return (
        motion.digest,
        motion.with_torso,
        motion.ticks_per_sample,
        motion.settled_ticks,
        tuple(a.tobytes() for a in arrays),
        tuple(laws),
    )
