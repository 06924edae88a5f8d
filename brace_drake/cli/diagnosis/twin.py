"""The command `brace-drake twin`: the twin beside a device, live."""

from __future__ import annotations

import argparse
import time

from brace_drake.cli.machine.link_options import (
    AddCountdown,
    AddDevice,
    AddRing,
    load_device_motion,
    load_device_options,
)
from brace_drake.cli.options import (
    AddCommand,
    AddMotion,
    not_negative,
    positive_real,
)
from brace_drake.core.errors import StoppedError

_EPILOG = """\
example:
  brace-drake twin --port /dev/ttyACM0 --motion reversal --scenario \\
      results/monday/repaired.scenario.yaml

The device follows the motion, and the twin does the same beside it. A page
shows both in 3D, the twin as a ghost. It also shows their curves, the distance
between them in noise floors, and the stiffness and damping of the contact at
the moving ring. A channel that leaves its band raises an alarm; with
--stop-at-alarm it ends the motion. Only this machine can open the page, unless
--host says otherwise.
"""
_SHOW = 0.2


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `twin`."""
    parser = AddCommand(
        subparsers,
        "twin",
        Run,
        help="run the twin beside a device and show the gap",
        description="Compares a device with its twin while it moves.",
        epilog=_EPILOG,
    )
    AddDevice(parser)
    AddMotion(
        parser,
        default="reversal",
        help="reference (*.csv), or a motion of the library (default:"
        " reversal)",
    )
    AddRing(parser)
    parser.add_argument(
        "--band",
        type=positive_real,
        default=3.0,
        metavar="X",
        help="noise floors that a channel may be away without an alarm"
        " (default: 3)",
    )
    parser.add_argument(
        "--memory",
        type=positive_real,
        default=20.0,
        metavar="S",
        help="seconds over which the contact's stiffness and damping are"
        " estimated (default: 20)",
    )
    parser.add_argument(
        "--stop-at-alarm", action="store_true", help="end the motion with it"
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        metavar="A",
        help="address that the page is served at (default: 127.0.0.1, this"
        " machine alone)",
    )
    parser.add_argument(
        "--web-port",
        type=not_negative,
        default=0,
        metavar="N",
        help="port of the page (default: a free one)",
    )
    AddCountdown(parser)


def Run(args: argparse.Namespace) -> int:
    """Follows the motion once with the twin beside it."""
    from brace_drake.link.operation.beside import TwinBeside
    from brace_drake.link.operation.console import CountDown, ReadKeys
    from brace_drake.link.operation.motion import RING, desired_at_ticks
    from brace_drake.link.operation.page import Page
    from brace_drake.link.operation.session import Session
    from brace_drake.link.operation.station import (
        MakeControl,
        OpenDevice,
    )
    from brace_drake.playback.overlay import OverlayProcess

    scenario, limits = load_device_options(args)
    motion = load_device_motion(args.motion, scenario.stages, args.ring)
    scenario.torso.present = motion.contact
    with (
        Page(args.host, args.web_port) as page,
        OverlayProcess(scenario, args.host) as overlay,
    ):
        beside = TwinBeside(
            scenario, args.band, args.memory, limits, args.ring or RING
        )
        overlay.Wait()
        with (
            OpenDevice(
                args.port, scenario, limits, args.baud, args.clear
            ) as link,
            ReadKeys() as keys,
        ):
            print(f"page: {page.url}", flush=True)
            desired = desired_at_ticks(motion, link.hello.rate_hz)
            session = Session(link, MakeControl(scenario, limits), limits)
            show = _Show(beside, page, session, overlay, args.stop_at_alarm)
            CountDown(args.countdown, motion.name, keys)
            session.Follow(desired, show.Take, keys.pressed)
    if session.trip is not None:
        alarm = ", ".join(show.told) if args.stop_at_alarm else ""
        cause = f"alarm in {alarm}" if alarm else session.stopped_by
        raise StoppedError(f"{motion.name}: stopped: {cause}")
    k, c = beside.contact.values
    print(f"contact: {k:.0f} N/m, {c:.0f} N s/m")
    name, ratio = show.largest
    print(f"largest gap: {name}, {ratio:.1f} noise floors")
    return 0


class _Show:
    """Tells alarms, and the page what there is.

    Attributes:
        told: Channels that have had an alarm.
        largest: Channel of the largest gap so far, and that, noise floors.
    """

    def __init__(self, beside, page, session, overlay, stops: bool):
        self._beside, self._page, self._session = beside, page, session
        self._overlay, self._scene = overlay, overlay.port
        self._stops, self._shown = stops, 0.0
        self.told: list[str] = []
        self._present: list[str] = []
        self.largest = ("none", 0.0)

    def Take(self, rows) -> None:
        """Takes the device's ticks, in order."""
        from brace_drake.link.protocol.words import Cause

        for row in rows:
            self._beside.Take(row)
        said = self._beside.describe()
        for name in said["alarms"]:
            if name not in self._present:
                print(f"alarm: {name} leaves its band", flush=True)
            if name not in self.told:
                self.told.append(name)
        self._present = said["alarms"]
        worst = max(said["ratio"].items(), key=lambda item: item[1])
        self.largest = max(self.largest, worst, key=lambda item: item[1])
        if self._stops and self.told and not self._session.is_over:
            self._session.Stop(Cause.HOST_STOP)
        if time.monotonic() - self._shown > _SHOW:
            self._shown = time.monotonic()
            self._page.Show(said | {"scene": self._scene})
            self._overlay.Show(*self._beside.readings)
