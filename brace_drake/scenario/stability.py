"""What a controller's numbers have to be together, to be stable above all."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from brace_drake.laws.control.impedance import low_pass_gain_cutoff
from brace_drake.laws.control.vpic import highest_next_stiffness
from brace_drake.scenario.control_numbers import (
    BraceRings,
    parse_coordinates,
    spread,
    vpic_alpha,
)
from brace_drake.scenario.controllers import BraceControl
from brace_drake.scenario.fields import check_fields, fail


def check_control(
    control: BraceControl,
    rings: BraceRings,
    source: str = "control",
    at: str = "",
) -> None:
    """Checks every number, then the stability of what the tag names.

    Args:
        control: Numbers.
        rings: What they are to control.
        source: Named in the error, such as a file.
        at: Key of the numbers in that file.

    Raises:
        ScenarioError: One line: source, key path, value, what is allowed.
    """
    check_fields(control, source, at, rings.num_rings)
    check = _Check(control, rings, source, f"{at}." if at else "")
    check.names()
    check.pairs()
    if control.tag == "pid":
        check.pid()
    else:
        check.inner()
    if control.tag in ("pic", "npic", "mraic", "vpic"):
        check.filter()
    if control.tag in ("mraic", "vpic"):
        getattr(check, control.tag)()


@dataclasses.dataclass
class _Check:
    control: BraceControl
    rings: BraceRings
    source: str
    prefix: str

    @property
    def period(self) -> float:
        return 1.0 / self.control.rate

    @property
    def velocity_gain(self) -> float:
        cutoff = self.control.estimation.velocity_cutoff_hz
        return low_pass_gain_cutoff(cutoff, self.period)

    def fail(self, path: str, value, allowed: str):
        fail(self.source, self.prefix + path, value, allowed)

    def names(self) -> None:
        """Refuses coordinates that are not there, or there twice."""
        c, n = self.control, self.rings.num_rings
        for path, names in (
            ("inner.force_feedforward", c.inner.force_feedforward),
            ("impedance.coordinates", c.impedance.coordinates),
            ("pid.force_coordinates", c.pid.force_coordinates),
        ):
            try:
                parse_coordinates(names, n)
            except ValueError as error:
                allowed = f"x, y, z, with a ring, 1 to {n}, behind it or none"
                self.fail(path, error.args[0], allowed)
            if len(set(names)) < len(names):
                self.fail(path, names, "each once")

    def pairs(self) -> None:
        """Checks what only makes sense together."""
        c = self.control
        nyquist = c.rate / 2.0
        if c.estimation.velocity_cutoff_hz > nyquist:
            self.fail(
                "estimation.velocity_cutoff_hz",
                c.estimation.velocity_cutoff_hz,
                f"at most half of rate, {nyquist:g} Hz",
            )
        for tag in ("mraic", "npic"):
            # Stepped by Euler's rule, h w stays below 0.3.
            hz = getattr(c, tag).filter_hz
            if hz > c.rate / 20.0:
                allowed = f"at most a twentieth of rate, {c.rate / 20:g} Hz"
                self.fail(f"{tag}.filter_hz", hz, allowed)
        if c.npic.covariance_limit < 3.0 * c.npic.initial_covariance:
            least = 3.0 * c.npic.initial_covariance
            self.fail(
                "npic.covariance_limit",
                c.npic.covariance_limit,
                f"at least 3 npic.initial_covariance, {least:g}",
            )
        if not c.vpic.upper > c.vpic.lower:
            allowed = f"more than vpic.lower, {c.vpic.lower:g} N/m"
            self.fail("vpic.upper", c.vpic.upper, allowed)

    def inner(self) -> None:
        """Refuses gains that the sampled inner loop does not carry."""
        n, inner = self.rings.num_rings, self.control.inner
        gains = zip(spread(inner.kp, n), spread(inner.kd, n), strict=True)
        for kp, kd in sorted(set(gains)):
            self._check_loop("inner", inner.kd, kp, kd, 0.0, 1.0)

    def pid(self) -> None:
        """Refuses gains that PID on a bare ring does not carry."""
        n, numbers = self.rings.num_rings, self.control.pid
        rows = [spread(g, n) for g in (numbers.kp, numbers.kd, numbers.ki)]
        masses = self.rings.task_mass
        by_force = parse_coordinates(numbers.force_coordinates, n) != 0.0
        for i in np.flatnonzero(~by_force):
            kp, kd, ki = (row[i] for row in rows)
            self._check_loop("pid", numbers.kd, kp, kd, ki, masses[i])

    def _check_loop(self, part, shown, kp, kd, ki, mass) -> None:
        arguments = ki / mass, self.velocity_gain, self.period
        kp, kd = kp / mass, kd / mass
        if spectral_radius(kp, kd, *arguments) < 1.0:
            return
        found = damping_range(kp, *arguments)
        where = f"at {self.control.rate:g} Hz and {part}.kp {kp * mass:g}"
        allowed = f"none {where}: no damping makes the loop stable"
        if found:
            low, high = (mass * kd for kd in found)
            allowed = f"{low:.3g} to {high:.3g} {where}, for a stable loop"
        self.fail(f"{part}.kd", shown, allowed)

    def _selected(self):
        """Desired mass and stiffness where there is an impedance."""
        n, target = self.rings.num_rings, self.control.impedance
        on = parse_coordinates(target.coordinates, n) != 0.0
        return tuple(
            spread(values, n, 3)[on]
            for values in (target.mass, target.stiffness)
        )

    def filter(self) -> None:
        """Refuses stiffness that the stepped filter does not carry."""
        target = self.control.impedance
        M, K = self._selected()
        for m, k in zip(M, K, strict=True):
            most = highest_stiffness(m, target.damping_ratio, self.period)
            if k >= most:
                allowed = f"less than {most:.4g} N/m, for a stable filter"
                self.fail("impedance.stiffness", target.stiffness, allowed)

    def mraic(self) -> None:
        numbers, ratio = self.control.mraic, self.control.impedance
        most = 0.2 * 2.0 * np.pi * numbers.filter_hz
        if np.any(numbers.rates > most):
            allowed = f"0 to {most:.3g} 1/s, a fifth of mraic.filter_hz"
            self.fail("mraic.rates", numbers.rates, allowed)
        for m, k in zip(*self._selected(), strict=True):
            c = 2.0 * ratio.damping_ratio * np.sqrt(m * k)
            corner = numbers.lower[0] * m, numbers.upper[1] * c
            corner = (*corner, numbers.upper[2] * k)
            if filter_margin(*corner, self.period) <= 0.0:
                self.fail(
                    "mraic.upper",
                    numbers.upper,
                    "damping and stiffness with which the filter is stable at"
                    f" {self.control.rate:g} Hz and the lowest mass",
                )

    def vpic(self) -> None:
        numbers, target = self.control.vpic, self.control.impedance
        M, K = self._selected()
        if np.any((numbers.lower > K) | (numbers.upper < K)):
            allowed = f"{numbers.lower:g} to {numbers.upper:g} N/m, as for vpic"
            self.fail("impedance.stiffness", target.stiffness, allowed)
        for m, alpha in zip(M, vpic_alpha(self.control, M), strict=True):
            most = highest_stiffness(m, target.damping_ratio, self.period)
            if numbers.upper >= most:
                allowed = f"less than {most:.4g} N/m, for a stable filter"
                self.fail("vpic.upper", numbers.upper, allowed)
            law = m, target.damping_ratio, alpha, self.period
            for k in np.geomspace(numbers.lower, numbers.upper, 60):
                if highest_next_stiffness(law[0], k, *law[1:]) <= k:
                    allowed = f"less than {k:.4g} N/m, where energy may grow"
                    self.fail("vpic.upper", numbers.upper, allowed)


def spectral_radius(
    kp: float, kd: float, ki: float, velocity_gain: float, period: float
) -> float:
    """Largest magnitude of a pole of PID on a unit mass, sampled and held.

    x'' = -kp x - kd v - I between ticks; at a tick v is the backward difference
    of x through the estimator's low pass, and I grows by period ki x. Nothing
    but the controller damps the mass. Below 1 the loop is stable; gains beyond
    floating point give inf.
    """
    h, g = period, velocity_gain
    # x, x', x of the last tick, v, I.
    v = np.array([g / h, 0.0, -g / h, 1.0 - g, 0.0])
    integral = np.array([h * ki, 0.0, 0.0, 0.0, 1.0])
    position = np.array([1.0, 0.0, 0.0, 0.0, 0.0])
    rate = np.array([0.0, 1.0, 0.0, 0.0, 0.0])
    with np.errstate(all="ignore"):
        a = -kp * position - kd * v - integral
        step = [position + h * rate + 0.5 * h * h * a, rate + h * a]
    step = np.array([*step, position, v, integral])
    if not np.isfinite(step).all():
        return math.inf
    if ki == 0.0:
        step = step[:4, :4]
    return float(np.abs(np.linalg.eigvals(step)).max())


def damping_range(
    kp: float, ki: float, velocity_gain: float, period: float
) -> tuple[float, float] | None:
    """Lowest and highest kd, on a unit mass, that leave the loop stable.

    Looked for between 0.01 and 100 over the period; None where there is none.
    """
    tried = np.geomspace(1e-5, 10.0, 400) / period
    good = [
        kd
        for kd in tried
        if spectral_radius(kp, kd, ki, velocity_gain, period) < 1.0
    ]
    return (float(min(good)), float(max(good))) if good else None


def highest_stiffness(
    mass: float, damping_ratio: float, period: float
) -> float:
    """K, N/m, below which the stepped impedance filter is stable.

    4 - 2 h C / M - h^2 K / M > 0 with C = 2 ratio sqrt(M K), solved for K.
    """
    root = 2.0 * (math.sqrt(damping_ratio**2 + 1.0) - damping_ratio)
    return mass * (root / period) ** 2


def filter_margin(M: float, C: float, K: float, period: float) -> float:
    """4 - 2 h C / M - h^2 K / M; above 0 the impedance filter is stable.

    The filter's pole polynomial is z^2 - (2 - h c - h^2 k) z + 1 - h c with
    c = C / M, k = K / M: by Jury's test its value at z = -1 has to be positive.
    """
    return 4.0 - (2.0 * period * C + period**2 * K) / M
