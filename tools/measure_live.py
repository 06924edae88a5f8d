"""Measures what `brace-drake twin` tells of faults that begin while it runs.

    python tools/measure_live.py quiet --hours 6
    python tools/measure_live.py faults --seeds 2 --out out/live.json

`quiet` simulates the bench with noise and without a fault, compiled, and counts
alarms. `faults` runs the emulated bench, its controller and the twin beside it
tick by tick, not in real time, and lets an effect of the library begin at a
random moment of the second cycle: delay of the alarm, and the place of the
right cause among those that are named from what is known then.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np

from brace_drake.core.output import WriteJson
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.library import MakeMotion
from brace_drake.devices.twin import Request
from brace_drake.effects.registry import find_effect
from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.operation.beside import TwinBeside
from brace_drake.link.operation.motion import desired_at_ticks, place_motion
from brace_drake.link.operation.rows import Row
from brace_drake.link.operation.station import MakeControl
from brace_drake.link.protocol.limits import DEFAULT
from brace_drake.monitoring.cycles import close_cycle, repeat_cycle
from brace_drake.monitoring.prepare import Namer, make_expected
from brace_drake.scenario.brace import BenchScenario

# Effects with values that a machine may have; first starts where none are said.
FAULTS = {
    "force_bias": {"force_bias_N": 0.2},
    "force_scale": {},
    "force_drift": {},
    "force_lag": {},
    "command_delay": {},
    "coulomb_friction": {},
    "backlash": {},
    "viscous_leg": {},
    "weak_leg": {},
    "ring_mass": {},
    "relaxation": {},
    "hardening": {},
    "leg_compliance": {},
    "encoder_offset": {},
}
PER_HOUR = 0.1
# A fault is watched for so long, s: an answer takes up to 10 s more.
WATCHED = 20.0


def make_scene(motion: str, subject: bool):
    """Scenario, cycle, what is expected, and the machine's own subject."""
    scenario = BenchScenario()
    cycle = close_cycle(MakeMotion(motion))
    expected = make_expected(scenario, cycle, 1, PER_HOUR)
    twin = BenchTwin(scenario)
    own = np.array([p.nominal for p in twin.subject])
    if subject:
        own = own * np.array([1.2, 1.2, 1.15, 1.2, 0.9, 1.0])
    return scenario, cycle, expected, own


def measure_quiet(args) -> dict:
    """Alarms of so many hours without a fault."""
    scenario, cycle, expected, own = make_scene(args.motion, args.subject)
    twin, alarms, largest, samples = BenchTwin(scenario), 0, 0.0, 0
    nominal = np.array([p.nominal for p in twin.subject])
    count = 40
    motion = twin.motion(repeat_cycle(cycle, count).run)
    exact = twin.simulate(motion, nominal)
    hours = count * len(cycle.time) / expected.rate / 3600.0
    for batch in range(-(-round(args.hours / hours) // 4)):
        logs = twin.simulate_each(
            [Request(motion, own, (), (batch, k, 77)) for k in range(4)]
        )
        for log in logs:
            watch, before = expected.watch(), None
            for row in log - exact:
                watch.Take(row)
                largest = max(largest, watch.excess)
                alarms += watch.onset is not None and before is None
                before = watch.onset
            samples += len(log)
        print(samples / expected.rate / 3600.0, alarms, largest, flush=True)
    total = samples / expected.rate / 3600.0
    return {"hours": total, "alarms": alarms, "largest_excess": largest}


def run_fault(scene, card, values, seed: int) -> dict:
    """One fault that begins in the second cycle."""
    scenario, cycle, expected, own = scene
    draw = np.random.default_rng([seed, 3])
    rate = scenario.control.rate
    every = expected.motion.ticks_per_sample
    length = len(cycle.time) * every
    begins = length + round(rate * draw.uniform(1.0, 11.0))
    plant = BenchPlant(scenario, (), own, seed=100 + seed)
    control, beside = MakeControl(scenario, DEFAULT), TwinBeside(scenario)
    desired = desired_at_ticks(
        place_motion(repeat_cycle(cycle, 5), scenario.stages), rate
    )
    watch, command = expected.watch(), plant.hold
    end = begins + round(WATCHED * rate)
    for i in range(end):
        if i == begins:
            plant.begin_effects([(card, values)])
        readings = plant.advance(command).copy()
        command = control.Tick(readings, desired[i])
        beside.Take(
            Row(i, command, readings, desired[i], control.y_virtual,
                control.y_ring, 0.0, 0)
        )  # fmt: skip
        if i % every == 0:
            watch.Take(beside.difference)
    found = {"effect": card.key, "seed": seed, "begins_s": begins / rate}
    if watch.onset is None:
        return found | {"delay_s": None, "rank": None}
    since = watch.since()
    spent = time.process_time()
    causes = Namer(expected).Name(since)
    spent = time.process_time() - spent
    names = [c.name for c in causes]
    rank = names.index(card.name) + 1 if card.name in names else None
    return found | {
        "false": watch.alarm * every < begins,
        "delay_s": watch.alarm * every / rate - begins / rate,
        "onset_off_s": watch.onset * every / rate - begins / rate,
        "rank": rank,
        "first": [[c.name, c.share, c.probability] for c in causes[:3]],
        "cpu_s": spent,
    }


def measure_faults(args) -> list[dict]:
    """All faults with all seeds."""
    scene, rows = make_scene(args.motion, args.subject), []
    for name in args.effect or FAULTS:
        card = find_effect(name)
        start = dict(zip(card.parameter_names, card.starts()[0], strict=True))
        values = card.in_run(card.vector(start | FAULTS.get(name, {})), 0)
        for seed in range(args.seeds):
            rows.append(run_fault(scene, card, values, seed))
            print(json.dumps(rows[-1]), flush=True)
    told = [r for r in rows if r["delay_s"] is not None]
    in_time = sum(r["delay_s"] <= 5.0 for r in told)
    among = sum((r["rank"] or 99) <= 3 for r in told)
    first = sum(r["rank"] == 1 for r in told)
    print(
        f"{len(rows)} faults: alarm within 5 s {in_time}, right cause among"
        f" three {among}, first {first}"
    )
    return rows


def main() -> None:
    """Runs one of both."""
    parser = argparse.ArgumentParser(description=__doc__)
    add = parser.add_argument
    add("what", choices=("quiet", "faults"))
    add("--hours", type=float, default=2.0)
    add("--seeds", type=int, default=2)
    add("--motion", default="reversal")
    add("--effect", action="append")
    add("--subject", action="store_true", help="machine with another subject")
    add("--out", type=Path)
    args = parser.parse_args()
    measure = measure_quiet if args.what == "quiet" else measure_faults
    found = measure(args)
    if args.out:
        WriteJson(args.out, found)
    else:
        print(found if args.what == "quiet" else "")


if __name__ == "__main__":
    main()
