"""Plug points: where an effect may enter the twin, and with what signature.

A plug point is a place in a block's law that an effect's own law may change,
always in place, after the nominal law has written its value. The same
compiled function serves the LeafSystem and the compiled rollout. `p` are the
effect's parameters and `x` the states it keeps at this plug point, which it
advances by one step; both belong to the caller.

    drive        (t, dt, u, l, l_dot, law, f, p, x)
        Leg forces f (n,), N, from the held commands u (n,), leg lengths l
        and rates l_dot; `law` holds the viscous friction of each leg. What
        changes commands acts on what is `delivered` so far. Every plant step.
    compression  (t, dt, pad, d, p, x)
        Compression and its rate d (2,), m and m/s, of one pad, before the
        contact law. Every plant step and pad.
    contact      (t, dt, pad, d, law, N, p, x)
        Normal force N (1,), N, of one pad before it is cut at zero; `law` is
        the block's parameter vector. Every plant step and pad.
    torso        (t, dt, p_T, r_T, V, law, F, p, x)
        Spatial force F (6,), torque first, on the torso from its displacement
        p_T, rotation vector r_T and velocity V = [w; v]; `law` is the
        posture's parameter vector. Every plant step.
    ring         (t, dt, p_R, r_R, V, F, p, x)
        The same for the ring, without `law`.
    sensing      (t, h, u, l, F, p, x)
        Ideal readings, leg lengths l (n,), m, and force F (3,), N, before
        noise and rounding, given the commands u held so far. Every tick.
    signal       (t, dt, y, p, x)
        Value y (1,) of one signal of a diagram. Every step of the signal.
"""

import warnings
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numba import boolean, float64, int64, njit, types
from numba.core import cgutils
from numba.core.errors import NumbaExperimentalFeatureWarning
from numba.extending import intrinsic

from brace_drake.laws.compiled import LAW, compiled_law
from brace_drake.laws.kept import keep_by_sources
from brace_drake.laws.lanes.arrays import LANE_VECTOR

vector = float64[::1]

SIGNATURES = {
    "drive": types.void(float64, float64, *[vector] * 7),
    "compression": types.void(float64, float64, int64, *[vector] * 3),
    "contact": types.void(float64, float64, int64, *[vector] * 5),
    "torso": types.void(float64, float64, *[vector] * 7),
    "ring": types.void(float64, float64, *[vector] * 6),
    "sensing": types.void(float64, float64, *[vector] * 5),
    "signal": types.void(float64, float64, *[vector] * 3),
}
PLUG_POINTS = tuple(SIGNATURES)
# Those of a brace's stage, and their places among them.
STAGE_POINTS = PLUG_POINTS[:6]
DRIVE, COMPRESSION, CONTACT, TORSO, RING, SENSING = range(len(STAGE_POINTS))

# The twin carries up to this many effects at once.
MAX_EFFECTS = 4

# First-class functions are what lets one compiled rollout serve all effects.
warnings.filterwarnings("ignore", category=NumbaExperimentalFeatureWarning)


def _of_lanes(signature):
    """A law's signature with lanes in place of floats, see `laws.lanes`."""
    kinds = [LANE_VECTOR if k == vector else k for k in signature.args]
    return signature.return_type(*kinds)


# Of laws that are compiled for several copies at once as well.
LANE_SIGNATURES = {p: _of_lanes(SIGNATURES[p]) for p in STAGE_POINTS}


def plug(point: str, lanes: bool = False):
    """Decorator: compiles a law for a plug point.

    Args:
        point: Its name.
        lanes: Whether the law serves lanes as well as floats: what copies may
            answer differently it asks by `where`, see `laws.lanes`.
    """
    signatures = [SIGNATURES[point]]
    if lanes:
        signatures.append(LANE_SIGNATURES[point])
    return keep_by_sources(njit(signatures, **LAW))


def serves_lanes(law: Callable, point: str) -> bool:
    """Whether a law of a plug point was compiled for lanes."""
    of_lanes = LANE_SIGNATURES.get(point)
    return of_lanes is not None and of_lanes.args in law.overloads


def stack_type(point: str):
    """Numba type of the fixed-size stack of laws at a plug point."""
    return types.UniTuple(types.FunctionType(SIGNATURES[point]), MAX_EFFECTS)


@compiled_law
def delivered(f, law, l_dot, k):
    """Command of leg k as the effects before have left it, N.

    Args:
        f, law, l_dot: As at the plug point of the drive.
        k: Index of the leg.
    """
    return f[k] + law[k] * l_dot[k]


@plug("drive")
def _no_drive(t, dt, u, l, l_dot, law, f, p, x):  # noqa: E741 (l: leg length)
    pass


@plug("compression")
def _no_compression(t, dt, pad, d, p, x):
    pass


@plug("contact")
def _no_contact(t, dt, pad, d, law, N, p, x):
    pass


@plug("torso")
def _no_torso(t, dt, p_T, r_T, V, law, F, p, x):
    pass


@plug("ring")
def _no_ring(t, dt, p_R, r_R, V, F, p, x):
    pass


@plug("sensing")
def _no_sensing(t, h, u, l, F, p, x):  # noqa: E741 (l: leg length)
    pass


@plug("signal")
def _no_signal(t, dt, y, p, x):
    pass


NO_LAW = {
    "drive": _no_drive,
    "compression": _no_compression,
    "contact": _no_contact,
    "torso": _no_torso,
    "ring": _no_ring,
    "sensing": _no_sensing,
    "signal": _no_signal,
}

matrix = float64[:, ::1]
# One parameter vector for each effect; one state vector for each at a point.
vectors = types.UniTuple(vector, MAX_EFFECTS)


class Effects(NamedTuple):
    """Effects at the plug points of a brace of n stages, each acting alike, or
    of several copies of a brace, see `laws.lanes`.

    Attributes:
        laws: Address of each law, 0: none (points, MAX_EFFECTS, copies).
        parameters: Of all effects, copies and stages, one behind the other.
        memory: States, likewise, of each plug point.
        places: Where an effect's own begin and end: parameters, then states at
            each plug point (1 + points, MAX_EFFECTS, copies, n, 2).
        active: Whether any copy has an effect at a plug point
            (points, MAX_EFFECTS).
        together: Whether an effect's laws serve all copies at once: `laws` has
            those of lanes, and the copies of each parameter and state lie
            behind each other, as the first copy's (MAX_EFFECTS,).
        work: Places for what one copy's law takes and changes (5, 15).
    """

    laws: np.ndarray
    parameters: np.ndarray
    memory: np.ndarray
    places: np.ndarray
    active: np.ndarray
    together: np.ndarray
    work: np.ndarray

    def parameters_of(self, e: int) -> np.ndarray:
        """Parameters of an effect in all stages, to be written into."""
        return self._own(self.parameters, 0, e)

    def memory_of(self, point: int, e: int) -> np.ndarray:
        """States of an effect at a plug point, to be written into."""
        return self._own(self.memory, 1 + point, e)

    def _own(self, values: np.ndarray, row: int, e: int) -> np.ndarray:
        places = self.places[row, e]
        return values[places.min() : places.max()]


EFFECTS = types.NamedTuple(
    (
        int64[:, :, ::1],
        vector,
        vector,
        int64[:, :, :, :, ::1],
        boolean[:, ::1],
        boolean[::1],
        matrix,
    ),
    Effects,
)


@cache
def address_of(law: Callable, point: str, lanes: bool = False) -> int:
    """Where the code of a law lies that was compiled for a plug point, for
    floats or for lanes; the law is kept from then on.
    """
    signature = LANE_SIGNATURES[point] if lanes else SIGNATURES[point]
    compiled = law.overloads[signature.args]
    return compiled.library.get_pointer_to_function(
        compiled.fndesc.llvm_func_name
    )


def caller_of(point: str, lanes: bool = False) -> Callable:
    """`call(address, arguments)` in compiled code, for laws of a plug point, of
    floats or of lanes.
    """
    kinds = (LANE_SIGNATURES[point] if lanes else SIGNATURES[point]).args

    @intrinsic
    def call(typingctx, address, arguments):
        def lower(context, builder, sig, args):
            own, packed = args
            kind = context.call_conv.get_function_type(types.none, kinds)
            function = builder.inttoptr(own, kind.as_pointer())
            parts = cgutils.unpack_tuple(builder, packed, len(kinds))
            context.call_conv.call_function(
                builder, function, types.none, kinds, parts
            )
            return context.get_dummy_value()

        return types.none(types.int64, types.Tuple(kinds)), lower

    return call
