"""Recordings of one axis by closed forms, without any of the twin."""

from pathlib import Path

import numpy as np

from brace_drake.recording.recording import Campaign, Run

RATE = 100.0
# Amplitude, m, and frequency, Hz, of each stroke, and what it is for.
STROKES = (
    ("short.csv", 0.02, 0.2, "fit"),
    ("long.csv", 0.05, 0.1, "fit"),
    ("fast.csv", 0.03, 0.5, "fit"),
    ("new.csv", 0.04, 0.3, "validation"),
)
SECONDS = 20.0


def stroke(amplitude: float, frequency: float):
    """Time (N,), s, position, rate and acceleration (N, 3) of sines that swell
    and fade.
    """
    t = np.arange(round(SECONDS * RATE)) / RATE
    w, e = 2.0 * np.pi * frequency, 2.0 * np.pi / SECONDS
    # a (1 - cos e t) / 2 sin w t, and its derivatives.
    grow = 0.5 * amplitude * (1.0 - np.cos(e * t))
    rise = 0.5 * amplitude * e * np.sin(e * t)
    bend = 0.5 * amplitude * e**2 * np.cos(e * t)
    s, c = np.sin(w * t), np.cos(w * t)
    y = grow * s
    v = rise * s + grow * w * c
    a = bend * s + 2.0 * rise * w * c - grow * w**2 * s
    return t, np.column_stack([y, v, a])


def dry_friction(y, level, stiffness, play):
    """Of an elastic joint with play: the limits that its friction's place is
    pushed between (N,).
    """
    reach = 0.5 * play + level / stiffness
    place, out = y[0], np.zeros(len(y))
    for i, position in enumerate(y):
        place = min(max(place, position - reach), position + reach)
        way = position - place
        beyond = max(0.0, abs(way) - 0.5 * play)
        out[i] = np.sign(way) * stiffness * beyond
    return out


def make_campaign(
    force_of, noise=0.05, kind="linear", nominal=None, inputs=None
) -> Campaign:
    """A campaign of an axis.

    Args:
        force_of: From (path (N, 3), extra inputs) to the force (N,).
        noise: Of a force reading, N.
        kind: linear or rotary.
        nominal: Numbers that it states.
        inputs: From the place of a run to its extra inputs by column.
    """
    position, force = "position_m", "force_N"
    if kind == "rotary":
        position, force = "position_rad", "torque_N_m"
    runs = []
    for i, (file, amplitude, frequency, split) in enumerate(STROKES):
        t, path = stroke(amplitude, frequency)
        generator = np.random.default_rng(i)
        values = inputs(i) if inputs else {}
        beside = {n: np.full(len(t), v) for n, v in values.items()}
        shake = generator.standard_normal((2, len(t)))
        columns = {
            "time_s": t,
            position: path[:, 0] + 1e-6 * shake[0],
            force: force_of(path, beside) + noise * shake[1],
            **beside,
        }
        runs.append(Run(file, False, file[:-4], None, split, columns))
    return Campaign(
        Path("synthetic"), "axis", RATE, "", tuple(runs), nominal or {}
    )
