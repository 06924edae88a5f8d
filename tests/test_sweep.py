"""Sweeps: what changes is what physics says, in any number of threads."""

import csv
import io
import json
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy import stats

from brace_drake.core.errors import BraceError, ScenarioError
from brace_drake.core.parallel import Workers
from brace_drake.core.resources import scenario_path
from brace_drake.effects.registry import find_effect
from brace_drake.scenario.brace import BenchScenario, BraceScenario
from brace_drake.scenario.effects import describe_use
from brace_drake.scenario.load import SaveScenario
from brace_drake.scenario.pad_bench import PadBenchScenario
from brace_drake.sweep.numbers import find_number, with_number
from brace_drake.sweep.outcomes import outcomes_of
from brace_drake.sweep.page import format_csv, format_text, render_sweep
from brace_drake.sweep.runs import (
    LoadMotion,
    _run_diagram,
    make_simulator,
)
from brace_drake.sweep.sweep import Plan, run_sweep, spaced
from tests.commands import run_command
from tests.test_report import PageParser
from tests.test_simulate_command import write_reference

FILE = "some.scenario.yaml"


def make_bench():
    """A bench with a relaxing tissue and a quick plant."""
    scenario = BenchScenario(time_step=5e-4)
    card = find_effect("relaxation")
    scenario.effects = [describe_use(card, np.array([3000.0, 0.7]))]
    return scenario


def write_pad_motion(path):
    """A slow way into the tissue and back, 6 mm deep."""
    time = np.arange(1000) / 100.0
    depth = 0.003 * (1.0 - np.cos(2.0 * np.pi * time / 10.0))
    table = np.column_stack([time, depth, 0.0 * time])
    head = "time_s,displacement_m,force_N"
    np.savetxt(path, table, "%.9f", ",", header=head, comments="")
    return path


class TestNumbers(unittest.TestCase):
    def setUp(self):
        self.scenario = make_bench()

    def test_a_number_has_its_path_unit_and_value(self):
        cases = (
            ("torso.mass", "kg", 40.0),
            ("contact.ring2.stiffness", "N/m", 6400.0),
            ("torso.posture_stiffness[1]", "N/m", 1800.0),
            ("effects.relaxation.arm_stiffness_N_m", "N/m", 3000.0),
            ("ring.mass", "kg", 0.85),
        )
        for path, unit, value in cases:
            with self.subTest(path=path):
                found = find_number(self.scenario, path, FILE)
                self.assertEqual((found.unit, found.value), (unit, value))
                other = with_number(self.scenario, found, 1.5 * value, FILE)
                again = find_number(other, path, FILE)
                self.assertAlmostEqual(again.value, 1.5 * value)
                own = find_number(self.scenario, path, FILE)
                self.assertEqual(own.value, value)

    def test_the_moving_ring_may_be_left_out(self):
        found = find_number(self.scenario, "contact.stiffness", FILE)
        self.assertEqual(found.path, "contact.ring2.stiffness")
        with self.assertRaisesRegex(ScenarioError, "may be any of"):
            find_number(BraceScenario(), "contact.stiffness", FILE)

    def test_a_wrong_path_is_told_the_right_one(self):
        cases = (
            ("torso.mas", "did you mean torso.mass?"),
            ("contact.stifness", "did you mean contact.ring2.stiffness?"),
            ("torso.posture_stiffness", "allowed: one of its numbers"),
            ("torso", "as in torso.mass"),
            ("contact.ring2.model", "no such number"),
            ("contact.ring1.stiffness", "contact.ring2.stiffness"),
            ("effects.relaxation.time", "no such number"),
        )
        for path, told in cases:
            with self.subTest(path=path):
                with self.assertRaises(ScenarioError) as caught:
                    find_number(self.scenario, path, FILE)
                self.assertTrue(str(caught.exception).startswith(FILE))
                self.assertIn(told, str(caught.exception))

    def test_limits_are_those_of_the_scenario(self):
        cases = (
            ("torso.mass", 0.0, "greater than 0 kg"),
            ("contact.ring2.preload", 0.2, "less than"),
            ("time_step", 3e-4, "a whole part of the control period"),
            ("contact.ring2.pad_points[0]", 1.5, "no such number"),
        )
        for path, value, told in cases:
            with self.subTest(path=path):
                with self.assertRaises(ScenarioError) as caught:
                    number = find_number(self.scenario, path, FILE)
                    with_number(self.scenario, number, value, FILE)
                self.assertIn(told, str(caught.exception))

    def test_values_are_even_or_of_even_ratios(self):
        np.testing.assert_allclose(spaced(1.0, 3.0, 3, False), [1, 2, 3])
        np.testing.assert_allclose(spaced(1.0, 100.0, 3, True), [1, 10, 100])
        for words in ((1.0, 1.0, 3, False), (1.0, 2.0, 1, False)):
            with self.assertRaises(ScenarioError):
                spaced(*words)
        with self.assertRaisesRegex(ScenarioError, "above 0"):
            spaced(0.0, 1.0, 3, True)


class TestRuns(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.reference = write_reference(cls.folder / "push.csv")

    def outcomes_both_ways(self, scenario):
        run = LoadMotion(str(self.reference), scenario)
        fast = make_simulator(scenario)(scenario, run, None)
        slow = _run_diagram(scenario, run, None)
        return outcomes_of(fast), outcomes_of(slow)

    def assert_alike(self, scenario):
        fast, slow = self.outcomes_both_ways(scenario)
        self.assertEqual(list(fast), list(slow))
        for name, value in slow.items():
            with self.subTest(outcome=name):
                self.assertAlmostEqual(fast[name], value, delta=1e-6)
        self.assertGreater(slow["peak_force_N"], 1.0)

    def test_outcomes_are_those_of_the_drake_diagram(self):
        self.assert_alike(make_bench())

    def test_one_ring_of_a_brace_has_its_own_pads(self):
        # Rings 1 and 3 keep theirs; a twin's subject would take one for all.
        scenario = BraceScenario()
        scenario.contact.ring2.stiffness = 3000.0
        self.assert_alike(scenario)

    def test_another_controller_is_simulated_by_the_diagram(self):
        scenario = BraceScenario()
        self.assertIsNot(make_simulator(scenario), _run_diagram)
        scenario.control.tag = "pid"
        self.assertIs(make_simulator(scenario), _run_diagram)

    def test_torso_and_posture_are_in_balance_at_the_end(self):
        scenario = make_bench()
        run = LoadMotion("push", scenario)
        found = outcomes_of(make_simulator(scenario)(scenario, run, None))
        # The torso has come to rest, its bushing alone holds it.
        stiffness = scenario.torso.posture_stiffness[1]
        self.assertLess(found["torso_peak_m"], 0.01)
        self.assertGreater(found["final_depth_m"], found["torso_peak_m"])
        self.assertAlmostEqual(
            found["final_force_N"] / (stiffness * found["torso_peak_m"]),
            1.0,
            delta=0.1,
        )

    def test_a_leg_beyond_its_stroke_is_told(self):
        scenario = make_bench()
        scenario.leg.stroke = 0.002
        run = LoadMotion("push", scenario)
        with self.assertRaisesRegex(BraceError, "its stroke allows 1 mm"):
            make_simulator(scenario)(scenario, run, None)


class TestSweep(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.scenario = make_bench()
        cls.run_ = LoadMotion(
            str(write_reference(cls.folder / "push.csv")), cls.scenario
        )
        number = find_number(cls.scenario, "contact.stiffness", FILE)
        values = spaced(3000.0, 12000.0, 3, True)
        cls.plan = Plan(cls.scenario, FILE, number, values, cls.run_, (1, 2, 3))
        with Workers(2) as workers:
            cls.document = run_sweep(cls.plan, workers)

    def test_the_number_of_threads_changes_nothing(self):
        with Workers(1) as workers:
            again = run_sweep(self.plan, workers)
        self.assertEqual(again, self.document)

    def test_mean_and_interval_are_those_of_the_seeds(self):
        row = self.document["rows"][1]
        scenario = with_number(
            self.scenario, self.plan.number, row["value"], FILE
        )
        simulate = make_simulator(scenario)
        for name, told in row["outcomes"].items():
            draws = [
                outcomes_of(simulate(scenario, self.run_, seed))[name]
                for seed in (1, 2, 3)
            ]
            mean, error = np.mean(draws), stats.sem(draws)
            self.assertAlmostEqual(told["mean"], mean)
            low, high = stats.t.interval(0.95, 2, mean, error)
            self.assertAlmostEqual(told["lower95"], low)
            self.assertAlmostEqual(told["upper95"], high)

    def test_stiffer_pads_push_harder(self):
        forces = [
            row["outcomes"]["peak_force_N"]["mean"]
            for row in self.document["rows"]
        ]
        self.assertEqual(forces, sorted(forces))
        self.assertGreater(forces[-1], 1.1 * forces[0])

    def test_a_value_that_breaks_down_has_its_reason_in_its_row(self):
        number = find_number(self.scenario, "leg.stroke", FILE)
        plan = replace(self.plan, number=number, values=(0.002, 0.05), seeds=())
        with Workers(1) as workers:
            document = run_sweep(plan, workers)
        bad, good = document["rows"]
        self.assertIn("stroke allows", bad["error"])
        self.assertIsNone(good["error"])
        self.assertIn("failed: ", format_text(document))
        self.assertIn("stroke allows", format_csv(document))
        self.assertIn("stroke allows", render_sweep(document))
        with Workers(1) as workers:
            with self.assertRaisesRegex(BraceError, "every run failed"):
                run_sweep(replace(plan, values=(0.002, 0.003)), workers)

    def test_the_page_is_whole_and_needs_nothing_else(self):
        parser = PageParser()
        page = render_sweep(self.document)
        parser.feed(page)
        self.assertEqual((parser.open, parser.faults), ([], []))
        for target in parser.refers:
            self.assertTrue(target.startswith("data:"), target[:40])
        figures = len(self.document["outcomes"])
        self.assertEqual(parser.tags.count("img"), figures)

    def test_the_table_has_the_numbers_of_the_document(self):
        rows = list(csv.DictReader(io.StringIO(format_csv(self.document))))
        self.assertEqual(len(rows), 3)
        for cells, row in zip(rows, self.document["rows"], strict=True):
            told = row["outcomes"]["peak_force_N"]
            for head, key in (
                ("peak_force_N", "mean"),
                ("peak_force_sd_N", "standard_deviation"),
                ("peak_force_upper95_N", "upper95"),
            ):
                self.assertEqual(float(cells[head]), told[key])


class TestCommand(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.pad = cls.folder / "pad.scenario.yaml"
        SaveScenario(PadBenchScenario(damping=0.0), cls.pad)
        cls.motion = write_pad_motion(cls.folder / "way.csv")

    def sweep(self, *words, scenario=None, motion=None):
        out = self.folder / "out"
        motion = motion or self.motion
        status, text, error = run_command(
            "sweep",
            scenario or self.pad,
            *("--motion", motion, "--out", out, *words),
        )
        return status, text, error.strip().splitlines()[-1:], out

    def test_a_pad_without_damping_is_a_spring(self):
        status, text, error, out = self.sweep(
            *("--number", "stiffness", "--from", 1000, "--to", 3000),
            *("--count", 3, "--outcomes", "peak_force_N"),
        )
        self.assertEqual(status, 0, error)
        document = json.loads((out / "sweep.json").read_text())
        for row in document["rows"]:
            force = row["outcomes"]["peak_force_N"]["mean"]
            self.assertAlmostEqual(force, 0.006 * row["value"], delta=0.01)
        names = sorted(p.name for p in out.iterdir())
        self.assertEqual(
            names, [f"sweep.{end}" for end in ("csv", "html", "json", "png")]
        )
        self.assertIn(str(out / "sweep.html"), text)
        png = (out / "sweep.png").read_bytes()
        self.assertTrue(png.startswith(b"\x89PNG"))

    def test_json_is_the_document_alone(self):
        status, text, _, out = self.sweep(
            *("--number", "stiffness", "--from", 1000, "--to", 3000),
            *("--count", 2, "--json"),
        )
        self.assertEqual(status, 0)
        written = json.loads((out / "sweep.json").read_text())
        self.assertEqual(json.loads(text), written)

    def test_what_is_wrong_is_one_line_and_status_2(self):
        bench = scenario_path("bench.scenario.yaml")
        usual = ("--number", "stiffness", "--from", 1, "--to", 2)
        mass = ("--number", "torso.mass", "--from", 1, "--to", 2)
        cases = (
            (
                ("--number", "stifness", *usual[2:]),
                {},
                "did you mean stiffness?",
            ),
            (("--number", "stiffness", "--from", -1, "--to", 2), {}, "greater"),
            ((*usual, "--outcomes", "peak_forc_N"), {}, "did you mean peak_f"),
            ((*usual, "--count", 1), {}, "2 or more"),
            (
                (*usual, "--count", 1000, "--seeds", 101),
                {},
                "at most 100000",
            ),
            (usual, {"motion": "push"}, "allowed for a pad bench"),
            (mass, {"scenario": bench, "motion": "psh"}, "did you mean push?"),
            (mass, {"scenario": bench}, "no column ring2_y_desired_m"),
        )
        for words, more, told in cases:
            with self.subTest(told=told):
                status, _, error, _ = self.sweep(*words, **more)
                self.assertEqual(status, 2)
                self.assertIn(told, error[0])


if __name__ == "__main__":
    unittest.main()
