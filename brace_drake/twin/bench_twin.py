"""The bench's twin as fits and diagnoses see it: values in, channels out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.campaign.recording import Run
from brace_drake.effects.stack import Use, modify_numbers, stack_effects
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.bench_numbers import pack_bench
from brace_drake.scenario.effects import scenario_uses
from brace_drake.twin.bench_rollout import (
    CHANNELS,
    Motion,
    draw_noise,
    simulate_bench,
)
from brace_drake.twin.reference import reference_at_ticks, reference_of_run
from brace_drake.twin.run_memory import RunMemory, key_of_run
from brace_drake.twin.subject import (
    bench_subject,
    scenario_of_subject,
    with_subject,
)

# Three plant steps in a control period: long enough to save a third of the
# cost, well inside the limit that the regularised friction sets (see
# `laws.contact`): mu N / v_s over the ring's mass.
_COARSE_STEP = 1e-3 / 3.0


# Longest time to settle, s: then the start is gone from the readings.
_SETTLE_S = 2.0


class BenchTwin:
    """Replays recorded references on the compiled bench.

    Attributes:
        channels: Names of the columns of what `simulate` returns.
        subject: Parameters to be estimated for every subject.
        carried: Effects of the scenario, always on.
        has_loop: Whether readings, with their noise, feed back to the motion.
        instruments_known: Whether noise and numbers are given by a data
            sheet, not taken from the recording itself.
    """

    channels = CHANNELS
    instruments_known = True
    has_loop = True

    def __init__(self, scenario: BenchScenario, time_step: float | None = None):
        self.scenario = scenario
        self.device = scenario.device
        self.time_step = time_step or scenario.time_step
        self.numbers = pack_bench(scenario)
        self.subject = bench_subject(self.numbers)
        self.carried = scenario_uses(scenario)
        self._memory = RunMemory()

    def coarse(self) -> BenchTwin:
        """The same twin with the longest plant step that stays accurate."""
        return BenchTwin(self.scenario, max(self.time_step, _COARSE_STEP))

    def finer(self) -> BenchTwin:
        """The same twin with half the plant step."""
        return BenchTwin(self.scenario, self.time_step / 2.0)

    def scenario_of(self, subject: np.ndarray) -> BenchScenario:
        """The scenario with a subject's numbers, a copy."""
        return scenario_of_subject(self.scenario, subject)

    def motion(self, run: Run) -> Motion:
        """The reference of a recorded run at control ticks."""
        times, samples = reference_of_run(run)
        rate = self.scenario.control.rate
        every = round(np.median(np.diff(times)) * rate)
        desired = reference_at_ticks(times, samples, rate)
        # Held at its first place, until what was switched on has settled.
        settle_s = min(run.settled_s, _SETTLE_S)
        settled = every * round(settle_s * rate / every)
        held = np.zeros((settled, 3))
        held[:, 0] = desired[0, 0]
        desired = np.vstack([held, desired])
        return Motion(desired, run.contact, every, settled)

    def measured(self, run: Run) -> np.ndarray:
        """The run's recorded channels, shape (N, C)."""
        return run.stack(self.channels)

    def active(self, run: Run) -> np.ndarray:
        """Which channels carry information in a run, bool (C,)."""
        names = np.array(self.channels)
        return run.contact | ~np.char.startswith(names, "torso")

    def simulate(
        self,
        motion: Motion,
        subject: np.ndarray,
        uses: Sequence[Use] = (),
        generator: np.random.Generator | None = None,
    ) -> np.ndarray:
        """Closed-loop replay, shape (N, C), not writable where it is exact.

        Args:
            motion: From `motion`.
            subject: Values of the subject's parameters.
            uses: Effects with their parameters, beside the carried ones.
            generator: Draws the reading noise; None: exact readings.

        Raises:
            BraceError: The simulated run broke down.
        """
        uses = (*self.carried, *uses)
        numbers = with_subject(self.numbers, subject)
        numbers = modify_numbers(numbers, uses)
        plug_ins = stack_effects(uses, numbers)

        def run(noise=None):
            return simulate_bench(
                numbers, motion, self.time_step, plug_ins, noise
            )

        if generator is not None:
            return run(draw_noise(numbers, len(motion.desired), generator))
        return self._memory.recall(key_of_run(numbers, motion, plug_ins), run)
