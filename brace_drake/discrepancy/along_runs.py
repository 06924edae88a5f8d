"""A law along recorded motions, beside the force that the twin lacks there.

The lacking force is no part of the law's fit: it is the inverse-dynamics
residual of the legs, or the residual of the pads and of the torso on their own,
from measured signals through one low pass (`devices.bench.force_balance`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from brace_drake.devices.bench.force_balance import (
    CUTOFF_HZ,
    MARGIN_S,
    calc_imbalance,
)
from brace_drake.devices.bench.recorded_motion import low_pass
from brace_drake.devices.bench.ring_way import RingWay, follow_ring, slope
from brace_drake.devices.bench.rollout import MARKER
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.subject import with_subject
from brace_drake.effects.card import Effect
from brace_drake.effects.stack import Use
from brace_drake.effects.unknown import is_term, parts_of_term, terms
from brace_drake.effects.unknown.places import Place
from brace_drake.identification.evaluation import PreparedRun
from brace_drake.laws.numbers import BraceNumbers


class TermAlong(NamedTuple):
    """One term in one run, without the ends that the low pass folds.

    Attributes:
        run: Of the campaign.
        x: What the term depends on (N, K), K legs or pads or 1, in SI units.
        value: What the term gives (N, K), N.
        lacks: What the twin lacks without the term (N, K), other terms of the
            same law at the place taken off; None where no signals tell it.
    """

    run: PreparedRun
    x: np.ndarray
    value: np.ndarray
    lacks: np.ndarray | None


class Signals(NamedTuple):
    """Place, speed and load at a place (N, K), and the force lacking there."""

    place: np.ndarray
    speed: np.ndarray
    load: np.ndarray
    lacks: np.ndarray | None


Part = tuple[Signals, np.ndarray]


def follow_law(
    twin: BenchTwin,
    subject: np.ndarray,
    uses: Sequence[Use],
    runs: Sequence[PreparedRun],
    rate: float,
) -> list[tuple[Effect, list[TermAlong]]]:
    """Every term of a law along every run; of the bench alone.

    Args:
        twin: Nominal.
        subject: Its values.
        uses: Effects with their values; those of the dictionary are the law.
            Beside others nothing is said of what the twin lacks.
        runs: With their measured channels.
        rate: Hz.
    """
    law = [(e, v) for e, v in uses if is_term(e)]
    is_alone = len(law) == len(uses)
    numbers = with_subject(twin.numbers, subject)
    found: list[tuple[Effect, list[TermAlong]]] = [(e, []) for e, _ in law]
    for run in runs:
        way = follow_ring(numbers, run.measured, rate, CUTOFF_HZ)
        parts = [_along(run, way, numbers, e, v, rate) for e, v in law]
        for i, (effect, _) in enumerate(law):
            if parts[i] is None:
                continue
            signals, value = parts[i]
            lacks = signals.lacks if is_alone else None
            if lacks is not None:
                lacks = lacks - _others(law, parts, i)
            edge = int(MARGIN_S * rate)
            inner = slice(edge, len(value) - edge)
            found[i][1].append(
                TermAlong(
                    run,
                    variable_of(effect, signals, rate)[inner],
                    value[inner],
                    None if lacks is None else lacks[inner],
                )
            )
    return found


def _others(
    law: Sequence[Use], parts: Sequence[Part | None], index: int
) -> np.ndarray:
    """What the other terms at the same place give."""
    place = parts_of_term(law[index][0])[0]
    total = np.zeros(1)
    for j, ((effect, _), part) in enumerate(zip(law, parts, strict=True)):
        if j != index and part and parts_of_term(effect)[0] is place:
            total = total + part[1]
    return total


def kind_of_variable(effect: Effect) -> int:
    """What a term is drawn over: 0 its place, 1 speed, 2 load, 3 time."""
    code = parts_of_term(effect)[1].code
    if terms.VISCOUS <= code <= terms.WEAKENING:
        return 1
    if terms.CONSTANT <= code <= terms.OSCILLATION:
        return 3
    return 2 if code >= terms.LOAD_SQUARE else 0


def variable_of(effect: Effect, signals: Signals, rate: float) -> np.ndarray:
    """The variable of a term along a run (N, K)."""
    kind = kind_of_variable(effect)
    if kind < 3:
        return signals[kind]
    times = np.arange(len(signals.place)) / rate
    return np.repeat(times[:, None], signals.place.shape[1], axis=1)


def _along(
    run: PreparedRun,
    way: RingWay,
    numbers: BraceNumbers,
    effect: Effect,
    values: np.ndarray,
    rate: float,
) -> Part | None:
    """Signals at a term's place and what it gives; None where there are none,
    as of pads without a torso.
    """
    place, form = parts_of_term(effect)
    signals = _signals_at(place, run, way, numbers, rate)
    if signals is None:
        return None
    scaled = [signals[i] / place.scales[i] for i in range(3)]
    count, width = signals.place.shape
    value, step = np.empty((count, width)), 1.0 / rate
    for k in range(width):
        state = 0.0
        for n in range(count):
            time = n * step
            term, state = terms.term_value(
                form.code, values[1], values[2],
                scaled[0][n, k], scaled[1][n, k], scaled[2][n, k],
                time, time / place.scales[3], step, state,
            )  # fmt: skip
            value[n, k] = values[0] * term
    if place.key == "pads":
        return _of_both_pads(signals, value)
    return signals, value


def _signals_at(
    place: Place,
    run: PreparedRun,
    way: RingWay,
    numbers: BraceNumbers,
    rate: float,
) -> Signals | None:
    head, axis = place.key, 1
    if place.key[-2] == "_":
        head, axis = place.key[:-2], "xyz".index(place.key[-1])
    touches = run.run.contact
    if head == "legs":
        # In contact a moment on the ring hides half of what legs lack.
        lacks = None if touches else -calc_imbalance(numbers, way, False)
        ways = way.lengths - way.lengths[0]
        return Signals(ways, way.leg_rates, way.commands, lacks)
    if head == "ring":
        push, speed = way.poses[:, 1:2], way.velocities[:, 1:2]
        lacks = -_wrench(numbers, way, touches, axis)
        return Signals(push, speed, np.zeros_like(push), lacks)
    marker = run.measured[:, MARKER.start + 1 : MARKER.start + 2]
    if not touches or np.isnan(marker).any():
        return None
    if head == "force_reading":
        # What is read less its error is what the term depends on.
        lacks = -_wrench(numbers, way, touches, axis)
        force = way.force[:, 1:2] - (lacks if axis == 1 else 0.0)
        return Signals(force, slope(force, rate), force, lacks)
    slow = low_pass(marker, CUTOFF_HZ, rate)
    if head == "pads":
        return _signals_at_pads(way, slow, numbers, rate)
    return _signals_at_torso(way, slow, numbers, rate, axis)


def _wrench(
    numbers: BraceNumbers, way: RingWay, touches: bool, axis: int
) -> np.ndarray:
    """What the leg forces have too much, as a force on the ring (N, 1)."""
    lack = calc_imbalance(numbers, way, touches)
    return np.linalg.solve(way.unit_forces, lack[:, :, None])[:, axis]


def _signals_at_pads(
    way: RingWay, marker: np.ndarray, numbers: BraceNumbers, rate: float
) -> Signals:
    """Depth of each pad; the force that both together lack."""
    law = numbers.contact[0]
    relative = way.poses[:, 1:2] - marker
    sides = np.array([[1.0, -1.0]])
    depth = law[5] - sides * relative
    speed = -sides * slope(relative, rate)
    force = np.where(depth > 0.0, law[0] * depth + law[1] * speed, 0.0)
    force = np.maximum(force, 0.0)
    lack = way.force[:, 1:2] + np.sum(sides * force, axis=1, keepdims=True)
    return Signals(depth, speed, force, lack)


def _of_both_pads(signals: Signals, value: np.ndarray) -> Part:
    """The force of both pads on the torso over the ring's way against it:
    which of them lacks a force is not told.
    """
    sides = np.array([[1.0, -1.0]])
    pressed = np.where(signals.place > 0.0, value, 0.0)
    place, speed = (-0.5 * (v[:, :1] - v[:, 1:]) for v in signals[:2])
    load = -np.sum(sides * signals.load, axis=1, keepdims=True)
    total = -np.sum(sides * pressed, axis=1, keepdims=True)
    return Signals(place, speed, load, signals.lacks), total


def _signals_at_torso(
    way: RingWay,
    marker: np.ndarray,
    numbers: BraceNumbers,
    rate: float,
    axis: int,
) -> Signals:
    """Way of the marker; along the push the force that its motion asks for
    beyond the measured one.
    """
    speed = slope(marker, rate)
    lacks = None
    if axis == 1:
        asked = numbers.torso[0] * slope(speed, rate)
        asked += numbers.posture[4] * speed + numbers.posture[1] * marker
        lacks = asked - way.force[:, 1:2]
    return Signals(marker, speed, np.zeros_like(marker), lacks)
