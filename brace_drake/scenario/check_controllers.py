"""What a controller's numbers may be, and with which it is stable."""

from __future__ import annotations

import dataclasses

import numpy as np

from brace_drake.core.errors import suggest
from brace_drake.laws.control.impedance import low_pass_gain_cutoff
from brace_drake.laws.control.vpic import highest_next_stiffness
from brace_drake.scenario.control_numbers import (
    BraceRings,
    parse_coordinates,
    spread,
    vpic_alpha,
)
from brace_drake.scenario.controllers import TAGS, BraceControl
from brace_drake.scenario.leaves import check_kind, walk
from brace_drake.scenario.messages import fail
from brace_drake.scenario.sampled_loops import (
    damping_range,
    filter_margin,
    highest_stiffness,
    spectral_radius,
)

_POSITIVE = (
    "estimation.velocity_cutoff_hz estimation.force_filter_tau inner.kp"
    " impedance.mass impedance.stiffness impedance.damping_ratio"
    " mraic.error_scale mraic.filter_hz npic.initial_covariance npic.filter_hz"
    " vpic.lower vpic.error_scale vpic.slide vpic.forgetting"
).split()
_NOT_NEGATIVE = (
    "inner.kd mraic.rates npic.excitation pid.kp pid.ki pid.kd"
    " pid.integral_limit pid.force_kp pid.force_ki"
).split()
_RANGES = {
    "rate": (100.0, 20000.0),
    "impedance.damping_ratio": (0.05, 10.0),
    "mraic.leak": (0.0, 1.0),
    "mraic.lower": (0.01, 1.0),
    "mraic.upper": (1.0, 100.0),
    "npic.kappa": (0.0, 0.95),
    "npic.forgetting": (0.9, 1.0),
    "npic.lower": (0.01, 1.0),
    "npic.upper": (1.0, 100.0),
    "vpic.alpha_share": (0.01, 0.99),
}
# Values for one ring or for all, along this many coordinates of a ring.
_PER_RING = {
    "inner.kp": 6, "inner.kd": 6, "impedance.mass": 3,
    "impedance.stiffness": 3, "pid.kp": 6, "pid.ki": 6, "pid.kd": 6,
    "pid.integral_limit": 6, "pid.desired_force": 3,
}  # fmt: skip
_COORDINATES = (
    "inner.force_feedforward", "impedance.coordinates",
    "pid.force_coordinates",
)  # fmt: skip


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
    _Check(control, rings, source, f"{at}." if at else "").run()


@dataclasses.dataclass
class _Check:
    control: BraceControl
    rings: BraceRings
    source: str
    prefix: str

    def run(self) -> None:
        self._check_values()
        tag = self.control.tag
        if tag == "pid":
            self._check_pid()
        else:
            self._check_inner()
        if tag in ("pic", "npic", "mraic", "vpic"):
            self._check_filter()
        if tag in ("mraic", "vpic"):
            getattr(self, f"_check_{tag}")()

    @property
    def period(self) -> float:
        return 1.0 / self.control.rate

    @property
    def velocity_gain(self) -> float:
        cutoff = self.control.estimation.velocity_cutoff_hz
        return low_pass_gain_cutoff(cutoff, self.period)

    def fail(self, path: str, value, allowed: str):
        fail(self.source, self.prefix + path, value, allowed)

    def _check_values(self) -> None:
        defaults = dict(walk(BraceControl()))
        values = dict(walk(self.control))
        for path, value in values.items():
            where = self.prefix + path
            if path in _PER_RING:
                self._check_size(path, value)
                default = value
            else:
                default = defaults.get(path, value)
            check_kind(self.source, where, value, default)
            self._check_range(path, value)
        if self.control.tag not in TAGS:
            hint = suggest(self.control.tag, TAGS)
            self.fail("tag", self.control.tag, f"{', '.join(TAGS)}{hint}")
        for path in _COORDINATES:
            part, name = path.split(".")
            self._check_names(path, getattr(getattr(self.control, part), name))
        self._check_pairs()

    def _check_size(self, path: str, value) -> None:
        one = _PER_RING[path]
        sizes = {one, one * self.rings.num_rings}
        words = " or ".join(str(size) for size in sorted(sizes))
        if not isinstance(value, np.ndarray) or value.shape not in {
            (size,) for size in sizes
        }:
            self.fail(path, value, f"{words} numbers")

    def _check_range(self, path: str, value) -> None:
        numbers = np.asarray(value)
        if path in _POSITIVE and not np.all(numbers > 0.0):
            self.fail(path, value, "greater than 0")
        if path in _NOT_NEGATIVE and not np.all(numbers >= 0.0):
            self.fail(path, value, "0 or more")
        if path in _RANGES:
            low, high = _RANGES[path]
            if not np.all((numbers >= low) & (numbers <= high)):
                self.fail(path, value, f"{low:g} to {high:g}")

    def _check_names(self, path: str, names: list[str]) -> None:
        try:
            parse_coordinates(names, self.rings.num_rings)
        except ValueError as error:
            n = self.rings.num_rings
            allowed = f"x, y, z, with a ring, 1 to {n}, behind it or none"
            self.fail(path, error.args[0], allowed)

    def _check_pairs(self) -> None:
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

    def _check_inner(self) -> None:
        """Refuses gains that the sampled inner loop does not carry."""
        n, inner = self.rings.num_rings, self.control.inner
        gains = zip(spread(inner.kp, n), spread(inner.kd, n), strict=True)
        for kp, kd in sorted(set(gains)):
            self._check_loop("inner", inner.kd, kp, kd, 0.0, 1.0)

    def _check_pid(self) -> None:
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

    def _check_filter(self) -> None:
        """Refuses stiffness that the stepped filter does not carry."""
        target = self.control.impedance
        M, K = self._selected()
        for m, k in zip(M, K, strict=True):
            most = highest_stiffness(m, target.damping_ratio, self.period)
            if k >= most:
                allowed = f"less than {most:.4g} N/m, for a stable filter"
                self.fail("impedance.stiffness", target.stiffness, allowed)

    def _check_mraic(self) -> None:
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

    def _check_vpic(self) -> None:
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
