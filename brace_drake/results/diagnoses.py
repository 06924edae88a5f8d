"""`diagnose`: where the gap lies, which effects make it, how far it shrinks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from brace_drake.core.errors import CampaignError, quoted, suggest
from brace_drake.core.frames import pick_frames
from brace_drake.core.output import MakeFolder, WriteJson
from brace_drake.recording.recording import Campaign
from brace_drake.results.campaigns import as_campaign
from brace_drake.results.options import (
    Names,
    Progress,
    find_diagram,
    make_choice,
    open_jobs,
    tell,
)
from brace_drake.results.tables import diagnosis_tables

if TYPE_CHECKING:
    from brace_drake.diagnosis import Diagnosis
    from brace_drake.report.law_curve import LawCurve
    from brace_drake.report.traces import RunTrace
    from brace_drake.results.repaired import RepairedTwin


class DiagnosisResult:
    """A diagnosis: verdict, tables, figures, files and the repaired twin.

    Attributes:
        found: All results in memory.
        document: Content of diagnosis.json.
        verdict: Its part of that name.
        sentence: The verdict in words.
        effects: Names of the effects that explain the gap.
        probability: That the verdict is right.
        closed: Share of the gap that they close on validation runs; None
            where that is not known.
        warnings: What has to be known beside the verdict.
    """

    def __init__(self, found: Diagnosis, command: str | None = None):
        from brace_drake.document.document import MakeDocument
        from brace_drake.document.origin import Origin

        self.found = found
        self.document: dict[str, Any] = MakeDocument(found, Origin(command))
        self.verdict: dict[str, Any] = self.document["verdict"]
        self.sentence: str = self.verdict["sentence"]
        self.effects = tuple(self.verdict["effects"])
        self.probability: float = self.verdict["probability"]
        self.closed: float | None = (self.document["shrink"] or {}).get(
            "closed"
        )
        self.warnings: list[str] = self.document["warnings"]

    def __repr__(self) -> str:
        text = f"<Diagnosis: {self.sentence} Probability {self.probability:.2f}"
        if self.closed is not None:
            text += f", closed share {100.0 * self.closed:.1f} %"
        return f"{text}>"

    def _repr_html_(self) -> str:
        from brace_drake.results.notebook import render_diagnosis

        return render_diagnosis(self.document)

    @cached_property
    def traces(self) -> list[RunTrace]:
        """Measured and predicted channels of every run."""
        from brace_drake.document.traces import MakeTraces

        return MakeTraces(self.found)

    @cached_property
    def laws(self) -> list[LawCurve]:
        """Curves of the law of what is left."""
        from brace_drake.document.law_curves import MakeLawCurves

        return MakeLawCurves(self.found)

    @cached_property
    def repaired(self) -> RepairedTwin:
        """The twin with the effects that were found.

        Raises:
            CampaignError: None was found.
        """
        from brace_drake.results.repaired import RepairedTwin

        return RepairedTwin(self.found)

    def to_pandas(self, table: str | None = None) -> Any:
        """Tables as DataFrames by name, or the one of a name: causes,
        parameters, subject, supported, budget, blocks, attribution, channels,
        phases, bands, validation, tolerances, left.

        Raises:
            BraceError: No such table.
            ExtraError: pandas is not installed.
        """
        return pick_frames(diagnosis_tables(self.document), table)

    def plot(self, run: str | None = None) -> Any:
        """Measured beside the twin before and after, as a matplotlib figure.

        Args:
            run: Name of a run; None: the validation run that shows the gap
                best, a fit run where there is no validation run.

        Raises:
            CampaignError: No such run, or nothing of it can be drawn.
        """
        from brace_drake.report.figures.traces import draw_trace
        from brace_drake.report.traces import most_telling

        if run is None:
            place, _ = most_telling(self.traces) or (0, None)
            trace = self.traces[place]
        else:
            known = {t.name: t for t in self.traces}
            if run not in known:
                hint = suggest(run, known)
                raise CampaignError(
                    f"no run {quoted(run)}{hint}; allowed: {', '.join(known)}"
                )
            trace = known[run]
        figure = draw_trace(trace, encode=lambda figure: figure)
        if figure is None:
            raise CampaignError(f"nothing of {trace.name} can be drawn")
        # Made outside of pyplot: notebooks show what can turn into a picture.
        figure._repr_png_ = lambda: _png_of(figure)
        return figure

    def report(self, path: str | Path) -> Path:
        """Writes the report, an HTML file that needs nothing else.

        Raises:
            OutputError: It cannot be written.
        """
        from brace_drake.report import WriteReport

        WriteReport(self.document, self.traces, path, self.laws)
        return Path(path)

    def save(self, folder: str | Path) -> Path:
        """Writes what the command writes: diagnosis.json, report.html, and
        where there are such, repaired.scenario.yaml and next_run.csv.

        Returns:
            The folder.

        Raises:
            OutputError: It cannot be written.
        """
        from brace_drake.design.next_run import WriteNextRun
        from brace_drake.validation.repaired import WriteRepairedScenario

        folder = MakeFolder(Path(folder))
        WriteJson(folder / "diagnosis.json", self.document)
        twin = self.found.device.twin
        WriteRepairedScenario(twin, self.found.repair, folder)
        WriteNextRun(self.found.next_run, folder)
        self.report(folder / "report.html")
        return folder

    def export(
        self,
        folder: str | Path,
        *,
        pdf: bool = False,
        figures: str | None = None,
        tables: str | None = None,
    ) -> list[Path]:
        """Writes files for a paper; returns them.

        Args:
            folder: Where to.
            pdf: Whether report.pdf is written, one page.
            figures: Format of the report's figures: svg, png or pdf.
            tables: Format of its tables: csv or latex.

        Raises:
            OutputError: They cannot be written.
        """
        from brace_drake.report.export import (
            WriteFigures,
            WritePdf,
            WriteTables,
        )

        document, traces = self.document, self.traces
        folder = MakeFolder(Path(folder))
        written = WritePdf(document, traces, folder) if pdf else []
        if figures:
            written += WriteFigures(
                document, traces, self.laws, folder, figures
            )
        if tables:
            written += WriteTables(document, folder, tables)
        return written


def diagnose(
    campaign: str | Path | Campaign,
    *,
    scenario: Any = None,
    diagram: str | Callable | None = None,
    effects: Names | None = None,
    without: Names | None = None,
    free: Names | None = None,
    fixed: Mapping[str, float | None] | Names | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
    jobs: int | None = None,
    cluster: str | None = None,
    seed: int = 0,
    progress: Progress = True,
    command: str | None = None,
) -> DiagnosisResult:
    """Diagnoses the gap between a twin and a campaign.

    Args:
        campaign: Its folder, or what `load` returned.
        scenario: File or scenario of the nominal twin; None: the one that the
            campaign names, else the package's.
        diagram: Function that makes the nominal Drake diagram, or its name as
            in "arm.py:MakeArm"; for campaigns whose device is a diagram.
        effects, without: Names of effects to search, and to leave out; None:
            all of the device.
        free: Parameters of the subject that are fitted; None: all but the
            fixed ones.
        fixed: Those that are held, by name, in SI units; None as a value: at
            the scenario's.
        bounds: Lower and upper limits by name, in SI units; of an effect's
            parameter as EFFECT.NAME.
        priors: Value and tolerance by name, in SI units: mean and standard
            deviation of a normal prior.
        jobs: Threads, all cores by default; results do not depend on it.
        cluster: Address of a Dask scheduler whose workers do the work.
        seed: Of all random draws.
        progress: A bar, nothing, or a function of what is done and its share.
        command: The command line that does the same, for the provenance.

    Raises:
        CampaignError: The campaign cannot be used.
        ScenarioError: The scenario cannot be used.
        EffectError, FitError: What was chosen is not there.
    """
    # Numba and Drake are slow to import: only once the input is good.
    loaded = as_campaign(campaign)
    choice = make_choice(effects, without, free, fixed, bounds, priors)
    from brace_drake import diagnosis

    with open_jobs(jobs, cluster) as workers, tell(progress) as say:
        found = diagnosis.diagnose(
            loaded,
            workers,
            seed,
            scenario,
            progress=say,
            diagram=find_diagram(diagram),
            choice=choice,
        )
    return DiagnosisResult(found, command)


def _png_of(figure: Any) -> bytes:
    import io

    memory = io.BytesIO()
    figure.savefig(memory, format="png", dpi=110)
    return memory.getvalue()
