"""What a digital instrument makes of a value: noise, then rounding."""

from numba import njit


@njit(cache=True, error_model="numpy")
def read_instrument(value, noise, resolution):
    """value + noise, rounded to the resolution (0: not rounded)."""
    reading = value + noise
    if resolution > 0.0:
        reading = resolution * round(reading / resolution)
    return reading
