"""Holds and moves an emulated device for long; looks for losses and leaks.

    python tools/soak_link.py --seconds 3600 --watchdog 1
    python tools/soak_link.py --scenario diagrams/brace.scenario.yaml
    python tools/soak_link.py --host-paced --stale 5 --at-most 180

Device and host are processes of their own. Each minute, or tenth of a shorter
run, a line tells how it goes. Status 1 where a tick is missing without being
counted, the run is stopped, or the memory of either grows by more than 2 MB
over the second half.

A machine that is late for tens of milliseconds stops the run, as it must: a
loop of such age does not hold a ring. With --host-paced the device's time waits
for the host instead: full rate where the machine holds it, else as fast as it
goes, until --at-most. The last line is for machines that others share.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from brace_drake.cli.machine.link_options import load_device_options
from brace_drake.devices.motions.library import MakeMotion
from brace_drake.link.operation.motion import desired_at_ticks, place_motion
from brace_drake.link.operation.session import Session
from brace_drake.link.operation.station import (
    MakeControl,
    OpenDevice,
)
from brace_drake.link.protocol.limits import DEFAULT, Limits

# What the memory of a process may grow by over the second half, MB.
_MOST_GROWTH = 2.0


def resident_mb(process: int | str = "self") -> float:
    """Memory of a process, MB."""
    with open(f"/proc/{process}/statm") as file:
        return int(file.read().split()[1]) * 4096 / 1e6


def growth_mb(memory: list[float]) -> float:
    """The second half's last third less its first, as means.

    A resident size also moves by itself.
    """
    half = memory[len(memory) // 2 :]
    third = max(1, len(half) // 3)
    return float(np.mean(half[-third:]) - np.mean(half[:third]))


def make_reference(seconds: float, rings: tuple[int, ...]) -> np.ndarray:
    """The library's multisine of ring 2, again and again."""
    motion = place_motion(MakeMotion("multisine"), rings)
    once = desired_at_ticks(motion, 1000.0)
    # Out and back in time: the reference stays continuous.
    back = once[::-1].copy()
    back[:, 1] *= -1.0
    both = np.concatenate([once, back])
    ticks = round(1000 * seconds)
    return np.resize(both, (ticks, *both.shape[1:]))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--host-paced", action="store_true")
    parser.add_argument(
        "--at-most",
        type=float,
        default=float("inf"),
        help="ends, without a fault, after so long by the clock, s",
    )
    parser.add_argument(
        "--stale", type=float, default=1.0, help="limit for this machine, s"
    )
    parser.add_argument(
        "--watchdog",
        type=float,
        default=DEFAULT.watchdog,
        help="limit of device and host, s: a machine that others share may be"
        " late by more than 0.05",
    )
    parser.add_argument("--scenario", help="bench or brace (nominal bench)")
    parser.set_defaults(limits=None)
    args = parser.parse_args()
    scenario, limits = load_device_options(args)
    limits = limits._replace(
        stale=args.stale, lost_messages=1000.0, watchdog=args.watchdog
    )
    command = [sys.executable, "-m", "brace_drake.cli.main", "emulate"]
    command += ["--host-paced", "10"] if args.host_paced else []
    command += ["--scenario", args.scenario] if args.scenario else []
    with tempfile.TemporaryDirectory() as folder:
        own = Path(folder) / "limits.yaml"
        own.write_text(f"watchdog: {args.watchdog}\n")
        device = subprocess.Popen(
            [*command, "--limits", str(own)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            return soak(device, args, scenario, limits)
        finally:
            device.kill()
            device.wait()


def soak(
    device: subprocess.Popen, args: argparse.Namespace, scenario, limits: Limits
) -> int:
    """Runs, prints what was seen, ends the device; the status."""
    port = device.stdout.readline().split()[1]
    seconds, is_over = args.seconds, False
    with OpenDevice(port, scenario, limits) as link:
        session = Session(link, MakeControl(scenario, limits), limits)
        expected, missing, looked, told = 0, 0, 0.0, time.monotonic()
        memory = {"host": [], "device": []}
        begun = time.monotonic()

        def take(rows):
            nonlocal expected, missing, looked, told
            for row in rows:
                missing += row.tick != expected
                expected = row.tick + 1
            now = time.monotonic()
            if now - looked > 1.0:
                looked = now
                memory["host"].append(resident_mb())
                memory["device"].append(resident_mb(device.pid))
            if now - told > min(60.0, seconds / 10.0):
                told = now
                sizes = ", ".join(f"{n} {m[-1]:.1f}" for n, m in memory.items())
                print(
                    f"{now - begun:6.0f} s: {expected} ticks, missing"
                    f" {missing}, MB: {sizes}",
                    flush=True,
                )

        def ends():
            nonlocal is_over
            is_over = time.monotonic() - begun > args.at_most
            return is_over

        reference = make_reference(seconds, scenario.stages)
        session.Follow(reference, take, ends)
        took = time.monotonic() - begun
        tally, counts = session.tally, link.counts
        growth = {name: growth_mb(m) for name, m in memory.items()}
        print(f"stopped by       {session.trip}")
        print(f"ticks            {tally.ticks} in {took:.1f} s")
        print(f"missing unseen   {missing}")
        print(f"bridged          {tally.bridged}, lost {counts.lost}")
        print(f"unanswered       {tally.unanswered}, bad {counts.bad}")
        for name, sizes in memory.items():
            said = f"{sizes[-1]:.1f} MB, grew {growth[name]:.2f}"
            print(f"memory of {name:6} {said}")
        for name, spread, scale in (
            ("latency, us", tally.latencies, 1e6),
            ("period, us", tally.periods, 1e6),
            ("age, ticks", tally.ages, 1.0),
        ):
            at = [scale * value for value in spread.percentiles()]
            text = ", ".join(f"{value:.0f}" for value in at)
            print(f"{name:16} {text} (50, 99, 99.9 %)")
        print(f"round trip, us   {1e6 * link.round_trip:.0f} at best")
        grew = max(growth.values()) > _MOST_GROWTH
        stopped = session.trip is not None and not is_over
    device.stdin.write("stop\n")
    device.stdin.close()
    print("device:", device.stdout.read().strip())
    return int(missing > 0 or grew or stopped)


if __name__ == "__main__":
    sys.exit(main())
