"""The bench is the brace with stage 2 alone, ring 1 clamped."""

from __future__ import annotations

import numpy as np

from brace_drake.scenario.bench import BenchScenario
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


def brace_of_bench(bench: BenchScenario) -> BraceScenario:
    """Stage 2 of a brace with the numbers of a bench, PIC along y.

    Its effects are not among them.
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
            tag="pic",
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
