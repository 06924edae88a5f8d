"""Error and force through one filter: what an impedance is estimated from.

M e'' + C e' + K e = F holds as well for e and F that went through the same
linear filter, here w^2 / (s^2 + 2 w s + w^2), whose own states are the filtered
e' and e'': no noisy signal is differentiated (state variable filter; Garnier
and Wang (eds.), Identification of Continuous-time Models from Sampled Data,
Springer 2008, chapter 1).

It is stepped as the impedance filter is (semi-implicit Euler), so for an
impedance that is constant and stepped with the same period the relation holds
to the last digit.
"""

from brace_drake.laws.compiled import compiled_law

# Rows of memory: filtered e, e', filtered F, F'.
NUM_REGRESSOR = 4


@compiled_law
def step_regressor(error, force, w, period, memory):
    """One step of both filters.

    Args:
        error: e, m or rad.
        force: F, N or N m.
        w: rad/s.
        period: h, s; h w well below 1.
        memory: See NUM_REGRESSOR (4,), updated.

    Returns:
        Filtered e'', e', e and F, all of this tick.
    """
    acceleration = w * w * (error - memory[0]) - 2.0 * w * memory[1]
    jerk = w * w * (force - memory[2]) - 2.0 * w * memory[3]
    now = acceleration, memory[1], memory[0], memory[2]
    memory[1] += period * acceleration
    memory[0] += period * memory[1]
    memory[3] += period * jerk
    memory[2] += period * memory[3]
    return now
