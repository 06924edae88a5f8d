"""A bench, nominal or repaired, as a task to learn on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.learning.rewards import improved
from brace_drake.learning.subjects import EffectRange, SubjectRanges
from brace_drake.learning.task import LearningTask
from brace_drake.scenario.bench import BenchScenario, EffectUse
from brace_drake.scenario.brace import (
    BraceJoints,
    BraceLeg,
    BraceRing,
    BraceScenario,
    RingContacts,
    StageJoints,
)
from brace_drake.scenario.controllers import (
    BraceControl,
    Estimation,
    InnerLoop,
    TargetImpedance,
)
from brace_drake.scenario.load import SaveScenario


def brace_of_bench(bench: BenchScenario) -> BraceScenario:
    """Stage 2 of a brace with the numbers of a bench, PIC along y.

    Its effects are not among them: they are of the task, see `MakeBenchTask`.
    """
    stage, control = bench.stage, bench.control
    heights = BraceScenario().ring_heights.copy()
    heights[1:3] = stage.lower_height, stage.upper_height
    heights[3] = max(heights[3], stage.upper_height + 0.01)
    ratio = control.desired_damping / (
        2.0 * np.sqrt(control.desired_mass * control.desired_stiffness)
    )
    joints = BraceJoints(stage2=StageJoints(stage.lower, stage.upper))
    return BraceScenario(
        stages=[2],
        time_step=bench.time_step,
        gravity=bench.gravity,
        ring_heights=heights,
        joints=joints,
        ring=BraceRing(mass=bench.ring.mass, inertia=bench.ring.inertia),
        leg=BraceLeg(
            viscous=bench.leg.viscous, force_limit=bench.leg.force_limit
        ),
        torso=bench.torso,
        contact=RingContacts(ring2=bench.contact),
        control=BraceControl(
            tag="vpic",
            rate=control.rate,
            estimation=Estimation(
                control.velocity_cutoff_hz, control.force_filter_tau
            ),
            inner=InnerLoop(
                kp=np.full(6, control.kp), kd=np.full(6, control.kd)
            ),
            impedance=TargetImpedance(
                coordinates=["y"],
                mass=np.full(3, control.desired_mass),
                stiffness=np.full(3, control.desired_stiffness),
                damping_ratio=float(ratio),
            ),
        ),
        sensors=bench.sensors,
    )


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
    SaveScenario(brace_of_bench(bench), file)
    reward = improved()
    limits = np.full(6, float(force_limit))
    return LearningTask(
        scenario=str(file),
        reward=replace(reward, force_limit=limits),
        readings="noisy",
        subjects=SubjectRanges(effects=fix_effects(bench.effects)),
    )
