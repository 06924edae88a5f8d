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
    count_to,
    positive_real,
)
from brace_drake.core.errors import BraceError, StoppedError

_EPILOG = """\
example:
  brace-drake twin --port /dev/ttyACM0 --motion reversal --scenario \\
      results/monday/repaired.scenario.yaml

  brace-drake twin --port /dev/ttyACM0 --cycles 40 --out recordings/tuesday

The device follows the motion, and the twin does the same beside it. A page
shows both in 3D, the twin as a ghost. It also shows their curves, the distance
between them in noise floors, and the stiffness and damping of the contact at
the moving ring. A channel that leaves its band raises an alarm; with
--stop-at-alarm it ends the motion. Only this machine can open the page, unless
--host says otherwise.

With --out the motion is repeated, with the way home and 2 s of rest after
each cycle. Each cycle is kept as a run of a campaign. Of several cycles the
first is usual: what device and twin differ by then, the subject above all, is
expected from then on. Page and terminal say since when the device is not as
expected. They name the three effects of the library that explain it best. A
process of its own looks for them, by the search of a diagnosis. Cycles after
the change are in DIR/since. `brace-drake diagnose` takes both folders.
"""
_SHOW = 0.2
# A recording begins at rest, s.
_SETTLE = 4.0
# Cycles of a recording, a day of the shortest; ports of a machine.
_MOST_CYCLES, _MOST_PORT = 100_000, 65_535


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
        type=count_to(_MOST_PORT, 0),
        default=0,
        metavar="N",
        help="port of the page (default: a free one)",
    )
    AddCountdown(parser)
    _AddWatching(parser)


def _AddWatching(parser: argparse.ArgumentParser) -> None:
    """Adds --out, --cycles, --usual and --false-alarms."""
    add = parser.add_argument
    add(
        "--out",
        metavar="DIR",
        help="folder of a campaign to keep the recording in; then changes are"
        " watched for, and their causes named",
    )
    add(
        "--cycles",
        type=count_to(_MOST_CYCLES),
        default=1,
        metavar="N",
        help="times that the motion is driven; needs --out (default: 1)",
    )
    add(
        "--usual",
        type=count_to(_MOST_CYCLES, 0),
        metavar="N",
        help="cycles at the beginning that are taken as usual; 0: the twin is"
        " expected (default: 1 of several, 0 of one)",
    )
    add(
        "--false-alarms",
        type=positive_real,
        default=0.1,
        metavar="X",
        help="changes told in an hour by mistake, at most, on average (default:"
        " 0.1)",
    )


def Run(args: argparse.Namespace) -> int:
    """Follows the motion once with the twin beside it."""
    from brace_drake.link.operation.beside import TwinBeside
    from brace_drake.link.operation.console import CountDown, ReadKeys
    from brace_drake.link.operation.live.observer import OpenObserver
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
    motion, expected = _plan(args, scenario, motion)
    settle = {"settle": _SETTLE} if expected else {}
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
            OpenObserver(
                expected, args.out, link.hello, args.scenario
            ) as observer,
        ):
            print(f"page: {page.url}", flush=True)
            desired = desired_at_ticks(motion, link.hello.rate_hz)
            session = Session(link, MakeControl(scenario, limits), limits)
            show = _Show(
                beside, page, session, overlay, args.stop_at_alarm, observer
            )
            CountDown(args.countdown, motion.name, keys)
            session.Follow(desired, show.Take, keys.pressed, **settle)
            if observer:
                observer.is_whole = session.done
    if session.trip is not None:
        alarm = ", ".join(show.told) if args.stop_at_alarm else ""
        cause = f"alarm in {alarm}" if alarm else session.stopped_by
        raise StoppedError(f"{motion.name}: stopped: {cause}")
    k, c = beside.contact.values
    print(f"contact: {k:.0f} N/m, {c:.0f} N s/m")
    name, ratio = show.largest
    print(f"largest gap: {name}, {ratio:.1f} noise floors")
    return 0


def _plan(args: argparse.Namespace, scenario, motion):
    """The motion to drive, and what is expected of it; None without --out.

    Raises:
        BraceError: Options that need each other.
    """
    from brace_drake.monitoring.cycles import close_cycle, repeat_cycle
    from brace_drake.monitoring.prepare import make_expected

    if args.out is None:
        if args.cycles > 1 or args.usual is not None:
            raise BraceError("--cycles and --usual need --out DIR")
        return motion, None
    cycle = close_cycle(motion)
    usual = int(args.cycles > 1) if args.usual is None else args.usual
    if 0 < args.cycles <= usual:
        raise BraceError(
            f"--usual {usual}: of {args.cycles} cycles none is left to watch"
        )
    expected = make_expected(scenario, cycle, usual, args.false_alarms)
    return repeat_cycle(cycle, args.cycles), expected


class _Show:
    """Tells alarms, and the page what there is.

    Attributes:
        told: Channels that have had an alarm.
        largest: Channel of the largest gap so far, and that, noise floors.
    """

    def __init__(self, beside, page, session, overlay, stops, observer):
        self._beside, self._page, self._session = beside, page, session
        self._overlay, self._scene = overlay, overlay.port
        self._stops, self._shown, self._observer = stops, 0.0, observer
        self.told: list[str] = []
        self._present: list[str] = []
        self.largest = ("none", 0.0)

    def Take(self, rows) -> None:
        """Takes the device's ticks, in order."""
        from brace_drake.link.protocol.words import Cause

        observer = self._observer
        for row in rows:
            self._beside.Take(row)
            if observer:
                observer.Take(row.tick, self._beside.difference)
        if observer:
            observer.Look(rows)
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
            more = {"watched": observer.describe()} if observer else {}
            self._page.Show(said | {"scene": self._scene} | more)
            self._overlay.Show(*self._beside.readings)
