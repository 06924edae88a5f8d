"""The same three machines by equations of their own, with one thing wrong.

They share neither code nor method with the package: Lagrange's equations by
hand, the classical Runge-Kutta method at a fine step, friction as a steep
hyperbolic tangent, encoders with noise and steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

G = 9.81


@dataclass
class Fault:
    """One thing that is wrong, at a place: joint, command or reading."""

    kind: str = "none"
    at: int = 0
    values: tuple[float, ...] = ()


@dataclass
class Machine:
    """Equations M(q) q'' + h(q, q') = tau."""

    mass: Callable
    bias: Callable
    control: Callable  # (command, q, v) -> tau


def cart_pole(cart=1.0, d=(1.5, 0.004), load=(0.0, 0.0)) -> Machine:
    """load: mass and distance on the pole."""
    m, half = 0.2, 0.25
    first = m * half + load[0] * load[1]
    second = m * (half**2 + (2 * half) ** 2 / 12) + load[0] * load[1] ** 2
    total = cart + m + load[0]

    def mass(q):
        c = first * np.cos(q[1])
        return np.array([[total, c], [c, second]])

    def bias(q, v):
        s = np.sin(q[1])
        return np.array(
            [d[0] * v[0] - first * s * v[1] ** 2, d[1] * v[1] + G * first * s]
        )

    return Machine(mass, bias, lambda u, q, v: np.array([u[0], 0.0]))


def arm(d=(0.3, 0.2), load=(0.0, 0.0)) -> Machine:
    """load: mass and distance on the lower link."""
    m1, c1, l1, m2, c2 = 1.2, 0.15, 0.3, 0.8, 0.125
    first = m2 * c2 + load[0] * load[1]
    I1 = m1 * (c1**2 + (2 * c1) ** 2 / 12)
    I2 = m2 * (c2**2 + (2 * c2) ** 2 / 12) + load[0] * load[1] ** 2
    tip = m2 + load[0]
    kp, kd = np.array([30.0, 15.0]), np.array([4.0, 2.0])

    def mass(q):
        c = first * l1 * np.cos(q[1])
        a = I1 + tip * l1**2 + I2 + 2 * c
        return np.array([[a, I2 + c], [I2 + c, I2]])

    def bias(q, v):
        s = first * l1 * np.sin(q[1])
        both = G * first * np.sin(q[0] + q[1])
        alone = G * (m1 * c1 + tip * l1) * np.sin(q[0])
        return np.array(
            [
                d[0] * v[0] - s * (2 * v[0] * v[1] + v[1] ** 2) + alone + both,
                d[1] * v[1] + s * v[0] ** 2 + both,
            ]
        )

    def control(u, q, v):
        return kp * (u[:2] - q) + kd * (u[2:] - v)

    return Machine(mass, bias, control)


def pendulum(d=(0.004, 0.0004), load=(0.0, 0.0)) -> Machine:
    """load: mass and distance on the pendulum."""
    m0, m, r, half = 0.3, 0.1, 0.2, 0.12
    first = m * half + load[0] * load[1]
    second = m * (half**2 + (2 * half) ** 2 / 12) + load[0] * load[1] ** 2
    J = m0 * (0.1**2 + 0.2**2 / 12) + (m + load[0]) * r**2

    def mass(q):
        s, c = np.sin(q[1]), np.cos(q[1])
        return np.array(
            [[J + second * s * s, r * first * c], [r * first * c, second]]
        )

    def bias(q, v):
        s, c = np.sin(q[1]), np.cos(q[1])
        return np.array(
            [
                d[0] * v[0]
                + 2 * second * s * c * v[0] * v[1]
                - r * first * s * v[1] ** 2,
                d[1] * v[1] - second * s * c * v[0] ** 2 + G * first * s,
            ]
        )

    return Machine(mass, bias, lambda u, q, v: np.array([u[0], 0.0]))


def joint_force(fault: Fault, q, v) -> float:
    """What a fault at a joint pushes with."""
    p = fault.values
    if fault.kind == "coulomb_friction":
        return -p[0] * np.tanh(v / p[1])
    if fault.kind == "stribeck_friction":
        level = p[0] + p[2] * np.exp(-((v / p[3]) ** 2))
        return -level * np.tanh(v / p[1])
    if fault.kind == "viscous_friction":
        return -p[0] * v
    if fault.kind == "joint_spring":
        return -p[0] * q
    if fault.kind == "cogging":
        return p[0] * np.sin(2 * np.pi * q / p[1])
    return 0.0


def command_of(fault: Fault, u, times, now):
    """The command that arrives, by the history of what was sent."""
    p = fault.values

    def held(t):
        return u[min(max(int(np.floor(t * p_rate + 1e-9)), 0), len(u) - 1)]

    p_rate = 1.0 / (times[1] - times[0])
    arrives = np.array(held(now))
    k = fault.at
    if fault.kind == "command_delay":
        arrives[k] = held(now - p[0])[k] if now >= p[0] else u[0][k]
    elif fault.kind == "command_gain":
        arrives[k] *= 1.0 + p[0]
    elif fault.kind == "command_offset":
        arrives[k] += p[0]
    elif fault.kind == "saturation":
        arrives[k] = np.clip(arrives[k], -p[0], p[0])
    elif fault.kind == "command_deadzone":
        arrives[k] = np.sign(arrives[k]) * max(0.0, abs(arrives[k]) - p[0])
    return arrives


def simulate(
    machine: Machine,
    commands: np.ndarray,
    rate: float,
    fault: Fault,
    fine: int = 20,
) -> tuple[np.ndarray, np.ndarray]:
    """Positions and speeds (N, 4), and torques (N, 2), at the samples."""
    times = np.arange(len(commands)) / rate
    dt = 1.0 / rate / fine
    x = np.zeros(4)
    log, taus = [], []
    lag = np.array(commands[0], dtype=float)
    slow = np.array(commands[0], dtype=float)

    def rates(x, u):
        q, v = x[:2], x[2:]
        tau = machine.control(u, q, v)
        tau = tau - machine.bias(q, v)
        k = fault.at
        if k < 2:
            tau[k] += joint_force(fault, q[k], v[k])
        return np.concatenate([v, np.linalg.solve(machine.mass(q), tau)])

    for i in range(len(commands)):
        sent = command_of(fault, commands, times, times[i])
        log.append(x.copy())
        taus.append(machine.control(sent, x[:2], x[2:]))
        for j in range(fine):
            now = times[i] + j * dt
            u = command_of(fault, commands, times, now + 1e-9)
            if fault.kind == "command_lag":
                share = 1.0 - np.exp(-dt / fault.values[0])
                lag[fault.at] += share * (u[fault.at] - lag[fault.at])
                u[fault.at] = lag[fault.at]
            if fault.kind == "rate_limit":
                most = fault.values[0] * dt
                step = u[fault.at] - slow[fault.at]
                slow[fault.at] += np.clip(step, -most, most)
                u[fault.at] = slow[fault.at]
            a = rates(x, u)
            b = rates(x + 0.5 * dt * a, u)
            c = rates(x + 0.5 * dt * b, u)
            d = rates(x + dt * c, u)
            x = x + dt / 6.0 * (a + 2 * b + 2 * c + d)
    return np.array(log), np.array(taus)


def read(values, fault: Fault, rate: float, sigma, quantum, rng):
    """Readings with the fault of one, noise and steps."""
    out = np.array(values)
    k, p = fault.at, fault.values
    if fault.kind == "sensor_offset":
        out[:, k] += p[0]
    elif fault.kind == "sensor_scale":
        out[:, k] *= 1.0 + p[0]
    elif fault.kind == "sensor_lag":
        share = 1.0 - np.exp(-1.0 / rate / p[0])
        for i in range(1, len(out)):
            out[i, k] = out[i - 1, k] + share * (values[i, k] - out[i - 1, k])
    elif fault.kind == "sensor_delay":
        times = np.arange(len(out)) / rate
        out[:, k] = np.interp(times - p[0], times, values[:, k])
    out = out + sigma * rng.standard_normal(out.shape)
    return quantum * np.round(out / quantum)
