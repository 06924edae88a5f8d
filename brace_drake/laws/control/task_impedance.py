"""Virtual poses of all task coordinates: equations (5) and (6) side by side.

Arrays over the task coordinates of n rings have a row for each quantity and
6n columns, ring by ring from the bottom: `desired` is X_d, X_d', X_d''
(3, 6n), `virtual` X_v, X_v', X_v'' (3, 6n), `impedance` M_d, C_d, K_d
(3, 6n). A coordinate without an impedance follows its reference, X_v = X_d.
"""

from brace_drake.laws.compiled import compiled_law
from brace_drake.laws.control import impedance as control
from brace_drake.laws.lanes.functions import lead


@compiled_law
def follow_reference(i, desired, virtual, impedance):
    """Coordinate i without an impedance: X_v = X_d with its rates."""
    for row in range(3):
        virtual[row, i] = desired[row, i]
        impedance[row, i] = 0.0


@compiled_law
def step_impedance(i, M_d, C_d, K_d, desired, force, period, virtual, used):
    """One step of equation (5) on coordinate i, and what was used in it.

    Args:
        i: Coordinate.
        M_d, C_d, K_d: kg, N s/m, N/m; of a rotation kg m^2, N m s, N m.
        desired: (3, 6n).
        force: On the torso along i, N or N m.
        period: s.
        virtual, used: (3, 6n), column i is updated.
    """
    control.update_impedance(
        M_d, C_d, K_d, desired[:, i], force, period, virtual[:, i]
    )
    used[0, i] = M_d
    used[1, i] = C_d
    used[2, i] = K_d


@compiled_law
def advance_idc(desired, virtual, impedance):
    """IDC, equation (6) alone: every coordinate follows its reference.

    With exact M and G the error of a coordinate obeys e'' + K_D e' + K_P e = 0:
    it dies away for all positive gains; sampled, for those that the scenario's
    check lets pass. What M, G and F_e miss, d, stays as e = d / (M K_P).
    """
    for i in range(desired.shape[1]):
        follow_reference(i, desired, virtual, impedance)


@compiled_law
def advance_pic(
    desired, force, period, selected, M_d, C_d, K_d, virtual, impedance
):
    """PIC, equations (4) and (5): a constant impedance where selected.

    M_d e'' + C_d e' + K_d e = F with e = X_d - X_v. From F to e' the filter is
    passive for all positive M_d, C_d, K_d, with M_d e'^2 / 2 + K_d e^2 / 2
    stored. Stepped with period h it is stable where
    4 - 2 h C_d / M_d - h^2 K_d / M_d > 0.

    Args:
        desired: (3, 6n).
        force: On the torso (6n,), N and N m.
        period: s.
        selected: Not 0 for coordinates with an impedance (6n,).
        M_d, C_d, K_d: (6n,).
        virtual, impedance: (3, 6n), updated.
    """
    for i in range(selected.shape[0]):
        if lead(selected[i]) == 0.0:
            follow_reference(i, desired, virtual, impedance)
        else:
            step_impedance(
                i, M_d[i], C_d[i], K_d[i],
                desired, force[i], period, virtual, impedance,
            )  # fmt: skip


@compiled_law
def calc_task_forces(state, virtual, force, fed, gains, mass, gravity, F):
    """Inverse dynamics (6) on all coordinates: M is block diagonal.

    F = M (X_v'' + K_D (X_v' - X') + K_P (X_v - X)) + G + F_e. Coriolis terms
    are negligible at brace speeds and left out.

    Args:
        state: X, X' (2, 6n).
        virtual: (3, 6n).
        force: F_e (6n,), N and N m.
        fed: 1 where F_e is fed forward, else 0 (6n,).
        gains: K_P, K_D (2, 6n), 1/s^2 and 1/s.
        mass: Diagonal of M (6n,), kg and kg m^2.
        gravity: G (6n,), N and N m.
        F: Output (6n,), for each ring force first.
    """
    for i in range(F.shape[0]):
        # Always summed in this order: a run is the same bit by bit.
        F[i] = mass[i] * (
            -gains[1, i] * state[1, i] - gains[0, i] * state[0, i]
        )
        F[i] += mass[i] * (
            virtual[2, i]
            + gains[1, i] * virtual[1, i]
            + gains[0, i] * virtual[0, i]
        )
        F[i] += fed[i] * force[i]
        F[i] += gravity[i]
