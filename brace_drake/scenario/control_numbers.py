"""A controller's numbers as the stacks of rows that its law takes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from brace_drake.kinematics import BraceGeometry
from brace_drake.laws.control import brace_control, mraic
from brace_drake.laws.control.impedance import (
    low_pass_gain_cutoff,
    low_pass_gain_tau,
)
from brace_drake.scenario.controllers import TAGS, BraceControl

AXES = ("x", "y", "z")
# The law of each tag.
KINDS = {tag: getattr(brace_control, tag.upper()) for tag in TAGS}


@dataclass(frozen=True)
class BraceRings:
    """What a controller knows of the rings and legs that it drives.

    Attributes:
        geometry: Anchors and rings at rest, S stages.
        mass: Mass, kg, and principal moments, kg m^2, of each ring (S, 4).
        force_limit: Of each leg's command (6 S,), N.
        gravity: m/s^2.
        start: Task coordinates at time 0 (6 S,); None: at rest.
    """

    geometry: BraceGeometry
    mass: np.ndarray
    force_limit: np.ndarray
    gravity: float = 9.81
    start: np.ndarray | None = None

    @property
    def num_rings(self) -> int:
        return self.geometry.num_stages

    @property
    def task_mass(self) -> np.ndarray:
        """Diagonal of M (6 S,)."""
        return self.mass[:, [0, 0, 0, 1, 2, 3]].ravel()


@dataclass(frozen=True)
class ControlNumbers:
    """Arrays of one controller, see `laws.control.brace_control`.

    Attributes:
        kind: Of the law.
        period: Of its ticks, s.
        law: Rows (rows, 6n).
        pose: The estimator's memory at the start (20n,).
        memory: Other memory at the start (rows, 6n).
        virtual: X_v, X_v', X_v'' at the start (18n,): at rest where it is.
    """

    kind: int
    period: float
    law: np.ndarray
    pose: np.ndarray
    memory: np.ndarray
    virtual: np.ndarray


def pack_control(control: BraceControl, rings: BraceRings) -> ControlNumbers:
    """Arrays of the controller that the tag of checked numbers names."""
    kind, n = KINDS[control.tag], rings.num_rings
    shared = _shared_law(control, rings)
    own = np.zeros((brace_control.NUM_OWN_LAW[kind], 6 * n))
    memory = np.zeros((1 + brace_control.NUM_OWN_MEMORY[kind], 6 * n))
    if control.tag in _OWN_ROWS:
        _OWN_ROWS[control.tag](control, shared, own, memory[1:])
    start = np.zeros(6 * n) if rings.start is None else rings.start
    held = brace_control.start_held(start, rings.geometry.rest, memory)
    return ControlNumbers(
        kind=kind,
        period=1.0 / control.rate,
        law=np.vstack([shared, own]),
        pose=held[0],
        memory=memory,
        virtual=held[2],
    )


def parse_coordinates(names: list[str], num_rings: int) -> np.ndarray:
    """1 for each coordinate (6n,) that is named, as in "y" or "y2", else 0.

    Raises:
        ValueError: A name means none; the error holds it.
    """
    mask = np.zeros((num_rings, 6))
    for name in names:
        axis, ring = str(name)[:1], str(name)[1:]
        if axis not in AXES:
            raise ValueError(name)
        if not ring:
            mask[:, AXES.index(axis)] = 1.0
        elif ring.isdecimal() and 1 <= int(ring) <= num_rings:
            mask[int(ring) - 1, AXES.index(axis)] = 1.0
        else:
            raise ValueError(name)
    return mask.ravel()


def spread(values: np.ndarray, num_rings: int, per_ring: int = 6) -> np.ndarray:
    """Values of one ring, or of all, as (6n,).

    Args:
        values: (per_ring,) or (per_ring n,).
        num_rings: n.
        per_ring: 6, or 3 for the translations; rotations then get 0.
    """
    rows = np.array(values, dtype=float).reshape((-1, per_ring))
    rows = np.broadcast_to(rows, (num_rings, per_ring))
    return np.pad(rows, ((0, 0), (0, 6 - per_ring))).ravel()


def _shared_law(control: BraceControl, rings: BraceRings) -> np.ndarray:
    c, n, period = brace_control, rings.num_rings, 1.0 / control.rate
    law = np.zeros((c.NUM_SHARED_LAW, 6 * n))
    estimator = law[c.ESTIMATOR].reshape((n, 6))
    estimator[:, 0:3] = rings.geometry.rest
    estimator[:, 3:6] = (
        period,
        low_pass_gain_cutoff(control.estimation.velocity_cutoff_hz, period),
        low_pass_gain_tau(control.estimation.force_filter_tau, period),
    )
    impedance, inner = control.impedance, control.inner
    law[c.SELECTED] = parse_coordinates(impedance.coordinates, n)
    law[c.FED_FORWARD] = parse_coordinates(inner.force_feedforward, n)
    M, K = spread(impedance.mass, n, 3), spread(impedance.stiffness, n, 3)
    law[c.M_D], law[c.K_D] = M, K
    law[c.C_D] = 2.0 * impedance.damping_ratio * np.sqrt(M * K)
    law[c.K_P], law[c.K_V] = spread(inner.kp, n), spread(inner.kd, n)
    law[c.MASS] = rings.task_mass
    law[c.GRAVITY, 2::6] = rings.mass[:, 0] * rings.gravity
    law[c.LIMIT] = rings.force_limit
    law[c.LOWER : c.LOWER + 3] = rings.geometry.lower.reshape((3, 6 * n))
    law[c.UPPER : c.UPPER + 3] = rings.geometry.upper.reshape((3, 6 * n))
    return law


def _selected(shared: np.ndarray) -> np.ndarray:
    return shared[brace_control.SELECTED] != 0.0


def _fill_mraic(control: BraceControl, shared, own, memory) -> None:
    numbers, on = control.mraic, _selected(shared)
    wanted = shared[brace_control.M_D : brace_control.K_D + 1]
    M, C, K = wanted[:, on]
    # e and e - e_m at their scales change a parameter by itself at its rate.
    scale = M / (K * numbers.error_scale**2)
    own[0:3, on] = numbers.rates[:, None] * wanted[:, on] ** 2 * scale
    own[3:6] = numbers.lower[:, None] * wanted
    own[6:9] = numbers.upper[:, None] * wanted
    own[9:11, on] = mraic.lyapunov_gains(M, C, K, 2.0 * K / M, 2.0)
    own[11] = numbers.leak
    own[12] = 2.0 * math.pi * numbers.filter_hz
    memory[6:9] = wanted


def _fill_npic(control: BraceControl, shared, own, memory) -> None:
    numbers = control.npic
    own[0] = 2.0 * math.pi * numbers.filter_hz
    own[1] = numbers.forgetting
    own[2] = numbers.kappa
    own[3] = numbers.covariance_limit
    own[4] = numbers.excitation
    own[5:8] = numbers.lower[:, None]
    own[8:11] = numbers.upper[:, None]
    memory[4:7] = 1.0
    memory[7:10] = numbers.initial_covariance


def vpic_alpha(control: BraceControl, mass: np.ndarray) -> np.ndarray:
    """alpha of the stability condition for each desired mass, 1/s."""
    ratio, numbers = control.impedance.damping_ratio, control.vpic
    return numbers.alpha_share * 2.0 * ratio * np.sqrt(numbers.lower / mass)


def _fill_vpic(control: BraceControl, shared, own, memory) -> None:
    numbers, on = control.vpic, _selected(shared)
    M, K = shared[brace_control.M_D, on], shared[brace_control.K_D, on]
    own[0] = numbers.lower
    own[1] = numbers.upper
    own[2, on] = vpic_alpha(control, M)
    own[3] = control.impedance.damping_ratio
    # The rule settles at twice its rest where e stays at its scale.
    own[4, on] = K * numbers.forgetting
    own[4, on] /= numbers.slide * numbers.error_scale**2
    own[5] = numbers.slide
    own[6] = numbers.forgetting
    memory[0:2] = np.clip(shared[brace_control.K_D], own[0], own[1])


def _fill_pid(control: BraceControl, shared, own, memory) -> None:
    numbers, n = control.pid, shared.shape[1] // 6
    gains = numbers.kp, numbers.ki, numbers.kd, numbers.integral_limit
    own[0:4] = [spread(g, n) for g in gains]
    own[4] = parse_coordinates(numbers.force_coordinates, n)
    own[5] = spread(numbers.desired_force, n, 3)
    own[6] = numbers.force_kp
    own[7] = numbers.force_ki


_OWN_ROWS = {
    "mraic": _fill_mraic,
    "npic": _fill_npic,
    "vpic": _fill_vpic,
    "pid": _fill_pid,
}
