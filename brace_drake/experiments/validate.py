"""The paper's section 4.1 on a recorded campaign: replay, network, forces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.devices.bench.recorded_motion import ring_poses
from brace_drake.devices.bench.rollout import FORCE, LENGTHS, MARKER
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.nominal_scenario import choose_scenario
from brace_drake.experiments.scores import rms
from brace_drake.identification.subject.contact_start import (
    contact_motion,
    contact_starts,
    start_values,
)
from brace_drake.identification.subject.nn_regression import (
    NnContactEstimate,
    fit_contact_nn,
)
from brace_drake.recording.columns import BENCH
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.brace import BenchScenario

FORMAT = "brace-validation/1"


class Trace(NamedTuple):
    """Along y, each (N,): ring's and torso's displacement, m; force, N."""

    ring: np.ndarray
    torso: np.ndarray
    force: np.ndarray


@dataclass(frozen=True)
class ReplayedRun:
    """A recorded run, and the same reference in the twin.

    Attributes:
        run: The recording.
        time: (N,), s, from 0.
        desired: y_d (N,), m.
        measured: What was recorded.
        before: The twin with the network's stiffness and damping.
        after: The twin with the fitted subject.
    """

    run: Run
    time: np.ndarray
    desired: np.ndarray
    measured: Trace
    before: Trace
    after: Trace

    def errors(self) -> dict[str, float]:
        """RMSE of force, N, ring and torso, m, before and after the fit."""
        return {
            f"{name}_rmse_{unit}_{when}": rms(
                getattr(twin, name) - getattr(self.measured, name)
            )
            for name, unit in (("force", "N"), ("ring", "m"), ("torso", "m"))
            for when, twin in (("before", self.before), ("after", self.after))
        }


@dataclass(frozen=True)
class Regression:
    """The paper's network on a run, equations (2) and (3), massless contact.

    Attributes:
        time: Middle of each block (B,), s.
        force: Means of the measured force (B,), N.
        predicted: a u(j) + b u(j-1) of the compression u (B,), N.
        estimate: What the network found.
    """

    time: np.ndarray
    force: np.ndarray
    predicted: np.ndarray
    estimate: NnContactEstimate

    @property
    def rmse(self) -> float:
        """Root mean square of the prediction's error, N."""
        return rms(self.predicted - self.force)


@dataclass(frozen=True)
class Validation:
    """What the figures show.

    Attributes:
        campaign: Its name.
        runs: The fit run that is shown and, where the campaign has one, the
            first validation run, by split.
        regression: Of the fit run.
        subject: Each parameter before, with the network's values within their
            limits, and after the optimisation.
    """

    campaign: str
    runs: dict[str, ReplayedRun]
    regression: Regression
    subject: dict[str, dict[str, float]]

    def document(self) -> dict:
        """The figures' numbers as a document of plain types."""
        estimate = self.regression.estimate
        return {
            "format": FORMAT,
            "campaign": self.campaign,
            "regression": {
                "run": self.runs["fit"].run.file,
                "stiffness_N_m": estimate.stiffness,
                "damping_N_s_m": estimate.damping,
                "rmse_N": self.regression.rmse,
            },
            "subject": self.subject,
            "runs": {
                split: {"file": r.run.file, **r.errors()}
                for split, r in self.runs.items()
            },
        }


def validate_twin(
    campaign: Campaign, found: dict, scenario=None, run_name: str | None = None
) -> Validation:
    """Replays a campaign before and after its fit.

    The paper drives its model with the recorded displacement, open loop. Here
    the recorded reference drives the twin's closed loop, as it drove the
    bench's, and ring, torso and force are all outcomes.

    Args:
        campaign: Of the bench.
        found: What `fit_campaign` returns for it.
        scenario: Of the nominal bench, or its file; None: the one that the
            campaign names, else the package's.
        run_name: Of the fit run to show; None: the first in contact.

    Raises:
        CampaignError: Not of the bench, no such run, or a fit of another.
    """
    run = choose_run(campaign, run_name)
    named = choose_scenario(campaign, scenario)
    twin = BenchTwin(named.scenario or BenchScenario())
    fitted = _fitted_values(twin, campaign, found)
    start = start_values(twin, contact_starts(twin, campaign))
    shown = {"fit": run}
    held_back = [r for r in campaign.split("validation") if r.contact]
    if held_back:
        shown["validation"] = held_back[0]
    values = zip(start.tolist(), fitted.tolist(), strict=True)
    return Validation(
        campaign=campaign.name,
        runs={k: _replay(twin, r, start, fitted) for k, r in shown.items()},
        regression=regress_force(twin, run),
        subject={
            p.name: {"before": before, "after": after}
            for p, (before, after) in zip(twin.subject, values, strict=True)
        },
    )


def regress_force(twin: BenchTwin, run: Run) -> Regression:
    """The network's prediction of a run's force from the compression."""
    motion = contact_motion(twin, run)
    estimate = fit_contact_nn(
        motion.time_s,
        motion.compression_m,
        motion.force_N,
        0.0,
        discretisation="consistent",
    )
    u = motion.compression_m
    # Without mass (2) needs one sample before; the fit leaves out two.
    predicted = estimate.a * u[2:] + estimate.b * u[1:-1]
    return Regression(
        motion.time_s[2:] - run.time_s[0],
        motion.force_N[2:],
        predicted,
        estimate,
    )


def choose_run(campaign: Campaign, name: str | None) -> Run:
    """The fit run to show; None: the first in contact.

    Raises:
        CampaignError: Not of the bench, or no such run.
    """
    if campaign.device != BENCH:
        raise CampaignError(
            f"{campaign.path}: validated is {BENCH!r}, this is a"
            f" {campaign.device!r}"
        )
    runs = [r for r in campaign.split("fit") if r.contact]
    chosen = [r for r in runs if name in (None, r.name, r.file)]
    if not chosen:
        names = ", ".join(r.name for r in runs) or "none"
        raise CampaignError(
            f"{campaign.path}: no fit run {name or ''} in contact; there"
            f" are: {names}"
        )
    return chosen[0]


def _fitted_values(twin, campaign: Campaign, found: dict) -> np.ndarray:
    names = [p.name for p in twin.subject]
    values = {p["name"]: p["value"] for p in found["parameters"]}
    if found["campaign"] != campaign.name or set(values) != set(names):
        raise CampaignError(
            f"{campaign.path}: the fit is of {found['campaign']!r} and its"
            f" parameters are {', '.join(values)}"
        )
    return np.array([values[name] for name in names])


def _replay(twin, run: Run, start, fitted) -> ReplayedRun:
    motion, measured = twin.motion(run), twin.measured(run)
    before, after = (twin.simulate(motion, s) for s in (start, fitted))
    n = len(measured)
    return ReplayedRun(
        run,
        run.time_s - run.time_s[0],
        run.channels["ring2_y_desired_m"],
        *(_trace(twin, log[:n]) for log in (measured, before, after)),
    )


def _trace(twin, log: np.ndarray) -> Trace:
    poses, _ = ring_poses(twin.numbers, log[:, LENGTHS])
    return Trace(poses[:, 1], log[:, MARKER][:, 1], log[:, FORCE][:, 1])
