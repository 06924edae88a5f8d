"""A case as the baselines see it: residual of the nominal twin, signatures.

The nominal twin is fitted as the diagnosis does it: subject alone, numbers
within their tolerances marginalised. Its whitened residual, the subject's
sensitivities and one replay of each effect at each of its starts are all that
the linear methods look at. They are kept as inner products: a least-squares fit
needs no more.
"""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from brace_drake.devices.device import MakeDevice
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.recording import Campaign, LoadCampaign
from tools.baselines.signatures import Signature, calc_signatures

SEED = 0


@dataclass(frozen=True)
class Bench:
    """A campaign with its twin.

    Attributes:
        device: Of the campaign.
        fit, validation: Evaluators over the runs of each split.
    """

    device: object
    fit: Evaluator
    validation: Evaluator


def open_bench(campaign: Campaign) -> Bench:
    """The twin of a campaign over its runs."""
    device = MakeDevice(campaign)
    twin, rate = device.twin, campaign.rate_hz
    usual = np.array([p.nominal for p in twin.subject])
    floors, _ = estimate_floors(twin, campaign, usual, SEED)

    def over(split, seed):
        runs = prepare_runs(twin, campaign.split(split), floors, rate, seed)
        return Evaluator(twin, runs, 1)

    return Bench(device, over("fit", SEED), over("validation", SEED + 1000))


@dataclass
class Case:
    """A case with what is kept of it.

    Attributes:
        campaign: The recordings.
        subject: Values of the nominal fit (s,).
        scales: Of those, a unit step of each (s,).
        residual: Whitened, once the subject has taken what it can (rows,).
        count: Number of independent values in it.
        gram: Inner products of the subject's sensitivities, the signatures'
            columns and the residual, in this order (n, n).
        signatures: Of all effects, with their places among the columns.
        seconds: CPU time that all this took.
    """

    campaign: Campaign
    subject: np.ndarray
    scales: np.ndarray
    residual: np.ndarray
    count: int
    gram: np.ndarray
    signatures: list[Signature]
    seconds: float

    @cached_property
    def bench(self) -> Bench:
        """The twin over the runs."""
        return open_bench(self.campaign)

    @property
    def num_subject(self) -> int:
        """How many parameters the subject has."""
        return len(self.subject)


def prepare_case(folder: Path) -> Case:
    """Fits the nominal twin to a campaign and replays all signatures."""
    begin = time.process_time()
    campaign = LoadCampaign(folder)
    bench = open_bench(campaign)
    evaluator, device = bench.fit, bench.device
    nominal = fit_nominal(evaluator, device.tolerances(), device.uses_off)
    rows, known = evaluator.ends[-1], nominal.tolerances
    columns, signatures = calc_signatures(evaluator, nominal.subject, known)
    S = nominal.solution.jacobian[:rows]
    r = nominal.solution.residual[:rows]
    whole = np.column_stack([S, columns, r]).astype(np.float32)
    gram = _gram(whole)
    basis = np.linalg.qr(S[:, np.linalg.norm(S, axis=0) > 0.0])[0]
    case = Case(
        campaign,
        nominal.subject,
        nominal.scales[: len(nominal.subject)],
        (r - basis @ (basis.T @ r)).astype(np.float32),
        evaluator.count,
        gram,
        signatures,
        time.process_time() - begin,
    )
    case.bench = bench
    return case


def _gram(columns: np.ndarray) -> np.ndarray:
    """Inner products of columns, in double precision piece by piece."""
    total = np.zeros((columns.shape[1],) * 2)
    for at in range(0, len(columns), 8192):
        piece = columns[at : at + 8192].astype(float)
        total += piece.T @ piece
    return total


def open_case(folder: Path, kept: Path) -> Case:
    """A case from what is kept of it, or prepared and kept now."""
    path = kept / f"{folder.name}.npz"
    if not path.exists():
        case = prepare_case(folder)
        kept.mkdir(parents=True, exist_ok=True)
        _keep(case, path)
        return case
    with np.load(path) as stored:
        head = json.loads(str(stored["head"]))
        return Case(
            LoadCampaign(folder),
            stored["subject"],
            stored["scales"],
            stored["residual"],
            head["count"],
            stored["gram"],
            [Signature.read(row) for row in head["signatures"]],
            head["seconds"],
        )


def _keep(case: Case, path: Path) -> None:
    head = {
        "count": case.count,
        "seconds": case.seconds,
        "signatures": [s.row() for s in case.signatures],
    }
    aside = path.with_suffix(".part.npz")
    np.savez_compressed(
        aside,
        head=json.dumps(head),
        subject=case.subject,
        scales=case.scales,
        residual=case.residual,
        gram=case.gram,
    )
    aside.replace(path)
