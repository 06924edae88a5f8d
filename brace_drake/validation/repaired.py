"""The repaired twin as an artefact: the scenario with what was found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from brace_drake.core.errors import CampaignError
from brace_drake.diagnose import Diagnosis
from brace_drake.scenario.effects import describe_use
from brace_drake.scenario.leg_bench import LegBenchScenario
from brace_drake.scenario.load import SaveScenario, Scenario

FILE = "repaired.scenario.yaml"

# Stands for no limit of a command, N: a file holds finite numbers.
_NO_LIMIT = 1e12


def MakeRepairedScenario(d: Diagnosis) -> Scenario:
    """The scenario of a diagnosis with the fitted subject and its effects.

    Built again, the twin replays a run as the diagnosis did after the repair.
    Parameters that every run has of its own, such as the phase of a breath,
    are no property of the device; they are not kept and are 0.

    Raises:
        CampaignError: The verdict names no effect.
    """
    winner = d.verdict.winner
    if winner is None:
        raise CampaignError(
            f"{d.campaign.name}: no effect was found, nothing to repair"
        )
    scenario = d.device.twin.scenario_of(winner.subject)
    found = [describe_use(effect, values) for effect, values in winner.uses]
    scenario.effects = [*scenario.effects, *found]
    if isinstance(scenario, LegBenchScenario):
        limit = min(scenario.control.force_limit, _NO_LIMIT)
        scenario.control = replace(scenario.control, force_limit=limit)
    return scenario


def WriteRepairedScenario(d: Diagnosis, folder: Path) -> Path | None:
    """Writes repaired.scenario.yaml; without effects, removes an older one.

    Returns:
        The file, None without effects.

    Raises:
        ScenarioError: It cannot be written.
    """
    path = folder / FILE
    if d.verdict.winner is None:
        path.unlink(missing_ok=True)
        return None
    SaveScenario(MakeRepairedScenario(d), path)
    return path
