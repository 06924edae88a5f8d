"""A bench scenario as the number arrays that the laws take."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brace_drake.kinematics import BraceGeometry, holding_leg_forces
from brace_drake.laws.control.brace_control import ESTIMATOR, LOWER, UPPER
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import (
    BraceNumbers,
    pack_brace,
    pack_contact,
    pack_rings,
)
from brace_drake.scenario.control_numbers import ControlNumbers, pack_control


@dataclass(frozen=True)
class BenchNumbers:
    """Arrays of the bench; the plant's may differ from the controller's.

    Attributes:
        rest: Position of Ro and To in W at rest (3,), m.
        p_WB, p_RT: Anchors of the plant (6, 3), m.
        viscous: Of each leg (6,), N s/m.
        contact: Stiffness, damping, friction, regularisation speed, pad
            offset, preload (6,).
        posture: K (3), D (3), K_r (3), D_r (3): (12,).
        ring, torso: Mass, moments (3), weight (5,).
        control: What the controller counts with: the shared rows of
            `laws.brace_control`, anchors and masses among them (17, 6).
        resolution: Of lengths, m, and forces, N (2,).
        noise_sigma: Of lengths (6), force (3), marker (3): (12,).
    """

    rest: np.ndarray
    p_WB: np.ndarray
    p_RT: np.ndarray
    viscous: np.ndarray
    contact: np.ndarray
    posture: np.ndarray
    ring: np.ndarray
    torso: np.ndarray
    control: np.ndarray
    resolution: np.ndarray
    noise_sigma: np.ndarray

    @property
    def period(self) -> float:
        """Of a control tick, s."""
        return float(self.control[ESTIMATOR, 3])

    @property
    def p_WB_known(self) -> np.ndarray:
        """Lower anchors as the controller knows them (6, 3), m."""
        return self.control[LOWER : LOWER + 3].reshape((6, 3))

    @property
    def p_RT_known(self) -> np.ndarray:
        """Upper anchors as the controller knows them (6, 3), m."""
        return self.control[UPPER : UPPER + 3].reshape((6, 3))

    @property
    def controller_law(self) -> np.ndarray:
        """The controller's numbers as one vector (102,)."""
        return self.control.ravel()

    @property
    def holding_forces(self) -> np.ndarray:
        """Forces of the legs, where they are, that hold the ring (6,), N."""
        return _hold(self, self.p_WB, self.p_RT)

    def with_changes(self, **arrays: np.ndarray) -> BenchNumbers:
        """A copy with some arrays replaced."""
        return replace(self, **arrays)


def pack_bench(scenario: BraceScenario) -> BenchNumbers:
    """Arrays of the nominal twin that a scenario describes.

    They are those of the brace of one stage that the bench is.

    Raises:
        KinematicsError: Legs without length, or a stage singular at rest.
    """
    numbers, torso = pack_brace(scenario), scenario.torso
    control = pack_control(scenario.control, pack_rings(scenario)).law
    return BenchNumbers(
        rest=numbers.geometry.rest[0],
        p_WB=numbers.geometry.lower[0],
        p_RT=numbers.geometry.upper[0],
        viscous=numbers.viscous,
        # The compiled twin knows the linear law alone, whatever the model.
        contact=pack_contact(scenario.contacts[0]),
        posture=numbers.posture,
        ring=numbers.ring,
        torso=np.array([torso.mass, *torso.inertia, 0.0]),
        control=control,
        resolution=numbers.resolution,
        noise_sigma=numbers.noise_sigma,
    )


def pack_bench_brace(brace: BraceScenario, bench: BenchNumbers) -> BraceNumbers:
    """Arrays of the brace that a bench is, with the bench's, maybe changed.

    Args:
        brace: A bench.
        bench: Of the same scenario; effects and subjects may have changed it.
    """
    numbers = pack_brace(brace)
    is_linear = brace.contacts[0].model == "linear"
    return replace(
        numbers,
        geometry=BraceGeometry(
            bench.p_WB[None], bench.p_RT[None], bench.rest[None]
        ),
        torso_rest=bench.rest,
        viscous=bench.viscous,
        # Else it is the plant that resolves the contact.
        contact=bench.contact[None] if is_linear else numbers.contact,
        posture=bench.posture,
        ring=bench.ring,
        resolution=bench.resolution,
        noise_sigma=bench.noise_sigma,
    )


def pack_bench_control(
    brace: BraceScenario, bench: BenchNumbers
) -> ControlNumbers:
    """Arrays of the bench's controller, arguments as above."""
    control = pack_control(brace.control, pack_rings(brace))
    return replace(control, law=bench.control)


def hold_forces(numbers: BenchNumbers) -> tuple[float, ...]:
    """Leg forces that carry the ring's weight at rest (6,), N.

    As the controller knows the anchors.
    """
    return tuple(
        _hold(numbers, numbers.p_WB_known, numbers.p_RT_known).tolist()
    )


def _hold(numbers, p_WB: np.ndarray, p_RT: np.ndarray) -> np.ndarray:
    geometry = BraceGeometry(p_WB[None], p_RT[None], numbers.rest[None])
    return holding_leg_forces(geometry, [numbers.ring[4]])
