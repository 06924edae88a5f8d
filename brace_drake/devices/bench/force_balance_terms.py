"""Errors of drives, ring and force reading in the balance of the leg forces.

Each error is a shape of unknown size along the recorded way: a force that the
drives (N, 6), a force or moment that the ring (through the legs), or an error
that the reading adds. What the balance lacks is compared with them.
"""

from __future__ import annotations

import numpy as np

from brace_drake.devices.bench.ring_way import RingWay, slope
from brace_drake.devices.declaration import Term
from brace_drake.laws.loop.disturbance import LEG_SPEED, PRESLIDING

# Slower than this the ring's sign is not yet one, m/s.
_RING_SPEED = 1e-3
# Between places from which on a force may begin, m.
_PLACES = 7.5e-4
_AXES = "xyz"
_FORCE_UNITS = "N", "N/m", "N s/m"
_MOMENT_UNITS = "N m", "N m/rad", "N m s/rad"
_Y = 1


def drive_terms(way: RingWay) -> list[Term]:
    """Forces that drives add to their command, from their own signals."""
    u, rate = way.commands, way.leg_rates
    terms = [
        Term("gain of the drives", "1", u),
        Term("gain that grows with the force", "1/N", u * np.abs(u)),
        Term("force lost or added by direction", "N", np.tanh(u)),
        Term("lag of the drives", "s", -slope(u, way.rate)),
        Term("damping of the drives", "N s/m", -rate),
        Term("quadratic drag of the drives", "N s2/m2", -rate * np.abs(rate)),
        Term("dry friction of the drives", "N", -np.tanh(rate / LEG_SPEED)),
        Term(
            "dry friction of the drives with presliding",
            "N",
            -_presliding(rate / way.rate),
        ),
        Term("springs along the legs", "N/m", way.lengths[0] - way.lengths),
    ]
    for k in range(u.shape[1]):
        alone = np.zeros_like(u)
        alone[:, k] = u[:, k]
        terms.append(Term(f"gain of leg {k + 1}", "1", alone))
    return terms


def ring_terms(way: RingWay, gravity: float) -> list[Term]:
    """Forces and moments on the ring from its place and motion.

    Args:
        way: From `follow_ring`.
        gravity: m/s2.
    """
    p, v = way.poses, way.velocities
    moved, one = p - p[0], np.ones(len(p))
    terms = [_added_mass(way, gravity)]
    for i in range(6):
        kind = "force" if i < 3 else "moment"
        axis = f"{'along' if i < 3 else 'about'} {_AXES[i % 3]}"
        units = _FORCE_UNITS if i < 3 else _MOMENT_UNITS
        for title, unit, size in (
            (f"constant {kind} {axis}", units[0], one),
            (f"{kind} of a spring {axis}", units[1], -moved[:, i]),
            (f"{kind} of a damper {axis}", units[2], -v[:, i]),
        ):
            terms.append(_on_ring(way, i, title, unit, size))
    speed = v[:, _Y]
    for title, unit, size in (
        ("dry friction along y", "N", -np.tanh(speed / _RING_SPEED)),
        ("quadratic drag along y", "N s2/m2", -speed * np.abs(speed)),
    ):
        terms.append(_on_ring(way, _Y, title, unit, size))
    for place, side in _places(p[:, _Y]):
        beyond = np.maximum(0.0, side * (p[:, _Y] - place))
        where = f"where y is {'above' if side > 0 else 'below'}"
        for i in range(3):
            title = f"force along {_AXES[i]} {where} {1e3 * place:.2f} mm"
            terms.append(_on_ring(way, i, title, "N/m", beyond))
    return terms


def reading_terms(way: RingWay, touches: bool) -> list[Term]:
    """Errors of the force that is read while the torso is there."""
    F = way.force if touches else np.zeros_like(way.force)
    time = np.arange(len(F)) / way.rate
    there = np.full(len(F), float(touches))
    y = F[:, _Y]
    return [
        *(
            _on_ring(way, i, f"offset of the read force {_AXES[i]}", "N", there)
            for i in range(3)
        ),
        _on_ring(way, _Y, "drift of the read force y", "N/s", there * time),
        Term(
            "share of the read force that is not there",
            "1",
            way.leg_forces(np.hstack([F, np.zeros_like(F)])),
        ),
        _on_ring(way, 0, "share of force y in the read force x", "1", y),
        _on_ring(way, 2, "share of force y in the read force z", "1", y),
        _on_ring(
            way,
            _Y,
            "share of force y that grows with it and is not there",
            "1/N",
            y * np.abs(y),
        ),
        _on_ring(way, _Y, "lag of the read force y", "s", -slope(y, way.rate)),
    ]


def _on_ring(way: RingWay, i: int, title: str, unit: str, size) -> Term:
    wrench = np.zeros((len(size), 6))
    wrench[:, i] = size
    return Term(title, unit, way.leg_forces(wrench))


def _added_mass(way: RingWay, gravity: float) -> Term:
    wrench = np.zeros_like(way.poses)
    wrench[:, :3] = -way.accelerations[:, :3]
    wrench[:, 2] -= gravity
    return Term("mass of the ring", "kg", way.leg_forces(wrench))


def _places(y: np.ndarray) -> list[tuple[float, float]]:
    """Places along y that the ring goes beyond, and on which side."""
    steps = np.arange(0.0, np.abs(y).max(), _PLACES)
    found = [(s, 1.0) for s in steps] + [(0.0 - s, -1.0) for s in steps]
    return [
        (s, side) for s, side in found if (side * (y - s)).max() > _PLACES / 2
    ]


def _presliding(ways: np.ndarray) -> np.ndarray:
    """Dahl's state, -1 to 1, from the way of each sample (N, n)."""
    out, z = np.empty_like(ways), np.zeros(ways.shape[1])
    for i, step in enumerate(ways / PRESLIDING):
        z = (z + step) / (1.0 + np.abs(step))
        out[i] = z
    return out
