"""What may be wrong in a withheld case: each effect and its severities.

A fault turns a strength into numbers of the simulator. Its three strengths
(small, medium, large) put the gap at about 1, 5 and 30 noise floors for a
nominal subject, where physics allows; the truth of a case records how far it
really lies. A strength of `saturation` is a part of the largest command that
the bench sends while nothing is wrong.

Among machines that are off within tolerances no fault is small, and one on a
number with a tolerance lies far outside it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brace_drake.withheld.tolerances import FAR, TOLERANCES

SEVERITIES = ("small", "medium", "large")
Changes = dict[str, object]
# Strengths vary by so much from case to case, relative.
_VARIATION = 0.1


@dataclass(frozen=True)
class Fault:
    """One effect of the simulator.

    Attributes:
        name: Identifier of the effect.
        block: Where it lies.
        strengths: Small, medium, large; SI units.
        make: From a generator and a strength to changes of the flaws.
        tolerance: Standard deviation that machines have of what the strength
            measures, 0 for none.
    """

    name: str
    block: str
    strengths: tuple[float, float, float]
    make: Callable[[np.random.Generator, float], Changes]
    tolerance: float = 0.0

    def strength(self, place: int, tolerances: float) -> float:
        """The strength that a case's varies about.

        Args:
            place: Of the severity in SEVERITIES.
            tolerances: Multiple of them that the machines are off by.
        """
        least = FAR * self.tolerance * tolerances / (1.0 - _VARIATION)
        return max(self.strengths[place], least)


def severities(tolerances: float) -> tuple[str, ...]:
    """Those to draw from beside a multiple of the tolerances."""
    return SEVERITIES[1:] if tolerances > 0.0 else SEVERITIES


def vary(rng: np.random.Generator) -> float:
    """The variation of one case's strength, about 1."""
    return rng.uniform(1.0 - _VARIATION, 1.0 + _VARIATION)


def _plain(field: str):
    return lambda rng, s: {field: s}


def _either_sign(field: str):
    return lambda rng, s: {field: float(s * rng.choice([-1.0, 1.0]))}


def _stribeck(rng, s):
    return {
        "legs.coulomb": 0.4 * s,
        "legs.breakaway": s,
        "legs.stribeck_speed": rng.uniform(0.8e-3, 2.5e-3),
        "legs.stribeck_shape": rng.uniform(1.5, 2.0),
    }


def _one_leg(field, nominal, signs):
    def make(rng, s):
        values = np.full(6, nominal)
        values[rng.integers(6)] += s * rng.choice(signs)
        return {field: values.tolist()}

    return make


def _all_legs(rng, s):
    return {"legs.gain": [float(1.0 + s * rng.choice([-1.0, 1.0]))] * 6}


def _anchors(rng, s):
    return {
        "ring.lower": (s * rng.standard_normal((6, 3))).tolist(),
        "ring.upper": (s * rng.standard_normal((6, 3))).tolist(),
    }


def _relaxation(rng, s):
    time = float(np.exp(rng.uniform(np.log(0.3), np.log(2.5))))
    return {"pads.arm": s, "pads.arm_time": time}


def _hysteresis(rng, s):
    return {"pads.loop": s, "pads.loop_width": rng.uniform(2e-4, 5e-4)}


def _clearance(rng, s):
    return {"pads.gap": [s, s]}


def _breathing(rng, s):
    sides = rng.uniform(0.15, 0.45) * rng.choice([-1.0, 1.0])
    return {
        "torso.breath": s,
        "torso.breath_rate": rng.uniform(0.2, 0.32),
        "torso.breath_second": rng.uniform(0.1, 0.3),
        "torso.breath_phase": rng.uniform(0.0, 2.0 * np.pi),
        "torso.breath_sides": float(sides),
    }


def _reflex(rng, s):
    return {
        "torso.reflex_stiffness": s,
        "torso.reflex_damping": s * rng.uniform(0.03, 0.1),
        "torso.reflex_delay": rng.uniform(0.05, 0.15),
    }


def _posture_drift(rng, s):
    return {
        "torso.creep": float(s * rng.choice([-1.0, 1.0])),
        "torso.creep_time": rng.uniform(4.0, 12.0),
    }


def _delay(rng, s):
    return {"legs.delay": round(s)}


def _in_block(block: str, *rows) -> tuple[Fault, ...]:
    return tuple(Fault(name, block, *rest) for name, *rest in rows)


# Six legs stand out from gains off by less only where these are larger.
_GAIN = 0.03 / FAR
_OFF = TOLERANCES

FAULTS = (
    *_in_block(
        "actuation",
        (
            "coulomb_friction",
            (0.015, 0.08, 0.6),
            _plain("legs.coulomb"),
            _OFF.leg_friction,
        ),
        ("stribeck_friction", (0.015, 0.08, 0.6), _stribeck, _OFF.leg_friction),
        (
            "viscous_leg",
            (7.0, 30.0, 100.0),
            _plain("legs.viscous"),
            _OFF.leg_viscous,
        ),
        ("backlash", (6e-5, 2e-4, 6e-4), _plain("legs.play")),
        ("force_deadzone", (0.008, 0.05, 0.3), _plain("legs.deadzone")),
        ("command_delay", (3.0, 6.0, 10.0), _delay, _OFF.delay),
        (
            "weak_leg",
            (0.006, 0.03, 0.2),
            _one_leg("legs.gain", 1.0, [-1.0]),
            _GAIN,
        ),
        ("force_gain", (0.004, 0.02, 0.12), _all_legs, _GAIN),
        ("saturation", (0.985, 0.95, 0.85), _plain("legs.limit")),
    ),
    *_in_block(
        "mechanism",
        ("anchor_error", (5e-5, 3e-4, 2e-3), _anchors, _OFF.anchor),
        (
            "ring_mass",
            (0.004, 0.02, 0.15),
            _plain("ring.mass"),
            _OFF.ring_mass,
        ),
        ("leg_compliance", (3e-5, 8e-5, 1.6e-4), _plain("legs.compliance")),
    ),
    *_in_block(
        "contact",
        ("hardening", (3e8, 1e9, 3e9), _plain("pads.cubic")),
        ("relaxation", (600.0, 2000.0, 6000.0), _relaxation),
        ("hysteresis", (0.4, 1.2, 3.0), _hysteresis),
        ("clearance", (1e-4, 4e-4, 1.5e-3), _clearance),
        ("hunt_crossley", (80.0, 160.0, 320.0), _plain("pads.crossley")),
    ),
    *_in_block(
        "torso",
        ("breathing", (1e-4, 3e-4, 8e-4), _breathing),
        ("reflex", (150.0, 400.0, 800.0), _reflex),
        ("posture_drift", (1e-4, 5e-4, 2e-3), _posture_drift),
    ),
    *_in_block(
        "sensing",
        (
            "force_bias",
            (0.02, 0.1, 0.45),
            _either_sign("sensors.bias"),
            _OFF.force_bias,
        ),
        (
            "force_scale",
            (0.006, 0.03, 0.12),
            _either_sign("sensors.scale"),
            _OFF.force_scale,
        ),
        ("force_drift", (0.003, 0.015, 0.08), _either_sign("sensors.drift")),
        ("force_lag", (0.008, 0.025, 0.07), _plain("sensors.lag")),
        (
            "encoder_offset",
            (1.2e-4, 4e-4, 1.2e-3),
            _one_leg("sensors.lengths", 0.0, [-1.0, 1.0]),
            _OFF.anchor,
        ),
    ),
)


def _cable(rng, s):
    return {"ring.cable": s, "ring.cable_start": -rng.uniform(1e-3, 3e-3)}


def _stop(rng, s):
    return {"ring.stop": s, "ring.stop_start": -rng.uniform(4e-3, 6e-3)}


def _tremor(rng, s):
    direction = rng.standard_normal(3) * np.array([1.0, 0.5, 0.3])
    force = s * direction / np.linalg.norm(direction)
    return {"torso.tremor": force.tolist(), "torso.tremor_rate": 1.3}


def _lost(rng, s):
    return {"legs.hold_rate": s, "legs.hold_time": rng.uniform(0.02, 0.05)}


def _cogging(rng, s):
    return {"legs.cogging": s, "legs.pitch": rng.uniform(0.6e-3, 1.5e-3)}


def _tilt(rng, s):
    angle = rng.uniform(0.0, 2.0 * np.pi)
    return {"ring.tilt": [s * np.cos(angle), s * np.sin(angle)]}


_drag = _plain("legs.drag")
_crosstalk = _either_sign("sensors.crosstalk")

# Nothing of a diagnosis' library: there is a gap, and none of these names.
OUTSIDE = (
    Fault("x_cable_pull", "mechanism", (20.0, 120.0, 450.0), _cable),
    Fault("table_tilt", "mechanism", (0.005, 0.02, 0.08), _tilt),
    Fault("tremor", "torso", (0.1, 0.4, 2.0), _tremor),
    Fault("lost_commands", "actuation", (0.5, 2.0, 6.0), _lost),
    Fault("screw_cogging", "actuation", (0.015, 0.08, 0.5), _cogging),
    Fault("quadratic_drag", "actuation", (1e3, 4e3, 1.2e4), _drag),
    Fault("force_crosstalk", "sensing", (0.01, 0.04, 0.15), _crosstalk),
    Fault("soft_stop", "mechanism", (60.0, 400.0, 3000.0), _stop),
)
