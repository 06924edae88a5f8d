"""Holds and moves an emulated bench for long; looks for losses and leaks.

    python tools/soak_link.py --seconds 3600

Device and host are processes of their own. Status 1 where a tick is missing
without being counted, or memory grows by more than 2 MB over the second half.
"""

import argparse
import subprocess
import sys
import time

import numpy as np

from brace_drake.hardware.limits import DEFAULT
from brace_drake.operation.session import Session
from brace_drake.operation.station import MakeControl, OpenDevice
from brace_drake.scenario.bench import BenchScenario
from brace_drake.twin.motion_library import MakeMotion
from brace_drake.twin.reference import reference_at_ticks


def resident_mb() -> float:
    """Memory of this process, MB."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096 / 1e6


def make_reference(seconds: float) -> np.ndarray:
    """The library's multisine, again and again (ticks, 3)."""
    motion = MakeMotion("multisine")
    once = reference_at_ticks(motion.time, motion.samples, 1000.0)
    # Out and back in time: the reference stays continuous.
    back = once[::-1] * (1.0, -1.0, 1.0)
    both = np.vstack([once, back])
    ticks = round(1000 * seconds)
    return np.tile(both, (-(-ticks // len(both)), 1))[:ticks]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--host-paced", action="store_true")
    parser.add_argument(
        "--stale", type=float, default=1.0, help="limit for this machine, s"
    )
    args = parser.parse_args()
    command = [sys.executable, "-m", "brace_drake.cli.main", "emulate"]
    command += ["--host-paced"] if args.host_paced else []
    device = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    port = device.stdout.readline().split()[1]
    limits = DEFAULT._replace(stale=args.stale, lost_messages=1000.0)
    scenario = BenchScenario()
    status = 0
    with OpenDevice(port, scenario, limits) as link:
        session = Session(link, MakeControl("pic", scenario), limits)
        session.Start(make_reference(args.seconds))
        expected, missing, memory, looked = 0, 0, [], 0.0
        begun = time.monotonic()
        while not session.is_over:
            time.sleep(0.05)
            session.CheckAlive()
            while session.rows:
                row = session.rows.popleft()
                missing += row.tick != expected
                expected = row.tick + 1
            if time.monotonic() - looked > 1.0:
                looked = time.monotonic()
                memory.append(resident_mb())
        took = time.monotonic() - begun
        tally, counts = session.tally, link.counts
        half = memory[len(memory) // 2 :]
        growth = half[-1] - half[0]
        print(f"stopped by       {session.trip}")
        print(f"ticks            {tally.ticks} in {took:.1f} s")
        print(f"missing unseen   {missing}")
        print(f"bridged          {tally.bridged}, lost {counts.lost}")
        print(f"unanswered       {tally.unanswered}, bad {counts.bad}")
        print(f"memory           {memory[-1]:.1f} MB, grew {growth:.2f}")
        for name, spread, scale in (
            ("latency, us", tally.latencies, 1e6),
            ("period, us", tally.periods, 1e6),
            ("age, ticks", tally.ages, 1.0),
        ):
            at = [scale * value for value in spread.percentiles()]
            text = ", ".join(f"{value:.0f}" for value in at)
            print(f"{name:16} {text} (50, 99, 99.9 %)")
        print(f"round trip, us   {1e6 * link.clock.round_trip:.0f} at best")
        status = int(missing > 0 or growth > 2.0 or session.trip is not None)
        if session.trip is None:
            session.Finish()
    device.stdin.write("stop\n")
    device.stdin.close()
    print("device:", device.stdout.read().strip())
    device.wait()
    return status


if __name__ == "__main__":
    sys.exit(main())
