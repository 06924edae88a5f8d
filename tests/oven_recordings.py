"""Recordings of an oven, a device of another package, that no twin has made."""

from pathlib import Path

import numpy as np

from brace_drake.recording import Campaign, Run, WriteCampaign
from tests.foreign.oven import HEATER, READING

RATE, LAG_S, LATE_S, RESISTANCE = 20.0, 2.5, 0.3, 0.6


def heated(seed: int, late: float = LATE_S) -> dict[str, np.ndarray]:
    """An oven that is heated in steps, its thermometer late by a lag; Euler's
    method at a thousandth of a second.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(400) / RATE
    heat = 100.0 * (rng.random(20) > 0.5)[(t / 1.0).astype(int)]
    fine = 50
    temperature, read, rows = 0.0, 0.0, []
    for u in heat:
        rows.append(read)
        for _ in range(fine):
            temperature += (RESISTANCE * u - temperature) / LAG_S / RATE / fine
            read += (temperature - read) / max(late, 1e-9) / RATE / fine
            read = read if late > 0.0 else temperature
    noise = 0.02 * rng.standard_normal(len(t))
    return {"time_s": t, HEATER: heat, READING: np.array(rows) + noise}


def write_oven(path: Path, late: float = LATE_S) -> Path:
    """A campaign of three runs, the last one for validation."""
    runs = [
        Run(f"r{i}.csv", True, "steps", None, split, heated(i, late))
        for i, split in enumerate(["fit", "fit", "validation"])
    ]
    WriteCampaign(Campaign(Path("o"), "oven", RATE, "oven", tuple(runs)), path)
    return path
