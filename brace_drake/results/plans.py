"""`plan`: what planned runs could not tell apart."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from brace_drake.core.errors import CampaignError
from brace_drake.core.frames import pick_frames
from brace_drake.recording.recording import Campaign, Run
from brace_drake.results.document_result import DocumentResult
from brace_drake.results.options import (
    Names,
    Progress,
    as_names,
    make_choice,
    open_jobs,
    tell,
)
from brace_drake.results.tables import plan_tables


class PlanResult(DocumentResult):
    """What runs would show of each effect, before they are recorded.

    Attributes:
        document: Content of plan.json.
        runs: Names of the planned runs.
        pairs: Pairs of effects that they do not tell apart.
    """

    FILE = "plan.json"

    def __init__(self, document: dict[str, Any]):
        super().__init__(document)
        self.runs: list[str] = document["runs"]
        self.pairs = [tuple(p["effects"]) for p in document["pairs"]]

    def __repr__(self) -> str:
        effects = len(self.document["effects"])
        alike = "; ".join(" and ".join(pair) for pair in self.pairs)
        text = f"<Plan of {', '.join(self.runs)}: {effects} effects"
        text += f", not told apart: {alike}" if alike else ", all told apart"
        if self.document["unseen"]:
            text += f"; not seen: {', '.join(self.document['unseen'])}"
        return f"{text}>"

    def _repr_html_(self) -> str:
        from brace_drake.results.notebook import render_plan

        return render_plan(self.document)

    def to_pandas(self, table: str | None = "effects") -> Any:
        """A table as a DataFrame, or all by name where `table` is None.

        Raises:
            BraceError: No such table.
            ExtraError: pandas is not installed.
        """
        return pick_frames(plan_tables(self.document), table)


def plan(
    motions: Names | None = None,
    *,
    references: str | Path | Campaign | None = None,
    scenario: Any = None,
    effects: Names | None = None,
    without: Names | None = None,
    jobs: int | None = None,
    cluster: str | None = None,
    seed: int = 0,
    progress: Progress = True,
) -> PlanResult:
    """Says which effects planned runs could not tell apart.

    Args:
        motions: Of the library; None: those of a common campaign.
        references: In place of motions: a folder of references (*.csv), or a
            campaign, whose fit runs are taken.
        scenario: File or scenario of the bench; None: the one that the
            campaign of `references` names, else the package's.
        effects, without: Names of effects to put in, and to leave out; None:
            all of the library.
        jobs: Threads, all cores by default; results do not depend on it.
        cluster: Address of a Dask scheduler whose workers do the work.
        seed: Of all random draws.
        progress: A bar, nothing, or a function of what is done and its share.

    Raises:
        CampaignError: No such motion, or a scenario of another device.
        EffectError: No such effect.
        ScenarioError: The scenario cannot be used.
    """
    from brace_drake.design.plan import plan_campaign
    from brace_drake.devices.bench.twin import BenchTwin
    from brace_drake.devices.motions.reference import common_rate

    if motions is not None and references is not None:
        raise CampaignError("a plan is of motions or of references, not both")
    choice = make_choice(effects, without)
    twin = BenchTwin(_scenario(references, scenario))
    cards = choice.effects_of(twin) if choice.limits_search else None
    runs = _runs(motions, references)
    with open_jobs(jobs, cluster) as workers, tell(progress) as say:
        return PlanResult(
            plan_campaign(
                twin, runs, common_rate(runs), cards, workers, seed, say
            )
        )


def _scenario(references: Any, given: Any) -> Any:
    """The bench's scenario that a plan is made for."""
    from brace_drake.devices.nominal_scenario import (
        choose_scenario,
        load_given,
    )
    from brace_drake.recording.columns import BENCH
    from brace_drake.scenario.brace import BenchScenario

    campaign = _campaign(references)
    if campaign is not None:
        found = choose_scenario(campaign, given)
    elif given is None:
        return BenchScenario()
    else:
        found = load_given(given)
    scenario = found.scenario or BenchScenario()
    if scenario.device != BENCH:
        raise CampaignError(
            f"{found.file or 'scenario'}: plans are made for {BENCH!r}, this is"
            f" a {scenario.device!r}"
        )
    return scenario


def _campaign(references: Any) -> Campaign | None:
    """The campaign that references are of; None of a folder of files."""
    from brace_drake.recording import LoadCampaign
    from brace_drake.recording.manifest import MANIFEST

    if references is None or isinstance(references, Campaign):
        return references
    is_campaign = (Path(references) / MANIFEST).is_file()
    return LoadCampaign(references) if is_campaign else None


def _runs(motions: Names | None, references: Any) -> tuple[Run, ...]:
    from brace_drake.devices.motions.library import STANDARD, MakeMotion
    from brace_drake.devices.motions.reference import LoadReferences

    if isinstance(references, Campaign):
        references = references.path
    if references is not None:
        return LoadReferences(references)
    names = as_names(motions) or STANDARD
    return tuple(MakeMotion(name).run for name in names)
