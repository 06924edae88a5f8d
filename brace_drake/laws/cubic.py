"""The paper's desired motion: a cubic polynomial from rest to rest."""

from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.lanes.functions import where


@compiled_law
def calc_cubic(t, duration, start, way, desired):
    """X_d = X_0 + way (3 s^2 - 2 s^3), s = t / T, and its rates.

    Before 0 and after T it rests at either end.

    Args:
        t: s.
        duration: T, s.
        start, way: X_0 and what is added by T (m,).
        desired: X_d, X_d', X_d'' one after another (3 m,); output.
    """
    m = start.shape[0]
    s = min(1.0, max(0.0, t / duration))
    moving = where((t >= 0.0) & (t <= duration), 1.0, 0.0)
    place = s * s * (3.0 - 2.0 * s)
    rate = 6.0 * s * (1.0 - s) / duration
    bend = moving * (6.0 - 12.0 * s) / (duration * duration)
    for i in range(m):
        desired[i] = start[i] + way[i] * place
        desired[m + i] = way[i] * rate
        desired[2 * m + i] = way[i] * bend
