"""The patient's posture: a bushing at the torso's rest pose, and its lean."""

from brace_drake.laws.compiled import compiled_law


@compiled_law
def add_posture_force(p_T, r_T, V_WT, posture, F_T_W):
    """Adds the spring and damper to rest, and the lean, acting at To along W.

    f = f_lean - K p - D v, torque = -K_r r - D_r w, with r the rotation vector.

    Args:
        p_T: Displacement of To from rest (3,), m.
        r_T: Rotation vector of the torso (3,), rad.
        V_WT: Spatial velocity [w; v] (6,).
        posture: K (3), D (3), K_r (3), D_r (3), constant f_lean (3), N.
        F_T_W: Spatial force (6,), torque first, added to.
    """
    for i in range(3):
        F_T_W[i] -= posture[6 + i] * r_T[i] + posture[9 + i] * V_WT[i]
        F_T_W[3 + i] -= posture[i] * p_T[i] + posture[3 + i] * V_WT[3 + i]
        F_T_W[3 + i] += posture[12 + i]
