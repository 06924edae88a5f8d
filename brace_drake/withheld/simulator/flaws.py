"""What can be wrong with the bench: every number at its default is harmless."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Tuples, not arrays: compiled code passes them on without counting references.
Six = tuple[float, ...]
Anchors = tuple[Six, ...]
_NO_SHIFT = ((0.0, 0.0, 0.0),) * 6


class LegFlaws(NamedTuple):
    """Of the drives, alike in all legs unless they are (6,)."""

    coulomb: float = 0.0  # N, sliding friction
    breakaway: float = 0.0  # N above it at standstill
    stribeck_speed: float = 1e-3  # m/s
    stribeck_shape: float = 2.0  # exponent of the speed ratio
    viscous: float = 0.0  # N s/m above the data sheet
    drag: float = 0.0  # N s^2/m^2
    cogging: float = 0.0  # N
    pitch: float = 1e-3  # m
    compliance: float = 0.0  # m/N between drive and ring
    play: float = 0.0  # m, whole width
    delay: int = 0  # ticks
    deadzone: float = 0.0  # N
    limit: float = 120.0  # N
    hold_rate: float = 0.0  # 1/s, bursts of lost commands per leg
    hold_time: float = 0.0  # s, mean length of a burst
    gain: Six = (1.0,) * 6  # delivered part of the command


class RingFlaws(NamedTuple):
    """Of the mechanism around the moving ring."""

    mass: float = 0.0  # kg more
    leg_mass: float = 0.0  # kg that each leg moves along itself
    cable: float = 0.0  # N/m
    cable_start: float = 0.0  # m of y beyond which the cable is tight
    stop: float = 0.0  # N/m of a soft stop
    stop_start: float = -0.005  # m of y beyond which the ring touches it
    tilt: tuple[float, float] = (0.0, 0.0)  # rad, of gravity about y and x
    lower: Anchors = _NO_SHIFT  # m, anchors displaced in W
    upper: Anchors = _NO_SHIFT  # m, likewise in the ring


class PadFlaws(NamedTuple):
    """Of the contact between pads and torso."""

    cubic: float = 0.0  # N/m^3
    arm: float = 0.0  # N/m, Maxwell arm
    arm_time: float = 1.0  # s
    loop: float = 0.0  # N, Bouc-Wen part
    loop_width: float = 3e-4  # m
    gap: tuple[float, float] = (-1.0, -1.0)  # m, instead of preload where >= 0
    crossley: float = -1.0  # s/m, replaces the damper where >= 0


class TorsoFlaws(NamedTuple):
    """Of the subject, beyond what a subject's numbers hold."""

    breath: float = 0.0  # m of chest expansion
    breath_rate: float = 0.25  # Hz
    breath_second: float = 0.2  # part of the second harmonic
    breath_phase: float = 0.4  # rad, of the second harmonic
    breath_sides: float = 0.25  # difference between the sides
    reflex_stiffness: float = 0.0  # N/m
    reflex_damping: float = 0.0  # N s/m
    reflex_delay: float = 0.1  # s
    creep: float = 0.0  # m, posture's final shift along y
    creep_time: float = 6.0  # s
    tremor: tuple[float, float, float] = (0.0, 0.0, 0.0)  # N
    tremor_rate: float = 1.3  # Hz


class SensorFlaws(NamedTuple):
    """Of the instruments."""

    bias: float = 0.0  # N on the y reading
    scale: float = 0.0  # gain error of all force readings
    drift: float = 0.0  # N/s on the y reading
    lag: float = 0.0  # s, of the force sensor
    crosstalk: float = 0.0  # part of y that shows on x and z
    colour: float = 0.0  # coefficient of the noise's first-order memory
    lengths: Six = (0.0,) * 6  # m, constant offsets


class Flaws(NamedTuple):
    """All flaws of one campaign."""

    legs: LegFlaws = LegFlaws()
    ring: RingFlaws = RingFlaws()
    pads: PadFlaws = PadFlaws()
    torso: TorsoFlaws = TorsoFlaws()
    sensors: SensorFlaws = SensorFlaws()


def with_flaws(flaws: Flaws, changes: dict[str, object]) -> Flaws:
    """A copy with changes like {"legs.coulomb": 1.0}; lists become tuples."""
    for name, value in changes.items():
        part, field = name.split(".")
        old = getattr(flaws, part)
        if isinstance(value, list | np.ndarray):
            value = _as_tuples(np.asarray(value, dtype=float).tolist())
        else:
            value = type(getattr(old, field))(value)
        flaws = flaws._replace(**{part: old._replace(**{field: value})})
    return flaws


def _as_tuples(values):
    if isinstance(values, list):
        return tuple(_as_tuples(v) for v in values)
    return values
