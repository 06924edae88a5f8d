"""Numbers of the brace's controllers; a tag says which one is in use.

[P] stated in the paper; [B] as the bench has it (bench.scenario.yaml);
[A] assumed, with the reason.
"""

from dataclasses import dataclass, field

import numpy as np

TAGS = ("idc", "pic", "mraic", "npic", "vpic", "pid")


def _vector(*values: float):
    return field(default_factory=lambda: np.array(values, dtype=float))


def _words(*words: str):
    return field(default_factory=lambda: list(words))


@dataclass
class Estimation:
    """Pose, velocity and force from the readings, the same for all."""

    velocity_cutoff_hz: float = 40.0  # [B]
    force_filter_tau: float = 0.02  # s [B]


@dataclass
class InnerLoop:
    """Inverse dynamics (6): gains of one ring (6,) or of all (6n,).

    `force_feedforward` names the coordinates whose measured force is fed
    forward: x, y, z of every ring, or y2 for that of the second moving ring
    from below alone.
    """

    # 1/s^2 and 1/s, position then rotation [B]; the paper has 6500 and 1000 for
    # the five coordinates without an impedance.
    kp: np.ndarray = _vector(1600, 1600, 1600, 1600, 1600, 1600)
    kd: np.ndarray = _vector(80, 80, 80, 80, 80, 80)
    force_feedforward: list[str] = _words("y")  # [B]


@dataclass
class TargetImpedance:
    """M_d, C_d, K_d of equation (4), C_d = 2 damping_ratio sqrt(M_d K_d).

    Along x, y, z of one ring (3,) or of all (3n,). `coordinates` are those
    with an impedance, named as above; inverse dynamics holds the others. The
    rings' forces are measured, not their torques, so rotations have none.
    """

    coordinates: list[str] = _words("y")  # [P]
    mass: np.ndarray = _vector(2, 2, 2)  # kg [P]
    stiffness: np.ndarray = _vector(6000, 6000, 6000)  # N/m [P]
    damping_ratio: float = 1.0  # [P]


@dataclass
class ReferenceAdaptation:
    """MRAIC; its reference impedance is the target impedance.

    A relative error of 1 in e and in e - e_m, both over `error_scale`, changes
    a parameter by its reference value within 1 / `rates`.
    """

    # 1/s of M, C, K [A: M stays, the motion's acceleration is below the noise]
    rates: np.ndarray = _vector(0, 3, 3)
    error_scale: float = 0.0005  # m [A: the paper's end error is 0.31 mm]
    leak: float = 0.02  # 1/s [A: forgets within minutes, a run lasts 12 s]
    lower: np.ndarray = _vector(0.5, 0.5, 0.33)  # over the reference [A]
    upper: np.ndarray = _vector(2, 3, 3)  # over the reference [A]
    filter_hz: float = 5.0  # of error and force [A: near the impedance's own]


@dataclass
class ImpedanceEstimation:
    """NPIC: recursive least squares and the force's correction."""

    kappa: float = 0.5  # [A: small gain needs less than 1]
    forgetting: float = 0.999  # lambda of a tick [A: one second at 1 kHz]
    initial_covariance: float = 1.0  # 1/N^2, parameters over the desired [A]
    covariance_limit: float = 100.0  # 1/N^2, of the trace [A]
    # N, of the desired impedance's force: below it nothing is estimated [A:
    # several times the force noise behind the filter]
    excitation: float = 0.2
    lower: np.ndarray = _vector(0.2, 0.2, 0.2)  # over the desired M, C, K [A]
    upper: np.ndarray = _vector(5, 5, 5)  # over the desired M, C, K [A]
    filter_hz: float = 5.0  # of error and force [A: near the impedance's own]


@dataclass
class VariableStiffness:
    """VPIC and RLPIC: limits of the stiffness, and the rule without a policy.

    The rule rests at the target stiffness and settles at twice that where the
    error stays at `error_scale`.
    """

    lower: float = 500.0  # N/m [A: 4 N over 8 mm]
    upper: float = (
        50000.0  # N/m [A: just above the 49 990 learned in the paper]
    )
    # alpha over its largest value, 2 damping_ratio sqrt(lower / mass) [A]
    alpha_share: float = 0.8
    error_scale: float = 0.0003  # m [A: the paper's end error of PIC]
    slide: float = 20.0  # 1/s, of e' + slide e [A: below the filter's own rate]
    forgetting: float = 0.5  # 1/s [A: relaxes within a hold]


@dataclass
class PoseForcePid:
    """PID of the pose, (6,) or (6n,); of the force where coordinates say so.

    Nothing is known of masses, and no force is fed forward but the weight.
    """

    kp: np.ndarray = _vector(4000, 4000, 4000, 50, 50, 50)  # N/m, N m [A]
    ki: np.ndarray = _vector(
        20000, 20000, 20000, 250, 250, 250
    )  # [A: kp/0.2 s]
    kd: np.ndarray = _vector(120, 120, 120, 1.5, 1.5, 1.5)  # N s/m, N m s [A]
    # N, N m [A: half of what the legs can do]
    integral_limit: np.ndarray = _vector(60, 60, 60, 6, 6, 6)
    force_coordinates: list[str] = _words()
    desired_force: np.ndarray = _vector(0, -4, 0)  # N, on the torso [P: 4 N]
    force_kp: float = 0.5  # [A]
    force_ki: float = 5.0  # 1/s [A: settles within a second]


@dataclass
class BraceControl:
    """All controllers' numbers; `tag` is idc, pic, mraic, npic, vpic or pid."""

    tag: str = "pic"
    rate: float = 1000.0  # Hz [B]
    estimation: Estimation = field(default_factory=Estimation)
    inner: InnerLoop = field(default_factory=InnerLoop)
    impedance: TargetImpedance = field(default_factory=TargetImpedance)
    mraic: ReferenceAdaptation = field(default_factory=ReferenceAdaptation)
    npic: ImpedanceEstimation = field(default_factory=ImpedanceEstimation)
    vpic: VariableStiffness = field(default_factory=VariableStiffness)
    pid: PoseForcePid = field(default_factory=PoseForcePid)
