"""`fit`: the subject's parameters from a campaign."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from brace_drake.core.frames import pick_frames
from brace_drake.core.progress import open_bar
from brace_drake.devices.choice import Choice
from brace_drake.recording.recording import Campaign
from brace_drake.results.campaigns import as_campaign
from brace_drake.results.document_result import DocumentResult
from brace_drake.results.options import (
    Names,
    Progress,
    find_diagram,
    make_choice,
    open_jobs,
)
from brace_drake.results.tables import fit_tables

# Floors of mean square beyond which the subject alone explains no recording.
_FAR = 2.0
# Evaluations that a fit usually takes; for the estimate of the time left.
_USUAL = 8


class FitResult(DocumentResult):
    """Parameters of a subject with their uncertainty.

    Attributes:
        document: Content of fit.json.
        parameters: Its rows: name, unit, value, standard_error, lower95,
            upper95, at_limit, nominal, fixed.
    """

    FILE = "fit.json"

    def __init__(self, document: dict[str, Any]):
        super().__init__(document)
        self.parameters: list[dict[str, Any]] = document["parameters"]

    @property
    def warnings(self) -> list[str]:
        """What has to be known beside the parameters."""
        return fit_warnings(self.document)

    def __repr__(self) -> str:
        width = max((len(p["name"]) for p in self.parameters), default=0)
        lines = [
            f"<Fit of {self.document['campaign']}: mean square"
            f" {self.document['mean_square']:.4g} floors",
            *(f"  {p['name']:{width}} {_shown(p)}" for p in self.parameters),
            *(f"  warning: {text}" for text in self.warnings),
        ]
        return "\n".join(lines) + ">"

    def __getitem__(self, name: str) -> dict[str, Any]:
        """The row of a parameter."""
        for row in self.parameters:
            if row["name"] == name:
                return row
        raise KeyError(name)

    def _repr_html_(self) -> str:
        from brace_drake.results.notebook import render_fit

        return render_fit(self.document)

    def to_pandas(self, table: str | None = "parameters") -> Any:
        """A table as a DataFrame, or all by name where `table` is None.

        Raises:
            BraceError: No such table.
            ExtraError: pandas is not installed.
        """
        return pick_frames(fit_tables(self.document), table)


def fit(
    campaign: str | Path | Campaign,
    *,
    scenario: Any = None,
    diagram: str | Callable | None = None,
    free: Names | None = None,
    fixed: Mapping[str, float | None] | Names | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
    solver: str = "snopt",
    jobs: int | None = None,
    cluster: str | None = None,
    seed: int = 0,
    progress: Progress = True,
) -> FitResult:
    """Fits the subject's parameters to all fit runs of a campaign jointly.

    Args:
        campaign: Its folder, or what `load` returned.
        scenario: File or scenario of the nominal twin; None: the one that the
            campaign names, else the package's.
        diagram: Function that makes the nominal Drake diagram, or its name as
            in "arm.py:MakeArm"; for campaigns whose device is a diagram.
        free: Parameters that are fitted; None: all but the fixed ones.
        fixed: Parameters that are held, by name, in SI units; None as a value:
            at the scenario's.
        bounds: Lower and upper limits by name, in SI units.
        priors: Value and tolerance by name, in SI units: mean and standard
            deviation of a normal prior.
        solver: snopt, ipopt or nlopt.
        jobs: Threads, all cores by default; results do not depend on it.
        cluster: Address of a Dask scheduler whose workers do the work.
        seed: Of all random draws.
        progress: A bar, nothing, or a function of the number of evaluations
            and the mean square.

    Raises:
        CampaignError: The campaign cannot be used.
        ScenarioError: The scenario cannot be used.
        FitError: A chosen parameter is not there, or the fit failed.
    """
    from brace_drake.identification.subject.campaign_fit import fit_campaign

    loaded = as_campaign(campaign)
    choice = make_choice(free=free, fixed=fixed, bounds=bounds, priors=priors)
    with open_jobs(jobs, cluster) as workers:
        run = _told(fit_campaign, progress)
        return FitResult(
            run(
                loaded,
                workers,
                seed,
                scenario,
                solver,
                choice=choice,
                diagram=find_diagram(diagram),
            )
        )


def fit_warnings(document: Mapping[str, Any]) -> list[str]:
    """What has to be known beside the parameters of fit.json."""
    priors = document.get("choice", {}).get("priors", {})
    values = {p["name"]: p["value"] for p in document["parameters"]}
    found = Choice(priors=priors).contradicted(values)
    if document["mean_square"] <= _FAR:
        return found
    return [
        *found,
        "far above 1: the twin lacks something, and its parameters follow"
        " what it lacks; run brace-drake diagnose",
    ]


def _told(run: Callable[..., dict], progress: Any) -> Callable[..., dict]:
    """A fit that tells of its evaluations."""
    if callable(progress):
        return lambda *given, **more: run(
            *given, on_evaluation=progress, **more
        )
    return _with_bar(run) if progress else run


def _with_bar(run: Callable[..., dict]) -> Callable[..., dict]:
    def told(*given: Any, **more: Any) -> dict:
        with open_bar(total=_USUAL, unit="evaluation") as bar:

            def tell(evaluation: int, mean_square: float) -> None:
                bar.total = max(bar.total, evaluation + 1)
                text = f"mean square {mean_square:.4g} floors"
                bar.set_postfix_str(text, refresh=False)
                bar.update(evaluation - bar.n)

            return run(*given, on_evaluation=tell, **more)

    return told


def _shown(p: Mapping[str, Any]) -> str:
    """Value, interval and unit of a parameter, on one line."""
    text = f"{p['value']:.5g} {p['unit']}".rstrip()
    if p.get("fixed"):
        return f"{text}, held"
    if p["standard_error"] is None:
        return f"{text}, the runs say nothing of it"
    text += f" (95 %: {p['lower95']:.5g} to {p['upper95']:.5g})"
    return f"{text}, at its limit" if p["at_limit"] else text
