"""All values and seeds of a sweep, in parallel; and what comes out."""

from __future__ import annotations

import hashlib
import importlib.metadata
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.common.yaml import yaml_dump_typed
from scipy import special

from brace_drake.core.errors import BraceError, ScenarioError
from brace_drake.core.parallel import Workers
from brace_drake.recording.recording import Run
from brace_drake.sweep.numbers import ScenarioNumber, with_number
from brace_drake.sweep.outcomes import choose_outcomes, outcomes_of, unit_of
from brace_drake.sweep.runs import make_simulator, with_contact

FORMAT = "brace-sweep/1"
# Of a sweep, whose outcomes are all kept until it is written.
_MOST_RUNS = 100_000


@dataclass(frozen=True)
class Plan:
    """What is swept.

    Attributes:
        scenario, source: Checked, and its file.
        number, values: Which number takes which values.
        run: The motion.
        seeds: Of the instruments' noise; empty: exact readings.
        outcomes: Of the option, comma-separated; None: all.
    """

    scenario: Any
    source: str
    number: ScenarioNumber
    values: Sequence[float]
    run: Run
    seeds: Sequence[int] = ()
    outcomes: str | None = None


def spaced(start: float, end: float, count: int, is_log: bool) -> list[float]:
    """Values from start to end, evenly or by even ratios.

    Raises:
        ScenarioError: Fewer than two values, or ratios of what is not above 0.
    """
    if count < 2 or start == end:
        raise ScenarioError(
            f"--count {count} from {start:g} to {end:g}; allowed: 2 or more"
            " different values"
        )
    if not is_log:
        return [float(v) for v in np.linspace(start, end, count)]
    if start <= 0.0 or end <= 0.0:
        raise ScenarioError(
            f"--log from {start:g} to {end:g}; allowed: both above 0"
        )
    return [float(v) for v in np.geomspace(start, end, count)]


def check_runs(count: int, seeds: int) -> None:
    """Refuses more runs than one sweep can hold.

    Raises:
        ScenarioError: It names the most.
    """
    runs = count * max(1, seeds)
    if runs > _MOST_RUNS:
        raise ScenarioError(
            f"--count {count} with --seeds {seeds} are {runs} runs; allowed: at"
            f" most {_MOST_RUNS}"
        )


def run_sweep(
    plan: Plan,
    workers: Workers,
    progress: Callable[[int], None] | None = None,
) -> dict:
    """Simulates every value with every seed.

    A value with which the twin breaks down has a row that says why; the others
    are told all the same.

    Returns:
        The sweep in plain JSON types, format brace-sweep/1.

    Raises:
        ScenarioError: A value is not allowed; nothing has been simulated.
        BraceError: The twin breaks down with every value.
    """
    scenarios = [
        with_number(plan.scenario, plan.number, value, plan.source)
        for value in plan.values
    ]
    seeds: Sequence[int | None] = plan.seeds or (None,)
    tasks = [(s, plan.run, seed) for s in scenarios for seed in seeds]
    found = workers.map(_simulate, tasks, progress)
    good = [item for item in found if not isinstance(item, str)]
    if not good:
        raise BraceError(f"{plan.source}: every run failed: {found[0]}")
    names = choose_outcomes(plan.outcomes, list(good[0]))
    per_value = [
        found[i : i + len(seeds)] for i in range(0, len(found), len(seeds))
    ]
    rows = [
        _row(value, own, names)
        for value, own in zip(plan.values, per_value, strict=True)
    ]
    return _document(plan, names, rows)


def _simulate(scenario, run: Run, seed: int | None) -> dict[str, float] | str:
    """Outcomes of one run, or why it broke down."""
    simulate = make_simulator(scenario)
    try:
        found = outcomes_of(
            simulate(scenario, with_contact(run, scenario), seed)
        )
    except ScenarioError:
        raise
    except BraceError as error:
        # Of another kind it is the input that is wrong, for every value.
        if type(error) is not BraceError:
            raise
        return str(error)
    broken = [name for name, v in found.items() if not np.isfinite(v)]
    return f"{broken[0]} is not finite" if broken else found


def _row(value: float, results: list, names: Sequence[str]) -> dict:
    failed = [r for r in results if isinstance(r, str)]
    row: dict = {"value": value, "error": failed[0] if failed else None}
    row["outcomes"] = {}
    if failed:
        return row
    for name in names:
        draws = np.array([r[name] for r in results])
        row["outcomes"][name] = _summary(draws)
    return row


def _summary(draws: np.ndarray) -> dict:
    """Mean over seeds, standard deviation of one run, interval of the mean."""
    n, mean = len(draws), float(draws.mean())
    if n < 2:
        return {
            "mean": mean,
            "standard_deviation": None,
            "lower95": None,
            "upper95": None,
        }
    deviation = float(draws.std(ddof=1))
    half = float(special.stdtrit(n - 1, 0.975)) * deviation / np.sqrt(n)
    return {
        "mean": mean,
        "standard_deviation": deviation,
        "lower95": mean - float(half),
        "upper95": mean + float(half),
    }


def _document(plan: Plan, names: Sequence[str], rows: list[dict]) -> dict:
    scenario = yaml_dump_typed(plan.scenario)
    return {
        "format": FORMAT,
        "scenario": plan.source,
        "device": plan.scenario.device,
        "number": {
            "path": plan.number.path,
            "unit": plan.number.unit,
            "nominal": plan.number.value,
        },
        "motion": plan.run.file,
        "duration_s": float(plan.run.time_s[-1] - plan.run.time_s[0]),
        "seeds": list(plan.seeds),
        "outcomes": [{"name": n, "unit": unit_of(n)} for n in names],
        "rows": rows,
        "provenance": {
            "scenario_sha256": hashlib.sha256(scenario.encode()).hexdigest(),
            "versions": {
                p: importlib.metadata.version(p)
                for p in ("brace_drake", "drake", "numpy", "numba")
            },
        },
    }
