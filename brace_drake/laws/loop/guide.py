"""A ring that is carried along a way, whatever presses on it.

In the place of all forces on the ring come those that keep it on its way:
computed torque, with the way's own acceleration. Loaded as a law at the plug
point of the ring, behind which only its weight is added.
"""

from brace_drake.laws.hooks import plug

# Head of the vector p, then rows of pose and rate (12,) of each sample.
START, RATE, MASS, MOMENTS, WEIGHT, STIFFNESS = 0, 1, 2, 3, 6, 7
NUM_HEAD, NUM_ROW = 8, 12


@plug("ring")
def follow_way(t, dt, p_R, r_R, V, F, p, x):
    """F = M (X_r'' + 2 k (X_r' - X') + k^2 (X_r - X)) + G, what F was aside.

    Between samples the way X_r is the cubic of their poses and rates.

    Args:
        t, dt, p_R, r_R, V, F, x: See `laws.hooks`.
        p: Time of the first sample, s; samples a second; mass, kg; moments of
            inertia (3), kg m^2; weight, N; k, 1/s; then a row for each sample.
    """
    last = (p.shape[0] - NUM_HEAD) // NUM_ROW - 2
    place = max(0.0, (t - p[START]) * p[RATE])
    i = min(int(place), last)
    s, h = min(place - i, 1.0), 1.0 / p[RATE]
    k = p[STIFFNESS]
    for c in range(6):
        a = NUM_HEAD + NUM_ROW * i + c
        b = a + NUM_ROW
        way, out, back = p[b] - p[a], h * p[a + 6], h * p[b + 6]
        bend, turn = 3.0 * way - 2.0 * out - back, out + back - 2.0 * way
        x_r = p[a] + s * (out + s * (bend + s * turn))
        v_r = (out + s * (2.0 * bend + 3.0 * s * turn)) / h
        a_r = (2.0 * bend + 6.0 * s * turn) / (h * h)
        if c < 3:
            x_c, v_c, inertia, to = p_R[c], V[3 + c], p[MASS], 3 + c
        else:
            x_c, v_c, to = r_R[c - 3], V[c - 3], c - 3
            inertia = p[MOMENTS + c - 3]
        pull = 2.0 * k * (v_r - v_c) + k * k * (x_r - x_c)
        F[to] = inertia * (a_r + pull)
    F[5] += p[WEIGHT]
