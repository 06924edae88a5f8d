"""The bench, one stage of the brace on a torso, as diagnoses see it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from brace_drake.devices.bench.block_tests import FORCE_Y, MARKER_Y, bench_tests
from brace_drake.devices.bench.control_law import BenchControlLaw
from brace_drake.devices.bench.drawn import draw_tolerances, uses_of_draws
from brace_drake.devices.bench.recorded_motion import ring_poses
from brace_drake.devices.bench.rollout import FORCE, LENGTHS, MARKER
from brace_drake.devices.bench.tolerances import bench_tolerances
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.declaration import (
    Device,
    MotionSignals,
    Nuisance,
    TorsoLaw,
)
from brace_drake.devices.motions.library import (
    MOTIONS,
    RATE_HZ,
    MakeMotion,
    MotionSet,
)
from brace_drake.devices.motions.limits import exceeded_limit
from brace_drake.effects.stack import Use
from brace_drake.effects.within_tolerances import ANCHORS, NUMBERS
from brace_drake.laws.control.brace_control import K_D
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.brace import BenchScenario


class Bench(Device):
    """Device of bench campaigns."""

    words = MappingProxyType(
        {
            "force_error_N": ("Force on the torso", "N"),
            "ring_error_mm": ("Position of the ring", "mm"),
        }
    )

    takes_subjects = True

    def __init__(self, campaign: Campaign, scenario=None):
        twin = BenchTwin(scenario or BenchScenario())
        rate = campaign.rate_hz
        super().__init__(twin, rate, bench_tests(twin, rate))
        self.control_law = BenchControlLaw(twin, rate)
        self.torso_law = _torso_law(twin)

    def quantities(self, x: np.ndarray) -> dict[str, np.ndarray]:
        """What a therapist asks for: pad force, N, and ring position, mm."""
        poses, _ = ring_poses(self.twin.numbers, x[:, LENGTHS])
        ring = 1e3 * poses[:, 0:3]
        return {"force_error_N": x[:, FORCE], "ring_error_mm": ring}

    def motion_signals(self, prepared, subject: np.ndarray) -> MotionSignals:
        """Signals along the push; a pad has lost touch where the force of the
        other one alone, 2 k d_0 and more, is measured.
        """
        twin, x = self.twin, prepared.measured
        poses, _ = ring_poses(twin.numbers, x[:, LENGTHS])
        travel, name, touching = poses[:, 1], "ring", None
        if prepared.run.contact:
            if prepared.run.has([twin.channels[MARKER_Y]]).all():
                travel, name = travel - x[:, MARKER_Y], "ring against torso"
            names = [p.name for p in twin.subject]
            values = dict(zip(names, subject, strict=True))
            k, preload = values["contact_stiffness_N_m"], values["preload_m"]
            alone, force = 2.0 * k * preload, x[:, FORCE_Y]
            touching = np.column_stack([force > -alone, force < alone])
        desired = prepared.run.channels["ring2_y_desired_m"]
        return MotionSignals(desired, FORCE_Y, touching, travel, name)

    def least_push(self, run: Run) -> tuple[str, float, np.ndarray] | None:
        """Impedance, pads and posture in series, the softest of any subject."""
        asked = run.channels["ring2_y_desired_m"]
        least = {p.name: p.lower for p in self.twin.subject}
        pads = 2.0 * least["contact_stiffness_N_m"]
        posture = least["posture_stiffness_y_N_m"]
        impedance = self.twin.numbers.control[K_D, 1]
        soft = 1.0 / (1.0 / pads + 1.0 / posture + 1.0 / impedance)
        travel = float(np.ptp(asked))
        name = self.twin.channels[FORCE_Y]
        return (name, soft * travel, asked) if travel > 0.0 else None

    def motions(self, runs: Sequence[Run]) -> MotionSet:
        """The library's with and without the torso, as far as recorded."""
        recorded = {run.contact for run in runs}
        library = [MakeMotion(name) for name in MOTIONS]
        chosen = [m for m in library if m.contact in recorded]
        return MotionSet(RATE_HZ, chosen, exceeded_limit)

    def uses_off(self, off: Mapping[str, float]) -> tuple[Use, ...]:
        """All in one effect; what cannot be below its limit is at it."""
        names = (*NUMBERS, *ANCHORS.parameter_names)
        drawn = {name: off.get(name, 0.0) for name in names}
        for name, card in NUMBERS.items():
            least = card.parameters[0].lower
            drawn[name] = max(drawn[name], least)
        return uses_of_draws(self.twin.scenario, drawn)

    def draw_uses(self, seed: int) -> tuple[Use, ...]:
        """As `simulate --tolerances` draws it."""
        scenario = self.twin.scenario
        return uses_of_draws(scenario, draw_tolerances(scenario, seed))

    def tolerances(self) -> list[Nuisance]:
        """Of the numbers that its scenario states or assumes."""
        return bench_tolerances(self.twin.scenario)


def _torso_law(twin: BenchTwin) -> TorsoLaw:
    """Posture of any subject, between force and marker along the push."""
    (posture,) = (
        p for p in twin.subject if p.name == "posture_stiffness_y_N_m"
    )
    marker = twin.channels[MARKER_Y]
    others = tuple(n for n in twin.channels[MARKER] if n != marker)
    force = twin.channels[FORCE_Y]
    return TorsoLaw(force, marker, others, posture.lower, posture.upper)
