"""Starting values of contact stiffness and damping by the paper's network.

The law to fit is equation (1) of the paper, one degree of freedom:

    m y'' + c y' + k y = F                                             (1)

Sampled every dt it becomes linear in two unknowns a and b,

    a y(j) + b y(j-1) = F(j) - e y(j-2),                               (2)

and a network without biases, whose summed weights are a and b, is trained on
it (3). Two readings of (2) are offered:

* "printed": a = m + c + k dt, b = -2m - c, e = m, as the paper has it. It
  adds a mass, a damping and an impulse per length.
* "consistent": backward differences of (1), a = m/dt^2 + c/dt + k,
  b = -(2m/dt^2 + c/dt), e = m/dt^2.

What the printed form recovers. With D2 y(j) = y(j) - 2 y(j-1) + y(j-2) and
D y(j) = y(j) - y(j-1), the printed form fits F - m D2 y on k_p dt y + c_p D y,
the consistent one F - (m/dt^2) D2 y on k_c y + (c_c/dt) D y: the same two
regressors. Write D2 y/dt^2 = alpha y + beta D y/dt for the least-squares
image of the acceleration in them. Then, on any record,

    k_p = (k_c + m (1 - dt^2) alpha) / dt,
    c_p = (c_c + m (1 - dt^2) beta) / dt.                              (*)

It does not converge to k and c: it grows as 1/dt. Without mass it is too
large by exactly 1/dt in both (20 times at the paper's 50 ms); with mass it
returns the apparent stiffness at the record's frequency (alpha is about
-w^2 for a sine, so k - m w^2), over dt. The two forms are one at dt = 1 s.

What the consistent form recovers. Its error is of first order in dt; for a
sine k_c = k - c w^2 dt/2 + O(dt^2), c_c = c - m w^2 dt + O(dt^2). With mass,
k and c are small differences of terms m/dt^2, which amplifies the noise of y.
Noise on y is an error in the regressors: without mass, where it exceeds the
motion within one step, k stays and c goes to -k dt/2, since then
(c/dt) D y is of most use in cancelling the noise in k y. A negative c says
that the record moves too little per step, not that the contact is active.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from brace_drake.core.errors import FitError

if TYPE_CHECKING:
    import torch

DISCRETISATIONS = ("printed", "consistent")


@dataclass(frozen=True)
class NnContactEstimate:
    """Law: a y(j) + b y(j-1) = F(j) - e y(j-2), with k and c out of a and b.

    Attributes:
        stiffness: k from the network's weights, N/m.
        damping: c from the network's weights, N s/m.
        a: sum of the weights on y(j), N/m as the regression uses it.
        b: sum of the weights on y(j-1), same unit.
        rmse_N: root mean square of prediction minus target, N.
        discretisation: "printed" or "consistent".
        least_squares_stiffness: k of the closed-form solution, N/m.
        least_squares_damping: c of the closed-form solution, N s/m.
        iterations: steps of the optimiser.
        active: share of samples at which the ReLU is on. At 1 the network
            is the linear regression and equals the closed form; below 1 the
            samples that are off (force lost in noise) have been left out.

    Source: equations (2) and (3) of the paper.
    """

    stiffness: float
    damping: float
    a: float
    b: float
    rmse_N: float
    discretisation: str
    least_squares_stiffness: float
    least_squares_damping: float
    iterations: int
    active: float


def fit_contact_nn(
    time_s: np.ndarray,
    displacement_m: np.ndarray,
    force_N: np.ndarray,
    mass: float,
    *,
    discretisation: str,
    hidden: int = 10,
    seed: int = 0,
) -> NnContactEstimate:
    """Law: ReLU((w_1+..+w_n) y(j) + (w_n+1+..+w_2n) y(j-1)) = F - e y(j-2).

    The network is equation (3) as printed: n hidden units of two weights and
    no bias, one ReLU around their sum. An activation around each unit would
    make the sum of the weights the slope only where all n units are on.

    Sign: a ReLU gives no negative force, and with mass the target
    F - e y(j-2) is negative in a push as soon as e > k. Law (1) is odd, so a
    sample and its mirror image (-y, -F) say the same of a and b: every sample
    is mirrored to the side where its target is >= 0. This is the paper's
    magnitude along the correction, taken sample by sample, and leaves the
    least-squares solution as it is.

    Scaling: y(j) and y(j-1) are collinear up to one step of motion (condition
    1e3 to 1e5), and gradient steps would find a + b fast and b hardly ever.
    The inputs are y(j) and y(j) - y(j-1), whitened by a QR factorisation, the
    target is divided by its RMS. Both maps are linear and exactly invertible,
    so trained weights give a and b without approximation, and the whitened
    problem has condition 1.

    Training: mean square error, full batch, L-BFGS in float64 on one thread;
    weights drawn from `seed`, mirrored once if they start on the dead side.

    Args:
        time_s: evenly spaced sample times, shape (N,), s.
        displacement_m: what loads the spring k, shape (N,), m. For the bench
            the compression of `nn_contact_motion`.
        force_N: force of law (1) in the same direction, shape (N,), N.
        mass: m of law (1), kg; 0 for the massless contact F = k y + c y'.
        discretisation: "printed" or "consistent".
        hidden: number n of hidden units.
        seed: seed of the first weights.

    Returns:
        The estimate and its closed-form check.

    Raises:
        FitError: if the record or an option cannot be used.

    Source: section 2.3 of the paper, equations (1) to (3).
    """
    _check_options(mass, discretisation, hidden)
    interval_s, y, force = _check_record(time_s, displacement_m, force_N)
    inertia = mass if discretisation == "printed" else mass / interval_s**2
    target = force[2:] - inertia * y[:-2]
    inputs = np.column_stack([y[2:], y[1:-1]])

    a_ls, b_ls = np.linalg.lstsq(inputs, target, rcond=None)[0]
    mirror = np.where(target < 0.0, -1.0, 1.0)
    a, b, iterations = _train(
        mirror[:, None] * inputs, mirror * target, hidden, seed
    )
    linear = mirror * (inputs @ [a, b])
    misfit = np.maximum(linear, 0.0) - mirror * target
    stiffness, damping = _physical(a, b, mass, interval_s, discretisation)
    k_ls, c_ls = _physical(a_ls, b_ls, mass, interval_s, discretisation)
    return NnContactEstimate(
        stiffness=stiffness,
        damping=damping,
        a=a,
        b=b,
        rmse_N=float(np.sqrt(np.mean(misfit**2))),
        discretisation=discretisation,
        least_squares_stiffness=k_ls,
        least_squares_damping=c_ls,
        iterations=iterations,
        active=float(np.mean(linear > 0.0)),
    )


def _physical(
    a: float, b: float, mass: float, interval_s: float, discretisation: str
) -> tuple[float, float]:
    """Equation (2) solved for k and c: stiffness N/m, damping N s/m."""
    if discretisation == "printed":
        damping = -b - 2.0 * mass
        stiffness = (a + b + mass) / interval_s
    else:
        damping = -b * interval_s - 2.0 * mass / interval_s
        stiffness = a + b + mass / interval_s**2
    return float(stiffness), float(damping)


def _train(
    inputs: np.ndarray, target: np.ndarray, hidden: int, seed: int
) -> tuple[float, float, int]:
    """Trains relu(sum of units); returns a, b and the optimiser's steps.

    Args:
        inputs: y(j) and y(j-1), mirrored, shape (N, 2), m.
        target: F - e y(j-2), mirrored, >= 0, shape (N,), N.
        hidden: number of units.
        seed: seed of the first weights.
    """
    import torch  # slow to import, and only this function needs it

    step = np.column_stack([inputs[:, 0], inputs[:, 0] - inputs[:, 1]])
    q, r = np.linalg.qr(step)
    diagonal = np.abs(np.diag(r))
    scale = np.sqrt(np.mean(target**2))
    # The increments of a usable record are far above rounding.
    if scale == 0.0 or diagonal[1] <= 1e-12 * diagonal[0]:
        raise FitError("the record has no force or no motion to fit")
    rows = np.sqrt(target.size)

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        x = torch.from_numpy(q * rows)
        f = torch.from_numpy(target / scale)
        weights, iterations = _minimise(x, f, hidden, seed)
    finally:
        torch.set_num_threads(threads)
    p, d = np.linalg.solve(r, rows * scale * weights)
    return float(p + d), float(-d), iterations


def _minimise(
    x: torch.Tensor, f: torch.Tensor, hidden: int, seed: int
) -> tuple[np.ndarray, int]:
    """Law: minimum over w of mean (relu(x sum(w)) - f)^2, by L-BFGS.

    Args:
        x: whitened inputs, shape (N, 2).
        f: scaled target, shape (N,).
        hidden: number of units; w has shape (hidden, 2).
        seed: seed of the first weights.

    Returns:
        The summed weights, shape (2,), and the number of steps.
    """
    import torch

    generator = torch.Generator().manual_seed(seed)
    w = torch.randn(hidden, 2, generator=generator, dtype=x.dtype) / hidden
    if torch.dot(x @ w.sum(0), f) < 0.0:
        w = -w  # a ReLU that is off everywhere has no gradient
    w.requires_grad_(True)
    optimiser = torch.optim.LBFGS(
        [w],
        max_iter=300,
        tolerance_grad=1e-13,
        tolerance_change=1e-24,
        line_search_fn="strong_wolfe",
    )

    def closure() -> torch.Tensor:
        optimiser.zero_grad()
        loss = torch.mean((torch.relu(x @ w.sum(0)) - f) ** 2)
        loss.backward()
        return loss

    optimiser.step(closure)
    summed = w.detach().sum(0).numpy()
    if not np.isfinite(summed).all():
        raise FitError("L-BFGS did not converge to finite weights")
    return summed, int(optimiser.state[w]["n_iter"])


def _check_options(mass: float, discretisation: str, hidden: int) -> None:
    """Raises FitError unless the options can be used."""
    if discretisation not in DISCRETISATIONS:
        raise FitError(
            f"discretisation is {discretisation!r}, expected one of "
            f"{', '.join(DISCRETISATIONS)}"
        )
    if not (np.isfinite(mass) and mass >= 0.0):
        raise FitError(f"mass is {mass}, expected a finite number >= 0 kg")
    if hidden < 1:
        raise FitError(f"hidden is {hidden}, expected at least 1 unit")


def _check_record(
    time_s: np.ndarray, displacement_m: np.ndarray, force_N: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Sampling interval in s and the two signals, or FitError."""
    time, y, force = (
        np.asarray(signal, dtype=float)
        for signal in (time_s, displacement_m, force_N)
    )
    if time.ndim != 1 or not time.shape == y.shape == force.shape:
        raise FitError(
            "time, displacement and force need one common length, got "
            f"shapes {time.shape}, {y.shape}, {force.shape}"
        )
    if time.size < 5:
        raise FitError(f"got {time.size} samples, expected at least 5")
    if not np.isfinite([time, y, force]).all():
        raise FitError("the record holds values that are not finite")
    steps = np.diff(time)
    interval_s = (time[-1] - time[0]) / (time.size - 1)
    if interval_s <= 0.0 or np.ptp(steps) > 0.01 * interval_s:
        raise FitError("the samples are not evenly spaced in time")
    return float(interval_s), y, force
