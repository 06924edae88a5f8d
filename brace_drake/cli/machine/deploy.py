"""The command `brace-drake deploy`: a controller or a policy on a device."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

from brace_drake.cli.machine.link_options import (
    AddCountdown,
    AddDevice,
    AddRing,
    load_device_motion,
    load_device_options,
)
from brace_drake.cli.options import AddCommand, AddMotion
from brace_drake.core.output import HoldFolder

_EPILOG = """\
example:
  brace-drake deploy --port /dev/ttyACM0 --controller pic --dry-run
  brace-drake deploy --port /dev/ttyACM0 --controller pic --motion push \\
      --out runs/tuesday
  brace-drake deploy --port /dev/ttyACM0 --scenario brace.scenario.yaml \\
      --controller mraic --motion push
  brace-drake deploy --port /dev/ttyACM0 --policy runs/paper/best.npz

Before the device is armed, device and twin must agree on kind, rate, geometry
and limits, and a dry run of two seconds must have kept its time. --dry-run ends
there.

A policy (of `train`) sets the stiffness of the variable impedance control.
Bounds and rate of the stiffness are enforced outside of the network, and once
more by the limits of the device. The policy's scenario is a brace with as many
stages as it was trained for, by default that of its training; stage 2 alone is
the bench.

--out gets ticks.csv of the last run, and timing.json of both runs. A stopped
run is there too, with the cause. A motion beyond 12 mm is refused.
"""
_DRY_SECONDS = 2.0


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `deploy`."""
    parser = AddCommand(
        subparsers,
        "deploy",
        Run,
        help="run a controller or a policy on a device",
        description="Runs a controller or a policy on a device.",
        epilog=_EPILOG,
    )
    AddDevice(parser)
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--controller",
        metavar="TAG",
        help="controller: idc, pic, mraic, npic, vpic or pid (default: the"
        " scenario's own)",
    )
    what.add_argument("--policy", metavar="FILE", help="*.npz of a training")
    AddMotion(
        parser,
        help="reference (*.csv), or a motion of the library (default: push; of"
        " a policy, that of its training)",
    )
    AddRing(parser)
    add = parser.add_argument
    add("--dry-run", action="store_true", help="end before the device is armed")
    add("--out", metavar="DIR", help="folder for log and timing")
    AddCountdown(parser)


def Run(args: argparse.Namespace) -> int:
    """Dry run, then the motion; prints and writes the timing."""
    import numpy as np

    from brace_drake.link.operation.console import CountDown, ReadKeys
    from brace_drake.link.operation.deploy import (
        RunController,
        RunLog,
        check_dry_run,
    )
    from brace_drake.link.operation.motion import desired_at_ticks
    from brace_drake.link.operation.station import OpenDevice

    load = _load_controller if args.policy is None else _load_policy
    motion, scenario, limits, control = load(args)
    log = None
    if args.out:
        log = RunLog(HoldFolder(Path(args.out)), tuple(scenario.stages))

    def run(name, desired, is_dry):
        keep = {"keep": partial(log.Write, name)} if log else {}
        session = RunController(
            link, control, limits, desired, is_dry, keys.pressed, **keep
        )
        print(f"{name.replace('_', ' ')}: {session.tally}", flush=True)
        return session.tally

    with (
        OpenDevice(args.port, scenario, limits, args.baud, args.clear) as link,
        ReadKeys() as keys,
    ):
        rate = link.hello.rate_hz
        desired = desired_at_ticks(motion, rate)
        still = np.zeros((round(_DRY_SECONDS * rate), *desired.shape[1:]))
        check_dry_run(run("dry_run", still, True))
        if not args.dry_run:
            CountDown(args.countdown, motion.name, keys)
            run("armed", desired, False)
    if log:
        print(f"log: {Path(args.out) / 'ticks.csv'}")
    return 0


def _load_controller(args: argparse.Namespace):
    """Motion, scenario, limits and control of --controller."""
    from brace_drake.link.operation.station import MakeControl

    scenario, limits = load_device_options(args)
    name = args.motion or "push"
    motion = load_device_motion(name, scenario.stages, args.ring)
    control = MakeControl(scenario, limits, args.controller)
    return motion, scenario, limits, control


def _load_policy(args: argparse.Namespace):
    """Motion, scenario, limits and control of --policy."""
    from brace_drake.learning.deployment import (
        MakePolicyControl,
        load_policy_scenario,
        motion_of_task,
    )
    from brace_drake.learning.policy import LoadPolicy
    from brace_drake.link.device.limits_file import LoadLimits

    policy = LoadPolicy(args.policy)
    scenario, law = load_policy_scenario(policy, args.scenario), policy.law
    limits = LoadLimits(args.limits, scenario.stages)
    control = MakePolicyControl(policy, scenario, limits)
    if args.motion is None:
        motion = motion_of_task(policy.task, len(scenario.stages))
    else:
        motion = load_device_motion(args.motion, scenario.stages, args.ring)
    print(
        f"stiffness: {law.lower:g} to {law.upper:g} N/m by the policy, at most"
        f" {limits.stiffness:g} N/m and {limits.stiffness_rate:g} N/m/s by the"
        " limits"
    )
    return motion, scenario, limits, control
