"""Options of the commands that work with a device."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from brace_drake.cli.options import (
    AddScenario,
    count_to,
    names_file,
    positive,
)
from brace_drake.core.errors import CampaignError, ScenarioError
from brace_drake.link.protocol.messages import BAUD
from brace_drake.recording.columns import BENCH, BRACE

# Bits a second, more than a USB port has; seconds, a day.
_MOST_BAUD, _MOST_COUNTDOWN = 1_000_000_000, 86_400


def AddDevice(parser: argparse.ArgumentParser) -> None:
    """Adds --port, --baud, --clear, --limits and --scenario."""
    add = parser.add_argument
    add(
        "--port",
        required=True,
        metavar="P",
        help="serial port, such as /dev/ttyACM0",
    )
    add(
        "--baud",
        type=count_to(_MOST_BAUD),
        default=BAUD,
        metavar="N",
        help=f"speed of the port, bits a second (default: {BAUD})",
    )
    add(
        "--clear",
        action="store_true",
        help="end a latched stop of the device first",
    )
    add(
        "--limits",
        metavar="FILE",
        help="limits to agree on (default: diagrams/limits.yaml)",
    )
    AddScenario(
        parser,
        "file of the device, bench or brace (default: the nominal bench)",
    )


def AddRing(parser: argparse.ArgumentParser) -> None:
    """Adds --ring."""
    parser.add_argument(
        "--ring",
        type=positive,
        metavar="N",
        help="ring of a brace that motions of the library move; the others are"
        " held (default: 2)",
    )


def AddCountdown(parser: argparse.ArgumentParser) -> None:
    """Adds --countdown."""
    parser.add_argument(
        "--countdown",
        type=count_to(_MOST_COUNTDOWN, 0),
        default=3,
        metavar="S",
        help="seconds until it moves (default: 3)",
    )


def AddRecording(parser: argparse.ArgumentParser) -> None:
    """Adds --out, --subject, --ring and --countdown."""
    add = parser.add_argument
    add(
        "--out",
        required=True,
        metavar="DIR",
        help="folder of the campaign, new or to continue",
    )
    add(
        "--subject",
        default="",
        metavar="TEXT",
        help="who or what is in the brace, free text",
    )
    AddRing(parser)
    AddCountdown(parser)


def OpenRecorder(args: argparse.Namespace):
    """The recorder of `AddDevice` and `AddRecording`; a context manager.

    Raises:
        BraceError: As `load_device_options`, or the device or the folder is
            not what it should be.
    """
    from brace_drake.link.operation import Recorder
    from brace_drake.link.operation.motion import RING

    scenario, limits = load_device_options(args)
    return Recorder(
        args.port, scenario, limits, args.out, args.subject, args.baud,
        args.clear, args.ring or RING,
    )  # fmt: skip


def load_device_motion(
    text: str, rings: Sequence[int] = (2,), ring: int | None = None
):
    """What a device is to do: a motion of the library, or a reference.

    Args:
        text: Name or file.
        rings: Numbers of the device's moving rings, bottom to top.
        ring: That a motion of the library moves; None: ring 2.

    Raises:
        CampaignError: Neither, or of another ring.
        LimitsError: It reaches further than any may.
    """
    from brace_drake.devices.motions.library import MakeMotion
    from brace_drake.devices.motions.limits import check_reach
    from brace_drake.devices.motions.reference import LoadReference
    from brace_drake.link.operation.motion import (
        RING,
        motion_of_rings,
        place_motion,
    )

    if not names_file(text):
        motion = place_motion(MakeMotion(text), rings, ring or RING)
    elif ring is not None:
        raise CampaignError(
            f"--ring {ring}: the columns of {text} say which rings move"
        )
    else:
        run = LoadReference(text, tuple(rings))
        motion = motion_of_rings(run, rings, f"from {text}")
    check_reach(motion.name, motion.samples[:, 0])
    return motion


def load_device_options(args: argparse.Namespace):
    """Scenario and limits of the options; the nominal bench by default.

    Raises:
        ScenarioError, LimitsError: A file is not what it should be, or of
            something else.
    """
    from brace_drake.link.device import LoadLimits
    from brace_drake.scenario.brace import BenchScenario
    from brace_drake.scenario.load import LoadScenario

    path = args.scenario
    scenario = LoadScenario(path) if path else BenchScenario()
    if scenario.device not in (BENCH, BRACE):
        raise ScenarioError(
            f"{path}: on the link there is a {BENCH!r} or a {BRACE!r}, this is"
            f" a {scenario.device!r}"
        )
    return scenario, LoadLimits(args.limits, scenario.stages)
