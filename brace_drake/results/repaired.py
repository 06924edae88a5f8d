"""The repaired twin: the fitted subject, with the effects that were found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError, quoted, suggest
from brace_drake.devices.motions.library import MOTIONS, MakeMotion
from brace_drake.devices.motions.reference import LoadReference
from brace_drake.devices.replays import is_dithered
from brace_drake.diagnosis import Diagnosis
from brace_drake.effects.stack import Use
from brace_drake.identification.evaluation import NUM_DITHERS
from brace_drake.recording.columns import BENCH, BRACE
from brace_drake.recording.recording import Run
from brace_drake.scenario.load import SaveScenario
from brace_drake.validation.repaired import MakeRepairedScenario


class RepairedTwin:
    """A nominal twin with everything that a diagnosis has found.

    Attributes:
        scenario: With the fitted subject and the effects, for --scenario.
        effects: Names of the effects.
    """

    def __init__(self, found: Diagnosis):
        """Raises CampaignError where nothing was found."""
        fit = found.repair
        self.scenario = MakeRepairedScenario(found.device.twin, fit)
        assert fit is not None  # Else there was no scenario.
        self._found, self._fit = found, fit
        self.effects = tuple(dict.fromkeys(e.name for e in fit.effects))

    def __repr__(self) -> str:
        name = self._found.campaign.name
        return f"<Twin of {name} with {', '.join(self.effects)}>"

    def simulate(
        self, motion: str | Path | Run, seed: int | None = None
    ) -> Run:
        """What the twin would record.

        Args:
            motion: Name of a run of the campaign, else of a motion of the
                library; a file of a reference (*.csv); or a run.
            seed: Of the noise of its instruments; None: exact readings, and
                where noise moves the machine, as it does with dry friction,
                the mean of some noisy ones.

        Returns:
            The run with the simulated channels in place of recorded ones, and
            with its reference.

        Raises:
            CampaignError: No such motion.
            BraceError: The simulated run broke down.
        """
        run, index = self._find(motion)
        twin, uses = self._found.device.twin, self._uses(index)
        moved = twin.motion(run)

        def record(generator: np.random.Generator | None) -> np.ndarray:
            return twin.simulate(moved, self._fit.subject, uses, generator)

        if seed is not None:
            samples = record(np.random.default_rng(seed))
        elif is_dithered(twin, uses):
            draws = [np.random.default_rng([0, i]) for i in range(NUM_DITHERS)]
            samples = np.mean([record(g) for g in draws], axis=0)
        else:
            samples = record(None)
        given = {
            name: values
            for name, values in run.channels.items()
            if name not in twin.channels and values.dtype.kind in "fiu"
        }
        simulated = dict(zip(twin.channels, samples.T.copy(), strict=True))
        return replace(run, channels={**given, **simulated}, repeat_of=None)

    def save(self, path: str | Path) -> Path:
        """Writes its scenario, for `simulate` and for --scenario.

        Raises:
            ScenarioError: It cannot be written.
        """
        SaveScenario(self.scenario, path)
        return Path(path)

    def _uses(self, index: int | None) -> tuple[Use, ...]:
        """Its effects with what a fit run has of its own, else with that 0."""
        found = []
        for effect, values in (*self._fit.uses, *self._fit.within):
            shared = values[: len(effect.parameters)]
            if index is not None:
                shared = effect.in_run(values, index)
            elif effect.run_parameters:
                shared = effect.in_run(shared, 0)
            found.append((effect, shared))
        return tuple(found)

    def _find(self, motion: str | Path | Run) -> tuple[Run, int | None]:
        """A run, and its place among the fit runs."""
        places = {p.run.name: p.index for p in self._found.evaluator.prepared}
        if isinstance(motion, Run):
            return motion, None
        runs = {run.name: run for run in self._found.campaign.runs}
        name = str(motion)
        if name in runs:
            return runs[name], places.get(name)
        has_library = self._found.campaign.device in (BENCH, BRACE)
        if has_library and name in MOTIONS:
            return MakeMotion(name).run, None
        if has_library and name.endswith(".csv"):
            return LoadReference(motion, self._stages()), None
        known = [*runs, *(MOTIONS if has_library else ())]
        hint = suggest(name, known)
        there = " There" if hint else "; there"
        raise CampaignError(
            f"no motion {quoted(name)}{hint}{there} are {', '.join(known)}"
        )

    def _stages(self) -> tuple[int, ...]:
        return tuple(getattr(self.scenario, "stages", (2,)))
