"""The command `brace-drake emulate`: a brace that is not there."""

from __future__ import annotations

import argparse
import contextlib
import os
import shlex
import signal
import sys
import threading

from brace_drake.cli.options import AddCommand, not_negative, positive_real
from brace_drake.core.errors import BraceError, LinkError

_EPILOG = """\
example:
  brace-drake emulate --link /tmp/brace --effect relaxation
  brace-drake record --port /tmp/brace --motion push --out recordings/monday

  brace-drake emulate --link /tmp/brace --scenario diagrams/brace.scenario.yaml

Lines on standard input change it while it runs:
  torso on|off               the subject comes or goes
  rest                       ring and torso are put back at rest
  estop on|off               the emergency stop
  drive on|off               a drive's own fault
  stuck 3 | frozen 3 | free  leg 3 jams | its reading stands still | neither
  to-host drop 0.01          drop, corrupt, truncate, duplicate, reorder: share
  to-device delay 0.005      of frames; delay: s
  noise 500                  bytes of noise before each hello
  unplug | plug              the line
  effect NAME[:P=V,...]      an effect of the library begins, while all moves
  stop                       end
"""
_LONGEST_LINE, _MOST_NOISE = 1000, 100_000


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `emulate`."""
    parser = AddCommand(
        subparsers,
        "emulate",
        Run,
        help="serve an emulated brace on a pseudo-terminal",
        description="Emulates a device with the laws of bench or brace.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("--link", metavar="PATH", help="symbolic link to make to the terminal")
    add(
        "--scenario",
        metavar="FILE",
        help="file of the bench, or of a brace in task space with linear pads"
        " (default: nominal bench)",
    )
    add(
        "--limits", metavar="FILE", help="the device's own (default: package's)"
    )
    add(
        "--effect",
        action="append",
        default=[],
        metavar="NAME[:P=V,...]",
        help="effect of the library, with its first start values; two at most;"
        " on a brace every stage has it",
    )
    add(
        "--subject",
        metavar="N=V,...",
        default="",
        help="subject on the bench, such as torso_mass_kg=35",
    )
    add(
        "--serial",
        default="emulated-1",
        metavar="TEXT",
        help="serial number that it tells (default: emulated-1)",
    )
    add(
        "--seed",
        type=not_negative,
        default=0,
        metavar="S",
        help="start of its instruments' noise (default: 0)",
    )
    add("--free", action="store_true", help="begin without the torso")
    add(
        "--host-paced",
        type=positive_real,
        nargs="?",
        const=1.0,
        default=0.0,
        metavar="S",
        help="device time waits up to S (default: 1) for each answer of an"
        " armed host, for a computer too busy to keep real time",
    )
    add(
        "--duration",
        type=positive_real,
        metavar="S",
        help="seconds until it ends by itself (default: it serves on)",
    )
    add(
        "--fault",
        action="append",
        default=[],
        metavar="LINE",
        help="line as on standard input, from the start",
    )


def Run(args: argparse.Namespace) -> int:
    """Serves until it is stopped; prints the terminal's path."""
    from brace_drake.effects.registry import all_effects

    # One that begins later must not keep its host waiting for the library.
    all_effects()
    device = _make_device(args)
    for line in args.fault:
        carry_out(device, line)
    print(f"port: {device.terminal.path}", flush=True)
    signal.signal(signal.SIGTERM, lambda *_: device.stop())
    threading.Thread(target=_Obey, args=(device,), daemon=True).start()
    try:
        device.run(args.duration)
    finally:
        device.terminal.disconnect()
        print(
            f"ticks: {device.firmware.tick_count},"
            f" late {device.late_ticks}, unanswered {device.unanswered};"
            f" commands {device.firmware.accepted},"
            f" refused {device.firmware.rejected}"
        )
    return 0


def _make_device(args: argparse.Namespace):
    from brace_drake.cli.machine.link_options import load_device_options
    from brace_drake.link.emulator import EmulatedDevice, describe_device

    scenario, limits = load_device_options(args)
    plant = _make_plant(scenario, args)
    plant.with_torso = scenario.torso.present and not args.free
    return EmulatedDevice(
        plant, describe_device(scenario, args.serial), limits, args.link,
        args.host_paced, args.seed,
    )  # fmt: skip


def _make_plant(scenario, args: argparse.Namespace):
    import numpy as np

    from brace_drake.devices.subject import bench_subject
    from brace_drake.link.emulator import BenchPlant, BracePlant
    from brace_drake.scenario.brace import BenchScenario
    from brace_drake.scenario.brace_numbers import pack_bench

    uses = tuple(parse_effect(text) for text in args.effect)
    changes = parse_numbers(args.subject)
    if not isinstance(scenario, BenchScenario):
        if changes:
            raise BraceError(
                f"--subject {args.subject}: of a brace the subject is in its"
                " scenario, under torso and contact"
            )
        return BracePlant(scenario, uses, args.seed)
    values = {p.name: p.nominal for p in bench_subject(pack_bench(scenario))}
    for name in changes:
        if name not in values:
            raise BraceError(
                f"no parameter {name!r} of a subject; there are"
                f" {', '.join(values)}"
            )
    subject = np.array(list((values | changes).values()))
    return BenchPlant(scenario, uses, subject, args.seed)


def parse_numbers(text: str) -> dict[str, float]:
    """Names with values from "a=1,b=2".

    Raises:
        BraceError: A part that is none.
    """
    numbers = {}
    for part in filter(None, text.split(",")):
        name, _, value = part.partition("=")
        try:
            numbers[name.strip()] = float(value)
        except ValueError as error:
            raise BraceError(f"{part!r} is not NAME=NUMBER") from error
    return numbers


def parse_effect(text: str):
    """An effect of the library with its values, from "name:p=v,...".

    Raises:
        EffectError: Unknown, or values outside their limits.
    """
    from brace_drake.effects.registry import find_effect

    name, _, numbers = text.partition(":")
    card = find_effect(name)
    values = dict(zip(card.parameter_names, card.starts()[0], strict=True))
    values |= parse_numbers(numbers)
    return card, card.in_run(card.vector(values), 0)


def _Obey(device) -> None:
    """Takes lines until the input ends; none of them ends it."""
    try:
        # Not through Python's buffer, whose lock would be missed at the end.
        given, rest = sys.stdin.fileno(), b""
    except (AttributeError, OSError, ValueError):
        return
    while data := _read(given):
        *lines, rest = (rest + data).split(b"\n")
        rest = rest[-_LONGEST_LINE:]
        for line in lines:
            _ObeyLine(device, line.decode("utf-8", "replace"))
    _ObeyLine(device, rest.decode("utf-8", "replace"))


def _read(given: int) -> bytes:
    try:
        return os.read(given, 1000)
    except OSError:
        return b""


def _ObeyLine(device, line: str) -> None:
    with contextlib.suppress(OSError, ValueError):
        try:
            carry_out(device, line)
        except BraceError as error:
            print(f"brace-drake: {error}", file=sys.stderr, flush=True)


def carry_out(device, line: str) -> None:
    """Changes an emulated device by one line of text, see the help.

    Raises:
        LinkError: No such line.
    """
    faults, plant = device.faults, device.plant
    try:
        match shlex.split(line):
            case []:
                pass
            case ["torso", "on" | "off" as value]:
                device.plan_torso(value == "on")
            case ["rest"]:
                device.plan_rest()
            case ["estop", "on" | "off" as value]:
                faults.estop = value == "on"
            case ["drive", "on" | "off" as value]:
                faults.drive_fault = value == "on"
            case ["stuck", leg]:
                faults.stuck_legs = (_leg(leg, plant),)
            case ["frozen", leg]:
                faults.frozen_legs = (_leg(leg, plant),)
            case ["free"]:
                faults.stuck_legs = faults.frozen_legs = ()
            case ["to-host" | "to-device" as way, name, value]:
                line_faults = getattr(faults, way.replace("-", "_"))
                line_faults.set(name, float(value))
            case ["noise", number]:
                faults.noise_before_hello = _noise(number)
            case ["effect", text]:
                device.plan_effect(parse_effect(text))
            case ["unplug" | "plug" as word]:
                device.plug(word == "plug")
            case ["stop"]:
                device.stop()
            case _:
                raise LinkError(f"{line.strip()!r}: no such line; see --help")
    except ValueError as error:
        raise LinkError(f"{line.strip()!r}: {error}") from error


def _noise(text: str) -> int:
    number = int(text)
    if not 0 <= number <= _MOST_NOISE:
        raise LinkError(f"noise {number}: allowed: 0 to {_MOST_NOISE} bytes")
    return number


def _leg(text: str, plant) -> int:
    number = int(text)
    if not 1 <= number <= len(plant.hold):
        raise LinkError(f"leg {number}: there are 1 to {len(plant.hold)}")
    return number - 1
