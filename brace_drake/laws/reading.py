"""What a digital instrument makes of a value: noise, then rounding."""

from brace_drake.laws.compiled import compiled_law


@compiled_law
def read_instrument(value, noise, resolution):
    """value + noise, rounded to the resolution (0: not rounded)."""
    reading = value + noise
    if resolution > 0.0:
        reading = resolution * round(reading / resolution)
    return reading
