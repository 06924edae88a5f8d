"""What a device declares of itself: its twin, its blocks, its signals."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from brace_drake.devices.motions.library import MotionSet
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.recording.recording import Run

Residual = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class BlockTest:
    """A block fed its recorded inputs, against its recorded outputs.

    Attributes:
        block: Its name.
        given, found: What it is fed and what is compared, in words.
        residual: From (prepared run, recording (N, C)) to the residual (M,)
            as a function of the subject's values, or None where the run says
            nothing about it.
        needs: Channels without which a run says nothing about it.
        own: Names of the subject's parameters that are the block's.
    """

    block: str
    given: str
    found: str
    residual: Callable[[Any, np.ndarray], Residual | None]
    needs: tuple[str, ...] = ()
    own: tuple[str, ...] = ()


@dataclass(frozen=True)
class MotionSignals:
    """What phases of a motion are read from.

    Attributes:
        position: Reference along the motion (N,), m.
        force: Column of the measured force along it, N; None without.
        touching: Whether each pad touches (N, pads); None where not known.
        travel: What the force answers to (N,), m.
        travel_name: In words.
    """

    position: np.ndarray
    force: int | None
    touching: np.ndarray | None
    travel: np.ndarray
    travel_name: str


@dataclass(frozen=True)
class Nuisance:
    """One number of the twin that is known to a tolerance.

    Attributes:
        name: With its unit as the last part.
        unit: SI.
        block: That the number belongs to.
        deviation: Standard deviation of its normal prior around the number of
            the scenario, in its unit; above 0.
        uses: Effects that put it off by exactly one deviation, upwards.
        lower: Least that it can be off, in deviations; 0 where it only adds,
            and its prior is the upper half of the normal one.
    """

    name: str
    unit: str
    block: str
    deviation: float
    uses: tuple[Use, ...]
    lower: float = -math.inf

    @property
    def is_dithered(self) -> bool:
        """Whether noise dithers what it does, as dry friction."""
        return any(e.dithered for e, _ in self.uses)

    def is_of(self, effect: Effect) -> bool:
        """Whether an effect, or a special case or part of it, is this
        number.
        """
        names = {e.name for e, _ in self.uses}
        mine = {effect.name, *effect.generalises, *effect.contains}
        return bool(names & mine)


class ControlLaw(ABC):
    """What a device's controller computes of what is recorded.

    It holds in every sound recording, whatever the machine does.

    Attributes:
        outputs: Channels that the controller has computed.
        by_output: Readings that each of them answers to.
        is_exact: Whether its numbers are known beyond doubt, so that a run
            which does not follow it is wrong.
    """

    outputs: tuple[str, ...]
    by_output: tuple[tuple[str, ...], ...]
    is_exact: bool = True

    @abstractmethod
    def recompute(self, run: Run) -> np.ndarray:
        """The outputs (N, n) that follow from a run's other channels."""

    def refitted(self, run: Run) -> np.ndarray:
        """The outputs (N, n) of the nearest controller of this kind, its
        numbers fitted to a run where they are not exact.
        """
        return self.recompute(run)

    def rest_error(self, run: Run) -> np.ndarray:
        """What a run begins with less what the scenario's geometry has at
        rest, m; none where a device has no such lengths.
        """
        return np.zeros(0)


@dataclass(frozen=True)
class TorsoLaw:
    """Along a push F = m y'' + c y' + k y, with k of some subject.

    Attributes:
        force, marker: Channels of F and y.
        others: The marker's other axes.
        lower, upper: Limits of k, N/m.
    """

    force: str
    marker: str
    others: tuple[str, ...]
    lower: float
    upper: float


class Device(ABC):
    """A nominal twin and the views on its recordings.

    Attributes:
        twin: The nominal twin.
        rate: Of the recordings, Hz.
        block_tests: In the order of the signal.
        control_law: Of its controller; None where it has none that is known.
        torso_law: Of the torso that it pushes; None where there is none.
        words: Title and unit of each of its `quantities`.
        presses: Channels of a force that can press alone, and of the way that
            it answers to; None without them.
        takes_work: Channels of a force on a machine that nothing else drives,
            and of the way along it; None without them.
        takes_subjects: Whether another subject may be in some of the runs.
    """

    control_law: ControlLaw | None = None
    torso_law: TorsoLaw | None = None
    words: Mapping[str, tuple[str, str]] = MappingProxyType({})
    presses: tuple[str, str] | None = None
    takes_work: tuple[str, str] | None = None
    takes_subjects: bool = False

    def __init__(self, twin, rate: float, block_tests: Sequence[BlockTest]):
        self.twin, self.rate = twin, rate
        self.block_tests = list(block_tests)

    @abstractmethod
    def quantities(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """What users ask for, as series (N, n), of a recording (N, C)."""

    @abstractmethod
    def motion_signals(self, prepared, subject: np.ndarray) -> MotionSignals:
        """What phases of a prepared run's motion are read from."""

    @abstractmethod
    def motions(self, runs: Sequence[Run]) -> MotionSet | None:
        """Motions that the device may be asked for after recorded runs; None
        where none is known to be safe.
        """

    def uses_off(self, off: Mapping[str, float]) -> tuple[Use, ...]:
        """Effects of a machine whose numbers are off, in SI units by the names
        of `tolerances`.
        """
        return ()

    def draw_uses(self, seed: int) -> tuple[Use, ...]:
        """Effects of a machine that is drawn within its tolerances."""
        return ()

    def least_push(self, run: Run) -> tuple[str, float, np.ndarray] | None:
        """Channel of the force along a run's motion, the least range that any
        subject would give it, N, and the motion that is asked for (N,); None
        where a run asks for none.
        """
        return None

    def tolerances(self) -> list[Nuisance]:
        """Numbers that may be off by their tolerance without being a finding;
        none where they are fitted or exactly known.
        """
        return []
