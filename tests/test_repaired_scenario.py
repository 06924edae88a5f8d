"""Scenarios that carry effects, and the repaired twin as a file."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from brace_drake.core.errors import CampaignError, EffectError, ScenarioError
from brace_drake.devices.bench.drawn import draw_tolerances, uses_of_draws
from brace_drake.devices.bench.rollout import Motion
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.device import MakeDevice
from brace_drake.devices.leg_bench.twin import LegBenchTwin
from brace_drake.devices.motions.reference import reference_at_ticks
from brace_drake.devices.pad_bench.twin import PadBenchTwin
from brace_drake.diagnosis import diagnose
from brace_drake.effects.registry import effects_for, find_effect
from brace_drake.effects.stack import stack_effects
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.model.brace_station import MakeControlledBrace
from brace_drake.recording import LoadCampaign
from brace_drake.scenario.brace import BenchScenario, EffectUse
from brace_drake.scenario.effects import describe_use, scenario_uses
from brace_drake.scenario.leg_bench import LegBenchScenario
from brace_drake.scenario.load import CheckScenario, LoadScenario, SaveScenario
from brace_drake.scenario.pad_bench import PadBenchScenario
from brace_drake.validation.repaired import (
    MakeRepairedScenario,
    WriteRepairedScenario,
)
from tests.brace_runs import along_y, bench_log
from tests.shared_data import EXAMPLE
from tests.test_station import smooth_push

SCENARIOS = (BenchScenario, LegBenchScenario, PadBenchScenario)
SUBJECT = np.array([6021.3, 143.7, 1712.9, 201.1, 43.21, 1.03e-3])


def use(key, values=None):
    """An effect at given values, or where its searches start."""
    card = find_effect(key)
    return card, np.array(card.starts()[0] if values is None else values)


def saved(scenario):
    """The scenario after a way through a file."""
    with tempfile.TemporaryDirectory() as folder:
        SaveScenario(scenario, Path(folder) / "s.yaml")
        return LoadScenario(Path(folder) / "s.yaml")


def found(subject, *uses, within=()):
    """What `MakeRepairedScenario` takes of a fit."""
    return SimpleNamespace(uses=uses, subject=subject, within=within)


class TestEffectsInFiles(unittest.TestCase):
    def test_every_effect_of_the_library_comes_back_from_a_file(self):
        schemas = {schema().device: schema for schema in SCENARIOS}
        for device in schemas:
            for card in effects_for(device).values():
                with self.subTest(effect=card.key, device=device):
                    values = card.starts()[-1]
                    scenario = schemas[device]()
                    scenario.effects = [describe_use(card, values)]
                    ((back, vector),) = scenario_uses(saved(scenario))
                    self.assertIs(back, card)
                    n = len(card.parameters)
                    np.testing.assert_array_equal(vector[:n], values)
                    np.testing.assert_array_equal(vector[n:], 0.0)

    def test_numbers_keep_their_last_digit(self):
        value = 1.0 / 3.0 + 1e-16
        scenario = BenchScenario()
        scenario.effects = [describe_use(*use("coulomb_friction", [value]))]
        ((_, vector),) = scenario_uses(saved(scenario))
        self.assertEqual(vector[0], value)

    def test_bad_effects_are_told_in_one_line(self):
        one = "name: coulomb_friction, parameters: {coulomb_N: 1}"
        cases = {
            "{name: coulom_friction}": ("[0].name", "coulomb_friction?"),
            "{name: relaxation}": ("[0].parameters.arm_stiffness_N_m", "value"),
            "{name: weak_leg, parameters: {leg: 1.5, force_loss: 0.1}}": (
                "[0].parameters.leg is 1.5",
                "1 or 2 or 3",
            ),
            "{name: coulomb_friction, parameters: {coulomb_N: -1}}": (
                "[0].parameters.coulomb_N is -1.0",
                "0 to 60 N",
            ),
            "{name: coulomb_friction, parameters: {columb_N: 1}}": (
                "[0].parameters.columb_N",
                "coulomb_N?",
            ),
            f"{{{one}, form: odd}}": ("[0].form", "'odd'"),
            "{name: backlash, form: odd}": ("[0].form", "'play' or 'gap'"),
            ", ".join([f"{{{one}}}"] * (MAX_EFFECTS + 1)): (
                "effects is",
                f"at most {MAX_EFFECTS}",
            ),
        }
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "some.scenario.yaml"
            for text, parts in cases.items():
                path.write_text(f"effects: [{text}]")
                with self.subTest(text=text):
                    with self.assertRaises(ScenarioError) as caught:
                        LoadScenario(path)
                    message = str(caught.exception)
                    self.assertNotIn("\n", message)
                    for part in (path.name, "effects", *parts):
                        self.assertIn(part, message)

    def test_an_effect_of_another_device_is_refused(self):
        scenario = PadBenchScenario()
        scenario.effects = [EffectUse("ring_mass", {"mass_kg": 0.1})]
        with self.assertRaisesRegex(ScenarioError, "effect of a pad bench"):
            CheckScenario(scenario)


class TestCarriedEffects(unittest.TestCase):
    def setUp(self):
        time, samples = smooth_push()
        self.reference = along_y(time, samples)
        self.duration = time[-1]
        desired = reference_at_ticks(time, samples, 1000.0)
        self.motion = Motion(desired, True)

    def repaired(self, *uses):
        twin = BenchTwin(BenchScenario(time_step=5e-4))
        return saved(MakeRepairedScenario(twin, found(SUBJECT, *uses)))

    def test_diagram_of_a_repaired_scenario_equals_its_rollout(self):
        pairs = (
            (use("relaxation"), use("coulomb_friction")),
            (use("ring_mass"), use("force_scale")),
        )
        for uses in pairs:
            scenario = self.repaired(*uses)
            twin = BenchTwin(scenario)
            rollout = twin.simulate(self.motion, SUBJECT)
            with self.subTest(effects=uses[0][0].name):
                station = MakeControlledBrace(scenario, self.reference)
                log = bench_log(station, self.duration)
                # The tolerance of tests/test_station.py.
                np.testing.assert_allclose(log, rollout, rtol=0, atol=1e-6)

    def test_the_file_holds_the_subject_and_the_effects_exactly(self):
        relaxing = use("relaxation")
        twin = BenchTwin(BenchScenario())
        repaired = BenchTwin(self.repaired(relaxing))
        nominal = [p.nominal for p in repaired.subject]
        np.testing.assert_array_equal(nominal, SUBJECT)
        twin.time_step = repaired.time_step
        np.testing.assert_array_equal(
            repaired.simulate(self.motion, SUBJECT),
            twin.simulate(self.motion, SUBJECT, [relaxing]),
        )

    def test_carried_effects_act_beside_those_under_test(self):
        first, second = use("hardening"), use("force_bias")
        repaired = BenchTwin(self.repaired(first))
        twin = BenchTwin(BenchScenario(time_step=5e-4))
        np.testing.assert_array_equal(
            repaired.simulate(self.motion, SUBJECT, [second]),
            twin.simulate(self.motion, SUBJECT, [first, second]),
        )

    def test_more_effects_than_the_twin_carries_are_one_clear_error(self):
        scenario = self.repaired(*[use("hardening")] * MAX_EFFECTS)
        more = [use("relaxation")]
        told = f"at most {MAX_EFFECTS} effects, got {MAX_EFFECTS + 1}"
        with self.assertRaisesRegex(EffectError, told):
            BenchTwin(scenario).simulate(self.motion, SUBJECT, more)
        with self.assertRaisesRegex(EffectError, told):
            MakeControlledBrace(scenario, self.reference, uses=more)
        with self.assertRaisesRegex(
            ScenarioError, f"carries {MAX_EFFECTS} effects"
        ):
            diagnose(LoadCampaign(EXAMPLE), 1, scenario=scenario)

    def test_effects_of_the_linear_contact_need_it(self):
        scenario = self.repaired(use("hardening"))
        scenario.contact.ring2.model = "hydroelastic"
        with self.assertRaisesRegex(EffectError, "contact.*model"):
            MakeControlledBrace(scenario, self.reference)

    def test_hydroelastic_numbers_follow_the_subject(self):
        scenario = BenchTwin(BenchScenario()).scenario_of(SUBJECT)
        contact = scenario.contact.ring2
        k, c, p = contact.stiffness, contact.damping, contact.preload
        area = contact.pad_size[0] * contact.pad_size[2]
        modulus = k * contact.hydroelastic_thickness / area
        self.assertAlmostEqual(contact.hydroelastic_modulus / modulus, 1.0)
        dissipation = contact.hydroelastic_dissipation
        self.assertAlmostEqual(dissipation / (c / (k * p)), 1.0)


class TestRepairedTwin(unittest.TestCase):
    def test_it_reproduces_the_runs_after_the_repair_exactly(self):
        campaign = LoadCampaign(EXAMPLE)
        runs = tuple(run for run in campaign.runs if run.name == "push")
        campaign = replace(campaign, runs=runs)
        twin = BenchTwin(BenchScenario(time_step=5e-4))
        floors, _ = estimate_floors(twin, campaign, SUBJECT, 0)
        prepared = prepare_runs(twin, runs, floors, 200.0, 0)
        before = Evaluator(twin, prepared, 1)
        drawn = draw_tolerances(twin.scenario, 5)
        off = uses_of_draws(twin.scenario, drawn)
        # Of the first two, noise is a dither to the first.
        for own, within in (
            ([use("coulomb_friction")], ()),
            ([use("relaxation")], ()),
            ([use("relaxation")], off),
        ):
            uses = [*own, *within]
            with self.subTest(effects=[effect.name for effect, _ in uses]):
                fit = found(SUBJECT, *own, within=within)
                repaired = BenchTwin(saved(MakeRepairedScenario(twin, fit)))
                after = before.simulate(prepared[0], SUBJECT, uses)
                again = Evaluator(repaired, prepared, 1)
                np.testing.assert_array_equal(
                    again.simulate(prepared[0], SUBJECT, ()), after
                )
                self.assertEqual(
                    again.noise_level(()), before.noise_level(uses)
                )

    def test_without_an_effect_there_is_none(self):
        twin = BenchTwin(BenchScenario())
        with self.assertRaisesRegex(CampaignError, "nothing to repair"):
            MakeRepairedScenario(twin, None)
        with tempfile.TemporaryDirectory() as folder:
            old = Path(folder) / "repaired.scenario.yaml"
            old.write_text("of an earlier diagnosis")
            self.assertIsNone(WriteRepairedScenario(twin, None, Path(folder)))
            self.assertFalse(old.exists())

    def test_leg_and_pad_are_repaired_alike(self):
        friction, hardening = use("coulomb_friction"), use("hardening")
        leg = LegBenchScenario()
        leg.control.force_limit = np.inf
        twin = LegBenchTwin(leg)
        fit = found(np.array([90.0, 180.0, -3.0]), friction)
        repaired = LegBenchTwin(saved(MakeRepairedScenario(twin, fit)))
        self.assertEqual([p.nominal for p in repaired.subject], [90, 180, -3])
        self.assertIs(repaired.carried[0][0], friction[0])
        pad = PadBenchTwin(PadBenchScenario(has_corners=True))
        fit = found(np.array([5e3, 120.0, 1e-3, 0.25]), hardening)
        repaired = PadBenchTwin(saved(MakeRepairedScenario(pad, fit)))
        self.assertEqual(
            [p.nominal for p in repaired.subject], [5e3, 120.0, 1e-3, 0.25]
        )
        self.assertIs(repaired.carried[0][0], hardening[0])

    def test_a_scenario_of_another_device_is_refused(self):
        with self.assertRaisesRegex(CampaignError, "of 'leg bench'"):
            MakeDevice(LoadCampaign(EXAMPLE), LegBenchScenario())

    def test_effects_put_together_are_at_most_as_many_as_places(self):
        with self.assertRaises(EffectError):
            stack_effects([use("hardening")] * (MAX_EFFECTS + 1))


if __name__ == "__main__":
    unittest.main()
