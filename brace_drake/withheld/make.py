"""Makes withheld cases: recordings in one place, their truth in another."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from pathlib import Path

import numpy as np
import yaml

from brace_drake.core.errors import OutputError
from brace_drake.core.output import HoldFolder, MakeFolder, WriteJson, WriteText
from brace_drake.core.parallel import Workers
from brace_drake.core.places import check_file, check_folder, real_path
from brace_drake.recording import Campaign, Run, WriteCampaign
from brace_drake.withheld.cases import Case, build_case, draw_faults, draw_kinds
from brace_drake.withheld.floors import measure
from brace_drake.withheld.seals import SEALS, VAULT_FORMAT, new_salt, seal
from brace_drake.withheld.simulator import (
    COLUMNS,
    LOG_PERIOD,
    REFERENCE,
    Flaws,
    Motion,
    Subject,
    make_motions,
    run_bench,
)
from brace_drake.withheld.tolerances import check_factor

_DEVICE = "bench stage 2"


def record_campaign(
    case: Case, motions: list[Motion], name: str, rng: np.random.Generator
) -> Campaign:
    """Records all motions of a case."""
    runs = []
    for motion in motions:
        log = run_bench(
            motion.wanted, motion.contact, case.subject, case.flaws, rng
        )
        channels = {"time_s": np.arange(len(log)) * LOG_PERIOD}
        channels |= dict(zip(COLUMNS, log.T, strict=True))
        channels |= dict(zip(REFERENCE, motion.samples.T, strict=True))
        runs.append(
            Run(
                file=f"{motion.name}.csv",
                contact=motion.contact,
                motion=motion.kind,
                repeat_of=motion.repeat_of,
                split=motion.split,
                channels=channels,
            )
        )
    return Campaign(Path(name), _DEVICE, 1.0 / LOG_PERIOD, name, tuple(runs))


def largest_command(motions: list[Motion]) -> Callable[[Subject], float]:
    """The function from a subject to the largest command, N, of a push."""
    push = next(m for m in motions if m.name == "push")

    def largest(subject: Subject) -> float:
        log = run_bench(
            push.wanted,
            True,
            subject,
            Flaws(),
            np.random.default_rng(0),
            False,
        )
        return float(np.max(np.abs(log[:, :6])))

    return largest


def size_of(case: Case, motions: list[Motion]) -> dict:
    """Sizes in floors of the faults on their machine and, apart from them, of
    the background; of two faults also what each adds beside the other.
    """
    background = measure(
        motions, case.subject, Flaws(), case.background, refit=False
    )
    sizes = {"background": background._asdict(), "faults": None}
    if case.faults:
        gap = measure(motions, case.subject, case.machine, case.flaws)
        sizes["faults"] = gap._asdict()
    if len(case.faults) > 1:
        sizes["beside"] = {
            f.name: measure(
                motions, case.subject, case.without(f), case.flaws
            )._asdict()
            for f in case.faults
        }
    return sizes


def make_cases(
    out: Path,
    vault: Path,
    count: int,
    seed: int | None = None,
    progress: Callable[[int], None] = lambda done: None,
    jobs: int = 1,
    tolerances: float = 0.0,
) -> None:
    """Writes `count` cases, their seals, and the vault.

    Args:
        out: Folder for the recordings and SEALS.yaml; it must not hold any.
        vault: File for the truth, outside `out`.
        count: Of cases.
        seed: For repeatable cases, which are not blind; by default the
            operating system's entropy, which is not kept.
        progress: Told how many cases are done.
        jobs: Cases at a time; they do not depend on it.
        tolerances: Multiple of its tolerances that each machine is off by;
            with 0 machines are as their data sheet says.

    Raises:
        OutputError: A place is taken or the vault lies among the cases.
        ToleranceError: There is no such multiple.
    """
    check_factor(tolerances)
    check_folder(Path(out))
    out, vault = real_path(out), real_path(vault)
    if out == vault.parent or out in vault.parents:
        raise OutputError(f"{vault}: the vault must lie outside {out}")
    for taken in (out / SEALS, vault):
        if taken.exists():
            raise OutputError(f"{taken}: exists already, not replaced")
    HoldFolder(out)
    MakeFolder(vault.parent)
    check_file(vault)
    entropy = secrets.randbits(256) if seed is None else seed
    source = np.random.SeedSequence(entropy)
    kinds_rng, *children = source.spawn(count + 1)
    kinds = draw_kinds(np.random.default_rng(kinds_rng), count)
    tasks = [
        (out / f"case{i:03d}", kind, np.random.default_rng(child), tolerances)
        for i, (kind, child) in enumerate(zip(kinds, children, strict=True))
    ]
    with Workers(jobs) as workers:
        made = workers.map(_make_case, tasks, progress)
    truths, seals = {}, {}
    for (path, *_), truth in zip(tasks, made, strict=True):
        salt = new_salt()
        truths[path.name] = {"salt": salt, "truth": truth}
        seals[path.name] = seal(truth, salt)
    # The vault first: seals without a truth would be worthless.
    WriteJson(vault, {"format": VAULT_FORMAT, "cases": truths})
    vault.chmod(0o600)
    WriteText(out / SEALS, yaml.safe_dump({"seals": seals}))


def _make_case(
    path: Path, kind: str, rng: np.random.Generator, tolerances: float
) -> dict:
    motions = make_motions(rng)
    faults, severity = draw_faults(rng, kind, tolerances)
    largest = largest_command(motions)
    case = build_case(rng, kind, faults, severity, largest, tolerances)
    WriteCampaign(record_campaign(case, motions, path.name, rng), path)
    floors = size_of(case, motions)
    return {"name": path.name, **case.truth(), "floors": floors}
