"""Options of the commands that work with a device."""

from __future__ import annotations

import argparse

from brace_drake.cli.options import AddScenario, names_file
from brace_drake.errors import ScenarioError
from brace_drake.hardware.messages import BAUD


def AddDevice(parser: argparse.ArgumentParser) -> None:
    """Adds --port, --baud, --clear, --limits and --scenario."""
    parser.add_argument(
        "--port", required=True, metavar="P", help="such as /dev/ttyACM0"
    )
    parser.add_argument(
        "--baud", type=int, default=BAUD, metavar="N", help="bits a second"
    )
    parser.add_argument(
        "--clear",
        action="store_true",
        help="end a latched stop of the device first",
    )
    parser.add_argument(
        "--limits",
        metavar="FILE",
        help="limits to agree on (default: diagrams/limits.yaml)",
    )
    AddScenario(parser, "of the twin (default: the nominal bench)")


def AddCountdown(parser: argparse.ArgumentParser) -> None:
    """Adds --countdown."""
    parser.add_argument(
        "--countdown", type=int, default=3, metavar="S", help="default: 3"
    )


def AddRecording(parser: argparse.ArgumentParser) -> None:
    """Adds --out, --subject and --countdown."""
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="campaign's folder"
    )
    parser.add_argument("--subject", default="", metavar="TEXT")
    AddCountdown(parser)


def OpenRecorder(args: argparse.Namespace):
    """The recorder of `AddDevice` and `AddRecording`; a context manager.

    Raises:
        BraceError: As `load_device_options`, or the device or the folder is
            not what it should be.
    """
    from brace_drake.operation.recorder import Recorder

    scenario, limits = load_device_options(args)
    return Recorder(
        args.port,
        scenario,
        limits,
        args.out,
        args.subject,
        args.baud,
        args.clear,
    )


def load_device_motion(text: str):
    """What a device is to do: a motion of the library, or a reference.

    Raises:
        CampaignError: Neither.
        LimitsError: It reaches further than any may.
    """
    from brace_drake.twin.motion_library import MakeMotion, motion_of_run
    from brace_drake.twin.motion_limits import check_reach
    from brace_drake.twin.reference_file import LoadReference

    if names_file(text):
        motion = motion_of_run(LoadReference(text), f"from {text}")
    else:
        motion = MakeMotion(text)
    check_reach(motion.name, motion.samples[:, 0])
    return motion


def load_device_options(args: argparse.Namespace):
    """Scenario and limits of the options.

    Raises:
        ScenarioError, LimitsError: A file is not what it should be.
    """
    from brace_drake.hardware.limits_file import LoadLimits
    from brace_drake.scenario.bench import DEVICE, BenchScenario
    from brace_drake.scenario.load import LoadScenario

    limits = LoadLimits(args.limits)
    scenario = LoadScenario(args.scenario) if args.scenario else BenchScenario()
    if scenario.device != DEVICE:
        raise ScenarioError(
            f"{args.scenario}: the link is to a {DEVICE!r}, this is a"
            f" {scenario.device!r}"
        )
    return scenario, limits
