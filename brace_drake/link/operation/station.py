"""A device taken into use: hello, what it must be, limits, control."""

from __future__ import annotations

import dataclasses

from brace_drake.core.errors import LinkError
from brace_drake.link.device.guards import LEGS
from brace_drake.link.emulator.describe import describe_device
from brace_drake.link.host.link import Link
from brace_drake.link.operation.control import HostControl
from brace_drake.link.protocol.limits import Limits
from brace_drake.link.protocol.messages import BAUD
from brace_drake.link.protocol.words import Cause, DeviceState, cause_name
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.check import CheckScenario

# How far an anchor of device and twin may lie apart, m.
_SAME_PLACE = 5e-5


def OpenDevice(
    path: str,
    scenario: BraceScenario,
    limits: Limits,
    baud: int = BAUD,
    clear: bool = False,
) -> Link:
    """Connects, compares the device with the twin, agrees on limits.

    Args:
        path, baud: Of the port.
        scenario: What the device must be.
        limits: To agree on.
        clear: Whether a latched stop is to be ended, which is for an operator
            to decide.

    Raises:
        LinkError: Not reachable, or not the device of the scenario.
        LimitsError: The limits are wider than the device's.
    """
    link = Link(path, baud)
    try:
        link.Connect()
        CheckDevice(link, scenario)
        link.Agree(limits)
        _TreatStop(link, clear)
    except BaseException:
        link.Close()
        raise
    return link


def _TreatStop(link: Link, clear: bool) -> None:
    """Clears a latched stop, or says that there is one."""
    if link.hello.state not in (DeviceState.STOPPED, DeviceState.FAULT):
        return
    state = link.WaitForState()
    if state.state not in (DeviceState.STOPPED, DeviceState.FAULT):
        return
    if not clear:
        raise LinkError(
            f"{link.path}: the device holds a stop:"
            f" {cause_name(state.cause)}; when it is safe, add --clear"
        )
    link.Clear(Cause(state.cause))


def CheckDevice(link: Link, scenario: BraceScenario) -> None:
    """Refuses a device that is not the scenario's: kind, rate, geometry.

    Raises:
        LinkError: One line: what differs, and both values.
    """
    hello, mine = link.hello, describe_device(scenario)
    who = f"{link.path}: device {hello.model!r} ({hello.identity})"
    if (hello.model, hello.stages) != (mine.model, mine.stages):
        raise LinkError(
            f"{who} with {LEGS * hello.stages} legs is not a"
            f" {mine.model!r} with {LEGS * mine.stages}"
        )
    if hello.units != mine.units:
        raise LinkError(f"{who} has units {hello.units!r}, not {mine.units!r}")
    # Written so that what is no number differs.
    if not abs(hello.rate_hz / mine.rate_hz - 1.0) <= 1e-6:
        raise LinkError(
            f"{who} ticks at {hello.rate_hz:g} Hz, the scenario at"
            f" {mine.rate_hz:g}"
        )
    for name in ("rest", "lower", "upper"):
        here, there = getattr(mine, name), getattr(link.geometry, name)
        for i, (a, b) in enumerate(zip(here, there, strict=True)):
            if not abs(a - b) <= _SAME_PLACE:
                raise LinkError(
                    f"{who}: geometry differs: {name}[{i // 3}]"
                    f".{'xyz'[i % 3]} is {b:.5f} m, in the scenario {a:.5f} m"
                )


def MakeControl(
    scenario: BraceScenario,
    limits: Limits,
    tag: str | None = None,
) -> HostControl:
    """The host's controller of a scenario.

    Args:
        scenario: Of the device.
        limits: Of the stiffness and its rate.
        tag: Of the controller; None: the scenario's own.

    Raises:
        ScenarioError: The scenario's numbers do not suit it.
    """
    if tag is not None:
        control = dataclasses.replace(scenario.control, tag=tag)
        scenario = dataclasses.replace(scenario, control=control)
        CheckScenario(scenario, "--controller")
    return HostControl(scenario, limits)
