"""Tolerances of a scenario's numbers: how they are stated, what they do."""

import copy
import gc
import pickle
import tempfile
import unittest
import weakref
from dataclasses import asdict, fields, replace
from pathlib import Path

import numpy as np
import yaml

from brace_drake.core.errors import ScenarioError
from brace_drake.core.resources import scenario_path
from brace_drake.devices.bench.tolerances import bench_tolerances
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.library import MakeMotion
from brace_drake.devices.tolerances import LinearTolerances
from brace_drake.effects.mechanism import ring_mass
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.load import LoadScenario, SaveScenario
from brace_drake.scenario.tolerances import Tolerances
from tests.test_scenario import SHEET, differences

DEFAULT = Tolerances()


class TestStated(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def load(self, text, overrides=None):
        path = self.folder / "some.scenario.yaml"
        path.write_text(text)
        return LoadScenario(path, overrides)

    @unittest.skipUnless(SHEET.is_file(), "needs the data sheet")
    def test_the_defaults_are_those_of_the_data_sheet(self):
        text = SHEET.read_text()
        sheet = yaml.safe_load(text[text.index("\nbrace:") :])
        stated = sheet["bench"]["tolerances"]
        # One tick or none.
        stated["command_delay"] = max(stated["command_delay"])
        self.assertEqual(asdict(DEFAULT), stated)

    def test_shipped_files_state_them(self):
        for path in scenario_path("bench.scenario.yaml").parent.glob(
            "*.scenario.yaml"
        ):
            scenario = LoadScenario(path)
            if hasattr(scenario, "tolerances"):
                with self.subTest(file=path.name):
                    self.assertEqual(scenario.tolerances, DEFAULT)
                    self.assertTrue(scenario.tolerances.is_stated)

    def test_a_file_states_those_that_it_names(self):
        cases = {
            "{}": ({}, False),
            "tolerances: {}": ({}, True),
            "tolerances: {anchor: 0}": ({"anchor": 0.0}, True),
            "tolerances: exact": (dict.fromkeys(asdict(DEFAULT), 0.0), True),
            "ring: {mass: {value: 0.9, tolerance: 0.02}}": (
                {"ring_mass": 0.02},
                True,
            ),
            "leg: {viscous: {tolerance: 2}}": ({"leg_viscous": 2.0}, True),
            "{leg: {viscous: {tolerance: 2}}, tolerances: {anchor: 1e-4}}": (
                {"leg_viscous": 2.0, "anchor": 1e-4},
                True,
            ),
        }
        for text, (changed, is_stated) in cases.items():
            with self.subTest(text=text):
                scenario = self.load(text)
                own = scenario.tolerances
                self.assertEqual(asdict(own), {**asdict(DEFAULT), **changed})
                self.assertEqual(own.is_stated, is_stated)
                self.assertEqual(copy.deepcopy(own).is_stated, is_stated)
                again = self.folder / "again.scenario.yaml"
                SaveScenario(scenario, again)
                loaded = LoadScenario(again)
                self.assertEqual(differences(loaded, scenario), [])
                self.assertEqual(loaded.tolerances.is_stated, is_stated)

    def test_each_is_stated_or_has_the_default(self):
        text = "{leg: {viscous: {tolerance: 2}}, tolerances: {anchor: 1e-4}}"
        named = self.load(text).tolerances.named
        self.assertEqual(named, {"leg_viscous", "anchor"})
        path = scenario_path("bench.scenario.yaml")
        self.assertEqual(
            LoadScenario(path).tolerances.named, set(asdict(DEFAULT))
        )
        self.assertEqual(self.load("{}").tolerances.named, set())

    def test_a_number_with_a_tolerance_is_the_number(self):
        scenario = self.load("ring: {mass: {value: 0.9, tolerance: 0.02}}")
        self.assertEqual(scenario.ring.mass, 0.9)
        scenario = self.load("leg: {viscous: {tolerance: 2}}")
        self.assertEqual(scenario.leg.viscous, 40.0)

    def test_overrides_go_over_those_of_the_file(self):
        scenario = self.load(
            "tolerances: exact", "ring: {mass: {value: 0.9, tolerance: 0.02}}"
        )
        self.assertEqual(scenario.tolerances.ring_mass, 0.02)
        self.assertEqual(scenario.tolerances.leg_viscous, 0.0)

    def test_bad_tolerances_are_told_in_one_line(self):
        cases = {
            "tolerances:": ("tolerances is None", "exact or a map"),
            "tolerances: 3": ("tolerances is 3", "exact or a map"),
            "tolerances: {anchr: 1}": ("tolerances.anchr", "mean anchor"),
            "tolerances: {anchor: -1}": ("tolerances.anchor is -1", "0 to"),
            "tolerances: {is_stated: true}": ("is_stated", "no such key"),
            "leg: {stroke: {value: 0.05, tolerance: 2}}": (
                "leg.stroke",
                "ring.mass and leg.viscous",
            ),
            "ring: {mass: {value: 1, toleranc: 1}}": (
                "ring.mass.toleranc",
                "tolerance",
            ),
            "ring: {mass: {value: 1, tolerance: .inf}}": (
                "ring.mass.tolerance is inf",
                "finite",
            ),
            "ring: {mass: {value: heavy, tolerance: 1}}": (
                "ring.mass is 'heavy'",
                "a number",
            ),
            "{ring: {mass: {tolerance: 0.1}}, tolerances: exact}": (
                "ring.mass.tolerance is 0.1",
                "0, which tolerances.ring_mass is",
            ),
            "{device: leg bench, mass: {value: 3, tolerance: 1}}": (
                "mass is",
                "no map",
            ),
            "{device: pad bench, tolerances: exact}": ("no such key",),
        }
        for text, parts in cases.items():
            with self.subTest(text=text):
                with self.assertRaises(ScenarioError) as caught:
                    self.load(text)
                line = str(caught.exception)
                self.assertNotIn("\n", line)
                for part in ("some.scenario.yaml", *parts):
                    self.assertIn(part, line)


class TestNuisances(unittest.TestCase):
    def test_each_number_of_the_bench_has_one(self):
        found = bench_tolerances(BenchScenario())
        names = [n.name for n in found]
        self.assertEqual(len(found), 42)
        self.assertEqual(len(set(names)), 42)
        anchors = [n for n in found if n.name[:5] in ("lower", "upper")]
        self.assertEqual(len(anchors), 36)
        self.assertTrue(all(n.deviation == 5e-5 for n in anchors))
        one_sided = {n.name for n in found if n.lower == 0.0}
        self.assertEqual(one_sided, {"leg_dry_friction_N", "command_delay_s"})

    def test_a_number_without_a_tolerance_has_none(self):
        scenario = BenchScenario()
        for f in fields(scenario.tolerances):
            setattr(scenario.tolerances, f.name, 0.0)
        self.assertEqual(bench_tolerances(scenario), [])
        scenario.tolerances.force_bias = 0.02
        names = [n.name for n in bench_tolerances(scenario)]
        self.assertEqual(names, ["force_bias_N"])

    def test_one_deviation_of_a_number_is_that_number_changed(self):
        found = {n.name: n.uses for n in bench_tolerances(BenchScenario())}
        heavier = BenchScenario()
        heavier.ring.mass += 0.015
        nominal, twin = BenchTwin(BenchScenario(), 1e-3 / 3), BenchTwin(heavier)
        motion = nominal.motion(MakeMotion("free_hold").run)
        subject = np.array([p.nominal for p in nominal.subject])
        # The controller goes on counting with the nominal mass.
        ((card, values),) = found["ring_mass_kg"]
        changed = card.modify(nominal.numbers, values)
        np.testing.assert_allclose(changed.ring[:, 0], twin.numbers.ring[:, 0])
        np.testing.assert_allclose(changed.ring[:, 4], twin.numbers.ring[:, 4])
        np.testing.assert_array_equal(changed.control, nominal.numbers.control)
        ((card, values),) = found["upper3_y_m"]
        moved = card.modify(nominal.numbers, values)
        shift = moved.upper - nominal.numbers.upper
        self.assertEqual(np.argmax(np.abs(shift)), 3 * 2 + 1)
        self.assertAlmostEqual(shift.sum(), 5e-5)
        np.testing.assert_array_equal(moved.lower, nominal.numbers.lower)
        reading = nominal.simulate(motion, subject)
        off = nominal.simulate(motion, subject, found["force_bias_N"])
        bias = (off - reading)[:, nominal.channels.index("ring2_force_y_N")]
        np.testing.assert_allclose(bias, 0.02)

    def linearised(self):
        """Numbers of a bench that change residuals at random."""
        numbers = tuple(bench_tolerances(BenchScenario()))
        changes = np.random.default_rng(0).normal(size=(300, len(numbers)))
        return LinearTolerances(numbers, *np.linalg.qr(changes))

    def test_what_was_linearised_is_freed_with_the_last_that_uses_it(self):
        known = self.linearised()
        part = known.beside([ring_mass.CARD])
        self.assertIs(known.beside([ring_mass.CARD]), part)
        self.assertIs(known.beside([]), known)
        off = part.at([0.5] * len(part.nuisances))
        every = [known, known.at_zero, part, off, off.whole, off.at_zero]
        refs = [weakref.ref(one) for one in every]
        gc.disable()
        self.addCleanup(gc.enable)
        del known, part, off, every
        self.assertEqual([ref() for ref in refs], [None] * len(refs))

    def test_it_comes_whole_through_a_pipe(self):
        known = self.linearised()
        known.beside([ring_mass.CARD])
        basis = known.basis
        again = pickle.loads(pickle.dumps(replace(known, nuisances=())))
        np.testing.assert_array_equal(again.basis, basis)
        self.assertIs(again.beside([]), again)


class TestWhitening(unittest.TestCase):
    def test_pieces_are_whitened_as_each_alone(self):
        random = np.random.default_rng(0)
        basis, _ = np.linalg.qr(random.normal(size=(60, 4)))
        columns = random.normal(size=(4, 3))
        known = LinearTolerances(("a", "b", "c"), basis, columns)
        residual, ends = random.normal(size=60), [10, 45, 60]
        found = known.whiten_pieces(residual, ends)
        for k, (a, b) in enumerate(((0, 10), (10, 45), (45, 60))):
            alone = np.zeros(60)
            alone[a:b] = residual[a:b]
            np.testing.assert_allclose(
                found[:, k], known.whiten(alone), rtol=0.0, atol=1e-13
            )
        # By the inverse root of I + J J'.
        J = basis @ columns
        whole = found.sum(axis=1)
        np.testing.assert_allclose(
            whole @ whole,
            residual @ np.linalg.solve(np.eye(60) + J @ J.T, residual),
        )


if __name__ == "__main__":
    unittest.main()
