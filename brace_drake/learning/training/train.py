"""A training run from start to end, or on from where a kill has left it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from brace_drake.core.errors import PolicyError
from brace_drake.core.output import HoldFolder, ReleaseFolder
from brace_drake.learning.policy import SavePolicy
from brace_drake.learning.task import (
    LearningTask,
    check_task,
    load_task_scenario,
)
from brace_drake.learning.training import run_folder
from brace_drake.learning.training.learner import Learner
from brace_drake.learning.training.numbers import (
    TrainingNumbers,
    check_training,
)

# (steps done, steps in all, return of the training episodes, best evaluation)
Progress = Callable[[int, int, float, float], None]


@dataclass
class _Best:
    """The best evaluation so far, and how many since were no better."""

    score: float = -math.inf
    since: int = 0


def StartTraining(
    folder: Path,
    task: LearningTask,
    numbers: TrainingNumbers,
    progress: Progress | None = None,
) -> dict:
    """Trains into a folder that has no run yet.

    Writes task, hyper-parameters, scenario, seed, versions; `curve.csv`,
    `curve.png`; `policy.npz`, the last, `best.npz`, the best in evaluation;
    `checkpoint.pt`.

    Returns:
        `steps`, `updates`, `best`, and `stopped`: whether patience ran out.

    Raises:
        PolicyError: The folder holds a run already.
        ScenarioError: Task or numbers are not allowed.
    """
    folder = Path(folder)
    if (folder / run_folder.CHECKPOINT).exists():
        raise PolicyError(f"{folder}: holds a training run: resume it")
    check_task(task, load_task_scenario(task))
    check_training(numbers)
    run_folder.WriteStart(folder, task, numbers)
    learner = Learner(task, numbers)
    return _train(folder, learner, [], _Best(), progress)


def ResumeTraining(folder: Path, progress: Progress | None = None) -> dict:
    """Continues a run, as `StartTraining` would have without a stop.

    The weights come out the same bit for bit, wherever it was killed.

    Raises:
        PolicyError: There is no run, or other versions have begun it.
        OutputError: Another process is at it.
    """
    folder = Path(folder)
    task, numbers = run_folder.LoadStart(folder)
    state = run_folder.LoadCheckpoint(folder)
    HoldFolder(folder)
    learner = Learner(task, numbers)
    learner.set_state(state["learner"])
    best = _Best(**state["best"])
    return _train(folder, learner, state["rows"], best, progress)


def TrainPolicy(
    folder: Path, task: LearningTask, numbers: TrainingNumbers
) -> Path:
    """Trains into a folder, or continues what it holds; the best policy.

    A run that is finished is not run again.

    Raises:
        PolicyError: Other versions have begun it, or it is of another task,
            scenario or numbers.
        ScenarioError: Task or numbers are not allowed.
    """
    folder = Path(folder)
    if (folder / run_folder.CHECKPOINT).exists():
        run_folder.CheckSame(folder, task, numbers)
        ResumeTraining(folder)
    else:
        StartTraining(folder, task, numbers)
    return folder / "best.npz"


def _train(
    folder: Path,
    learner: Learner,
    rows: list[dict],
    best: _Best,
    progress: Progress | None,
) -> dict:
    numbers = learner.numbers
    total = numbers.episodes * learner.task.max_steps
    updates = math.ceil(total / numbers.horizon)
    stopped = _is_over(learner, best)
    try:
        while learner.updates < updates and not stopped:
            rows.append(learner.advance())
            last = learner.updates == updates
            evaluates = last or learner.updates % numbers.evaluate_every == 0
            rows[-1]["evaluation"] = math.nan
            if evaluates:
                stopped = _evaluate(folder, learner, rows, best)
            if (
                last
                or stopped
                or not learner.updates % numbers.checkpoint_every
            ):
                _save(folder, learner, rows, best)
            if progress is not None:
                mean = rows[-1]["episode_return"]
                progress(learner.steps, total, mean, best.score)
    finally:
        learner.close()
        ReleaseFolder(folder)
    return {
        "steps": learner.steps,
        "updates": learner.updates,
        "best": best.score,
        "stopped": stopped,
    }


def _evaluate(
    folder: Path, learner: Learner, rows: list[dict], best: _Best
) -> bool:
    """Evaluates, keeps the best; whether patience has run out."""
    score = rows[-1]["evaluation"] = learner.evaluate()
    best.since += 1
    if score > best.score:
        best.score, best.since = score, 0
        SavePolicy(learner.policy(), folder / "best.npz")
    run_folder.DrawCurve(folder, rows)
    return _is_over(learner, best)


def _is_over(learner: Learner, best: _Best) -> bool:
    """Whether patience has run out."""
    return 0 < learner.numbers.patience <= best.since


def _save(
    folder: Path, learner: Learner, rows: list[dict], best: _Best
) -> None:
    SavePolicy(learner.policy(), folder / "policy.npz")
    run_folder.WriteCurve(folder, rows)
    state = {"learner": learner.state(), "rows": rows, "best": vars(best)}
    run_folder.WriteCheckpoint(folder, state)
