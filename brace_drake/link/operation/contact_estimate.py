"""Stiffness and damping of the contact while a device moves.

With x the ring's displacement from the torso along y and p the preload, both
pads together press with

    F_y = k (max(0, p + x) - max(0, p - x)) + c x' (1[p + x > 0] + 1[p - x > 0])

which is linear in k and c. They follow by least squares with forgetting. The
regressors are measured with noise, which would bias them to 0; so the twin's
own, free of noise, are the instruments (Ljung, System Identification, 7.6).
"""

from __future__ import annotations

import numpy as np


def contact_regressors(x: float, rate: float, preload: float) -> np.ndarray:
    """What k and c are multiplied with: m, m/s (2,)."""
    first, second = preload + x, preload - x
    touching = float(first > 0.0) + float(second > 0.0)
    return np.array([max(0.0, first) - max(0.0, second), rate * touching])


class ContactEstimate:
    """k and c, updated with each tick.

    Attributes:
        values: k, N/m, and c, N s/m.
        seen: How much of the past counts, in ticks with motion.
    """

    def __init__(
        self, start: np.ndarray, preload: float, memory: float, period: float
    ):
        """Begins with a guess.

        Args:
            start: k, c (2,); counts as much as a tenth of a second of a push.
            preload: p, m.
            memory: Time after which 63 % are forgotten, s.
            period: Of a tick, s.
        """
        self.values, self.seen = np.array(start, float), 0.0
        self._preload = preload
        self._keep = 1.0 - period / memory
        # Regressors of a push, m and m/s, as weights of the guess.
        self._scale = np.array([2e-3, 2e-2])
        weight = 0.1 / period * np.diag(self._scale**2)
        self._Z, self._y = weight, weight @ self.values

    def Update(self, measured, instrument, force: float) -> np.ndarray:
        """Takes a tick.

        Args:
            measured: x, x' of the device, through the same filter as `force`.
            instrument: x, x' of the twin.
            force: F_y on the torso, N.

        Returns:
            k, c (2,).
        """
        phi = contact_regressors(*measured, self._preload)
        z = contact_regressors(*instrument, self._preload)
        moves = abs(z[0]) > 0.05 * self._scale[0]
        moves |= abs(z[1]) > 0.05 * self._scale[1]
        if not moves:
            # Where nothing moves nothing is learnt, and nothing forgotten.
            return self.values
        self._Z = self._keep * self._Z + np.outer(z, phi)
        self._y = self._keep * self._y + z * force
        self.seen = self._keep * self.seen + 1.0
        scaled = self._Z / np.outer(self._scale, self._scale)
        if abs(np.linalg.det(scaled)) > 1e-6 * np.linalg.norm(scaled) ** 2:
            self.values = np.linalg.solve(self._Z, self._y)
        return self.values
