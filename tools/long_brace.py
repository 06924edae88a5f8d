"""The whole brace over long runs: its closed loops, and the work of its legs.

python tools/long_brace.py [--loops S] [--energy S]

The articulated brace, at plant steps of 1 ms, moves all its rings there and
back and has to keep its 18 loops closed. Then both mechanisms swing once a
second, and what the legs have worked is set against what bodies and springs
have stored and dampers have taken, at two steps of the plant each. Status 1
where a loop opens by 1 um, or an account is off by 1 % of the work.
"""

import argparse
import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from brace_drake.model.articulated import calc_closure_error
from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.scenario.brace_numbers import pack_brace
from tests.brace_runs import brace, run
from tests.brace_servo import BraceServo
from tests.test_brace_energy import settle, swing

OPEN, OFF = 1e-6, 0.01  # m; of the work
CASES = (
    ("task_space", "linear", 5e-4),
    ("task_space", "linear", 2.5e-4),
    ("task_space", "none", 1e-3),
    ("task_space", "none", 5e-4),
    ("articulated", "none", 1e-3),
    ("articulated", "none", 5e-4),
)


def widest_opening(seconds):
    """Largest distance of the ends of a closed loop over a run, m."""
    scenario = brace("articulated", time_step=1e-3)
    servo = BraceServo(pack_brace(scenario))
    station = MakeBraceStation(scenario, servo, swing(seconds))
    worst = 0.0

    def watch(context):
        nonlocal worst
        if round(context.get_time() * 1000) % 10 == 0:
            own = station.plant.GetMyContextFromRoot(context)
            error = calc_closure_error(station.plant, own, scenario)
            worst = max(worst, error)

    run(station.diagram, seconds, watch)
    return worst


def main():
    """Prints both; the status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--loops", type=int, default=60, metavar="S")
    parser.add_argument("--energy", type=int, default=10, metavar="S")
    args = parser.parse_args()
    worst = widest_opening(args.loops)
    print(
        f"loops of 18 legs open by {worst:.1e} m in {args.loops} s", flush=True
    )
    is_good = worst < OPEN
    print(f"{'mechanism, contact, step':36} {'work, J':>8} {'off, %':>7}")
    for mechanism, contact, step in CASES:
        stored, work, lost = settle(mechanism, contact, step, args.energy)
        off = abs(stored + lost - work) / work
        label = f"{mechanism}, {contact}, {1e3 * step:g} ms"
        print(f"{label:36} {work:8.3f} {100.0 * off:7.3f}", flush=True)
        is_good = is_good and off < OFF
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
