"""Devices of others beside those of the package.

`register_device` adds one to this process; an installed package adds its own by
entry points of the group `brace_drake.devices`, each a `DeviceCard`, and the
command line then knows them too.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

from brace_drake.core.errors import CampaignError
from brace_drake.core.plugins import load_plugins
from brace_drake.devices.declaration import Device
from brace_drake.devices.device import DEVICES
from brace_drake.effects.registry import PLACES
from brace_drake.recording import columns
from brace_drake.scenario.load import SCHEMAS

ENTRY_POINTS = "brace_drake.devices"


@dataclass(frozen=True)
class DeviceCard:
    """All that the package has to know of a device.

    Attributes:
        name: As campaign.yaml has it.
        recorded: Its channels, with units and limits, and its nominal numbers.
        device: Made of a campaign, and of a scenario where one is given: the
            twin and the views on its recordings.
        schema: Dataclass of its scenario; None where it has no file.
        places: Plug points that its twin has, and what else effects need:
            those of the library whose needs are among these can occur.
    """

    name: str
    recorded: columns.Device
    device: type[Device]
    schema: type | None = None
    places: frozenset[str] = field(default_factory=frozenset)


def register_device(card: DeviceCard) -> DeviceCard:
    """Adds a device to all that this process does from now on.

    Returns:
        The card.

    Raises:
        CampaignError: There is a device of this name already.
    """
    if card.name in columns.DEVICES:
        raise CampaignError(f"device {card.name!r} is registered twice")
    columns.DEVICES[card.name] = card.recorded
    DEVICES[card.name] = card.device
    PLACES[card.name] = set(card.places)
    if card.schema is not None:
        SCHEMAS[card.name] = card.schema
    return card


def forget_device(name: str) -> None:
    """Takes back what `register_device` has added."""
    for table in (columns.DEVICES, DEVICES, PLACES, SCHEMAS):
        table.pop(name, None)


@cache
def load_installed() -> None:
    """Registers the devices of installed packages, once.

    Raises:
        CampaignError: A package's entry point cannot be loaded, or is none.
    """
    for card in load_plugins(ENTRY_POINTS, DeviceCard, "device", CampaignError):
        register_device(card)
