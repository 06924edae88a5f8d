"""Series in frequency by the cosine transform.

It continues a series by its mirror image. What integrates noise, as a virtual
position does, ends elsewhere than it began: a Fourier transform, which
continues a series by itself, would take that for a jump.

Source: Ahmed, Natarajan and Rao, Discrete cosine transform, IEEE Transactions
on Computers C-23, 1974.
"""

from __future__ import annotations

import numpy as np
from scipy import fft


def frequencies_of(samples: int, rate: float) -> np.ndarray:
    """Frequencies of `to_frequency` of so many samples (N,), Hz."""
    return 0.5 * rate * np.arange(samples) / samples


def to_frequency(series: np.ndarray, axis: int = 0) -> np.ndarray:
    """The orthonormal cosine transform (type II) of series along an axis.

    The squares of a series add up to those of its transform.
    """
    return fft.dct(series, type=2, axis=axis, norm="ortho")


def to_time(transform: np.ndarray) -> np.ndarray:
    """The inverse of `to_frequency` along the first axis."""
    return fft.idct(transform, type=2, axis=0, norm="ortho")
