"""Recordings of a pad on tissue by closed forms, without any of the twin."""

from pathlib import Path

import numpy as np

from brace_drake.recording.recording import Campaign, Run

RATE = 100.0
# Ramps and holds: times, s, and displacements, m, of the knots.
STAIRS = ([0, 1, 1.2, 5, 5.3, 9, 9.4, 13], [0, 0, 4, 4, 8, 8, 12, 12])
SLOW = ([0, 2, 8, 12, 18, 20], [0, 0, 12, 12, 0, 0])
CYCLES = ([0, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5, 8], [0, 0, *[9, 3] * 4, 0])
FRESH = ([0, 0.5, 0.8, 4, 4.2, 7, 9, 10], [0, 0, 7, 7, 11, 11, 2, 2])


def knots(motion) -> tuple[np.ndarray, np.ndarray]:
    times, millimetres = motion
    return np.array(times, dtype=float), 1e-3 * np.array(millimetres)


def standard_linear_solid(motion, time, k, c, offset, arm=0.0, tau=1.0):
    """Force on a path of straight pieces, exact (N,).

    On a piece d = d_0 + v s the arm's creep is
    z = d - v tau + (z_0 - d_0 + v tau) exp(-s / tau).
    """
    t, d = knots(motion)
    d = d - offset
    for i in np.flatnonzero(d[:-1] * d[1:] < 0.0)[::-1]:
        touch = t[i] - d[i] * (t[i + 1] - t[i]) / (d[i + 1] - d[i])
        t, d = np.insert(t, i + 1, touch), np.insert(d, i + 1, 0.0)
    d = np.maximum(d, 0.0)
    force, z = np.zeros(len(time)), 0.0
    for i in range(len(t) - 1):
        v = (d[i + 1] - d[i]) / (t[i + 1] - t[i])
        rest = z - d[i] + v * tau

        def creep(s, i=i, v=v, rest=rest):
            return d[i] + v * s - v * tau + rest * np.exp(-s / tau)

        here = (time >= t[i]) & (time <= t[i + 1])
        s = time[here] - t[i]
        depth = d[i] + v * s
        pressed = k * depth + c * v + arm * (depth - creep(s))
        force[here] = np.where(depth > 0.0, np.maximum(pressed, 0.0), 0.0)
        z = creep(t[i + 1] - t[i])
    return force


def hardening_solid(motion, time, k, c, offset, cubic):
    """Force of a cubic spring on a path of straight pieces (N,)."""
    t, d = knots(motion)
    depth = np.maximum(np.interp(time, t, d) - offset, 0.0)
    linear = standard_linear_solid(motion, time, k, c, offset)
    return np.where(linear > 0.0, linear + cubic * depth**3, 0.0)


def make_run(name, motion, force_of, seed, split="fit", repeat_of=None,
             rate=RATE, force_noise=0.02, displacement_noise=2e-6):  # fmt: skip
    """A recording of `force_of(motion, time)` with white reading noise."""
    t, d = knots(motion)
    time = np.arange(round(t[-1] * rate) + 1) / rate
    generator = np.random.default_rng(seed)
    noise = generator.standard_normal((2, len(time)))
    channels = {
        "time_s": time,
        "displacement_m": np.interp(time, t, d) + displacement_noise * noise[0],
        "force_N": force_of(motion, time) + force_noise * noise[1],
    }
    return Run(name, True, "press", repeat_of, split, channels)


def make_campaign(force_of, nominal=None, rate=RATE, **noise) -> Campaign:
    """Three presses to fit, one repeated, and one to validate."""
    plan = (
        ("stairs.csv", STAIRS, "fit", None),
        ("slow.csv", SLOW, "fit", None),
        ("cycles.csv", CYCLES, "fit", None),
        ("again.csv", CYCLES, "fit", "cycles.csv"),
        ("fresh.csv", FRESH, "validation", None),
    )
    runs = [
        make_run(name, motion, force_of, i, split, repeat, rate, **noise)
        for i, (name, motion, split, repeat) in enumerate(plan)
    ]
    path = Path("synthetic")
    return Campaign(
        path, "pad bench", rate, "phantom", tuple(runs), nominal or {}
    )


SUBJECT = {"k": 1500.0, "c": 12.0, "offset": 0.0013}
ARM = {"arm": 900.0, "tau": 1.4}
CUBIC = 8e6


def linear(motion, time):
    """A contact without any effect."""
    return standard_linear_solid(motion, time, **SUBJECT)


def relaxing(motion, time):
    """The same with one Maxwell arm."""
    return standard_linear_solid(motion, time, **SUBJECT, **ARM)


def stiffening(motion, time):
    """The same with a cubic spring."""
    return hardening_solid(motion, time, **SUBJECT, cubic=CUBIC)


def exact_run(motion, force_of, rate=1000.0):
    """A recording without noise."""
    noise = {"force_noise": 0.0, "displacement_noise": 0.0}
    return make_run("exact.csv", motion, force_of, 0, rate=rate, **noise)
