"""The command `brace-drake predict`: the impedance that a policy asks for."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.options import AddCommand, finite
from brace_drake.core.errors import PolicyError

_EPILOG = """\
example:
  brace-drake predict runs/paper/best.npz --displacement-mm -10 \\
      --subject contact_stiffness=1.2 --subject posture_stiffness=0.9

Factors of the subject are on the scenario's numbers: contact_stiffness,
contact_damping, preload, posture_stiffness, posture_damping, torso_mass,
displacement.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `predict`."""
    parser = AddCommand(
        subparsers,
        "predict",
        Run,
        help="desired impedance for a displacement and a subject",
        description="Moves the twin of a subject under a trained policy.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("policy", metavar="POLICY", help="file *.npz of a training run")
    add(
        "--displacement-mm",
        type=finite,
        metavar="Y",
        help="displacement of every ring along y, mm (default: that of the"
        " training)",
    )
    add(
        "--subject",
        action="append",
        default=[],
        metavar="NAME=FACTOR",
        help="factor on a number of the subject, NAME as listed below; may be"
        " repeated",
    )
    add("--out", metavar="DIR", help="write prediction.json and course.csv")
    add("--onnx", metavar="FILE", help="also write the network as ONNX")


def Run(args: argparse.Namespace) -> int:
    """Prints the impedance; writes it where asked to."""
    from brace_drake.core.places import check_folder, check_replaced
    from brace_drake.learning.policy import ExportOnnx, LoadPolicy
    from brace_drake.learning.predict import predict_impedance

    if args.out is not None:
        check_folder(Path(args.out))
    if args.onnx is not None:
        # A model begins with the version of its format.
        check_replaced(Path(args.onnx), ".onnx", b"\x08", "network")
    policy = LoadPolicy(args.policy)
    factors = dict(_parse_factor(text) for text in args.subject)
    displacement = None
    if args.displacement_mm is not None:
        displacement = [0.0, 1e-3 * args.displacement_mm, 0.0, 0.0, 0.0, 0.0]
    found = predict_impedance(policy, displacement, factors)
    for i, name in enumerate(found.names):
        bound = ", at the bound of its range" if found.at_bound[i] else ""
        print(
            f"{name}: K_d {found.stiffness[i]:.0f} +- {found.spread[i]:.0f}"
            f" N/m (from {found.lowest[i]:.0f} to {found.highest[i]:.0f} over"
            f" the motion){bound},"
            f" C_d {found.damping[i]:.1f} N s/m, M_d {found.mass[i]:g} kg;"
            f" error {1e3 * found.error[i]:.3f} mm, force up to"
            f" {found.force[i]:.2f} N"
        )
    if args.out is not None:
        _Write(Path(args.out), found, policy.task.sample_time)
        print(f"prediction: {Path(args.out) / 'prediction.json'}")
        print(f"course: {Path(args.out) / 'course.csv'}")
    if args.onnx is not None:
        ExportOnnx(policy, args.onnx)
        print(f"network: {args.onnx}")
    return 0


def _Write(folder: Path, found, sample_time: float) -> None:
    from brace_drake.core.output import HoldFolder, WriteJson, WriteText
    from brace_drake.experiments.tables import format_csv

    HoldFolder(folder)
    rows = {
        name: {
            "mass_kg": float(found.mass[i]),
            "damping_N_s_m": float(found.damping[i]),
            "stiffness_N_m": float(found.stiffness[i]),
            "stiffness_deviation_N_m": float(found.spread[i]),
            "stiffness_lowest_N_m": float(found.lowest[i]),
            "stiffness_highest_N_m": float(found.highest[i]),
            "at_bound": bool(found.at_bound[i]),
            "rms_error_m": float(found.error[i]),
            "largest_force_N": float(found.force[i]),
        }
        for i, name in enumerate(found.names)
    }
    WriteJson(folder / "prediction.json", rows)
    names = [n.replace(" ", "_") + "_stiffness_N_m" for n in found.names]
    course = [
        {"time_s": (k + 1) * sample_time, **dict(zip(names, row, strict=True))}
        for k, row in enumerate(found.log.stiffness)
    ]
    WriteText(folder / "course.csv", format_csv(course))


def _parse_factor(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError as error:
        raise PolicyError(
            f"--subject {text!r}; allowed: NAME=FACTOR"
        ) from error
