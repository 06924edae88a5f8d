"""A bench, nominal or repaired, as a task to learn on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.learning.rewards import improved
from brace_drake.learning.subjects import EffectRange, SubjectRanges
from brace_drake.learning.task import LearningTask
from brace_drake.scenario.bench import BenchScenario, EffectUse
from brace_drake.scenario.bench_brace import brace_of_bench
from brace_drake.scenario.load import SaveScenario


def fix_effects(uses: list[EffectUse]) -> list[EffectRange]:
    """Effects of a scenario as those that every subject has, alike."""
    return [
        EffectRange(
            name=use.name,
            form=use.form,
            parameters={
                name: np.array([value, value])
                for name, value in use.parameters.items()
            },
        )
        for use in uses
    ]


def MakeBenchTask(
    bench: BenchScenario, file: Path, force_limit: float = 4.0
) -> LearningTask:
    """The paper's push on a bench, with the improved reward.

    Args:
        bench: With the effects that it carries.
        file: Where the brace that has its numbers is written.
        force_limit: F_max of the reward, N. The bench's wearer is stiffer than
            the paper's, and more than 4 N is on him from the start.
    """
    brace = brace_of_bench(bench)
    brace.control.tag = "vpic"
    SaveScenario(brace, file)
    reward = improved()
    limits = np.full(6, float(force_limit))
    return LearningTask(
        scenario=str(file),
        reward=replace(reward, force_limit=limits),
        readings="noisy",
        subjects=SubjectRanges(effects=fix_effects(bench.effects)),
    )
