"""A machine whose numbers are off by draws within their tolerances."""

import dataclasses
import tempfile
import unittest
from pathlib import Path

import numpy as np
import yaml

from brace_drake.core.errors import ScenarioError
from brace_drake.devices.bench.drawn import (
    describe_draws,
    draw_tolerances,
    uses_of_draws,
)
from brace_drake.devices.bench.tolerances import KEYS, bench_tolerances
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.effects.registry import find_effect
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.model.simulate import RecordBrace
from brace_drake.recording import LoadCampaign
from brace_drake.scenario.brace import BenchScenario, BraceScenario, EffectUse
from brace_drake.scenario.load import SaveScenario
from brace_drake.scenario.tolerances import Tolerances
from tests.commands import run_command
from tests.shared_data import SHARED
from tests.test_simulate_command import LoadReference, write_reference

STEP = 5e-4
NAMES = (*KEYS, *find_effect("anchor_error").parameter_names)


class TestDraws(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scenario, cls.count = BenchScenario(), 500
        cls.draws = [
            draw_tolerances(cls.scenario, seed) for seed in range(cls.count)
        ]

    def of(self, name):
        return np.array([drawn[name] for drawn in self.draws])

    def test_the_names_are_those_of_the_nuisances(self):
        names = [n.name for n in bench_tolerances(self.scenario)]
        self.assertEqual(list(self.draws[0]), names)

    def test_draws_are_normal_with_their_tolerance(self):
        for nuisance in bench_tolerances(self.scenario):
            if nuisance.lower == 0.0:
                continue
            z = self.of(nuisance.name) / nuisance.deviation
            with self.subTest(name=nuisance.name):
                # Four standard errors.
                self.assertLess(abs(z.mean()), 4.0 / self.count**0.5)
                error = 4.0 / (2.0 * self.count) ** 0.5
                self.assertAlmostEqual(z.std(), 1.0, delta=error)

    def test_what_only_adds_is_not_negative(self):
        z = self.of("leg_dry_friction_N") / 0.03
        self.assertGreaterEqual(z.min(), 0.0)
        # Of the upper half of a normal law.
        mean, spread = (2.0 / np.pi) ** 0.5, (1.0 - 2.0 / np.pi) ** 0.5
        error = 4.0 * spread / self.count**0.5
        self.assertAlmostEqual(z.mean(), mean, delta=error)
        late = self.of("command_delay_s")
        self.assertEqual(set(late), {0.0, 0.001})
        error = 4.0 * 0.5 / self.count**0.5
        self.assertAlmostEqual((late > 0.0).mean(), 0.5, delta=error)

    def test_draws_do_not_go_together(self):
        table = np.array([[d[n] for n in NAMES] for d in self.draws])
        together = np.corrcoef(table.T) - np.eye(len(NAMES))
        # Of 861 pairs, five standard errors.
        self.assertLess(np.abs(together).max(), 5.0 / self.count**0.5)

    def test_the_seed_decides_them_each_for_itself(self):
        self.assertEqual(draw_tolerances(self.scenario, 3), self.draws[3])
        scenario = BenchScenario()
        scenario.tolerances.leg_viscous = 0.0
        scenario.tolerances.anchor *= 2.0
        changed, before = draw_tolerances(scenario, 3), self.draws[3]
        for name in NAMES:
            factor = 1.0
            if name == "leg_viscous_N_s_m":
                factor = 0.0
            elif name not in KEYS:
                factor = 2.0
            self.assertAlmostEqual(changed[name], factor * before[name], 15)

    def test_legs_do_not_push_by_themselves(self):
        scenario = BenchScenario()
        scenario.leg.viscous = 0.5
        off = [
            draw_tolerances(scenario, seed)["leg_viscous_N_s_m"]
            for seed in range(20)
        ]
        self.assertEqual(min(off), -0.5)

    def test_what_cannot_be_drawn_is_told_in_one_line(self):
        heavy = BenchScenario()
        heavy.tolerances.ring_mass = 9.0
        legs = BenchScenario(mechanism="articulated")
        for scenario, words in (
            (heavy, r"ring_mass is 9.0; allowed: less: seed 0 draws -?\d.*kg"),
            (legs, "mechanism is 'articulated'; allowed: task_space"),
            (BraceScenario(), r"stages is \[1, 2, 3\]; allowed: one stage"),
        ):
            with self.subTest(words=words):
                with self.assertRaisesRegex(ScenarioError, words) as caught:
                    draw_tolerances(scenario, 0, "some.yaml")
                self.assertNotIn("\n", str(caught.exception))
        full = BenchScenario()
        full.effects = [
            EffectUse("ring_mass", {"added_mass_kg": 0.1})
        ] * MAX_EFFECTS
        with self.assertRaisesRegex(
            ScenarioError, f"at most {MAX_EFFECTS - 1} beside drawn"
        ):
            uses_of_draws(full, self.draws[0])


class TestMachine(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.reference = write_reference(cls.folder / "push.csv")
        cls.scenario = BenchScenario(time_step=STEP)
        cls.file = cls.folder / "some.scenario.yaml"
        SaveScenario(cls.scenario, cls.file)
        cls.twin = BenchTwin(cls.scenario)
        cls.subject = np.array([p.nominal for p in cls.twin.subject])
        cls.run_ = LoadReference(cls.reference)
        cls.motion = cls.twin.motion(cls.run_)

    def simulate(self, uses):
        return self.twin.simulate(self.motion, self.subject, uses)

    def drawn(self, **off):
        return {name: off.get(name, 0.0) for name in NAMES}

    def test_it_is_the_machine_with_these_effects(self):
        anchors = np.random.default_rng(1).normal(0.0, 5e-5, 36)
        cases = (
            ("command_delay", 0.001, "coulomb_friction", 0.4),
            ("command_delay", 0.0015, "viscous_leg", 4.0),
            ("ring_mass", 0.02, "viscous_leg", -3.0),
            ("force_scale", 0.05, "force_bias", 0.3),
            ("anchor_error", anchors, "coulomb_friction", 0.4),
        )
        names = {
            "command_delay": "command_delay_s",
            "coulomb_friction": "leg_dry_friction_N",
            "viscous_leg": "leg_viscous_N_s_m",
            "ring_mass": "ring_mass_kg",
            "force_scale": "force_scale",
            "force_bias": "force_bias_N",
        }
        nominal = self.simulate(())
        for *pair, second, value in cases:
            pairs = ((pair[0], pair[1]), (second, value))
            with self.subTest(effects=(pair[0], second)):
                by_hand, off = [], {}
                for name, values in pairs:
                    card, values = find_effect(name), np.atleast_1d(values)
                    by_hand.append((card, values))
                    own = [names.get(name, name)]
                    if name == "anchor_error":
                        own = card.parameter_names
                    off |= dict(zip(own, values, strict=True))
                uses = uses_of_draws(self.scenario, self.drawn(**off))
                machine = self.simulate(uses)
                np.testing.assert_array_equal(machine, self.simulate(by_hand))
                self.assertGreater(np.abs(machine - nominal).max(), 1e-3)

    def test_the_diagram_is_the_rollout_of_the_drawn_machine(self):
        drawn = draw_tolerances(self.scenario, 5)
        self.assertGreater(drawn["command_delay_s"], 0.0)
        uses = uses_of_draws(self.scenario, drawn)
        recorded = RecordBrace(self.scenario, self.run_, uses=uses)
        error = self.twin.measured(recorded) - self.simulate(uses)
        self.assertLess(np.abs(error).max(), 1e-7)

    def test_nothing_drawn_is_no_effect(self):
        self.assertEqual(uses_of_draws(self.scenario, self.drawn()), ())

    def test_a_label_tells_effects_and_draws(self):
        scenario = BenchScenario()
        use = EffectUse("force_bias", {"force_bias_N": 0.3})
        scenario.effects = [use]
        drawn = draw_tolerances(scenario, 2)
        label = describe_draws(scenario, drawn)
        self.assertEqual(label["effects"], ["force_bias"])
        self.assertEqual(label["blocks"], ["sensing"])
        self.assertEqual(label["parameters"], {"force_bias_N": 0.3})
        within = label["within_tolerances"]
        self.assertEqual(within.pop("anchor_spread_m"), 5e-5)
        self.assertEqual(within, drawn)

    @unittest.skipUnless(SHARED.is_dir(), "needs the shared campaigns")
    def test_labels_have_the_names_of_the_shared_campaigns(self):
        (path,) = SHARED.glob("campaigns/open11*/label.yaml")
        shared = yaml.safe_load(path.read_text())
        drawn = draw_tolerances(self.scenario, 2)
        label = describe_draws(self.scenario, drawn)
        for names in ("effects", "blocks", "parameters"):
            self.assertEqual(label[names], shared[names])
        missing = set(shared["within_tolerances"])
        self.assertEqual(missing - set(label["within_tolerances"]), set())


class TestCommands(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.reference = write_reference(self.folder / "push.csv")

    def save(self, name="some", **changes):
        scenario = BenchScenario(time_step=STEP)
        scenario.tolerances = Tolerances(**changes)
        path = self.folder / f"{name}.scenario.yaml"
        SaveScenario(scenario, path)
        return path

    def simulate(self, file, out, *more):
        out = self.folder / out
        words = ("--motion", self.reference, "--out", out, *more)
        code, text, error = run_command("simulate", file, *words)
        self.assertEqual(code, 0, error)
        return out, text

    def test_what_was_drawn_is_told_and_kept(self):
        file = self.save()
        words = ("--tolerances", 7, "--noise-seed", 1)
        out, text = self.simulate(file, "drawn", *words)
        self.assertIn("tolerances: stated, drawn with seed 7", text)
        drawn = draw_tolerances(BenchScenario(), 7)
        for name in KEYS:
            self.assertRegex(text, rf"(?m)^  {name} +[+-]")
            self.assertIn(f"{drawn[name]:+.3g}", text)
        label = yaml.safe_load((out / "label.yaml").read_text())
        within = label["within_tolerances"]
        self.assertEqual({n: within[n] for n in NAMES}, drawn)
        again, _ = self.simulate(file, "again", *words)
        nominal, _ = self.simulate(file, "nominal", "--noise-seed", 1)
        first, second, exact = (
            (folder / "push.csv").read_bytes()
            for folder in (out, again, nominal)
        )
        self.assertEqual(first, second)
        self.assertNotEqual(first, exact)
        self.assertFalse((nominal / "label.yaml").exists())
        self.assertEqual(len(LoadCampaign(out).runs), 1)

    def test_exact_numbers_record_as_without_draws(self):
        zeros = {f.name: 0.0 for f in dataclasses.fields(Tolerances)}
        file = self.save("exact", **zeros)
        drawn, _ = self.simulate(file, "a", "--tolerances", 7)
        nominal, _ = self.simulate(self.save(), "b")
        first, second = (
            (folder / "push.csv").read_bytes() for folder in (drawn, nominal)
        )
        self.assertEqual(first, second)

    def test_the_doctor_tells_tolerances(self):
        file = self.folder / "bare.scenario.yaml"
        file.write_text("ring: {mass: 0.9}\n")
        stated = self.save(anchor=0.0)
        leg = self.folder / "leg.scenario.yaml"
        leg.write_text("device: leg bench\n")
        out, _ = self.simulate(stated, "campaign")
        for of, words in (
            (file, f"optional +tolerances +assumed, as {file} states none"),
            (stated, f"ok +tolerances +stated in {stated}"),
            (stated, r"ok +tolerances\.ring_mass +0.015 kg"),
            (stated, r"ok +tolerances\.anchor +exact"),
            (leg, "ok +tolerances +none: the numbers of a leg bench are"),
            (out, "stated in the package's bench stage 2"),
        ):
            with self.subTest(words=words):
                _, text, _ = run_command("doctor", of)
                self.assertRegex(text, words)
        code, _, error = run_command("doctor", self.folder / "none.yaml")
        self.assertEqual(code, 2)
        self.assertEqual(error.count("\n"), 1)
        self.assertIn("none.yaml: cannot be read", error)


if __name__ == "__main__":
    unittest.main()
