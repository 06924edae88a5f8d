"""Open-loop replay on imposed motion: what follows from the ring's trajectory.

Where drives stick and slip by chance a twin in closed loop does not reach the
noise floor, and a second effect is lost in what it leaves. On the recorded
trajectory of the ring nothing sticks: an effect of contact, torso or force
reading shows there as it would without friction, and so does the subject.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.core.errors import BraceError
from brace_drake.core.parallel import Workers
from brace_drake.devices.declaration import Nuisance
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording.recording import Campaign

# Times the floor's amplitude, up to which there is no gap: the noise of a way
# is known to a sixth.
_THRESHOLD = 1.17


@dataclass(frozen=True)
class ImposedMotionFit:
    """The subject's fit on the recorded trajectory of the ring.

    Attributes:
        evaluator: Of the twin on imposed motion, over the fit runs.
        nominal: Its fit without effects.
    """

    evaluator: Evaluator
    nominal: CandidateFit

    def row(self) -> dict:
        """What the nominal fit leaves, as a row of block tests."""
        rest = max(0.0, self.nominal.excess / self.evaluator.count)
        ratio = float(np.sqrt(1.0 + rest))
        return {
            "block": "contact, torso and force reading",
            "input": "way of the ring",
            "output": "force, marker",
            "normalised_rms": ratio,
            "threshold": _THRESHOLD,
            "acquitted": ratio <= _THRESHOLD,
        }


def fit_imposed_motion(
    twin,
    campaign: Campaign,
    jobs: int | Workers,
    seed: int,
    nuisances: Sequence[Nuisance] = (),
) -> ImposedMotionFit | None:
    """Fits the subject to what the way of the ring does to it.

    Args:
        twin: On imposed motion; None where the device has none.
        campaign: Its fit runs are looked at.
        jobs, seed: As of the diagnosis.
        nuisances: Numbers that are known to a tolerance.

    Returns:
        None where there is no twin or one without room for effects, where way
        or force were not recorded or nothing was touched, and where the twin
        breaks down.
    """
    if twin is None or not twin.has_room:
        return None
    runs = tuple(campaign.split("fit"))
    recorded = all(run.has(twin.needs).all() for run in runs)
    if not (recorded and any(run.contact for run in runs)):
        return None
    usual = np.array([p.nominal for p in twin.subject])
    try:
        # Of a run held back nothing may be known, so not its way either.
        known = replace(campaign, runs=runs)
        floors, _ = estimate_floors(twin, known, usual, seed)
        prepared = prepare_runs(twin, runs, floors, campaign.rate_hz, seed)
        evaluator = Evaluator(twin, prepared, jobs)
        return ImposedMotionFit(evaluator, fit_nominal(evaluator, nuisances))
    except (BraceError, ValueError):
        return None
