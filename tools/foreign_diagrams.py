"""Blind cases of three foreign Drake diagrams, each with one fault.

    python tools/foreign_diagrams.py [--cases 60] [--machines arm] [--seed 1]

A cart-pole, a two-link arm under joint control and a rotary pendulum, recorded
by equations, integrator and noise of their own (`tests/foreign`); the package
has their nominal diagrams. A case is right where exactly the effect is named,
at its place. Cases that are answered stay in OUT and are not answered again.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import brace_drake as bd  # noqa: E402
from brace_drake.recording import LoadCampaign, WriteCampaign  # noqa: E402
from tests.foreign.campaigns import (  # noqa: E402
    SETUPS,
    draw_fault,
    make_campaign,
)
from tests.foreign.diagrams import (  # noqa: E402
    MakeArm,
    MakeCartPole,
    MakePendulum,
)
from tests.foreign.machines import Fault  # noqa: E402

MAKERS = {"cart_pole": MakeCartPole, "arm": MakeArm, "pendulum": MakePendulum}
JOINTS = {
    "cart_pole": ("slide", "hinge"),
    "arm": ("shoulder", "elbow"),
    "pendulum": ("turn", "swing"),
}
LOADED = {"cart_pole": "pole", "arm": "lower", "pendulum": "pendulum"}


def right_names(name: str, fault: Fault) -> set[str]:
    """Names of the effect that a fault is; empty for none.

    Args:
        name: Of the machine.
        fault: What was put in.
    """
    if fault.kind == "none":
        return set()
    setup = SETUPS[name]
    if fault.kind == "payload":
        return {f"payload ({LOADED[name]})"}
    if fault.kind.startswith("sensor"):
        column = next(iter(setup.outputs.values()))[fault.at]
        stem = re.sub(r"_(rad|m)$", "", column)
        return {f"{fault.kind} ({place})" for place in (stem, column)}
    if fault.kind.startswith(("command", "saturation", "rate_limit")):
        ((port, columns),) = setup.inputs.items()
        stem = re.sub(r"_(rad|N|N_m)$", "", columns[fault.at])
        return {f"{fault.kind} ({p})" for p in (port, columns[fault.at], stem)}
    return {f"{fault.kind} ({JOINTS[name][fault.at]})"}


def answer(name: str, seed: int, fault: Fault, out: Path) -> dict:
    """The verdict on one case, from its folder where it is answered."""
    folder = out / f"{name}-{seed}"
    path = folder / "verdict.json"
    if path.exists():
        return json.loads(path.read_text())
    WriteCampaign(make_campaign(name, fault, seed), folder / "campaign")
    campaign = LoadCampaign(folder / "campaign")
    start = time.process_time()
    found = bd.diagnose(campaign, diagram=MAKERS[name], progress=False, jobs=1)
    verdict = found.document["verdict"]
    verdict["cpu_s"] = time.process_time() - start
    path.write_text(json.dumps(verdict, indent=1))
    return verdict


def is_right(name: str, fault: Fault, verdict: dict) -> bool:
    """Whether exactly the fault's effect is named; for none, no gap."""
    if fault.kind == "none":
        return not verdict["gap"]
    named, outside = told(verdict), verdict["outside_library"]
    alone = len(named) == 1 and named[0] in right_names(name, fault)
    return alone and not outside


def told(verdict: dict) -> list[str]:
    """Effects of a verdict, each with its place."""
    return [f"{r['effect']} ({r['form']})" for r in verdict["supported"]]


def main() -> None:
    """Prints a line for each case and one for each machine."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--machines", nargs="*", choices=MAKERS, default=MAKERS)
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--none", type=int, default=12, help="sound machines")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/diagrams"))
    args = parser.parse_args()
    for name in args.machines:
        right = [0, 0]
        for i in range(args.cases + args.none):
            is_sound = i >= args.cases
            seed = 1000 * args.seed + i
            fault = Fault() if is_sound else draw_fault(name, seed)
            verdict = answer(name, seed, fault, args.out)
            well = is_right(name, fault, verdict)
            right[is_sound] += well
            print(
                f"{name} {seed} {'right' if well else 'WRONG'}"
                f" {fault.kind} {fault.at} {fault.values}:"
                f" {told(verdict)}"
                f"{' outside' if verdict['outside_library'] else ''}"
                f" p {verdict['probability']:.2f}, {verdict['cpu_s']:.0f} s",
                flush=True,
            )
        print(
            f"{name}: {right[0]} of {args.cases} with a fault,"
            f" {right[1]} of {args.none} without"
        )


if __name__ == "__main__":
    main()
