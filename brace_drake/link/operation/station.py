"""A device taken into use: hello, what it must be, limits, control."""

from __future__ import annotations

import dataclasses

import numpy as np

from brace_drake.core.errors import LinkError
from brace_drake.link.device.limits import Limits
from brace_drake.link.device.link import Link
from brace_drake.link.operation.control import HostControl
from brace_drake.link.protocol.messages import BAUD
from brace_drake.link.protocol.words import Cause, DeviceState, cause_name
from brace_drake.model.simulate_brace import recorded_device, recorded_stages
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.bench_numbers import pack_bench
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_geometry

# How far an anchor of device and twin may lie apart, m.
_SAME_PLACE = 5e-5
_LEGS = 6


def OpenDevice(
    path: str,
    scenario: BenchScenario | BraceScenario,
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


def CheckDevice(link: Link, scenario: BenchScenario | BraceScenario) -> None:
    """Refuses a device that is not the scenario's: kind, rate, geometry.

    Raises:
        LinkError: One line: what differs, and both values.
    """
    hello = link.hello
    who = f"{link.path}: device {hello.model!r} ({hello.identity})"
    model, geometry = device_model(scenario), describe_geometry(scenario)
    legs = _LEGS * len(geometry["rest"])
    if hello.model != model or _LEGS * hello.stages != legs:
        raise LinkError(
            f"{who} with {_LEGS * hello.stages} legs is not a"
            f" {model!r} with {legs}"
        )
    if hello.units != "m N s rad":
        raise LinkError(f"{who} has units {hello.units!r}, not 'm N s rad'")
    if abs(hello.rate_hz / scenario.control.rate - 1.0) > 1e-6:
        raise LinkError(
            f"{who} ticks at {hello.rate_hz:g} Hz, the scenario at"
            f" {scenario.control.rate:g}"
        )
    for name, mine in geometry.items():
        there = np.array(getattr(link.geometry, name))
        away = np.abs(there - mine.ravel())
        worst = int(np.argmax(away))
        if not away[worst] <= _SAME_PLACE:
            raise LinkError(
                f"{who}: geometry differs: {name}[{worst // 3}]"
                f".{'xyz'[worst % 3]} is {there[worst]:.5f} m, in the scenario"
                f" {mine.ravel()[worst]:.5f} m"
            )


def device_model(scenario: BenchScenario | BraceScenario) -> str:
    """What the device of a scenario is called: stage 2 alone is the bench."""
    return recorded_as(scenario)[0]


def recorded_as(
    scenario: BenchScenario | BraceScenario,
) -> tuple[str, tuple[int, ...]]:
    """Device of a campaign, and the stages that it has to name."""
    if isinstance(scenario, BraceScenario):
        return recorded_device(scenario), recorded_stages(scenario)
    return scenario.device, ()


def moving_rings(scenario: BenchScenario | BraceScenario) -> tuple[int, ...]:
    """Numbers of a device's moving rings, bottom to top."""
    return tuple(getattr(scenario, "stages", (2,)))


def describe_geometry(
    scenario: BenchScenario | BraceScenario,
) -> dict[str, np.ndarray]:
    """Rest (S, 3), lower and upper anchors (6 S, 3) in their rings, m."""
    if isinstance(scenario, BraceScenario):
        geometry = pack_geometry(scenario)
        lower = geometry.lower.copy()
        lower[0, :, 2] -= scenario.ring_heights[scenario.stages[0] - 1]
        return {
            "rest": geometry.rest,
            "lower": lower.reshape((-1, 3)),
            "upper": geometry.upper.reshape((-1, 3)),
        }
    numbers = pack_bench(scenario)
    lower = numbers.p_WB_known.copy()
    lower[:, 2] -= scenario.stage.lower_height
    rest = numbers.rest[None, :]
    return {"rest": rest, "lower": lower, "upper": numbers.p_RT_known}


def MakeControl(
    scenario: BenchScenario | BraceScenario,
    limits: Limits,
    tag: str | None = None,
) -> HostControl:
    """The host's controller of a scenario.

    Args:
        scenario: Of the device.
        limits: Of the stiffness and its rate.
        tag: Of the controller; None: the scenario's own.

    Raises:
        LinkError: No such controller for this device.
        ScenarioError: The scenario's numbers do not suit it.
    """
    if isinstance(scenario, BenchScenario):
        if tag not in (None, "pic"):
            raise LinkError(
                f"no controller {tag!r} in a scenario of the bench; there is"
                " pic (a scenario of a brace has them all)"
            )
    elif tag is not None:
        control = dataclasses.replace(scenario.control, tag=tag)
        scenario = dataclasses.replace(scenario, control=control)
    return HostControl(scenario, limits)
