"""The imposed path of a pad between the samples of its recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import dct, idct
from scipy.interpolate import Akima1DInterpolator

# A frequency counts as motion where its power is this many times the noise's.
_ABOVE_NOISE = 4.0
# Values of the spectrum that are averaged before that comparison.
_AVERAGED = 9
_ORDER = 8


@dataclass(frozen=True)
class PadMotion:
    """Where a pad is asked to be.

    Attributes:
        time: Sample times from 0 (N,), s.
        displacement: As recorded (N,), m.
        pass_band: Of the light smoothing, see `noise_gain` (N,).
    """

    time: np.ndarray
    displacement: np.ndarray
    pass_band: np.ndarray

    def path(self, noise: np.ndarray | None = None) -> np.ndarray:
        """Displacement, m, and rate, m/s, at the samples (N, 2).

        A cubic Hermite through them, with rates by Akima's weighted slopes,
        is the path: it follows corners without overshoot, which a spline with
        continuous curvature does not.

        Args:
            noise: Added to the recorded displacement (N,), m.

        Source: Akima, J. ACM 17, 1970, with the modified weights of Moler.
        """
        displacement = self.displacement
        if noise is not None:
            displacement = displacement + noise
        smooth = filter_cosines(displacement, self.pass_band)
        if len(smooth) < 3:
            return np.column_stack([smooth, np.gradient(smooth, self.time)])
        curve = Akima1DInterpolator(self.time, smooth, method="makima")
        return np.column_stack([smooth, curve.derivative()(self.time)])


def filter_cosines(signal: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Filters (N,) without phase: `gain` (N,) on its cosine transform.

    The transform takes the signal as mirrored at both ends, so that a record
    that ends elsewhere than it began is no step.
    """
    if np.all(gain == 1.0):
        return signal.copy()
    return idct(gain * dct(signal, norm="ortho"), norm="ortho")


def noise_gain(displacement: np.ndarray, sigma: float) -> np.ndarray:
    """The low pass that a displacement's own noise asks for (N,).

    Its cutoff is the highest frequency at which the displacement still stands
    above the white noise of its readings: beyond that the recording holds no
    motion, and differentiating it would feed noise to the damping. Readings
    without noise are left as they are.

    Args:
        displacement: (N,), m.
        sigma: Standard deviation of the noise of a reading, m.
    """
    samples = len(displacement)
    power = dct(displacement - displacement.mean(), norm="ortho") ** 2
    box = np.ones(min(_AVERAGED, samples))
    counts = np.convolve(np.ones(samples), box, mode="same")
    power = np.convolve(power, box, mode="same") / counts
    above = np.flatnonzero(power > _ABOVE_NOISE * sigma**2)
    cutoff = above[-1] + 1 if len(above) else 1
    if cutoff + _AVERAGED >= samples:
        return np.ones(samples)
    return 1.0 / (1.0 + (np.arange(samples) / cutoff) ** _ORDER)
