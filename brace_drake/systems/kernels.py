"""The laws of a plant step and of a tick, on the systems' own vectors.

A call from Python into compiled code pays for each array that it hands over,
more than these laws take to run; so a system hands over as few as it can.
"""

import numba
import numpy as np
from numba import njit

from brace_drake.laws import _cache_folder, blocks, controller
from brace_drake.scenario.bench_numbers import BenchNumbers

# Rest position (3), then as `blocks.calc_bench_forces` orders it (60).
NUM_BENCH_LAW = 63
# A bench's forces and signals: F on the ring (6) and on the torso (6), torque
# first; leg lengths (6), force of the ring on the torso (3), displacement and
# rotation vector of the torso (6).
NUM_BENCH = 27
# Resolution (2), noise sigma (12), then `controller.NUM_LAW` (56).
NUM_TICK_LAW = 14 + controller.NUM_LAW
# A tick's results: leg command (6), readings (12), then the memory (24).
NUM_TICK = 18 + controller.NUM_MEMORY

# The compiled code holds that of the laws: it is kept, and outdated, with it.
_cache_before = numba.config.CACHE_DIR
numba.config.CACHE_DIR = _cache_before or str(_cache_folder())


@njit(cache=True, error_model="numpy")
def add_absent_torso(state):
    """The state (13,) of the ring alone as that of both bodies (26,)."""
    bodies = np.zeros(26)
    bodies[0:7] = state[0:7]
    bodies[14:20] = state[7:13]
    return bodies


@njit(cache=True, error_model="numpy")
def calc_bench(inputs, with_pads, out):
    """All nominal forces of the bench, and what its instruments see.

    Args:
        inputs: q, p of ring and, where present, torso, then [w; v] of each
            (13) or (26); held leg commands (6), N; law, see NUM_BENCH_LAW.
        with_pads: Whether pads press on the torso.
        out: See NUM_BENCH, overwritten; the torso's part is left alone where
            it is absent.
    """
    n = inputs.shape[0] - NUM_BENCH_LAW - 6
    with_torso = n == 26
    bodies = inputs[0:26] if with_torso else add_absent_torso(inputs)
    law = inputs[n + 6 :]
    blocks.calc_bench_forces(
        bodies,
        inputs[n : n + 6],
        with_torso,
        with_pads,
        law[0:3],
        law[3:63],
        out[12:18],
        np.empty(6),
        np.empty((6, 6)),
        np.empty(6),
        np.empty((2, 17)),
        out[21:27],
        out[0:6],
        out[6:12],
        out[18:21],
    )


@njit(cache=True, error_model="numpy")
def advance_tick(inputs, tick):
    """One control tick: from readings to commands.

    Args:
        inputs: Leg lengths (6), m, force (3), N, marker (3), m; y_d, y_d',
            y_d'' (3); standard normal draws (12), or NaN for exact readings;
            law, see NUM_TICK_LAW.
        tick: See NUM_TICK, updated.

    Returns:
        False where no pose was found or the legs are singular.
    """
    readings, noise, law = inputs[0:12], inputs[15:27], inputs[27:]
    if not np.isnan(noise[0]):
        blocks.read_instruments(law[0:2], noise * law[2:14], readings)
    tick[6:18] = readings
    return controller.control_tick(
        readings, inputs[12:15], law[14:], tick[18:], np.empty(19), tick[0:6]
    )


numba.config.CACHE_DIR = _cache_before


def pack_tick_law(numbers: BenchNumbers) -> np.ndarray:
    """The law of a tick, see NUM_TICK_LAW."""
    return np.concatenate(
        [numbers.resolution, numbers.noise_sigma, numbers.controller_law]
    )


def pack_bench_law(numbers: BenchNumbers) -> np.ndarray:
    """The law of a bench's forces, see NUM_BENCH_LAW."""
    arrays = (
        numbers.rest,
        numbers.viscous,
        numbers.p_WB,
        numbers.p_RT,
        numbers.contact,
        numbers.posture,
    )
    return np.concatenate([np.ravel(a) for a in arrays])
