"""The command `brace-drake train`: a policy for the stiffness (RLPIC)."""

from __future__ import annotations

import argparse
from pathlib import Path

from brace_drake.cli.options import (
    AddCommand,
    check_training_extra,
    count_to,
    not_negative,
    positive,
)
from brace_drake.core.errors import PolicyError
from brace_drake.core.progress import open_bar

_EPILOG = """\
example:
  brace-drake train --out runs/paper                 # the paper's budget
  brace-drake train --out runs/wide --reward improved --subjects between \\
      --readings noisy
  brace-drake train --out runs/paper --resume        # after a stop or a kill

Writes policy.npz (the last one), best.npz, curve.csv, curve.png, the task,
hyper-parameters, scenario, seed and versions, and a checkpoint after each
update. A run that was stopped and resumed ends with the same weights bit for
bit. Needs pip install -e '.[train]'.
"""


def AddParser(subparsers: argparse._SubParsersAction) -> None:
    """Adds the subcommand `train`."""
    parser = AddCommand(
        subparsers,
        "train",
        Run,
        help="train a policy that sets the stiffness",
        description="Trains a policy: PPO with the paper's hyper-parameters.",
        epilog=_EPILOG,
    )
    add = parser.add_argument
    add("--out", required=True, metavar="DIR", help="folder of the run")
    add("--resume", action="store_true", help="continue the training in DIR")
    add("--task", metavar="FILE", help="the task, LearningTask as YAML")
    add("--training", metavar="FILE", help="TrainingNumbers as YAML")
    add(
        "--full", action="store_true", help="three rings, 18 degrees of freedom"
    )
    add(
        "--reward",
        choices=("paper", "improved"),
        help="the paper's as written, or one that pays for less force",
    )
    add(
        "--subjects",
        choices=("nominal", "between"),
        help="the scenario's own, or drawn from 0.7 to 1.5 times its numbers",
    )
    add("--readings", choices=("exact", "noisy"), help="what the policy sees")
    add(
        "--episodes",
        type=positive,
        metavar="N",
        help="budget (the paper: 1000)",
    )
    add(
        "--envs",
        type=count_to(1024),
        metavar="N",
        help="episodes side by side (default: 1)",
    )
    add("--patience", type=not_negative, metavar="N", help="0: no early stop")
    add(
        "--seed",
        type=not_negative,
        metavar="S",
        help="start of all random draws (default: 0)",
    )


def Run(args: argparse.Namespace) -> int:
    """Trains or resumes; prints where and how well."""
    if args.resume:
        _refuse_changes(args)
    else:
        task, numbers = _make_records(args)
    check_training_extra()
    from brace_drake.learning.training.train import (
        ResumeTraining,
        StartTraining,
    )

    folder = Path(args.out)
    with open_bar(unit="step", unit_scale=True) as bar:

        def progress(done: int, total: int, mean: float, best: float) -> None:
            bar.total = total
            bar.set_postfix_str(f"return {mean:.1f}, best {best:.1f}", False)
            bar.update(done - bar.n)

        if args.resume:
            result = ResumeTraining(folder, progress)
        else:
            result = StartTraining(folder, task, numbers, progress)
    why = "patience ran out" if result["stopped"] else "budget used"
    print(
        f"run: {folder}, {result['steps']} steps, best return"
        f" {result['best']:.2f}, {why}"
    )
    print(f"policy: {folder / 'best.npz'}")
    return 0


_CHANGES = (
    "task", "training", "reward", "subjects", "readings", "episodes", "envs",
    "patience", "seed",
)  # fmt: skip


def _refuse_changes(args: argparse.Namespace) -> None:
    given = [n for n in _CHANGES if getattr(args, n) is not None]
    if given or args.full:
        named = ", ".join(f"--{n}" for n in given) or "--full"
        raise PolicyError(f"--resume goes on as begun; not with {named}")


def _make_records(args: argparse.Namespace):
    """Task and hyper-parameters from files, then options over them."""
    from brace_drake.learning.rewards import improved
    from brace_drake.learning.subjects import between_patients
    from brace_drake.learning.task import LearningTask, full_task
    from brace_drake.learning.training.numbers import TrainingNumbers
    from brace_drake.scenario.load import LoadRecord

    task = full_task() if args.full else LearningTask()
    if args.task is not None:
        task = LoadRecord(task, args.task)
    if args.reward == "improved":
        task.reward = improved()
    if args.subjects == "between":
        task.subjects = between_patients()
    task.readings = args.readings or task.readings
    numbers = TrainingNumbers()
    if args.training is not None:
        numbers = LoadRecord(numbers, args.training)
    for name in ("episodes", "envs", "patience", "seed"):
        value = getattr(args, name)
        if value is not None:
            setattr(numbers, name, value)
    return task, numbers
