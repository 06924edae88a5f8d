"""What is told of a simulated run: a few numbers with names and units."""

from __future__ import annotations

import numpy as np

from brace_drake.core.errors import ScenarioError, suggest
from brace_drake.recording.columns import shown_unit, split_unit
from brace_drake.sweep.runs import Simulated

# The end of a run over which a final value is a mean, s.
_END_S = 0.5


def outcomes_of(run: Simulated) -> dict[str, float]:
    """Outcomes by name, whose last part is the unit, SI."""
    if run.rings is not None:
        return _of_brace(run)
    end = run.time >= run.time[-1] - _END_S
    found = {}
    for name, values in run.channels.items():
        found[f"peak_{name}"] = float(np.abs(values).max())
        found[f"rms_{name}"] = _rms(values)
        found[f"final_{name}"] = float(values[end].mean())
    return found


def _of_brace(run: Simulated) -> dict[str, float]:
    """Forces on the torso, ways of the rings, commands of the legs.

    The ring that is asked to move farthest tells what is final; depth is along
    -y, from where it is asked to begin.
    """
    rings, asked = run.rings, run.asked
    assert rings is not None and asked is not None
    names = list(run.channels)
    force = np.column_stack(
        [run.channels[n] for n in names if "_force_y_" in n]
    )
    others = [
        np.column_stack([run.channels[n] for n in names if f"_force_{a}_" in n])
        for a in "xz"
    ]
    size = np.sqrt(force**2 + others[0] ** 2 + others[1] ** 2)
    moved = np.nan_to_num(np.ptp(asked, axis=0), nan=-1.0)
    first = int(np.argmax(moved))
    end = run.time >= run.time[-1] - _END_S
    off = (rings - asked)[:, ~np.isnan(asked[0])]
    torso = np.column_stack([run.channels[n] for n in names if "torso_" in n])
    legs = np.column_stack(
        [run.channels[n] for n in names if n.endswith("_force_command_N")]
    )
    return {
        "peak_force_N": float(size.max()),
        "rms_force_N": _rms(size),
        "final_force_N": float(size[end, first].mean()),
        "tracking_rms_m": _rms(off),
        "tracking_peak_m": float(np.abs(off).max()),
        "final_depth_m": float(asked[0, first] - rings[end, first].mean()),
        "torso_peak_m": float(np.linalg.norm(torso, axis=1).max()),
        "peak_command_N": float(np.abs(legs).max()),
    }


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def choose_outcomes(words: str | None, known: list[str]) -> list[str]:
    """The outcomes of an option, all without.

    Raises:
        ScenarioError: One that is not known; the message offers the closest.
    """
    if words is None:
        return known
    chosen = [word.strip() for word in words.split(",")]
    for word in chosen:
        if word not in known:
            raise ScenarioError(
                f"--outcomes: no outcome {word!r}{suggest(word, known)};"
                f" allowed: {', '.join(known)}"
            )
    return chosen


def unit_of(outcome: str) -> str:
    """Unit of an outcome as readers have it."""
    return shown_unit(split_unit(outcome)[1])
