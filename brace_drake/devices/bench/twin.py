"""The bench's twin as fits and diagnoses see it: values in, channels out."""

from __future__ import annotations

from typing import Self

import numpy as np

from brace_drake.devices.bench.rollout import (
    CHANNELS,
    Motion,
    draw_noise,
    simulate_bench,
    smooth_rounding,
)
from brace_drake.devices.bench.rollout_copies import (
    MachineRun,
    simulate_copies,
)
from brace_drake.devices.motions.reference import (
    COLUMNS,
    reference_at_ticks,
)
from brace_drake.devices.run_memory import RunMemory, key_of_run
from brace_drake.devices.subject import (
    bench_subject,
    scenario_of_subject,
    with_subject,
)
from brace_drake.devices.twin import ReplayTwin
from brace_drake.effects.stack import stack_effects
from brace_drake.laws.lanes.kinds import COUNT
from brace_drake.laws.numbers import BraceNumbers
from brace_drake.recording.recording import Run
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.brace_numbers import pack_bench

# Three plant steps in a control period: long enough to save a third of the
# cost, well inside the limit that the regularised friction sets (see
# `laws.contact`): mu N / v_s over the ring's mass.
_COARSE_STEP = 1e-3 / 3.0


# Longest time to settle, s: then the start is gone from the readings.
_SETTLE_S = 2.0


class BenchTwin(ReplayTwin):
    """Replays recorded references on the compiled bench."""

    channels: tuple[str, ...] = CHANNELS
    has_loop = True
    num_lanes = COUNT

    def __init__(self, scenario: BenchScenario, time_step: float | None = None):
        super().__init__(scenario, pack_bench(scenario), time_step)
        self.device = scenario.device
        self.subject = bench_subject(self.numbers)
        self._memory = RunMemory()

    def coarse(self) -> Self:
        """The same twin with the longest plant step that stays accurate."""
        return type(self)(self.scenario, max(self.time_step, _COARSE_STEP))

    def scenario_of(self, subject: np.ndarray) -> BenchScenario:
        """The scenario with a subject's numbers, a copy."""
        return scenario_of_subject(self.scenario, subject)

    def with_subject(self, values: np.ndarray) -> BraceNumbers:
        """The numbers of a subject, values in the order of `subject`."""
        return with_subject(self.numbers, values)

    def motion(self, run: Run) -> Motion:
        """The reference of a recorded run at control ticks."""
        samples = run.stack(COLUMNS)
        rate = self.scenario.control.rate
        desired, every, settled = settled_reference(run, samples, rate)
        return Motion(desired, run.contact, every, settled)

    @property
    def reading_steps(self) -> np.ndarray:
        """Of lengths and forces, m and N; see `smooth_rounding`."""
        length, force = self.numbers.resolution
        ends = {"_length_m": length}
        ends |= {f"_force_{a}_N": force for a in "xyz"}
        return np.array(
            [
                next((q for end, q in ends.items() if n.endswith(end)), 0.0)
                for n in self.channels
            ]
        )

    def active(self, run: Run) -> np.ndarray:
        """Which channels carry information in a run, bool (C,)."""
        names = np.array(self.channels)
        return run.contact | ~np.char.startswith(names, "torso")

    def simulate_each(self, requests):
        """Side by side, where nothing is known yet."""
        runs, keys, noises = [], [], {}
        for motion, subject, uses, seed in requests:
            numbers, every = self._machine(subject, uses)
            plug_ins = self._plug_ins(numbers, motion, every)
            if seed is None:
                noise, key = None, key_of_run(numbers, motion, plug_ins)
            else:
                numbers = smooth_rounding(numbers)
                of_run = (len(motion.desired), seed)
                if of_run not in noises:
                    generator = np.random.default_rng(seed)
                    noises[of_run] = draw_noise(
                        numbers, len(motion.desired), generator
                    )
                noise, key = noises[of_run], None
            runs.append(MachineRun(numbers, plug_ins, motion, noise))
            keys.append(key)
        return self._memory.recall_each(
            keys,
            lambda places: simulate_copies(
                [runs[i] for i in places], self.time_step
            ),
        )

    def _plug_ins(self, numbers, motion, uses):
        return stack_effects(uses, numbers)

    def _replay(self, numbers, motion, subject, uses, generator):
        """In closed loop; not writable where readings are exact."""
        plug_ins = self._plug_ins(numbers, motion, uses)

        def run(numbers, noise=None):
            return simulate_bench(
                numbers, motion, self.time_step, plug_ins, noise
            )

        if generator is not None:
            numbers = smooth_rounding(numbers)
            noise = draw_noise(numbers, len(motion.desired), generator)
            return run(numbers, noise)
        key = key_of_run(numbers, motion, plug_ins)
        return self._memory.recall(key, lambda: run(numbers))


def settled_reference(
    run: Run, samples: np.ndarray, rate: float
) -> tuple[np.ndarray, int, int]:
    """A reference at control ticks, held at its first place until what was
    switched on has settled.

    Args:
        run: The recording.
        samples: y, y', y'' at its samples (N, 3), or of C rings (N, 3, C).
        rate: Of the control, Hz.

    Returns:
        The reference (ticks, 3) or (ticks, 3, C), ticks in a sample, and how
        many it is held for.
    """
    times = run.time_s - run.time_s[0]
    every = round(np.median(np.diff(times)) * rate)
    desired = reference_at_ticks(times, samples, rate)
    settle_s = min(run.settled_s, _SETTLE_S)
    settled = every * round(settle_s * rate / every)
    held = np.zeros((settled, *desired.shape[1:]))
    held[:, 0] = desired[0, 0]
    return np.concatenate([held, desired]), every, settled
