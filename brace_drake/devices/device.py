"""Which device a campaign was recorded on."""

from __future__ import annotations

from brace_drake.core.errors import CampaignError, ScenarioError
from brace_drake.devices.axis.device import Axis
from brace_drake.devices.bench.device import Bench
from brace_drake.devices.brace.device import Brace
from brace_drake.devices.declaration import Device
from brace_drake.devices.diagram.device import DiagramDevice
from brace_drake.devices.leg_bench.device import LegBench
from brace_drake.devices.nominal_scenario import choose_scenario
from brace_drake.devices.pad_bench.device import PadBench
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.recording.columns import AXIS, BRACE, DIAGRAM, LEG_BENCH
from brace_drake.recording.recording import Campaign

DEVICES: dict[str, type[Device]] = {
    "bench stage 2": Bench,
    "leg bench": LegBench,
    "pad bench": PadBench,
    "axis": Axis,
    BRACE: Brace,
    DIAGRAM: DiagramDevice,
}


def MakeDevice(campaign: Campaign, scenario=None, diagram=None) -> Device:
    """The device of a campaign.

    Args:
        campaign: Whose device and numbers it takes.
        scenario: Of the device, or its file, other than the one that the
            campaign names, that comes with the package or from the recording
            itself.
        diagram: Function that makes the nominal diagram of a campaign whose
            device is one.

    Raises:
        CampaignError: No twin of this device yet, or a scenario of another.
        ScenarioError: The scenario's file is no scenario.
    """
    scenario = choose_scenario(campaign, scenario).scenario
    if diagram is not None and campaign.device != DIAGRAM:
        raise CampaignError(
            f"{campaign.path}: recorded on {campaign.device!r}; a diagram is"
            f" for device: {DIAGRAM}"
        )
    if campaign.device not in DEVICES:
        names = ", ".join(repr(name) for name in DEVICES)
        raise CampaignError(
            f"{campaign.path}: there is no twin of device {campaign.device!r}"
            f" yet; diagnosed are {names}"
        )
    device = campaign.device
    # The position of a drive without a known loop would drift with every error
    # of the model: its motion is imposed.
    is_open = device == LEG_BENCH and not campaign.control
    if campaign.device == DIAGRAM:
        return DiagramDevice(campaign, scenario, diagram)
    if scenario is None:
        return DEVICES[AXIS if is_open else device](campaign)
    if scenario.device != device and not (is_open and scenario.device == AXIS):
        raise CampaignError(
            f"{campaign.path}: recorded on {device!r}, but the scenario is of"
            f" {scenario.device!r}"
        )
    return DEVICES[scenario.device](campaign, scenario)


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
