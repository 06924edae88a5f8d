"""Five materials between two plates, by laws of their own, and what is told.

    python tools/materials.py [--out out/materials]

A stiffening spring, arms of spring and damper, a slider behind a spring (dry
friction of rubber) and a loss of stiffness after the first stretch (Mullins)
in several mixtures, pressed by triangular strokes of five rates and sizes and
held. The package's laws are not used. Each is diagnosed as a bench of one pad;
what is told stands beside what was put in.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import brace_drake as bd  # noqa: E402
from brace_drake.recording import (  # noqa: E402
    Campaign,
    LoadCampaign,
    Run,
    WriteCampaign,
)

RATE, SECONDS = 100.0, 20.0
# Of each run: strokes a second, how deep, m, and what it is for; then one is
# held.
STROKES = (
    (0.1, 0.006, "fit"),
    (1.0, 0.006, "fit"),
    (0.3, 0.003, "fit"),
    (3.0, 0.004, "validation"),
    (0.2, 0.005, "validation"),
)
HELD, HELD_DEPTH = 2, 0.0055
NOISE_M, NOISE_SHARE = 1e-6, 0.004
SOFTENS_OVER = 0.002  # m


@dataclass(frozen=True)
class Material:
    """One mixture, N and m.

    Attributes:
        stiffness, cubic: Of the spring.
        arms: Stiffness, N/m, and relaxation time, s, of each.
        slider: Level, N, and stiffness in front of it, N/m.
        softening: Share that is lost once it was stretched farther.
    """

    stiffness: float = 2000.0
    cubic: float = 4e7
    arms: tuple[tuple[float, float], ...] = ()
    slider: tuple[float, float] = (0.0, 6000.0)
    softening: float = 0.0

    def force(self, depth: np.ndarray) -> np.ndarray:
        """What a plate feels that sinks in, never pulled (N,), N."""
        force, pulled = np.zeros(len(depth)), np.zeros(len(self.arms))
        level, stiff = self.slider
        slid = farthest = before = 0.0
        for i, x in enumerate(depth):
            for j, (k, tau) in enumerate(self.arms):
                pulled[j] += k * (x - before)
                pulled[j] *= np.exp(-1.0 / RATE / tau)
            slid = min(max(slid, x - level / stiff), x + level / stiff)
            farthest = max(farthest, x)
            far = 1.0 - np.exp(-(farthest - x) / SOFTENS_OVER)
            spring = self.stiffness * x + self.cubic * x**3
            spring *= 1.0 - self.softening * far
            force[i] = spring + pulled.sum() + stiff * (x - slid)
            before = x
        return np.maximum(force, 0.0)


RUBBER = Material(arms=((900.0, 0.4), (700.0, 6.0)), slider=(3.0, 6000.0))
MATERIALS = {
    "elastomer": RUBBER,
    "rubber, Mullins": Material(
        arms=RUBBER.arms, slider=RUBBER.slider, softening=0.25
    ),
    "skin": Material(150.0, 8e6, ((120.0, 0.3), (90.0, 4.0))),
    "foam": Material(800.0, 0.0, slider=(6.0, 8000.0)),
    "two arms": Material(cubic=0.0, arms=RUBBER.arms),
}


def strokes(place: int) -> np.ndarray:
    """Depths of one run (N,), m."""
    rate, depth, _ = STROKES[place]
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    way = depth * (1.0 - np.abs(1.0 - 2.0 * (t * rate % 1.0)))
    if place == HELD:
        half = SECONDS / 2.0
        start = np.interp(half, t, way)
        goes = np.interp(t, [half, half + 0.5], [start, HELD_DEPTH])
        way = np.where(t < half, way, goes)
    return way


def make_campaign(name: str, material: Material, seed: int) -> Campaign:
    """Five runs of a material, with white noise."""
    noise, runs = np.random.default_rng([seed, 0]), []
    for i, (_, _, split) in enumerate(STROKES):
        depth = strokes(i)
        force = material.force(depth)
        size = NOISE_SHARE * force.max()
        channels = {
            "time_s": np.arange(len(depth)) / RATE,
            "displacement_m": depth
            + NOISE_M * noise.standard_normal(len(depth)),
            "force_N": force + size * noise.standard_normal(len(depth)),
        }
        runs.append(Run(f"{i}.csv", True, f"stroke{i}", None, split, channels))
    return Campaign(Path(name), "pad bench", RATE, name, tuple(runs))


def main() -> None:
    """Prints a paragraph for each material."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("out/materials"))
    parser.add_argument("--seed", type=int, default=3)
    args = parser.parse_args()
    for name, material in MATERIALS.items():
        folder = args.out / name.replace(", ", "_").replace(" ", "_")
        if not folder.exists():
            WriteCampaign(make_campaign(name, material, args.seed), folder)
        start = time.process_time()
        found = bd.diagnose(LoadCampaign(folder), progress=False)
        took = time.process_time() - start
        print(f"{name}: {material}\n  {found.sentence}")
        print(f"  p {found.probability:.2f}, {took:.0f} CPU s", flush=True)


if __name__ == "__main__":
    main()
