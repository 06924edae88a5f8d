"""Recordings that the bench's twin makes of itself, with effects."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.devices.bench.rollout import Motion
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.reference import COLUMNS
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.least_squares import beyond
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.identification.problem import CandidateProblem
from brace_drake.identification.sensitivities import calc_sensitivities
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.brace import BenchScenario

RATE, DEVICE = 200.0, "bench stage 2"
# Mean square of the gap, in floors, that a recording is made to have.
SIZES = 1.0, 25.0
# Anchors a little off look like encoders that are off.
SIZES_OF_MANY = 100.0, 1000.0


def reference(duration, depth, ripple):
    """A slow push with a ripple, at rest at both ends (ticks, 3)."""
    t = np.arange(round(duration * 1000) + 1) / 1000.0
    window = np.sin(np.pi * t / duration) ** 2
    y = depth * window
    for rate, phase in ((1.1, 0.3), (2.3, 1.9), (4.7, 4.0)):
        y = y + ripple / rate * window * np.sin(2 * np.pi * rate * t + phase)
    velocity = np.gradient(y, 1e-3)
    return np.column_stack([y, velocity, np.gradient(velocity, 1e-3)])


MOTIONS = {
    "free": (False, reference(2.0, -0.003, 0.002)),
    "push": (True, reference(5.0, -0.008, 0.0)),
    "multisine": (True, reference(3.0, -0.003, 0.003)),
}


def record(twin, subject, uses, seed):
    """A campaign that the twin itself recorded."""
    runs = []
    for i, (name, (contact, desired)) in enumerate(MOTIONS.items()):
        mine = [(card, card.in_run(values, i)) for card, values in uses]
        noise = np.random.default_rng([seed, i])
        log = twin.simulate(Motion(desired, contact), subject, mine, noise)
        channels = {"time_s": np.arange(len(log)) / RATE}
        channels |= dict(zip(twin.channels, log.T, strict=True))
        channels |= dict(zip(COLUMNS, desired[::5].T, strict=True))
        runs.append(Run(f"{name}.csv", contact, name, None, "fit", channels))
    return Campaign(Path("synthetic"), DEVICE, RATE, "twin", tuple(runs))


def residual_of(evaluator, subject, uses=(), step=""):
    """Weighted residual of all runs."""
    (residual,) = evaluator.weighted_residuals([(subject, uses)], step)
    return residual


def without_torso(run):
    """The run without the torso's marker."""
    kept = {
        name: values
        for name, values in run.channels.items()
        if not name.startswith("torso")
    }
    return replace(run, channels=kept)


def strength_of(card, seed):
    """Values of an effect in the middle of its starts."""
    starts = card.starts()
    values = starts[len(starts) // 2].astype(float)
    generator = np.random.default_rng(seed)
    if not values[card.is_continuous].any():
        values = 3e-4 * generator.standard_normal(len(values))
    if not card.run_parameters:
        return values
    # A chest that widens alike on both sides hardly moves the brace.
    values[1] *= 0.3
    own = [p.starts[len(p.starts) // 2] for p in card.run_parameters]
    return np.concatenate([values, own * len(MOTIONS)])


class SyntheticBench:
    """A bench whose recordings are the twin's own, with noise.

    Attributes:
        twin: The bench's, at the coarse plant step.
        subject: Who is recorded, not the nominal one.
    """

    def __init__(self):
        self.twin = BenchTwin(BenchScenario(), 1e-3 / 3.0)
        self.subject = np.array([p.nominal for p in self.twin.subject])
        self.subject = self.subject * [1.1, 0.9, 1.05, 1.1, 0.95, 1.1]
        campaign = record(self.twin, self.subject, (), 0)
        self._floors, _ = estimate_floors(self.twin, campaign, self.subject, 0)
        # What a change of the subject could make, and no effect is needed for.
        problem = CandidateProblem(self.evaluator(()), ())
        columns = calc_sensitivities(problem, self.subject / problem.scales)
        self._basis = np.linalg.qr(columns)[0]

    def evaluator(self, uses, edit=lambda run: run):
        """Over a recording with effects, each run of it edited."""
        runs = record(self.twin, self.subject, uses, 97).runs
        runs = [edit(run) for run in runs]
        prepared = prepare_runs(self.twin, runs, self._floors, RATE, 0)
        return Evaluator(self.twin, prepared, 2)

    def values_of_a_gap(self, card, sign=1.0):
        """Values of an effect whose gap is neither faint nor wild."""
        values = strength_of(card, 3)
        shared = len(card.parameters)
        if sign < 0.0:
            values = card.scaled(values, sign)
        least, most = SIZES_OF_MANY if card.spread else SIZES
        for _ in range(12):
            evaluator = self.evaluator([(card, values)])
            residual = residual_of(evaluator, self.subject)
            left = beyond(residual, self._basis)
            size = left @ left / evaluator.count - 1.0
            if least <= size <= most:
                break
            factor = np.sqrt(np.sqrt(least * most) / max(size, 1e-3))
            scaled = card.scaled(values[:shared], np.clip(factor, 0.1, 10.0))
            values = np.concatenate([scaled, values[shared:]])
        return values

    def recording_with_a_gap(self, card, sign=1.0):
        """Evaluator of a recording with an effect, and its nominal fit.

        The effect is made stronger where another subject would do as well.
        """
        values, shared = self.values_of_a_gap(card, sign), len(card.parameters)
        for _ in range(4):
            evaluator = self.evaluator([(card, values)])
            nominal = fit_nominal(evaluator)
            if nominal.excess >= 0.2 * evaluator.count:
                return evaluator, nominal
            scaled = card.scaled(values[:shared], 2.5)
            values = np.concatenate([scaled, values[shared:]])
        raise AssertionError(f"{card.key}: no gap beyond another subject")
