"""The controllers of the whole brace; with one moving ring, of the bench.

All have the ports of `BraceController` and share its pose estimator (forward
kinematics, backward difference, low pass) and its way to the legs (f = J^-T F,
stages from the top down, each leg limited, the rings' weight carried).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydrake.systems.framework import Context

from brace_drake.model.systems.brace_controller import BraceController
from brace_drake.scenario.control_numbers import BraceRings, pack_control
from brace_drake.scenario.controllers import BraceControl
from brace_drake.scenario.stability import check_control


class BraceIdc(BraceController):
    """Inverse dynamics alone, equation (6) of the paper, X_v = X_d.

    F = M (X_d'' + K_D (X_d' - X') + K_P (X_d - X)) + G + F_e: position control
    of all coordinates. Errors obey e'' + K_D e' + K_P e = 0, stable for all
    positive gains; sampled, for those that the check of the numbers lets pass.
    Source: the paper, section 3; Siciliano et al., Robotics, 2009, section 8.5.
    """

    TAG = "idc"


class BracePic(BraceController):
    """Position-based impedance control, equations (4) to (6) of the paper.

    M_d e'' + C_d e' + K_d e = F_e gives X_v where coordinates are selected;
    inverse dynamics follows it, and X_d elsewhere. The filter is passive from
    F_e to e' for all positive M_d, C_d, K_d. Source: the paper, section 3.
    """

    TAG = "pic"


class BraceMraic(BraceController):
    """Model reference adaptive impedance control, after the paper's ref. 17.

    The full law is not public: this is a reconstruction, the standard Lyapunov
    law with projection and sigma modification (`laws.control.mraic`).
    V = z'Pz + d'Gamma^-1 d of model error z and parameter error d does not
    grow without the leak; with it V is bounded. `impedance` holds the adapted
    values.
    """

    TAG = "mraic"


class BraceNpic(BraceController):
    """Novel position-based impedance control, after the paper's ref. 18.

    The full law is not public: this is a reconstruction (`laws.control.npic`).
    Recursive least squares estimates the realised impedance, and its error
    corrects the force in (5): F_c = F + kappa phi' (theta_hat - theta_d).
    Stable by small gain for kappa < 1; at rest e = F / K_d for any kappa.
    """

    TAG = "npic"


class BraceVpic(BraceController):
    """Variable position-based impedance control; with a policy, RLPIC.

    PIC with a stiffness that varies: by a rule (Yang et al., 2011), or as the
    input port `stiffness` (6n,), N/m, asks where it is connected; columns of
    coordinates without an impedance are not read. It stays within its limits,
    rises no faster than the condition of Kronander and Billard (2016) allows,
    and damping is 2 ratio sqrt(M_d K): the stored energy of the error never
    grows without a force, whatever is asked (`laws.control.vpic`).
    """

    TAG = "vpic"

    def _DeclarePorts(self, coordinates: int) -> None:
        super()._DeclarePorts(coordinates)
        self._stiffness_port = self.DeclareVectorInputPort(
            "stiffness", coordinates
        )

    def _AskedStiffness(self, context: Context) -> np.ndarray:
        if self._stiffness_port.HasValue(context):
            return self._stiffness_port.Eval(context)
        return super()._AskedStiffness(context)


class BracePid(BraceController):
    """PID of the pose, and of the force where coordinates are chosen for it.

    The baseline of robotic braces before the paper's. Not Drake's
    PidController, which has no limits. Integrals do not wind up; stable for
    ki < kd kp / m on a bare ring (`laws.control.pid`). There is no impedance,
    and the measured force is not fed forward.
    """

    TAG = "pid"


_CONTROLLERS = {
    controller.TAG: controller
    for controller in (
        BraceIdc, BracePic, BraceMraic, BraceNpic, BraceVpic, BracePid,
    )
}  # fmt: skip


def MakeController(
    control: BraceControl,
    rings: BraceRings,
    law: np.ndarray | None = None,
    source: str = "control",
) -> BraceController:
    """The controller that the numbers' tag names.

    Args:
        control: Numbers.
        rings: Geometry, masses and limits as the controller knows them.
        law: Rows in place of those that these two give.
        source: Named where a number is refused.

    Raises:
        ScenarioError: A number is not allowed: source, key, value, range.
    """
    check_control(control, rings, source)
    numbers = pack_control(control, rings)
    if law is not None:
        numbers = replace(numbers, law=law)
    return _CONTROLLERS[control.tag](numbers)
