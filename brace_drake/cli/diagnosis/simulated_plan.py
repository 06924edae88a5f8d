"""A plan's runs as `brace-drake simulate` records them."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from brace_drake.core.errors import CampaignError, OutputError
from brace_drake.core.places import check_replaced, real_path

if TYPE_CHECKING:
    from brace_drake.recording.recording import Run

# In place of a file: the plan that `campaign` records without one.
_STANDARD = ""


def AddPlan(parser: argparse._ActionsContainer) -> None:
    """Adds --plan."""
    parser.add_argument(
        "--plan",
        nargs="?",
        const=_STANDARD,
        metavar="FILE",
        help="record all runs of a plan, as of `campaign` or `plan` (without a"
        " file: the standard one); readings then have noise, seed 0 unless"
        " given",
    )


def refuse_playback(args: argparse.Namespace) -> None:
    """Raises CampaignError where several runs would have to be shown, and
    OutputError where the page would be within the campaign, or in the place of
    a file that is none.
    """
    if args.html and real_path(args.html).is_relative_to(real_path(args.out)):
        raise OutputError(
            f"--html {args.html}: within the campaign {args.out}; give another"
            " place"
        )
    if args.plan is not None and (args.html or args.meshcat):
        raise CampaignError(
            "--plan records several runs; --html and --meshcat show one:"
            " take --motion"
        )
    if args.html:
        check_replaced(Path(args.html), ".html", b"<!DOCTYPE html>", "page")


def planned_motions(file: str, noise_seed: int | None) -> list[tuple[Run, int]]:
    """Runs of a plan that are not recorded yet, each with a seed of its own.

    Repeats have another file and the same motion; readings without noise would
    make copies of them.

    Raises:
        CampaignError: One line: file, run, key, value, what is allowed.
    """
    from brace_drake.devices.motions.library import MakeMotion
    from brace_drake.link.operation.campaign import LoadPlan

    first: dict[str, str] = {}
    taken: dict[str, int] = {}
    found = []
    for number, planned in enumerate(LoadPlan(file or None)):
        run, name = MakeMotion(planned.motion).run, planned.motion
        taken[name] = taken.get(name, 0) + 1
        if taken[name] > 1:
            run = replace(run, file=f"{name}_{taken[name]}.csv")
        repeated = first.get(name) if planned.repeat else None
        first.setdefault(name, run.file)
        run = replace(run, split=planned.split, repeat_of=repeated)
        found.append((run, (noise_seed or 0) + number))
    return found
