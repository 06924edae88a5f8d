"""A policy at run time: as a system of a diagram, and on a device."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from brace_drake.core.errors import PolicyError
from brace_drake.devices.motions.library import RATE_HZ, SafeMotion
from brace_drake.devices.motions.limits import check_reach
from brace_drake.laws.cubic import calc_cubic
from brace_drake.learning.policy import Policy
from brace_drake.learning.task import LearningTask, load_task_scenario
from brace_drake.link.operation.control import HostControl
from brace_drake.link.protocol.limits import Limits
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.control_numbers import spread

_ALONG = 1


class PolicySystem(LeafSystem):
    """A policy that sets the stiffness of `BraceVpic`: RLPIC at run time.

    At each decision the network acts on what the controller knew at its last
    tick, and a+ = a + cut(cut(action) - a) within `law.largest`; K(a) lies
    within the law's bounds whatever the network says (`actions.ActionLaw`).

    Input ports:
        estimate: X, X', filtered force (18n,), of the controller.
        desired: X_d, X_d', X_d'' (18n,).

    Output ports:
        stiffness: Of all coordinates (6n,), N/m, 0 where there is none.
        held_action: (k,).
    """

    def __init__(self, policy: Policy):
        super().__init__()
        self._policy, size = policy, len(policy.selected)
        self._ports = [
            self.DeclareVectorInputPort(name, 3 * size)
            for name in ("estimate", "desired")
        ]
        held = self.DeclareDiscreteState(policy.law.action(policy.law.start))
        self.DeclareVectorOutputPort(
            "stiffness",
            size,
            self._CalcStiffness,
            prerequisites_of_calc={self.discrete_state_ticket(held)},
        )
        self.DeclareStateOutputPort("held_action", held)
        self._held = int(held)
        period = policy.task.sample_time
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._Decide)

    def _Decide(self, context: Context, discrete) -> None:
        before = context.get_discrete_state(self._held).CopyToVector()
        action = self._policy.act_on(*(p.Eval(context) for p in self._ports))
        discrete.set_value(self._held, self._policy.law.limit(action, before))

    def _CalcStiffness(self, context: Context, output: BasicVector) -> None:
        held = context.get_discrete_state(self._held).value()
        stiffness = np.zeros(len(self._policy.selected))
        stiffness[self._policy.selected] = self._policy.law.stiffness(held)
        output.SetFromVector(stiffness)


def load_policy_scenario(
    policy: Policy, path: str | None = None
) -> BraceScenario:
    """The brace that a policy drives: the one of its training, or a file's.

    Raises:
        ScenarioError: The scenario cannot be read, or is none to learn on.
    """
    task = policy.task if path is None else replace(policy.task, scenario=path)
    return load_task_scenario(task)


def MakePolicyControl(
    policy: Policy, scenario: BraceScenario, limits: Limits
) -> HostControl:
    """The host's control with the stiffness that a policy asks for.

    Bounds and rate are held twice outside of the network: by the policy's own
    law (`actions.ActionLaw`) and by the limits of the device.

    Raises:
        PolicyError: The policy is for another number of rings.
        ScenarioError: Numbers that are not allowed.
    """
    rings, stages = len(policy.selected) // 6, len(scenario.stages)
    if rings != stages:
        raise PolicyError(
            f"the policy is for {rings} rings; allowed on the device: {stages}"
        )
    return HostControl(scenario, limits, PolicySystem(policy))


def motion_of_task(task: LearningTask, num_rings: int = 1) -> SafeMotion:
    """The motion that a policy was trained on, held for a second at its end.

    Args:
        task: Of the training.
        num_rings: That the device has.

    Raises:
        PolicyError: It is not along y alone.
        LimitsError: It reaches further than any may.
    """
    way = spread(task.displacement, num_rings).reshape((-1, 6))
    if np.delete(way, _ALONG, axis=1).any():
        raise PolicyError(
            "the motion of the training is not along y alone: choose another"
            " with --motion"
        )
    along = np.ascontiguousarray(way[:, _ALONG])
    duration = min(task.motion_time, task.max_steps * task.sample_time)
    time = np.arange(round((duration + 1.0) * RATE_HZ)) / RATE_HZ
    samples = np.empty((len(time), 3, num_rings))
    for row, t in zip(samples, time, strict=True):
        flat = row.reshape(-1)
        calc_cubic(t, task.motion_time, np.zeros(num_rings), along, flat)
    if num_rings == 1:
        samples = np.ascontiguousarray(samples[:, :, 0])
    check_reach("training", samples[:, 0])
    meaning = f"{1e3 * np.abs(way).max():g} mm in {task.motion_time:g} s"
    return SafeMotion("training", meaning, True, "push", time, samples)
