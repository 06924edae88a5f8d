"""Numbers of the brace's controllers; a tag says which one is in use.

[P] stated in the paper; [B] as the bench has it (bench.scenario.yaml);
[A] assumed, with the reason.
"""

from dataclasses import dataclass, field

import numpy as np

from brace_drake.scenario.fields import items, number, vector, word

TAGS = ("idc", "pic", "mraic", "npic", "vpic", "pid")
AXES = ("x", "y", "z")

# kp, ki, kd and the integrals' limits, position then rotation.
_PID = (
    (4000, 4000, 4000, 50, 50, 50),
    (20000, 20000, 20000, 250, 250, 250),
    (120, 120, 120, 1.5, 1.5, 1.5),
    (60, 60, 60, 6, 6, 6),
)


@dataclass(slots=True)
class Estimation:
    """Pose, velocity and force from the readings, the same for all."""

    velocity_cutoff_hz: float = number(40.0, "Hz", above=0.0)  # [B]
    force_filter_tau: float = number(0.02, "s", above=0.0)  # [B]


@dataclass(slots=True)
class InnerLoop:
    """Inverse dynamics (6): gains of one ring (6,) or of all (6n,).

    `force_feedforward` names the coordinates whose measured force is fed
    forward: x, y, z of every ring, or y2 for that of the second moving ring
    from below alone.
    """

    # Position, then rotation [B]; the paper has 6500 and 1000 for the five
    # coordinates without an impedance.
    kp: np.ndarray = vector(*[1600] * 6, unit="1/s^2", above=0.0, per_ring=6)
    kd: np.ndarray = vector(*[80] * 6, unit="1/s", least=0.0, per_ring=6)
    force_feedforward: list[str] = items("y")  # [B]


@dataclass(slots=True)
class TargetImpedance:
    """M_d, C_d, K_d of equation (4), C_d = 2 damping_ratio sqrt(M_d K_d).

    Along x, y, z of one ring (3,) or of all (3n,). `coordinates` are those
    with an impedance, named as above; inverse dynamics holds the others. The
    rings' forces are measured, not their torques, so rotations have none.
    """

    coordinates: list[str] = items("y")  # [P]
    mass: np.ndarray = vector(2, 2, 2, unit="kg", above=0.0, per_ring=3)  # [P]
    stiffness: np.ndarray = vector(
        6000, 6000, 6000, unit="N/m", above=0.0, per_ring=3
    )  # [P]
    damping_ratio: float = number(1.0, least=0.05, most=10.0)  # [P]


@dataclass(slots=True)
class ReferenceAdaptation:
    """MRAIC; its reference impedance is the target impedance.

    A relative error of 1 in e and in e - e_m, both over `error_scale`, changes
    a parameter by its reference value within 1 / `rates`.
    """

    # Of M, C, K [A: M stays, the motion's acceleration is below the noise].
    rates: np.ndarray = vector(0, 3, 3, unit="1/s", least=0.0)
    # [A: the paper's end error is 0.31 mm]
    error_scale: float = number(0.0005, "m", above=0.0)
    # [A: forgets within minutes, a run lasts 12 s]
    leak: float = number(0.02, "1/s", least=0.0, most=1.0)
    # Over the reference [A].
    lower: np.ndarray = vector(0.5, 0.5, 0.33, least=0.01, most=1.0)
    upper: np.ndarray = vector(2, 3, 3, least=1.0, most=100.0)
    # Of error and force [A: near the impedance's own].
    filter_hz: float = number(5.0, "Hz", above=0.0)


@dataclass(slots=True)
class ImpedanceEstimation:
    """NPIC: recursive least squares and the force's correction."""

    # [A: small gain needs less than 1]
    kappa: float = number(0.5, least=0.0, most=0.95)
    # lambda of a tick [A: one second at 1 kHz]
    forgetting: float = number(0.999, least=0.9, most=1.0)
    # Of parameters over the desired, and of the trace [A].
    initial_covariance: float = number(1.0, "1/N^2", above=0.0)
    covariance_limit: float = number(100.0, "1/N^2", above=0.0)
    # Of the desired impedance's force: below it nothing is estimated [A:
    # several times the force noise behind the filter].
    excitation: float = number(0.2, "N", least=0.0)
    # Over the desired M, C, K [A].
    lower: np.ndarray = vector(0.2, 0.2, 0.2, least=0.01, most=1.0)
    upper: np.ndarray = vector(5, 5, 5, least=1.0, most=100.0)
    # Of error and force [A: near the impedance's own].
    filter_hz: float = number(5.0, "Hz", above=0.0)


@dataclass(slots=True)
class VariableStiffness:
    """VPIC and RLPIC: limits of the stiffness, and the rule without a policy.

    The rule rests at the target stiffness and settles at twice that where the
    error stays at `error_scale`.
    """

    lower: float = number(500.0, "N/m", above=0.0)  # [A: 4 N over 8 mm]
    # [A: just above the 49 990 learned in the paper]
    upper: float = number(50000.0, "N/m", above=0.0)
    # alpha over its largest value, 2 damping_ratio sqrt(lower / mass) [A]
    alpha_share: float = number(0.8, least=0.01, most=0.99)
    # [A: the paper's end error of PIC]
    error_scale: float = number(0.0003, "m", above=0.0)
    # Of e' + slide e [A: below the filter's own rate].
    slide: float = number(20.0, "1/s", above=0.0)
    # [A: relaxes within a hold]
    forgetting: float = number(0.5, "1/s", above=0.0)


@dataclass(slots=True)
class PoseForcePid:
    """PID of the pose, (6,) or (6n,); of the force where coordinates say so.

    Nothing is known of masses, and no force is fed forward but the weight.
    """

    # N/m, N m; ki over 0.2 s; N s/m, N m s [A].
    kp: np.ndarray = vector(*_PID[0], least=0.0, per_ring=6)
    ki: np.ndarray = vector(*_PID[1], least=0.0, per_ring=6)
    kd: np.ndarray = vector(*_PID[2], least=0.0, per_ring=6)
    # N, N m [A: half of what the legs can do].
    integral_limit: np.ndarray = vector(*_PID[3], least=0.0, per_ring=6)
    force_coordinates: list[str] = items()
    # On the torso [P: 4 N].
    desired_force: np.ndarray = vector(0, -4, 0, unit="N", per_ring=3)
    force_kp: float = number(0.5, least=0.0)  # [A]
    # [A: settles within a second]
    force_ki: float = number(5.0, "1/s", least=0.0)


@dataclass(slots=True)
class BraceControl:
    """All controllers' numbers; `tag` says which one is in use."""

    tag: str = word("pic", *(tag for tag in TAGS if tag != "pic"))
    rate: float = number(1000.0, "Hz", least=100.0, most=20000.0)  # [B]
    estimation: Estimation = field(default_factory=Estimation)
    inner: InnerLoop = field(default_factory=InnerLoop)
    impedance: TargetImpedance = field(default_factory=TargetImpedance)
    mraic: ReferenceAdaptation = field(default_factory=ReferenceAdaptation)
    npic: ImpedanceEstimation = field(default_factory=ImpedanceEstimation)
    vpic: VariableStiffness = field(default_factory=VariableStiffness)
    pid: PoseForcePid = field(default_factory=PoseForcePid)
