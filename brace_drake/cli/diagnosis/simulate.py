"""The command `brace-drake simulate`: a recording by the Drake diagram."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from brace_drake.cli.diagnosis.playback import (
    AddPlaybackOptions,
    PlayStates,
    wants_playback,
)
from brace_drake.cli.diagnosis.simulated_plan import (
    AddPlan,
    planned_motions,
    refuse_playback,
)
from brace_drake.cli.options import (
    AddCommand,
    AddMotion,
    AddNoiseSeed,
    MakeBar,
    load_motion,
    not_negative,
)
from brace_drake.core.errors import ScenarioError

_EPILOG = """\
example:
  brace-drake simulate results/monday/repaired.scenario.yaml \\
      --motion results/monday/next_run.csv --out simulated/monday
  brace-drake simulate diagrams/bench.scenario.yaml --motion push \\
      --out simulated/push --html simulated/push.html
  brace-drake simulate diagrams/bench.scenario.yaml --motion push \\
      --tolerances 7 --noise-seed 7 --out simulated/real
  brace-drake simulate diagrams/bench.scenario.yaml --plan --out simulated/all

The motion is a name of the library, or a file with the columns time_s,
ring2_y_desired_m, ring2_vy_desired_m_s and ring2_ay_desired_m_s2. Rings 1 and 3
of a brace may have such columns too; without them they stay where they start.
A file has even steps of 1e-4 s or more, lasts 600 s at most, and has no more
than 120000 rows; what is recorded of it must have 10 rows or more.
The torso is absent if the file's name begins with "free", or if its column
`contact` is 0. The result is a campaign with one run of the scenario's stages.
Stage 2 alone records as the bench does. --plan records all runs of the plan,
repeats and validation runs included. --tolerances also writes label.yaml:
how far each number of the machine is off. Ends with status 2 if the twin has
done what `check` refuses; the campaign then is left to be looked at.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `simulate`."""
    parser = AddCommand(
        subparsers,
        "simulate",
        Run,
        help="record a motion with the twin of a scenario",
        description="Runs the Drake diagram of a scenario over a reference.",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "scenario",
        metavar="SCENARIO",
        help="file of the bench or of the brace, *.scenario.yaml; or a"
        " campaign, for the scenario that it names",
    )
    what = parser.add_mutually_exclusive_group(required=True)
    AddMotion(what)
    AddPlan(what)
    parser.add_argument(
        "--out", required=True, metavar="DIR", help="campaign folder to make"
    )
    parser.add_argument(
        "--torso",
        metavar="FOLDER",
        help="folder of `personalize`: what the hydroelastic rings of a brace"
        " meet (default: half spaces)",
    )
    parser.add_argument(
        "--limits",
        metavar="FILE",
        help="hold these limits as on a device, such as diagrams/limits.yaml;"
        " a broken limit releases the rings (default: no supervisor)",
    )
    parser.add_argument(
        "--tolerances",
        type=not_negative,
        metavar="SEED",
        help="draw how far each number of the machine is off within its"
        " tolerance; the controller keeps the scenario's numbers (default:"
        " exact)",
    )
    AddNoiseSeed(parser)
    AddPlaybackOptions(parser)


def Run(args: argparse.Namespace) -> int:
    """Simulates and writes a campaign; prints where; 2 where `check` refuses
    it, else 0.
    """
    from brace_drake.recording.columns import BENCH, BRACE
    from brace_drake.recording.write import check_new_folder

    out = Path(args.out)
    check_new_folder(out)
    refuse_playback(args)
    scenario = _load_scenario(args.scenario)
    if scenario.device not in (BENCH, BRACE):
        names = f"{BENCH!r} or {BRACE!r}"
        raise ScenarioError(
            f"{args.scenario}: simulated is {names}, this is a"
            f" {scenario.device!r}"
        )
    from brace_drake.devices.bench.drawn import describe_draws
    from brace_drake.devices.motions.times import check_recorded_rows
    from brace_drake.model.simulate import recorded_device, recorded_stages
    from brace_drake.recording import Campaign, WriteCampaign

    drawn = _draw(scenario, args)
    if args.motion is not None:
        asked = [(load_motion(args.motion, rings=(1, 2, 3)), args.noise_seed)]
    else:
        asked = planned_motions(args.plan, args.noise_seed)
    for run, _ in asked:
        check_recorded_rows(run, scenario.sensors.log_period)
    recorded, told = [], []
    for run, seed in asked:
        made, end, live = _record(scenario, args, drawn, run, seed)
        recorded.append(made)
        told.append(_stop_text(*end))
    rate = 1.0 / scenario.sensors.log_period
    subject = f"twin of {Path(args.scenario).name}"
    label = None
    if drawn is not None:
        label = describe_draws(scenario, drawn)
        _tell_draws(scenario, args, drawn)
    device, stages = recorded_device(scenario), recorded_stages(scenario)
    runs = tuple(recorded)
    WriteCampaign(
        Campaign(out, device, rate, subject, runs, stages=stages), out, label
    )
    is_usable = _tell_errors(out)
    for made, text in zip(recorded, told, strict=True):
        print(f"campaign: {out}, {made.file}, {made.time_s[-1]:.3f} s")
        if text:
            print(text)
    if wants_playback(args):
        (made,) = recorded
        scenario.torso.present = made.contact
        states = _states(scenario, made, *end)
        title = f"{subject}, {made.file}"
        PlayStates(args, scenario, states, title, _torso_mesh(args), live)
    return 0 if is_usable else 2


def _load_scenario(path: str):
    """Of a file, or of a campaign: what it names, or its device's own."""
    from brace_drake.scenario.load import LoadScenario

    if not Path(path).is_dir():
        return LoadScenario(path)
    from brace_drake.devices.device import MakeDevice
    from brace_drake.recording import LoadCampaign

    return MakeDevice(LoadCampaign(path)).twin.scenario


def _draw(scenario, args) -> dict[str, float] | None:
    """Of --tolerances: by how much each number is off; None without."""
    from brace_drake.devices.bench.drawn import draw_tolerances

    if args.tolerances is None:
        return None
    return draw_tolerances(scenario, args.tolerances, args.scenario)


def _tell_draws(scenario, args, drawn: dict[str, float]) -> None:
    """Prints each draw beside its tolerance; of the anchors the largest."""
    from brace_drake.devices.bench.tolerances import KEYS

    own = scenario.tolerances
    rows = {n: (drawn[n], getattr(own, key)) for n, key in KEYS.items()}
    largest = max((drawn[n] for n in drawn if n not in KEYS), key=abs)
    rows["largest_of_anchors_m"] = largest, own.anchor
    origin = "stated" if own.is_stated else "assumed"
    print(f"tolerances: {origin}, drawn with seed {args.tolerances}")
    print(f"  {'':20}  {'off by':>10}  one standard deviation")
    for name, (off, size) in rows.items():
        print(f"  {name:20}  {off:+10.3g}  {size:g}")


def _tell_errors(out: Path) -> bool:
    """Whether a recorded campaign can be used; says why it cannot."""
    from brace_drake.recording import CheckCampaign

    for problem in CheckCampaign(out):
        if problem.severity == "error":
            print(f"brace-drake: not usable, {problem}", file=sys.stderr)
            return False
    return True


def _stop_text(station, context) -> str:
    """What a supervisor has stopped; empty where there is none."""
    if station.supervisor is None:
        return ""
    own = station.supervisor.GetMyContextFromRoot(context)
    memory = station.supervisor.memory(own)
    if memory.trip.cause:
        return f"stopped at {memory.since:.3f} s: {memory.trip}"
    return "limits: held"


def _load_limits(scenario, args):
    """Of --limits, for the scenario's rings; None without."""
    from brace_drake.link.device.limits_file import LoadLimits

    rings = scenario.stages
    return LoadLimits(args.limits, rings) if args.limits else None


def _states(scenario, recorded, station, context):
    """What a playback shows of a run that has just ended."""
    from brace_drake.playback import states_of_run

    rings = tuple(f"ring{i}" for i in scenario.stages)
    force = [
        recorded.channels[f"{ring}_force_{axis}_N"]
        for ring in rings
        for axis in "xyz"
    ]
    return states_of_run(station, context, rings, np.transpose(force))


def _torso_mesh(args) -> Path | None:
    """The surface of --torso."""
    from brace_drake.torso.folder import SURFACE

    return Path(args.torso) / SURFACE if args.torso else None


def _record(scenario, args, drawn, run, noise_seed):
    """A recording of a run, the station and context that it has ended with,
    and the Meshcat that has shown it, or None.
    """
    from brace_drake.devices.bench.drawn import uses_of_draws
    from brace_drake.model.simulate import RecordBrace

    add_geometry = None
    if args.torso:
        models = [contact.model for contact in scenario.contacts]
        if "hydroelastic" not in models:
            raise ScenarioError(
                f"{args.scenario}: contact.{scenario.rings[0]}.model is"
                f" {models[0]!r}, and no other ring's is 'hydroelastic', which"
                " --torso is for"
            )
        from brace_drake.torso.contact import MakeTorsoGeometry
        from brace_drake.torso.folder import LoadTorso

        add_geometry = MakeTorsoGeometry(LoadTorso(args.torso))
    ended: list[tuple] = []
    options, live = _options(
        scenario, args, run, noise_seed, lambda *end: ended.append(end)
    )
    uses = uses_of_draws(scenario, drawn or {}, args.scenario)
    with MakeBar(run) as on_progress:
        recorded = RecordBrace(
            scenario,
            run,
            on_progress=on_progress,
            add_geometry=add_geometry,
            uses=uses,
            **options,
        )
    return recorded, ended[0], live


def _options(scenario, args, run, noise_seed, at_end):
    """Of either recording; and the Meshcat that shows it live, or None."""
    options = {
        "noise_seed": noise_seed,
        "at_end": at_end,
        "log_pads": wants_playback(args),
        "limits": _load_limits(scenario, args),
    }
    if not args.meshcat:
        return options, None
    from brace_drake.playback.live import LiveScene

    scenario.torso.present = run.contact
    scene = LiveScene(scenario, _torso_mesh(args))
    print(f"live at {scene.meshcat.web_url()}", flush=True)
    return options | {"watch": scene.Show}, scene.meshcat
