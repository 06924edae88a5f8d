"""The command `brace-drake personalize`: a patient's torso and its pads."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.options import AddCommand, AddScenario, finite
from brace_drake.core.output import HoldFolder
from brace_drake.core.places import check_folder

_EPILOG = """\
example:
  brace-drake personalize scan.ply --unit mm --origin 0 0 1184 --out patient
  brace-drake personalize diagrams/torso_girl13.measures.yaml --out girl

A scan (.obj, .stl, .ply) is the closed surface of the trunk, without head and
arms. The origin is the centre of ring 2, at the vertebra T7, in the scan's own
coordinates and unit. The axes are those of the scan that point to the front,
the left and up. A scan is never repaired; a bad one is refused.

Writes torso.obj (surface), torso.vtk (tetrahedra), torso.sdf (model with mass
and contact), pads.yaml with a face for each pad, torso.png, and the scenarios
of the package with this torso's mass, inertia and width put in.
"""
_SCENARIOS = ("brace.scenario.yaml", "bench.scenario.yaml")


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `personalize`."""
    parser = AddCommand(
        subparsers,
        "personalize",
        Run,
        help="make a torso, its pads and a scenario from a scan",
        description="Makes a subject's torso, and pads that fit it.",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "source",
        metavar="SCAN|MEASURES.yaml",
        help="surface of the trunk, or its breadths, depths and heights",
    )
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="folder for the results"
    )
    parser.add_argument(
        "--unit", default="m", metavar="U", help="m (default), cm, mm or in"
    )
    parser.add_argument(
        "--origin",
        nargs=3,
        type=finite,
        default=(0.0, 0.0, 0.0),
        metavar=("X", "Y", "Z"),
        help="centre of ring 2 in the scan (default: 0 0 0)",
    )
    parser.add_argument(
        "--axes",
        default="+x+y+z",
        metavar="A",
        help="axes of the scan to front, left, up (default: +x+y+z; write"
        " --axes=A)",
    )
    parser.add_argument(
        "--resolution",
        type=finite,
        metavar="M",
        help="largest facet of the solid, m (default: 0.025)",
    )
    parser.add_argument(
        "--pad-resolution",
        type=finite,
        metavar="M",
        help="largest facet under pads, m (default: 0.005)",
    )
    AddScenario(parser, "file of the nominal bench (default: the package's)")


def Run(args: argparse.Namespace) -> int:
    """Fits and writes; prints what was measured and where it is."""
    # Drake is slow to import.
    from brace_drake.core.errors import TorsoError
    from brace_drake.torso.fitted import PAD_RESOLUTION, RESOLUTION
    from brace_drake.torso.personalize import (
        LoadSurfaceOf,
        WritePersonal,
        personalize,
    )
    from brace_drake.torso.scan import ScanFrame

    out = Path(args.out)
    check_folder(out)
    scenarios = _load_scenarios(args.scenario)
    frame = ScanFrame(args.unit, tuple(args.origin), args.axes)
    loft = LoadSurfaceOf(args.source, frame)
    resolution = RESOLUTION if args.resolution is None else args.resolution
    under_pads = args.pad_resolution
    under_pads = PAD_RESOLUTION if under_pads is None else under_pads
    try:
        personal = personalize(loft, scenarios, resolution, under_pads)
    except TorsoError as error:
        raise TorsoError(f"{args.source}: {error}") from error
    WritePersonal(HoldFolder(out), personal)
    for line in describe(personal):
        print(line)
    print(f"torso, pads, scenario, picture: {args.out}")
    return 0


def _load_scenarios(path: str | None) -> dict:
    """The one that was given, else those of the package, by file name."""
    from brace_drake.core.errors import TorsoError
    from brace_drake.core.resources import scenario_path
    from brace_drake.scenario.brace import BraceScenario
    from brace_drake.scenario.load import LoadScenario

    if path is None:
        return {name: LoadScenario(scenario_path(name)) for name in _SCENARIOS}
    scenario = LoadScenario(path)
    if not isinstance(scenario, BraceScenario):
        raise TorsoError(
            f"{path}: device is {scenario.device!r}, which has no torso;"
            " allowed: a bench or a brace"
        )
    return {Path(path).name: scenario}


def describe(personal) -> list[str]:
    """What was measured, a line each."""
    from brace_drake.torso.loft import half_widths, measure_trunk_bend

    torso, loft = personal.torso, personal.loft
    x, y, z = torso.inertia.get_com()
    lines = [
        f"mass {torso.inertia.get_mass():.2f} kg, centre of mass at"
        f" {1e3 * x:.1f} {1e3 * y:.1f} {1e3 * z:.1f} mm,"
        f" {len(torso.solid.tetrahedra)} tetrahedra",
        f"bend of the trunk's centre line {measure_trunk_bend(loft):.1f} deg",
    ]
    for i, height in enumerate(torso.ring_heights, start=1):
        left, right = half_widths(loft, float(height))
        lines.append(
            f"ring {i} at {1e3 * height:.0f} mm: pads at {1e3 * left:.1f} mm"
            f" left, {1e3 * right:.1f} mm right"
        )
    tall = torso.pads[0].place.size[1]
    for i, gap in enumerate(torso.ring_heights[1:] - torso.ring_heights[:-1]):
        if gap < tall:
            lines.append(
                f"note: pads of rings {i + 1} and {i + 2} overlap by"
                f" {1e3 * (tall - gap):.0f} mm in height"
            )
    return lines
