"""The repaired twin as an artefact: the scenario with what was found."""

from __future__ import annotations

from pathlib import Path

from brace_drake.core.errors import CampaignError
from brace_drake.identification.fits import CandidateFit
from brace_drake.scenario.effects import describe_use
from brace_drake.scenario.load import SaveScenario, Scenario

FILE = "repaired.scenario.yaml"


def MakeRepairedScenario(twin, winner: CandidateFit | None) -> Scenario:
    """The scenario of a twin with the fitted subject, the effects found and
    its numbers as far off within their tolerances as the fit has them.

    Built again, the twin replays a run as the diagnosis did after the repair.
    Parameters that every run has of its own, such as the phase of a breath,
    are no property of the device; they are not kept and are 0.

    Args:
        twin: The nominal one.
        winner: The fit that explains the gap.

    Raises:
        CampaignError: There is none.
    """
    if winner is None:
        raise CampaignError("no effect was found, nothing to repair")
    scenario = twin.scenario_of(winner.subject)
    uses = (*winner.uses, *winner.within)
    found = [describe_use(effect, values) for effect, values in uses]
    scenario.effects = [*scenario.effects, *found]
    return scenario


def WriteRepairedScenario(
    twin, winner: CandidateFit | None, folder: Path
) -> Path | None:
    """Writes repaired.scenario.yaml; without effects, removes an older one.

    Returns:
        The file, None without effects.

    Raises:
        ScenarioError: It cannot be written.
    """
    path = folder / FILE
    if winner is None:
        path.unlink(missing_ok=True)
        return None
    SaveScenario(MakeRepairedScenario(twin, winner), path)
    return path
