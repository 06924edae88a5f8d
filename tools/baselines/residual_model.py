"""A residual model without causes: Gaussian process on states of the twin.

What the nominal twin leaves of each channel is a smooth function of where the
twin is, how fast, and where it was: a Gaussian process with a squared
exponential kernel, its mean at a few hundred samples of the fit runs
(Rasmussen and Williams, Gaussian Processes for Machine Learning, section 8.3).
It predicts validation runs and names nothing: it tells how far such a model
comes, and that a gap is there.
"""

from __future__ import annotations

import numpy as np

from tools.baselines.case import Case
from tools.baselines.linear import LEVEL
from tools.baselines.repair import Repair

_SEED = 0
# Samples of the fit runs in the kernel's sum, and all that are fitted.
_CENTRES, _SAMPLES = 400, 6000
# Lags of the states, samples; variance of noise beside that of a residual.
_LAGS, _NOISE = (0, 10, 40), 0.05
_WIDTHS = (1.0, 2.0, 4.0)


def answer(case: Case) -> dict:
    """Whether there is a gap, and how much of it the model takes."""
    misfit = float(case.residual @ case.residual) / case.count - 1.0
    if misfit <= LEVEL:
        return {"effects": [], "outside": False, "probability": None}
    repair = Repair(case)
    return {"effects": None, "closed": repair.closed(predict(case, repair))}


def predict(case: Case, repair: Repair) -> list[np.ndarray]:
    """Recordings of the validation runs: the twin's, and what is learnt."""
    fit, within, learnt = case.bench.fit, repair.within, {}
    for contact in {p.run.contact for p in fit.prepared}:
        runs = [p for p in fit.prepared if p.run.contact == contact]
        replays = [fit.simulate(p, case.subject, within) for p in runs]
        states = [_states(p.run, x) for p, x in zip(runs, replays, strict=True)]
        left = [p.measured - x for p, x in zip(runs, replays, strict=True)]
        sizes = [len(s) for s in states]
        learnt[contact] = Process(
            np.concatenate(states),
            np.concatenate(left),
            np.repeat(np.arange(len(sizes)), sizes),
        )
    found = []
    for c in repair.before:
        run = c.prepared.run
        states = _states(run, c.before)
        model = learnt.get(run.contact)
        found.append(c.before + model.mean(states) if model else c.before)
    return found


def _states(run, replay: np.ndarray) -> np.ndarray:
    """Reference, its speed and direction, and force, now and before (N, n)."""
    channels = run.channels
    speed = channels["ring2_vy_desired_m_s"]
    now = [
        channels["ring2_y_desired_m"],
        speed,
        channels["ring2_ay_desired_m_s2"],
        np.tanh(speed / 1e-3),
        replay[:, :6].mean(axis=1),
    ]
    series = np.column_stack(now)
    lagged = [np.roll(series, lag, axis=0) for lag in _LAGS]
    for lag, part in zip(_LAGS, lagged, strict=True):
        part[:lag] = series[0]
    return np.concatenate(lagged, axis=1)


class Process:
    """A Gaussian process with inducing points, one for all channels.

    Args:
        states: (N, n).
        left: What is to be predicted (N, C).
        runs: Which run each sample is of (N,); the width of the kernel is
            chosen by runs that are left out.
    """

    def __init__(self, states: np.ndarray, left: np.ndarray, runs: np.ndarray):
        rng = np.random.default_rng(_SEED)
        self._middle, self._scale = states.mean(axis=0), states.std(axis=0)
        self._scale = np.maximum(self._scale, 1e-9)
        some = rng.choice(
            len(states), min(_SAMPLES, len(states)), replace=False
        )
        x, y, runs = self._scaled(states[some]), left[some], runs[some]
        size = np.maximum(y.std(axis=0), 1e-12)
        few = rng.choice(len(x), min(_CENTRES, len(x)), replace=False)
        self._centres = x[few]
        scores = []
        for width in _WIDTHS:
            error = 0.0
            for run in np.unique(runs):
                out = runs == run
                if out.all():
                    continue
                w = self._solve(x[~out], y[~out] / size, width)
                there = self._kernel(x[out], width) @ w
                error += float(np.sum((y[out] / size - there) ** 2))
            scores.append(error)
        self._width = _WIDTHS[int(np.argmin(scores))]
        self._weights = self._solve(x, y / size, self._width) * size

    def mean(self, states: np.ndarray) -> np.ndarray:
        """Prediction at states (N, C)."""
        kernel = self._kernel(self._scaled(states), self._width)
        return kernel @ self._weights

    def _scaled(self, states):
        return (states - self._middle) / self._scale

    def _kernel(self, x, width):
        square = (x**2).sum(axis=1)[:, None] - 2.0 * x @ self._centres.T
        square += (self._centres**2).sum(axis=1)
        return np.exp(-0.5 * square / (width**2 * x.shape[1]))

    def _solve(self, x, y, width):
        """Weights of the centres: subset of regressors."""
        across = self._kernel(x, width)
        among = self._kernel(self._centres, width)
        matrix = across.T @ across + _NOISE * among
        matrix[np.diag_indices(len(matrix))] += 1e-6 * len(x)
        return np.linalg.solve(matrix, across.T @ y)
