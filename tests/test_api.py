"""What `import brace_drake` offers, on a machine that no twin has made."""

import builtins
import json
import pkgutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np

import brace_drake as bd
from brace_drake.core.errors import (
    BraceError,
    CampaignError,
    EffectError,
    ExtraError,
    FitError,
    ScenarioError,
)
from brace_drake.devices import register_device
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.library import MakeMotion
from brace_drake.devices.registry import forget_device
from brace_drake.effects.registry import find_effect
from brace_drake.results.notebook import (
    render_diagnosis,
    render_fit,
    render_plan,
)
from brace_drake.results.repaired import RepairedTwin
from brace_drake.results.tables import diagnosis_tables, fit_tables, plan_tables
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.load import LoadScenario
from tests.diagnoses import make_diagnosis, make_unexplained
from tests.foreign.oven import CARD, READING, OvenScenario
from tests.oven_recordings import LAG_S, LATE_S, RESISTANCE, write_oven

ROOT = Path(__file__).resolve().parents[1]
SLOW = ("pydrake", "torch", "numba", "pandas", "matplotlib", "scipy", "numpy")


def run_python(code: str) -> str:
    """What a new Python prints."""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True
    )
    if done.returncode:
        raise AssertionError(done.stderr)
    return done.stdout.strip()


class TestImport(unittest.TestCase):
    def test_the_package_alone_imports_nothing_slow(self):
        found = run_python(
            "import sys, brace_drake; brace_drake.__all__;"
            f"print([n for n in {SLOW!r} if n in sys.modules])"
        )
        self.assertEqual(found, "[]")

    def test_names_are_functions_whatever_was_imported_before(self):
        first = "import brace_drake as bd; bd.diagnose;"
        then = (
            "import brace_drake.diagnosis, brace_drake.document.document,"
            " brace_drake.cli.main, brace_drake.cli.diagnosis.diagnose,"
            " brace_drake.cli.diagnosis.plan, brace_drake.cli.diagnosis.fit;"
            " from brace_drake.diagnosis import diagnose;"
        )
        shown = (
            "import brace_drake as bd;"
            "print([type(getattr(bd, n)).__name__ for n in"
            " ('diagnose', 'fit', 'load', 'plan')])"
        )
        for code in (first + then, then + first):
            with self.subTest(code=code):
                self.assertEqual(
                    run_python(code + shown), str(["function"] * 4)
                )

    def test_no_public_name_is_a_module_of_the_package(self):
        modules = {m.name for m in pkgutil.iter_modules(bd.__path__)}
        self.assertEqual(modules & set(bd.__all__), set())

    def test_all_names_are_there_and_listed(self):
        for name in bd.__all__:
            self.assertIn(name, dir(bd))
            self.assertEqual(getattr(bd, name).__name__, name)
        with self.assertRaisesRegex(AttributeError, "no attribute 'diagnos'"):
            _ = bd.diagnos


class TestDiagnosis(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        register_device(CARD)
        cls.addClassCleanup(forget_device, CARD.name)
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        cls.path = write_oven(cls.folder / "oven")
        cls.told: list[tuple[str, float]] = []
        cls.result = bd.diagnose(
            cls.path, jobs=1, progress=lambda *what: cls.told.append(what)
        )

    def test_it_names_the_cause_and_prints_short(self):
        self.assertEqual(self.result.effects, ("sensor_lag",))
        self.assertEqual(self.result.verdict["effects"], ["sensor_lag"])
        text = repr(self.result)
        self.assertIn(self.result.sentence, text)
        self.assertIn(f"Probability {self.result.probability:.2f}", text)
        share = f"closed share {100 * self.result.closed:.1f} %"
        self.assertIn(share, text)
        self.assertNotIn("\n", text)

    def test_a_caller_is_told_of_the_progress(self):
        shares = [share for _, share in self.told]
        self.assertEqual(shares, sorted(shares))
        self.assertIn("verdict", [what for what, _ in self.told])

    def test_it_is_the_same_as_the_command_writes(self):
        out = self.result.save(self.folder / "saved")
        written = json.loads((out / "diagnosis.json").read_text())
        self.assertEqual(written, self.result.document)
        self.assertTrue((out / "report.html").read_text().startswith("<!"))
        again = LoadScenario(out / "repaired.scenario.yaml")
        self.assertEqual([e.name for e in again.effects], ["sensor_lag"])

    def test_the_repaired_twin_replays_as_the_diagnosis_did(self):
        (run,) = self.result.found.validation_runs
        simulated = self.result.repaired.simulate("r2")
        np.testing.assert_allclose(
            simulated.channels[READING], run.after[:, 0], atol=1e-9
        )
        shown = "<Run r2: validation, 3 channels, 19.95 s>"
        self.assertEqual(repr(simulated), shown)

    def test_a_seed_draws_the_noise_of_the_instruments(self):
        twin = self.result.repaired
        exact = twin.simulate("r0").channels[READING]
        noisy = twin.simulate("r0", seed=3).channels[READING]
        again = twin.simulate("r0", seed=3).channels[READING]
        np.testing.assert_array_equal(noisy, again)
        self.assertAlmostEqual(float(np.std(noisy - exact)), 0.02, delta=0.003)

    def test_a_motion_that_is_not_there_is_refused(self):
        with self.assertRaisesRegex(CampaignError, "there are r0, r1, r2"):
            self.result.repaired.simulate("push")

    def test_the_figure_shows_a_run(self):
        figure = self.result.plot()
        self.assertIn(
            "temperature", figure.axes[0].get_title(loc="left").lower()
        )
        lines = figure.axes[0].lines
        (run,) = self.result.found.validation_runs
        for line, values in zip(
            lines, (run.prepared.measured, run.before, run.after), strict=True
        ):
            drawn = np.asarray(line.get_ydata())
            np.testing.assert_allclose(
                drawn / drawn.max(), values[:, 0] / values.max(), atol=1e-9
            )
        self.assertTrue(figure._repr_png_().startswith(b"\x89PNG"))
        shown = self.result.plot("r0").axes[0].lines[0].get_ydata()
        self.assertFalse(np.array_equal(shown, lines[0].get_ydata()))
        with self.assertRaisesRegex(CampaignError, "no run 'r9'"):
            self.result.plot("r9")

    def test_a_notebook_shows_verdict_parameters_and_interval(self):
        page = self.result._repr_html_()
        self.assertIn("sensor_lag", page)
        self.assertIn("closed share", page)
        self.assertIn("named by package", page)

    def test_tables_hold_what_the_document_does(self):
        tables = diagnosis_tables(self.result.document)
        (row,) = tables["parameters"]
        self.assertEqual((row["effect"], row["name"]), ("sensor_lag", "lag_s"))
        self.assertAlmostEqual(row["value"], LATE_S, delta=0.05 * LATE_S)
        self.assertEqual(
            [r["effect"] for r in tables["causes"]],
            [c["effect"] for c in self.result.document["causes"]],
        )

    def test_a_search_is_limited_and_says_so(self):
        found = bd.diagnose(
            self.path,
            effects=["sensor_lag", "sensor_offset"],
            without="sensor_lag",
            jobs=1,
            progress=False,
        )
        tried = {c["effect"] for c in found.document["causes"]}
        self.assertEqual(tried, {"sensor_offset (signal)"})
        self.assertTrue(found.verdict["gap"])
        self.assertNotIn("sensor_lag", found.effects)
        self.assertTrue(
            any("limited to sensor_offset" in w for w in found.warnings)
        )
        self.assertEqual(
            found.document["provenance"]["choice"],
            {
                "effects": ["sensor_lag", "sensor_offset"],
                "without": ["sensor_lag"],
            },
        )

    def test_what_cannot_be_used_is_a_typed_error(self):
        options = {"jobs": 1, "progress": False}
        for words, error, changes in (
            ("sensor_lga", EffectError, {"effects": "sensor_lga"}),
            ("no effect is left", EffectError, {"without": "sensor_lag,"
             "sensor_delay,sensor_offset,sensor_quantisation,sensor_hold,"
             "sensor_scale"}),
            ("'lag', did you mean lag_s", FitError, {"fixed": {"lag": 1.0}}),
            ("allowed: a number", FitError, {"fixed": {"lag_s": "x"}}),
            ("allowed: two numbers", FitError, {"bounds": {"lag_s": 3.0}}),
            ("all subject parameters are held", FitError,
             {"fixed": "lag_s, resistance_K_W"}),
            ("none.yaml", ScenarioError, {"scenario": "none.yaml"}),
        ):  # fmt: skip
            with self.subTest(words=words):
                with self.assertRaisesRegex(error, words):
                    bd.diagnose(self.path, **options, **changes)
        with self.assertRaisesRegex(CampaignError, "no such folder"):
            bd.diagnose(self.folder / "nowhere", **options)

    def test_a_scenario_in_memory_is_used_and_hashed(self):
        found = bd.diagnose(
            self.path,
            scenario=OvenScenario(lag=2.2),
            effects="sensor_lag",
            jobs=1,
            progress=False,
        )
        rows = {p["name"]: p for p in found.document["subject"]["parameters"]}
        self.assertEqual(rows["lag_s"]["nominal"], 2.2)
        used = found.document["provenance"]["scenario"]
        self.assertEqual((used["file"], used["named_by"]), (None, "caller"))
        other = self.result.document["provenance"]["scenario"]
        self.assertNotEqual(used["sha256"], other["sha256"])


class TestNothingFound(unittest.TestCase):
    def test_without_a_gap_there_is_nothing_to_repair(self):
        register_device(CARD)
        self.addCleanup(forget_device, CARD.name)
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        campaign = bd.load(write_oven(folder / "oven", late=0.0))
        self.assertEqual(
            repr(campaign),
            "<Campaign oven: oven, 20 Hz, 2 fit and 1 validation runs>",
        )
        found = bd.diagnose(campaign, jobs=1, progress=False)
        self.assertFalse(found.verdict["gap"])
        with self.assertRaisesRegex(CampaignError, "nothing to repair"):
            _ = found.repaired

    def test_the_fit_of_a_sound_machine_has_its_numbers(self):
        register_device(CARD)
        self.addCleanup(forget_device, CARD.name)
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        path = write_oven(folder / "oven", late=0.0)
        both = bd.fit(path, jobs=1, progress=False)
        for name, truth in (("lag_s", LAG_S), ("resistance_K_W", RESISTANCE)):
            row = both[name]
            self.assertAlmostEqual(row["value"], truth, delta=0.01 * truth)
        self.assertIn("lag_s", repr(both))
        self.assertIn("95 %", repr(both))
        one = bd.fit(path, fixed={"lag_s": 2.4}, jobs=1, progress=False)
        self.assertEqual(one["lag_s"]["value"], 2.4)
        self.assertTrue(one["lag_s"]["fixed"])
        self.assertIsNone(one["lag_s"]["standard_error"])
        self.assertIn("2.4 s, held", repr(one))
        # What moves with a parameter is known better where that is held.
        errors = [f["resistance_K_W"]["standard_error"] for f in (both, one)]
        self.assertLess(0.0, errors[1])
        other = bd.fit(path, free="resistance_K_W", jobs=1, progress=False)
        self.assertEqual(other["lag_s"]["value"], OvenScenario().lag)
        within = bd.fit(
            path, bounds={"lag_s": (1.0, 2.3)}, jobs=1, progress=False
        )
        self.assertAlmostEqual(within["lag_s"]["value"], 2.3, places=6)
        self.assertTrue(within["lag_s"]["at_limit"])
        file = both.save(folder / "out")
        self.assertEqual(json.loads(file.read_text()), both.document)


class TestRepairedBench(unittest.TestCase):
    """The bench's twin with an effect, without the search that finds it."""

    def make(self, name, values):
        """A repaired twin, and the twin of its scenario."""
        card, twin = find_effect(name), BenchTwin(BenchScenario())
        subject = 1.1 * np.array([p.nominal for p in twin.subject])
        uses = ((card, np.array(values)),)
        fit = SimpleNamespace(
            subject=subject, effects=(card,), uses=uses, within=()
        )
        found = SimpleNamespace(
            repair=fit,
            device=SimpleNamespace(twin=twin),
            campaign=SimpleNamespace(name="c", device=twin.device, runs=()),
            evaluator=SimpleNamespace(prepared=[]),
        )
        repaired = RepairedTwin(found)
        return repaired, BenchTwin(repaired.scenario)

    def replay(self, twin, run, seed=None):
        """What the twin of the saved scenario records."""
        subject = np.array([p.nominal for p in twin.subject])
        noise = None if seed is None else np.random.default_rng(seed)
        return twin.simulate(twin.motion(run), subject, (), noise)

    def test_it_moves_as_the_library_asks_and_as_its_scenario_does(self):
        repaired, twin = self.make("relaxation", [3000.0, 0.7])
        run = MakeMotion("push_fast").run
        got = repaired.simulate("push_fast")
        for name in ("time_s", "ring2_y_desired_m"):
            np.testing.assert_array_equal(
                got.channels[name], run.channels[name]
            )
        want = self.replay(twin, run)
        np.testing.assert_allclose(got.stack(twin.channels), want, atol=1e-9)
        noisy = repaired.simulate("push_fast", seed=4).stack(twin.channels)
        want = self.replay(twin, run, 4)
        np.testing.assert_allclose(noisy, want, atol=1e-9)
        again = repaired.simulate(run).stack(twin.channels)
        np.testing.assert_array_equal(again, got.stack(twin.channels))
        with self.assertRaisesRegex(CampaignError, "did you mean push_fast"):
            repaired.simulate("push_fats")

    def test_where_noise_moves_the_machine_exact_readings_are_a_mean(self):
        repaired, twin = self.make("coulomb_friction", [2.0])
        run = MakeMotion("push_fast").run
        got = repaired.simulate("push_fast").stack(twin.channels)
        want = [self.replay(twin, run, [0, i]) for i in range(3)]
        np.testing.assert_allclose(got, np.mean(want, axis=0), atol=1e-9)


class TestPlan(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.plan = bd.plan(
            "quiet_hold", effects="force_bias,force_scale", progress=False
        )

    def test_it_says_what_stays_unseen(self):
        self.assertEqual(self.plan.runs, ["quiet_hold"])
        names = [row["effect"] for row in self.plan.document["effects"]]
        self.assertEqual(names, ["force_bias", "force_scale"])
        self.assertIn("quiet_hold", repr(self.plan))

    def test_a_wrong_motion_or_two_sources_are_refused(self):
        with self.assertRaisesRegex(CampaignError, "did you mean push"):
            bd.plan("pusch", progress=False)
        with self.assertRaisesRegex(CampaignError, "not both"):
            bd.plan("push", references="x", progress=False)


class TestShown(unittest.TestCase):
    def test_names_from_files_are_escaped(self):
        document = make_diagnosis()
        document["verdict"]["sentence"] = "<script>alert(1)</script>"
        document["provenance"]["scenario"] = {
            "file": "<b>.yaml",
            "named_by": "caller",
            "sha256": None,
        }
        page = render_diagnosis(document)
        self.assertNotIn("<script>", page)
        self.assertNotIn("<b>.yaml", page)
        self.assertIn("&lt;script&gt;", page)

    def test_what_no_effect_explains_is_shown_too(self):
        document = make_unexplained()
        self.assertIn("no effect in the library", render_diagnosis(document))

    def test_fit_and_plan_are_shown(self):
        row = {
            "name": "<k>_N_m", "unit": "N/m", "value": 1.0,
            "standard_error": 0.1, "lower95": 0.8, "upper95": 1.2,
            "at_limit": False, "nominal": 1.0, "fixed": False,
        }  # fmt: skip
        fit = {"campaign": "a", "mean_square": 1.0, "parameters": [row]}
        self.assertIn("&lt;k&gt;", render_fit(fit))
        plan = {"runs": ["push"], "effects": [], "pairs": [], "unseen": ["x"]}
        self.assertIn("Not seen: x", render_plan(plan))


class TestTables(unittest.TestCase):
    def setUp(self):
        self.document = make_diagnosis()

    def test_each_table_has_rows_of_the_same_keys(self):
        for document in (self.document, make_unexplained()):
            for name, rows in diagnosis_tables(document).items():
                with self.subTest(table=name):
                    keys = {tuple(row) for row in rows}
                    self.assertLessEqual(len(keys), 1 + (name == "subject"))

    def test_the_budget_is_the_cube(self):
        tables = diagnosis_tables(self.document)
        self.assertEqual(tables["budget"], self.document["where"]["cube"])

    def test_matrices_have_a_row_and_a_column_of_each_name(self):
        fit = {
            "parameters": [{"name": "a"}, {"name": "b"}],
            "correlation": [[1.0, 0.5], [0.5, 1.0]],
        }
        (first, _) = fit_tables(fit)["correlation"]
        self.assertEqual(first, {"parameter": "a", "a": 1.0, "b": 0.5})
        plan = {
            "effects": [{"effect": "x", "parameters": {}, "size": 2.0}],
            "pairs": [], "cosines": [[1.0]], "undetermined": [],
        }  # fmt: skip
        tables = plan_tables(plan)
        self.assertEqual(tables["cosines"], [{"effect": "x", "x": 1.0}])
        self.assertEqual(tables["effects"], [{"effect": "x", "size": 2.0}])

    def test_without_pandas_one_line_says_what_to_install(self):
        kept = builtins.__import__

        def refuse(name, *more):
            if name == "pandas":
                raise ImportError(name)
            return kept(name, *more)

        result = bd.FitResult(
            {"parameters": [], "correlation": [], "campaign": "a"}
        )
        with mock.patch.object(builtins, "__import__", refuse):
            with self.assertRaisesRegex(ExtraError, "pip install pandas"):
                result.to_pandas()
        self.assertTrue(issubclass(ExtraError, BraceError))

    def test_a_table_that_is_not_there_is_told(self):
        result = bd.FitResult(
            {"parameters": [], "correlation": [], "campaign": "a"}
        )
        with self.assertRaisesRegex(BraceError, "did you mean parameters"):
            result.to_pandas("parametres")

    def test_frames_have_the_rows_as_they_are(self):
        try:
            import pandas  # noqa: F401
        except ImportError:
            self.skipTest("pandas is not installed")
        tables = diagnosis_tables(self.document)
        from brace_drake.core.frames import pick_frames

        frames = pick_frames(tables, None)
        self.assertEqual(list(frames), list(tables))
        causes = pick_frames(tables, "causes")
        self.assertEqual(len(causes), len(self.document["causes"]))
        self.assertEqual(
            causes["effect"].tolist(),
            [c["effect"] for c in self.document["causes"]],
        )


if __name__ == "__main__":
    unittest.main()
