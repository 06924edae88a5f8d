"""Campaigns of the three machines, drawn with one fault."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from brace_drake.recording import Campaign, Run
from brace_drake.recording.ports import Ports
from tests.foreign import machines
from tests.foreign.machines import Fault

RATE = 100.0
DURATION_S = 4.0


def smooth(rng, count, low, high):
    """A sum of sines between two frequencies, of size about 1 (N,)."""
    t = np.arange(count) / RATE
    f = rng.uniform(low, high, 4)
    phase = rng.uniform(0, 2 * np.pi, 4)
    wave = np.sin(2 * np.pi * t[:, None] * f + phase).sum(axis=1)
    ease = np.clip((t - 0.2) / 0.5, 0.0, 1.0)
    return ease * wave / 2.0


def steps(rng, count):
    """Plateaus of 0.5 s with different heights (N,)."""
    heights = rng.uniform(-1.0, 1.0, 20)
    heights[0] = 0.0
    at = (np.arange(count) / RATE / 0.5).astype(int)
    return heights[at]


def slow(rng, count):
    """A slow stroke there and back (N,)."""
    t = np.arange(count) / RATE
    f = rng.uniform(0.3, 0.4)
    return np.clip((t - 0.2) / 0.3, 0, 1) * np.sin(2 * np.pi * f * (t - 0.2))


SHAPES = {
    "multisine": lambda rng, n: smooth(rng, n, 0.3, 2.5),
    "steps": steps,
    "slow": slow,
}


@dataclass(frozen=True)
class Setup:
    """How a machine is made, commanded and read.

    Attributes:
        make: From dampings and a load to the machine.
        size: Of the commands.
        inputs, outputs: Columns of each port.
        dampings: Nominal value and limits of each joint's.
        known: Numbers that are not fitted.
    """

    make: Callable
    size: float
    inputs: dict[str, tuple[str, ...]]
    outputs: dict[str, tuple[str, ...]]
    dampings: dict[str, tuple[float, float, float]]
    known: dict[str, float] = field(default_factory=dict)

    @property
    def ports(self) -> Ports:
        """As a campaign has them."""
        nominal = {n: value for n, (value, _, _) in self.dampings.items()}
        limits = {n: (low, high) for n, (_, low, high) in self.dampings.items()}
        return Ports(
            inputs=self.inputs,
            outputs=self.outputs,
            numbers={**self.known, **nominal},
            fitted=limits,
        )

    def true_dampings(self, seed: int) -> list[float]:
        """Of the machine that is drawn."""
        rng = np.random.default_rng([seed, 1])
        return [v * rng.uniform(0.7, 1.4) for v, _, _ in self.dampings.values()]


_ARM = ("shoulder", "elbow")
SETUPS = {
    "cart_pole": Setup(
        make=lambda d, load: machines.cart_pole(1.0, d, load),
        size=4.0,
        inputs={"force": ("force_N",)},
        outputs={
            "state": (
                "cart_m",
                "pole_rad",
                "cart_speed_m_s",
                "pole_speed_rad_s",
            )
        },
        dampings={
            "slide_damping_N_s_m": (1.5, 0.1, 6.0),
            "hinge_damping_N_m_s_rad": (0.004, 0.0004, 0.02),
        },
        known={"cart_mass_kg": 1.0},
    ),
    "arm": Setup(
        make=machines.arm,
        size=0.8,
        inputs={
            "desired": tuple(
                f"{j}_desired_{unit}" for unit in ("rad", "rad_s") for j in _ARM
            )
        },
        outputs={
            "state": tuple(f"{j}_{u}" for u in ("rad", "rad_s") for j in _ARM),
            "torque": tuple(f"{j}_torque_N_m" for j in _ARM),
        },
        dampings={
            "shoulder_damping_N_m_s_rad": (0.3, 0.03, 1.5),
            "elbow_damping_N_m_s_rad": (0.2, 0.02, 1.0),
        },
    ),
    "pendulum": Setup(
        make=machines.pendulum,
        size=0.06,
        inputs={"torque": ("torque_N_m",)},
        outputs={"state": ("arm_rad", "swing_rad", "arm_rad_s", "swing_rad_s")},
        dampings={
            "turn_damping_N_m_s_rad": (0.004, 0.0004, 0.02),
            "swing_damping_N_m_s_rad": (0.0004, 0.00004, 0.002),
        },
    ),
}
# Of readings: standard deviation and step of a position, and of a speed.
NOISE = {
    "cart_pole": ([1e-4, 3e-4, 2e-3, 4e-3], [5e-5, 2e-4, 1e-4, 1e-4]),
    "arm": ([2e-4, 2e-4, 3e-3, 3e-3], [1e-4, 1e-4, 1e-4, 1e-4]),
    "pendulum": ([5e-4, 5e-4, 5e-3, 5e-3], [2e-4, 2e-4, 1e-4, 1e-4]),
}


def _load(fault):
    return fault.values if fault.kind == "payload" else (0.0, 0.0)


def make_campaign(name: str, fault: Fault, seed: int) -> Campaign:
    """A campaign of five runs, two of them for validation."""
    setup = SETUPS[name]
    machine = setup.make(setup.true_dampings(seed), _load(fault))
    ports, size = setup.ports, setup.size
    sigma, quantum = map(np.array, NOISE[name])
    count = int(DURATION_S * RATE) + 1
    runs = []
    plan = ["multisine", "steps", "slow", "multisine", "steps"]
    for i, shape in enumerate(plan):
        rng = np.random.default_rng([seed, 2, i])
        if name == "arm":
            wave = [
                size * smooth_steps(SHAPES[shape](rng, count)) for _ in (0, 1)
            ]
            rates = [np.gradient(w) * RATE for w in wave]
            commands = np.column_stack([*wave, *rates])
        else:
            commands = size * SHAPES[shape](rng, count)[:, None]
        log, tau = machines.simulate(machine, commands, RATE, fault)
        rows = read_all(name, log, tau, fault, sigma, quantum, rng)
        time = np.arange(count) / RATE
        columns = [c for own in ports.outputs.values() for c in own]
        channels = {"time_s": time}
        channels |= dict(zip(ports.commands, commands.T, strict=True))
        channels |= dict(zip(columns, rows.T, strict=True))
        split = "fit" if i < 3 else "validation"
        runs.append(Run(f"run{i}.csv", True, shape, None, split, channels))
    return Campaign(
        Path(name), "diagram", RATE, f"{name} {seed}", tuple(runs), ports=ports
    )


def smooth_steps(wave):
    """A wave without corners, as a reference of a position."""
    kernel = np.hanning(41)
    padded = np.concatenate([np.full(20, wave[0]), wave, np.full(20, wave[-1])])
    return np.convolve(padded, kernel / kernel.sum(), mode="valid")


def read_all(name, log, tau, fault, sigma, quantum, rng):
    """All columns of a run, in the order of the outputs."""
    out = machines.read(log, fault, RATE, sigma, quantum, rng)
    if name != "arm":
        return out
    noise = 5e-3 * rng.standard_normal(tau.shape)
    return np.column_stack([out, np.round(tau + noise, 3)])


FAULTS = {
    "cart_pole": [
        ("coulomb_friction", 0, lambda r: (r.uniform(0.3, 1.0), 2e-3)),
        ("coulomb_friction", 1, lambda r: (r.uniform(0.01, 0.04), 1e-2)),
        ("payload", 1, lambda r: (r.uniform(0.02, 0.08), r.uniform(0.2, 0.5))),
        ("command_delay", 0, lambda r: (r.uniform(0.02, 0.08),)),
        (
            "command_gain",
            0,
            lambda r: (r.choice([-1, 1]) * r.uniform(0.05, 0.2),),
        ),
        ("command_offset", 0, lambda r: (r.uniform(0.1, 0.4),)),
        ("saturation", 0, lambda r: (r.uniform(1.5, 3.0),)),
        ("command_deadzone", 0, lambda r: (r.uniform(0.2, 0.8),)),
        ("command_lag", 0, lambda r: (r.uniform(0.03, 0.15),)),
        ("joint_spring", 0, lambda r: (r.uniform(1.0, 5.0),)),
        ("sensor_scale", 1, lambda r: (r.uniform(0.03, 0.1),)),
        ("sensor_delay", 1, lambda r: (r.uniform(0.02, 0.06),)),
    ],
    "arm": [
        ("coulomb_friction", 0, lambda r: (r.uniform(0.4, 1.5), 5e-3)),
        ("coulomb_friction", 1, lambda r: (r.uniform(0.2, 0.7), 5e-3)),
        ("payload", 1, lambda r: (r.uniform(0.1, 0.5), r.uniform(0.15, 0.3))),
        ("joint_spring", 1, lambda r: (r.uniform(0.5, 3.0),)),
        ("cogging", 0, lambda r: (r.uniform(0.3, 0.8), r.uniform(0.15, 0.4))),
        ("command_delay", 0, lambda r: (r.uniform(0.02, 0.08),)),
        ("command_lag", 1, lambda r: (r.uniform(0.03, 0.15),)),
        ("sensor_offset", 0, lambda r: (r.uniform(0.01, 0.04),)),
        ("sensor_scale", 1, lambda r: (r.uniform(0.03, 0.1),)),
        ("sensor_lag", 1, lambda r: (r.uniform(0.02, 0.08),)),
        ("sensor_delay", 0, lambda r: (r.uniform(0.02, 0.06),)),
    ],
    "pendulum": [
        ("coulomb_friction", 0, lambda r: (r.uniform(0.003, 0.012), 2e-2)),
        ("coulomb_friction", 1, lambda r: (r.uniform(0.001, 0.004), 2e-2)),
        ("payload", 1, lambda r: (r.uniform(0.01, 0.04), r.uniform(0.1, 0.24))),
        ("command_delay", 0, lambda r: (r.uniform(0.02, 0.08),)),
        (
            "command_gain",
            0,
            lambda r: (r.choice([-1, 1]) * r.uniform(0.05, 0.2),),
        ),
        ("command_deadzone", 0, lambda r: (r.uniform(0.004, 0.012),)),
        ("saturation", 0, lambda r: (r.uniform(0.02, 0.045),)),
        ("joint_spring", 0, lambda r: (r.uniform(0.01, 0.05),)),
        ("rate_limit", 0, lambda r: (r.uniform(0.1, 0.4),)),
        ("sensor_scale", 0, lambda r: (r.uniform(0.03, 0.1),)),
        ("sensor_delay", 1, lambda r: (r.uniform(0.02, 0.06),)),
    ],
}


def draw_fault(name: str, seed: int) -> Fault:
    """One fault of a machine, in turn, its size drawn."""
    rng = np.random.default_rng([seed, 3])
    kinds = FAULTS[name]
    kind, at, draw = kinds[seed % len(kinds)]
    return Fault(kind, at, tuple(float(v) for v in draw(rng)))
