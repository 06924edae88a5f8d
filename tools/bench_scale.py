"""Where the time of a diagnosis goes, and how it grows.

    python tools/bench_scale.py                    # all of the table
    python tools/bench_scale.py --rows causes,runs,subjects,workers
    python tools/bench_scale.py --campaign DIR --rows whole

Each row is a process of its own with compiled laws. CPU time counts all of its
threads and is what a bill counts; wall time is what a shared machine allows.
"""

import argparse
import multiprocessing
import os
import resource
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

EXAMPLE = Path(__file__).resolve().parents[1] / "tests" / "data" / "example"
# The example's own cause stays in every library.
KEPT = "relaxation"
ROWS = "whole,causes,runs,subjects,workers"


@dataclass(frozen=True)
class Task:
    """One row: a campaign, cut down, diagnosed so many times.

    Attributes:
        label: Of the row.
        campaign: Folder.
        causes: Effects in the library; None: all.
        runs: Fit runs; None: all.
        subjects: Campaigns, one after the other in one process.
        jobs: Threads.
        in_stages: Whether each stage has a line too.
    """

    label: str
    campaign: str
    causes: int | None = None
    runs: int | None = None
    subjects: int = 1
    jobs: int = 1
    in_stages: bool = False


class StageClock:
    """Time of each stage of a diagnosis, from what it says that it does.

    Attributes:
        stages: CPU s and wall s by name, in the order of their beginnings.
    """

    def __init__(self):
        self.stages: dict[str, list[float]] = {}
        self._name, self._since = "", (0.0, 0.0)

    def say(self, what: str, share: float) -> None:
        """The diagnosis begins something; to be handed over as progress."""
        now = time.process_time(), time.monotonic()
        if self._name:
            spent = self.stages.setdefault(self._name, [0.0, 0.0])
            for i in range(2):
                spent[i] += now[i] - self._since[i]
        if what.startswith("cause "):
            what = "two effects" if "+" in what else "single effects"
        self._name, self._since = what, now


def make_tasks(rows: list[str], campaign: str) -> Iterator[Task]:
    """The rows of the table."""
    if "whole" in rows:
        yield Task("whole campaign", campaign, in_stages=True)
    for causes in (1, 6, 12, None) if "causes" in rows else ():
        yield Task(f"causes: {causes or 'all'}", campaign, causes=causes)
    for runs in (1, 2, None) if "runs" in rows else ():
        yield Task(f"fit runs: {runs or 'all'}", campaign, runs=runs)
    for subjects in (1, 2, 4) if "subjects" in rows else ():
        label = f"subjects: {subjects}, 6 causes"
        yield Task(label, campaign, causes=6, subjects=subjects)
    for jobs in (1, 2) if "workers" in rows else ():
        yield Task(f"threads: {jobs}, 6 causes", campaign, causes=6, jobs=jobs)


def keep_causes(count: int) -> None:
    """Leaves so many effects in the library of this process."""
    from brace_drake.effects import registry

    cards = registry._library()
    names = sorted(cards, key=lambda name: not name.startswith(KEPT))[:count]
    kept = {name: cards[name] for name in names}
    registry._library = lambda: kept


def cut_runs(campaign, count: int):
    """The last fit runs, which touch the torso, and all validation runs."""
    files = {r.file for r in campaign.split("fit")[-count:]}
    runs = [r for r in campaign.runs if r.file in files or r.split != "fit"]
    runs = [
        r if r.repeat_of in files else replace(r, repeat_of=None) for r in runs
    ]
    return replace(campaign, runs=tuple(runs))


def run_task(task: Task, answer) -> None:
    """Diagnoses; sends CPU s, wall s, peak MB, the verdict, the stages."""
    from brace_drake.diagnosis import diagnose
    from brace_drake.document.document import MakeDocument
    from brace_drake.recording import LoadCampaign

    if task.causes is not None:
        keep_causes(task.causes)
    campaign = LoadCampaign(task.campaign)
    if task.runs is not None:
        campaign = cut_runs(campaign, task.runs)
    clock = StageClock()
    cpu, wall = time.process_time(), time.monotonic()
    for _ in range(task.subjects):
        diagnosis = diagnose(campaign, task.jobs, progress=clock.say)
        clock.say("document", 1.0)
        document = MakeDocument(diagnosis)
        clock.say("end", 1.0)
    cpu, wall = time.process_time() - cpu, time.monotonic() - wall
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    found = ", ".join(document["verdict"]["effects"])
    answer.send((cpu, wall, peak, found, clock.stages))


def measure(task: Task) -> tuple[float, float, float, str, dict]:
    """A row, from a process of its own."""
    here, there = multiprocessing.Pipe(duplex=False)
    context = multiprocessing.get_context("spawn")
    process = context.Process(target=run_task, args=(task, there))
    process.start()
    there.close()
    try:
        return here.recv()
    except EOFError:
        sys.exit(f"{task.label}: the process ended without an answer")
    finally:
        process.join()


def print_table(rows: list[str], campaign: str) -> None:
    """Prints the table, row by row."""
    head = ("CPU s", "wall s", "peak MB")
    print(f"{'diagnosis':28}" + "".join(f"{h:>9}" for h in head) + "  found")
    for task in make_tasks(rows, campaign):
        cpu, wall, peak, found, stages = measure(task)
        numbers = f"{cpu:9.1f}{wall:9.1f}{peak:9.0f}"
        print(f"{task.label:28}{numbers}  {found or 'nothing'}", flush=True)
        for name, spent in stages.items() if task.in_stages else ():
            print(f"  {name:26}{spent[0]:9.1f}{spent[1]:9.1f}", flush=True)


def main() -> None:
    """Prints what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--campaign", default=str(EXAMPLE))
    parser.add_argument("--rows", default=ROWS)
    args = parser.parse_args()
    print_table(args.rows.split(","), args.campaign)


if __name__ == "__main__":
    main()
