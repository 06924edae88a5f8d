"""What the diagnosis needs to know of each kind of device."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from brace_drake.campaign.recording import Campaign
from brace_drake.errors import CampaignError
from brace_drake.gap.bench_ladder import (
    bench_quantities,
    bench_rungs,
    prepared_phase_inputs,
)
from brace_drake.gap.ladder import Rung
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.leg_bench import MakeLegBenchScenario
from brace_drake.twin.bench_twin import BenchTwin
from brace_drake.twin.leg_bench_twin import LegBenchTwin


@dataclass(frozen=True)
class Device:
    """A twin and the views on its recordings.

    Attributes:
        twin: The nominal twin.
        rungs: Of the substitution ladder.
        quantities: From (twin, recording) to series of what users ask for.
        phase_inputs: From a prepared run to reference and force or None.
    """

    twin: object
    rungs: list[Rung]
    quantities: Callable
    phase_inputs: Callable


def MakeDevice(campaign: Campaign, scenario=None) -> Device:
    """The device of a campaign.

    Args:
        campaign: Whose device and numbers it takes.
        scenario: Of the bench, other than the one that comes with the package.

    Raises:
        CampaignError: No twin of this device yet.
    """
    if campaign.device == "bench stage 2":
        twin = BenchTwin(scenario or BenchScenario())
        return Device(
            twin,
            bench_rungs(twin, campaign.rate_hz),
            bench_quantities,
            prepared_phase_inputs,
        )
    if campaign.device == "leg bench":
        twin = LegBenchTwin(MakeLegBenchScenario(campaign))
        return Device(
            twin, _leg_rungs(twin), _leg_quantities, _leg_phase_inputs
        )
    raise CampaignError(
        f"{campaign.path}: there is no twin of device {campaign.device!r} yet;"
        " diagnosed are 'bench stage 2' and 'leg bench'"
    )


def _leg_rungs(twin: LegBenchTwin) -> list[Rung]:
    def controller(prepared, x, subject):
        if not twin.numbers.is_closed_loop:
            return None
        run = _with_channels(prepared.run, x)
        residual = x[:, 0] - twin.control_law(run)
        if twin.command_holds_external(prepared.run):
            residual = residual - run.channels.get("external_force_N", 0.0)
        return residual[np.isfinite(residual)]

    def actuation(prepared, x, subject):
        mass, viscous, offset = subject
        step = np.median(np.diff(prepared.run.time_s))
        position = _smooth(x[:, 1], step)
        velocity = np.gradient(position, step)
        asked = mass * np.gradient(velocity, step) + viscous * velocity + offset
        inner = slice(int(0.5 / step), -int(0.5 / step))
        return (_smooth(x[:, 0], step) - asked)[inner]

    return [
        Rung("controller", "position, reference", "command", controller),
        Rung("actuation", "command, motion", "balance of forces", actuation),
    ]


def _smooth(signal, step):
    from brace_drake.gap.ladder import low_pass

    return low_pass(signal, 20.0, 1.0 / step)


def _with_channels(run, x):
    from dataclasses import replace

    channels = dict(run.channels)
    channels["force_command_N"], channels["position_m"] = x[:, 0], x[:, 1]
    return replace(run, channels=channels)


def _leg_quantities(twin, x):
    return {"force_error_N": x[:, [0]], "position_error_mm": 1e3 * x[:, [1]]}


def _leg_phase_inputs(prepared):
    channels = prepared.run.channels
    return channels.get("position_desired_m", channels["position_m"]), None
