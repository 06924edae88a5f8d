"""What a policy says: the desired impedance for a displacement and a subject.

The paper's flow from the virtual to the physical: the twin of a subject is
moved by the desired displacement under the policy, and the stiffness that it
settles on is what the physical brace is to be given.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np

from brace_drake.core.errors import PolicyError
from brace_drake.learning.env import RlpicEnv
from brace_drake.learning.episode import EpisodeLog, run_episode
from brace_drake.learning.policy import Policy
from brace_drake.learning.signals import name_of
from brace_drake.learning.subjects import FACTORS, Subject
from brace_drake.scenario.control_numbers import spread


@dataclass(frozen=True)
class Prediction:
    """Desired impedance of the coordinates with one, and what it does.

    Attributes:
        names: Of those coordinates.
        mass, damping, stiffness: M_d, C_d = 2 ratio sqrt(M_d K_d), K_d (k,):
            means over the second half of the motion.
        spread: Standard deviation of K_d there (k,), N/m.
        lowest, highest: Of K_d over the whole motion (k,).
        at_bound: Whether the mean lies within 1 % of an end of the range (k,).
        error: Root mean square of X_d - X along them (k,), m.
        force: Largest force of the torso along them (k,), N.
        log: The episode.
    """

    names: tuple[str, ...]
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    spread: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray
    at_bound: np.ndarray
    error: np.ndarray
    force: np.ndarray
    log: EpisodeLog


def predict_impedance(
    policy: Policy,
    displacement: np.ndarray | None = None,
    factors: dict[str, float] | None = None,
) -> Prediction:
    """Runs the twin of a subject under a policy.

    Args:
        policy: Trained.
        displacement: What the motion adds to the start, (6,) or (6n,), m and
            rad; None: that of its task.
        factors: On the scenario's numbers, by name, see `SubjectRanges`.

    Raises:
        PolicyError: No such factor, or the motion broke off: the cause.
    """
    factors = factors or {}
    for name, value in factors.items():
        if name not in FACTORS or not value > 0.0:
            raise PolicyError(
                f"subject: {name}={value:g}; allowed: above 0, of"
                f" {', '.join(FACTORS)}"
            )
    task = copy.deepcopy(policy.task)
    if displacement is not None:
        task.displacement = np.asarray(displacement, dtype=float)
    env = RlpicEnv(task)
    subject = Subject(factors)
    log = run_episode(env, policy.act, options={"subject": subject})
    if log.cause:
        raise PolicyError(
            f"the motion broke off after {len(log.rewards)} decisions:"
            f" {log.cause}"
        )
    return _summarize(env, policy, log)


def _summarize(env: RlpicEnv, policy: Policy, log: EpisodeLog) -> Prediction:
    on, scenario = policy.selected, env.scenario
    settled = log.stiffness[len(log.stiffness) // 2 :]
    K = settled.mean(axis=0)
    impedance, n = scenario.control.impedance, len(on) // 6
    M = spread(impedance.mass, n, 3)[on]
    slack = 0.01 * (policy.law.upper - policy.law.lower)
    near = np.minimum(K - policy.law.lower, policy.law.upper - K) < slack
    error = (log.signals.desired - log.signals.position)[:, on]
    return Prediction(
        names=tuple(name_of(i, scenario.rings) for i in np.flatnonzero(on)),
        mass=M,
        damping=2.0 * impedance.damping_ratio * np.sqrt(M * K),
        stiffness=K,
        spread=settled.std(axis=0),
        lowest=log.stiffness.min(axis=0),
        highest=log.stiffness.max(axis=0),
        at_bound=near,
        error=np.sqrt(np.mean(error**2, axis=0)),
        force=np.abs(log.signals.force[:, on]).max(axis=0),
        log=log,
    )
