"""What the diagnosis needs to know of each kind of device."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from brace_drake.core.errors import CampaignError, ScenarioError
from brace_drake.devices.bench.block_tests import (
    bench_quantities,
    bench_rungs,
    bench_signals,
)
from brace_drake.devices.bench.imposed_twin import GuidedBenchTwin
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.leg_bench.block_tests import (
    leg_quantities,
    leg_rungs,
    leg_signals,
)
from brace_drake.devices.leg_bench.twin import LegBenchTwin
from brace_drake.devices.motions.library import (
    MOTIONS,
    RATE_HZ,
    MakeMotion,
    MotionSet,
)
from brace_drake.devices.motions.limits import (
    exceeded_limit,
    leg_motions,
    pad_motions,
)
from brace_drake.devices.pad_bench.block_tests import (
    pad_quantities,
    pad_rungs,
    pad_signals,
)
from brace_drake.devices.pad_bench.twin import PadBenchTwin
from brace_drake.isolation.bench_attribution import attribute_bench
from brace_drake.isolation.block_tests import Rung
from brace_drake.isolation.force_balance import explain_imbalance
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.recording.recording import Campaign, Run
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.leg_bench import MakeLegBenchScenario
from brace_drake.scenario.pad_bench import MakePadBenchScenario


@dataclass(frozen=True)
class Device:
    """A twin and the views on its recordings.

    Attributes:
        twin: The nominal twin.
        rungs: Of the substitution ladder.
        quantities: From (twin, recording) to series of what users ask for.
        motion_signals: From (twin, prepared run, subject values) to what phases
            of the motion are read from.
        motions: From (twin, recorded runs, their rate in Hz) to motions that
            the device may be asked for; None where none is known to be safe.
        attribute: From (evaluator, nominal fit, seed) to shares of the blocks
            in a gap that no effect explains; None where that is not known.
        guided: The twin with its ring carried along the recorded way; None
            where there is no ring.
        balance: From (twin, prepared runs, rate in Hz, the ladder's row of the
            drives) to whose errors the balance of the leg forces shows; None
            where there is no such balance.
    """

    twin: object
    rungs: list[Rung]
    quantities: Callable
    motion_signals: Callable
    motions: Callable
    attribute: Callable | None = None
    guided: GuidedBenchTwin | None = None
    balance: Callable | None = None


def MakeDevice(campaign: Campaign, scenario=None) -> Device:
    """The device of a campaign.

    Args:
        campaign: Whose device and numbers it takes.
        scenario: Of the device, other than the one that comes with the
            package or from the recording itself.

    Raises:
        CampaignError: No twin of this device yet, or a scenario of another.
    """
    if campaign.device not in _DEVICES:
        names = ", ".join(repr(name) for name in _DEVICES)
        raise CampaignError(
            f"{campaign.path}: there is no twin of device {campaign.device!r}"
            f" yet; diagnosed are {names}"
        )
    if scenario is not None and scenario.device != campaign.device:
        raise CampaignError(
            f"{campaign.path}: recorded on {campaign.device!r}, but the"
            f" scenario is of {scenario.device!r}"
        )
    return _DEVICES[campaign.device](campaign, scenario)


def check_room(twin) -> None:
    """Checks that a twin takes an effect beside those that it carries.

    Raises:
        ScenarioError: It carries as many as it can.
    """
    if len(twin.carried) >= MAX_EFFECTS:
        raise ScenarioError(
            f"the scenario carries {len(twin.carried)} effects, and the twin at"
            f" most {MAX_EFFECTS}: none can be tested beside them"
        )


def _MakeBench(campaign: Campaign, scenario) -> Device:
    twin = BenchTwin(scenario or BenchScenario())
    rungs = bench_rungs(twin, campaign.rate_hz)
    return Device(
        twin,
        rungs,
        bench_quantities,
        bench_signals,
        _bench_motions,
        attribute_bench,
        GuidedBenchTwin(twin.scenario, twin.time_step),
        explain_imbalance,
    )


def _bench_motions(twin, runs: Sequence[Run], rate: float) -> MotionSet:
    """The library's with and without the torso, as far as recorded."""
    recorded = {run.contact for run in runs}
    library = [MakeMotion(name) for name in MOTIONS]
    chosen = [m for m in library if m.contact in recorded]
    return MotionSet(RATE_HZ, chosen, exceeded_limit)


def _MakeLegBench(campaign: Campaign, scenario) -> Device:
    twin = LegBenchTwin(scenario or MakeLegBenchScenario(campaign))
    return Device(
        twin, leg_rungs(twin), leg_quantities, leg_signals, leg_motions
    )


def _MakePadBench(campaign: Campaign, scenario) -> Device:
    twin = PadBenchTwin(scenario or MakePadBenchScenario(campaign))
    return Device(
        twin, pad_rungs(twin), pad_quantities, pad_signals, pad_motions
    )


_DEVICES = {
    "bench stage 2": _MakeBench,
    "leg bench": _MakeLegBench,
    "pad bench": _MakePadBench,
}
