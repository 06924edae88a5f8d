"""Trends: changes are found at the stated rate, and no others."""

import contextlib
import csv
import io
import itertools
import json
import math
import os
import shutil
import tempfile
import unittest
import warnings
from fractions import Fraction
from pathlib import Path
from unittest import mock

import numpy as np
from scipy import stats

from brace_drake.cli.main import make_parser
from brace_drake.core.errors import CampaignError
from brace_drake.core.parallel import Workers
from brace_drake.trend import diagnosed
from brace_drake.trend.alarms import (
    APPEARS,
    DRIFT,
    GROWS,
    MOVED,
    SCATTER,
    STEP,
    judge_effects,
    judge_series,
)
from brace_drake.trend.document import MakeTrendDocument
from brace_drake.trend.grouping import (
    check_alike,
    make_timeline,
    split_sessions,
)
from brace_drake.trend.page import render_trend, trend_files
from brace_drake.trend.presence import switch_probability
from brace_drake.trend.series import GAP, Point, make_series
from brace_drake.trend.sessions import session_of
from brace_drake.trend.statistics import (
    constancy,
    find_steps,
    fit_line,
    fit_linear,
    fit_mean,
    holm,
    scatter_interval,
)
from tests.commands import run_command
from tests.diagnoses import make_diagnosis, make_without_gap
from tests.shared_data import EXAMPLE
from tests.test_report import PageParser

STIFFNESS = "contact_stiffness_N_m"


def make_number(x, s, name="k", of="subject"):
    """A series of values with errors, ten days apart."""
    points = [
        Point(i, 10.0 * i, float(v), float(e), v - 1.96 * e, v + 1.96 * e)
        for i, (v, e) in enumerate(zip(x, s, strict=True))
    ]
    return make_series(name, "N/m", of, points)


def draw_page(generator, n, numbers=3, scatter=0.0, change=None):
    """Numbers without a change, but for what is added to the first."""
    page = []
    for k in range(numbers):
        s = generator.uniform(0.5, 2.0, n)
        wide = np.hypot(s, scatter)
        x = 100.0 + wide * generator.standard_normal(n)
        if k == 0 and change is not None:
            x = x + change
        page.append(make_number(x, s, f"k{k}"))
    return page


def write_diagnosis(folder, number, change=0.0, **more):
    """A session of the example, its draws of its own, the stiffness moved."""
    generator = np.random.default_rng(number)
    document = make_diagnosis() | more
    document["provenance"]["data_sha256"] = f"{number:064d}"
    rows = document["subject"]["parameters"]
    for row in [*rows, *document["verdict"]["supported"][0]["parameters"]]:
        off = row["standard_error"] * generator.standard_normal()
        off += change * (row["name"] == STIFFNESS)
        for key in ("value", "lower95", "upper95"):
            row[key] += off
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "diagnosis.json").write_text(json.dumps(document))
    return folder


def make_sessions(documents):
    """Sessions of documents, of different recordings."""
    sessions = []
    for i, document in enumerate(documents):
        document["provenance"]["data_sha256"] = f"{i:064d}"
        sessions.append(session_of(document, Path(f"s{i}"), f"s{i}"))
    return sessions


class TestStatistics(unittest.TestCase):
    x = np.array([10.0, 12.0, 11.0, 15.0])
    s = np.array([1.0, 2.0, 0.5, 1.5])
    t = np.array([0.0, 3.0, 10.0, 12.0])

    def test_the_mean_is_weighted_and_its_chi_square_is_scipys(self):
        found = fit_mean(self.x, self.s)
        w = self.s**-2.0
        mean = np.average(self.x, weights=w)
        self.assertAlmostEqual(found.stated.value, mean)
        self.assertAlmostEqual(found.stated.error, w.sum() ** -0.5)
        chi2 = float(w @ (self.x - mean) ** 2)
        p, birge = constancy(found)
        self.assertAlmostEqual(p, stats.chi2.sf(chi2, 3))
        self.assertAlmostEqual(birge, math.sqrt(chi2 / 3.0))

    def test_the_slope_is_that_of_a_weighted_polynomial(self):
        found = fit_line(self.t, self.x, self.s)
        fit, covariance = np.polyfit(
            self.t, self.x, 1, w=1.0 / self.s, cov="unscaled"
        )
        self.assertAlmostEqual(found.stated.value, fit[0])
        error = math.sqrt(covariance[0, 0])
        self.assertAlmostEqual(found.stated.error, error)
        p = 2.0 * stats.norm.sf(abs(fit[0]) / error)
        self.assertAlmostEqual(found.stated.p, p)

    def test_beside_a_scatter_equal_errors_give_the_usual_t_test(self):
        # Errors far below the scatter: ordinary least squares.
        found = fit_line(self.t, self.x, np.full(4, 1e-6)).scattered
        usual = stats.linregress(self.t, self.x)
        self.assertAlmostEqual(found.value, usual.slope, 6)
        self.assertAlmostEqual(found.error, usual.stderr, 6)
        self.assertAlmostEqual(found.p, usual.pvalue, 6)

    def test_the_scatter_is_what_chi_square_has_beyond_its_expectation(self):
        w = self.s**-2.0
        mean = np.average(self.x, weights=w)
        rest = float(w @ (self.x - mean) ** 2) - 3.0
        square = rest / (w.sum() - (w**2).sum() / w.sum())
        self.assertGreater(square, 0.0)
        self.assertAlmostEqual(
            fit_mean(self.x, self.s).scatter, math.sqrt(square)
        )

    def test_the_interval_of_the_scatter_is_that_of_a_variance(self):
        # Equal errors: the sum of squares is chi-square of s^2 + tau^2.
        s = 0.5
        low, high = scatter_interval(self.x, np.full(4, s))
        squares = float(np.sum((self.x - self.x.mean()) ** 2))
        ends = squares / stats.chi2.ppf([0.975, 0.025], 3) - s**2
        self.assertAlmostEqual(low, math.sqrt(ends[0]), 6)
        self.assertAlmostEqual(high, math.sqrt(ends[1]), 6)

    def exact(self, z, x, s):
        """Slope, variance, chi-square and trace, in rational numbers."""
        z, x, s = ([Fraction(float(v)) for v in row] for row in (z, x, s))
        w = [1 / v**2 for v in s]

        def total(*rows):
            return sum(math.prod(row) for row in zip(*rows, strict=True))

        a, b, c = sum(w), total(w, z), total(w, z, z)
        area = a * c - b * b
        slope = (a * total(w, z, x) - b * total(w, x)) / area
        start = (total(w, x) - slope * b) / a
        rest = [v - start - slope * u for u, v in zip(z, x, strict=True)]
        chi2 = total(w, rest, rest)
        lever = [
            k * (c - 2 * b * u + a * u * u) / area
            for k, u in zip(w, z, strict=True)
        ]
        trace = sum(k * (1 - h) for k, h in zip(w, lever, strict=True))
        return slope, a / area, chi2, trace

    def test_errors_of_any_size_give_what_rational_numbers_give(self):
        x = [64.0, 61.0, 70.0, 66.0]
        for s in (
            (2.0, 1.0, 3.0, 1e12),
            (1e12, 1.0, 3.0, 2.0),
            (2.0, 1.0, 1e-6, 3.0),
            (1e-6, 1e12, 1.0, 1e6),
        ):
            for z in ((0, 0, 1, 1), (0, 1, 1, 1), (0.0, 0.3, 0.8, 1.0)):
                with self.subTest(s=s, z=z):
                    own = [np.array(v, dtype=float) for v in (z, x, s)]
                    found = fit_linear(*own)
                    slope, square, chi2, trace = self.exact(*own)
                    self.assertTrue(
                        math.isclose(found.stated.value, slope, rel_tol=1e-6)
                    )
                    error = math.sqrt(square)
                    self.assertTrue(
                        math.isclose(found.stated.error, error, rel_tol=1e-6)
                    )
                    self.assertAlmostEqual(
                        found.chi2, float(chi2), delta=1e-6 * (1 + float(chi2))
                    )
                    scatter = math.sqrt(max(0, (chi2 - 2) / trace))
                    self.assertAlmostEqual(
                        found.scatter, scatter, delta=1e-6 * (1.0 + scatter)
                    )

    def test_a_step_of_two_sessions_is_their_difference(self):
        step, _ = find_steps(self.x[:2], self.s[:2])
        self.assertEqual(step.after, 1)
        self.assertAlmostEqual(step.fit.stated.value, 2.0)
        z = 2.0 / math.hypot(1.0, 2.0)
        self.assertAlmostEqual(step.p, 2.0 * stats.norm.sf(z))

    def test_a_clear_step_is_put_where_it_is(self):
        x = np.array([0.0, 0.1, -0.1, 9.0, 9.1])
        for step in find_steps(x, np.full(5, 0.1)):
            self.assertEqual(step.after, 3)
            self.assertAlmostEqual(step.fit.stated.value, 9.05)

    def test_holms_correction_is_that_of_the_book(self):
        found = holm([0.01, 0.04, 0.03, 0.005])
        np.testing.assert_allclose(found, [0.03, 0.06, 0.06, 0.02])


class TestRates(unittest.TestCase):
    LEVEL = 0.05

    def count(self, pages, make):
        """How many pages raise an alarm, and of which kinds."""
        generator = np.random.default_rng(5)
        kinds: dict[str, int] = {}
        for _ in range(pages):
            found = {j.alarm for j in judge_series(make(generator), self.LEVEL)}
            for kind in found | ({"any"} if found - {""} else set()):
                kinds[kind] = kinds.get(kind, 0) + 1
        return kinds

    def test_without_a_change_alarms_come_no_more_often_than_stated(self):
        pages = 200
        for n in (2, 5):
            with self.subTest(sessions=n):
                found = self.count(pages, lambda g, n=n: draw_page(g, n))
                most = stats.binom.ppf(0.9999, pages, self.LEVEL)
                self.assertLessEqual(found.get("any", 0), most)
                # Nor are they silenced.
                self.assertGreater(found.get("any", 0), 0)

    def test_a_scatter_between_sessions_is_not_called_drift_or_step(self):
        pages = 60
        found = self.count(pages, lambda g: draw_page(g, 6, scatter=8.0))
        self.assertGreater(found[SCATTER], 0.9 * pages)
        most = stats.binom.ppf(0.9999, pages, self.LEVEL)
        named = found.get(DRIFT, 0) + found.get(STEP, 0)
        self.assertLessEqual(named, most)

    def test_a_drift_of_ten_errors_is_called_a_drift(self):
        pages, n = 20, 8
        change = np.linspace(0.0, 20.0, n)
        found = self.count(pages, lambda g: draw_page(g, n, change=change))
        self.assertEqual(found["any"], pages)
        self.assertGreater(found[DRIFT], 0.85 * pages)

    def test_a_step_of_ten_errors_is_called_a_step(self):
        pages, n = 20, 8
        change = 20.0 * (np.arange(n) >= 3)
        found = self.count(pages, lambda g: draw_page(g, n, change=change))
        self.assertEqual(found["any"], pages)
        self.assertGreater(found[STEP], 0.85 * pages)

    def test_three_sessions_tell_no_kind(self):
        x, s = np.array([0.0, 10.0, 20.0]), np.ones(3)
        (found,) = judge_series([make_number(x, s)], self.LEVEL)
        self.assertEqual(found.alarm, MOVED)

    def test_a_gap_raises_an_alarm_where_it_grows_alone(self):
        x, s = np.array([1.0, 1.1, 2.0, 3.0, 3.2]), np.full(5, 0.1)
        for values, alarm in ((x, GROWS), (x[::-1], ""), (x * 0 + 2.0, "")):
            series = make_number(values, s, GAP, "twin")
            (found,) = judge_series([series], self.LEVEL)
            self.assertEqual(found.alarm, alarm)


class TestPresence(unittest.TestCase):
    def brute_force(self, named, wrong):
        """Probability by plain counting over all patterns of names."""
        n = len(named)

        def likelihood(pattern, truth):
            return math.prod(
                1.0 - e if a == b else e
                for a, b, e in zip(pattern, truth, wrong, strict=True)
            )

        nulls = [(False,) * n, (True,) * n]
        switches = [
            tuple((i >= k) != gone for i in range(n))
            for k in range(1, n)
            for gone in (False, True)
        ]

        def ratio(pattern):
            best = max(likelihood(pattern, t) for t in switches)
            return best / max(likelihood(pattern, t) for t in nulls)

        seen = ratio(tuple(named)) * (1.0 - 1e-9)
        patterns = list(itertools.product((False, True), repeat=n))
        return max(
            sum(likelihood(p, t) for p in patterns if ratio(p) >= seen)
            for t in nulls
        )

    def test_the_probability_is_that_of_counting_all_patterns(self):
        wrong = np.array([0.1, 0.05, 0.2, 0.02, 0.07])
        for bits in ((0, 0, 1, 1, 1), (1, 1, 1, 0, 0), (0, 1, 0, 1, 1)):
            named = np.array(bits, dtype=bool)
            with self.subTest(named=bits):
                found, _ = switch_probability(named, wrong)
                self.assertAlmostEqual(found, self.brute_force(named, wrong))

    def test_the_switch_is_put_where_it_is(self):
        named = np.array([0, 0, 0, 1, 1, 1], dtype=bool)
        for own in (named, ~named):
            p, at = switch_probability(own, np.full(6, 0.05))
            self.assertEqual(at, 3)
            self.assertLess(p, 1e-3)

    def test_one_session_is_not_enough(self):
        named = np.array([0, 0, 0, 0, 1], dtype=bool)
        p, _ = switch_probability(named, np.full(5, 0.05))
        self.assertGreater(p, 0.04)

    def test_an_effect_that_stays_is_lost_no_more_often_than_stated(self):
        generator, level, pages = np.random.default_rng(2), 0.05, 2000
        wrong = np.array([0.1, 0.05, 0.2, 0.1, 0.07, 0.1])
        alarms = 0
        for _ in range(pages):
            named = generator.random(6) > wrong
            alarms += switch_probability(named, wrong)[0] <= level
        self.assertGreater(alarms, 0)
        most = stats.binom.ppf(0.9999, pages, level)
        self.assertLessEqual(alarms, most)

    def test_many_sessions_are_drawn_and_agree_with_the_count(self):
        named = np.arange(15) >= 12
        wrong = np.full(15, 0.15)
        with mock.patch("brace_drake.trend.presence._MOST_COUNTED", 20):
            exact, _ = switch_probability(named, wrong)
        drawn, at = switch_probability(named, wrong)
        self.assertEqual(at, 12)
        self.assertAlmostEqual(drawn, exact, delta=0.1 * exact + 1e-3)

    def test_a_verdict_that_leaves_an_effect_open_is_not_counted(self):
        documents = [make_without_gap() for _ in range(3)]
        documents += [make_diagnosis() for _ in range(3)]
        documents[2]["verdict"]["ambiguous_with"] = ["relaxation"]
        timeline = make_timeline(make_sessions(documents))
        (found,) = judge_effects(timeline)
        self.assertEqual(found.named, (False, False, None, True, True, True))
        self.assertEqual(found.at, 3)


class TestTimeline(unittest.TestCase):
    def setUp(self):
        self.sessions = make_sessions([make_diagnosis() for _ in range(3)])

    def test_sessions_come_in_the_order_of_their_dates(self):
        dates = ("2026-03-01", "2026-01-01T12:00", "2026-02-01T02:00+02:00")
        documents = [make_diagnosis() for _ in dates]
        for document, date in zip(documents, dates, strict=True):
            document["provenance"]["recorded"] = date
        found = make_timeline(make_sessions(documents))
        self.assertEqual([s.name for s in found.sessions], ["s1", "s2", "s0"])
        np.testing.assert_allclose(found.times, [0.0, 30.5, 58.5])

    def test_without_dates_the_order_counts_and_is_said(self):
        found = make_timeline(self.sessions)
        self.assertEqual(found.times, (0.0, 1.0, 2.0))
        self.assertIn("order", found.source)

    def assert_refused(self, sessions, *words):
        with self.assertRaises(CampaignError) as caught:
            check_alike(sessions)
            make_timeline(sessions)
        for word in words:
            self.assertIn(word, str(caught.exception))

    def test_what_does_not_belong_together_is_refused(self):
        other = make_diagnosis() | {"subject_name": "somebody"}
        other["provenance"]["data_sha256"] = "f"
        mixed = [*self.sessions, session_of(other, Path("x"), "x")]
        self.assert_refused(mixed, "x:", "somebody", "--split")
        self.assertEqual(
            [len(g) for g in split_sessions(mixed).values()], [3, 1]
        )
        other = make_diagnosis() | {"device": "brace"}
        mixed[-1] = session_of(other, Path("x"), "x")
        self.assert_refused(mixed, "x:", "device", "'brace'")
        other = make_diagnosis()
        other["subject"]["parameters"][0]["nominal"] = 5000.0
        mixed[-1] = session_of(other, Path("x"), "x")
        self.assert_refused(mixed, "x:", "scenario")

    def test_scenarios_are_told_apart_by_their_hash(self):
        documents = [make_diagnosis() for _ in range(3)]
        for document, own in zip(documents, "aab", strict=True):
            document["provenance"]["scenario"] = {"sha256": own}
        sessions = make_sessions(documents)
        self.assert_refused(sessions, "s2:", "scenario")
        self.assertEqual(
            [len(g) for g in split_sessions(sessions).values()], [2, 1]
        )
        # That of an axis holds what each recording shows: it always differs.
        for document in documents:
            document["device"] = "axis"
        check_alike(make_sessions(documents))
        # An older diagnosis has no hash, and is taken by its numbers.
        documents = [make_diagnosis() for _ in range(2)]
        documents[0]["provenance"]["scenario"] = {"sha256": "a"}
        del documents[1]["provenance"]["scenario"]
        check_alike(make_sessions(documents))

    def test_one_session_or_the_same_twice_is_refused(self):
        self.assert_refused(self.sessions[:1], "two or more")
        self.assert_refused([*self.sessions, self.sessions[0]], "same")

    def test_a_missing_date_among_dates_is_refused(self):
        documents = [make_diagnosis() for _ in range(2)]
        documents[0]["provenance"]["recorded"] = "2026-01-01"
        self.assert_refused(make_sessions(documents), "s1: no date")

    def test_a_bad_value_is_named_with_its_place(self):
        cases = (
            (("verdict", "probability", 2.0), "verdict.probability is 2.0"),
            (("verdict", "supported", [1]), "verdict.supported"),
            (("subject", "parameters", 3), "subject.parameters is 3"),
            (("shrink", "before_interval", [1]), "shrink.before_interval"),
            (("shrink", "before_interval", [5, 1]), "shrink.before_interval"),
            (("shrink", "before", -1.0), "shrink.before is -1.0"),
            (("provenance", "recorded", "soon"), "date is 'soon'"),
            (("provenance", "recorded", "0001-01-01"), "date is '0001"),
            (("provenance", "recorded", "9999-12-31"), "date is '9999"),
            (
                ("provenance", "recorded", "9999-12-31T23:59-14:00"),
                "date is '9999",
            ),
        )
        for (part, key, value), words in cases:
            document = make_diagnosis()
            document[part][key] = value
            with self.subTest(key=key):
                with self.assertRaises(CampaignError) as caught:
                    session_of(document, Path("a"), "a/diagnosis.json")
                self.assertIn(
                    f"a/diagnosis.json: {words}", str(caught.exception)
                )
                self.assertIn("allowed", str(caught.exception))

    def test_an_estimate_that_cannot_be_is_named_with_its_place(self):
        place = "a/diagnosis.json: subject.parameters"
        for change, words in (
            ({"standard_error": -3.0}, "[0].standard_error is -3.0"),
            ({"standard_error": 1e-300}, "[0].standard_error is 1e-300"),
            ({"standard_error": 5e-324}, "[0].standard_error is 5e-324"),
            ({"standard_error": 1e13}, "allowed: 0, or a number from 1e-12 to"),
            ({"lower95": 9.0, "upper95": 1.0}, "[0].lower95 is 9; allowed"),
            ({"name": "preload_m"}, ": name 'preload_m' is there twice"),
        ):
            document = make_diagnosis()
            document["subject"]["parameters"][0] |= change
            with self.subTest(change=change):
                with self.assertRaises(CampaignError) as caught:
                    session_of(document, Path("a"), "a/diagnosis.json")
                self.assertTrue(str(caught.exception).startswith(place))
                self.assertIn(words, str(caught.exception))

    def test_an_effect_that_is_named_twice_is_refused(self):
        document = make_diagnosis()
        document["verdict"]["supported"] *= 2
        with self.assertRaisesRegex(CampaignError, "'relaxation' is there tw"):
            session_of(document, Path("a"), "a")

    def test_a_parameter_in_another_unit_is_refused_with_both(self):
        documents = [make_diagnosis() for _ in range(3)]
        documents[2]["subject"]["parameters"][0]["unit"] = "kN/m"
        file = Path("s2") / "diagnosis.json"
        self.assert_refused(make_sessions(documents), str(file), "kN/m", "'N/m")


class TestKept(unittest.TestCase):
    def setUp(self):
        folder = self.enterContext(tempfile.TemporaryDirectory())
        self.folder = Path(folder) / "monday"
        shutil.copytree(EXAMPLE, self.folder)
        cache = {"XDG_CACHE_HOME": str(Path(folder) / "cache")}
        self.enterContext(mock.patch.dict(os.environ, cache))
        self.diagnose = self.enterContext(
            mock.patch.object(
                diagnosed, "_diagnose", side_effect=lambda *_: make_diagnosis()
            )
        )

    def load(self, seed=0):
        return diagnosed.LoadOrDiagnose(self.folder, Workers(1), seed)

    def test_a_second_call_diagnoses_nothing_and_says_the_same(self):
        first, document = self.load()
        again, other = self.load()
        self.assertEqual(self.diagnose.call_count, 1)
        self.assertEqual((first, document), (again, other))

    def test_other_recordings_or_seeds_are_diagnosed_anew(self):
        self.load()
        self.load(seed=1)
        self.assertEqual(self.diagnose.call_count, 2)
        with (self.folder / "push.csv").open("a") as file:
            last = (self.folder / "push.csv").read_text().splitlines()[-1]
            time, _, rest = last.partition(",")
            file.write(f"{float(time) + 0.005:.6f},{rest}\n")
        self.load()
        self.assertEqual(self.diagnose.call_count, 3)

    def test_what_was_kept_and_is_spoilt_is_made_again(self):
        self.load()
        (kept,) = Path(os.environ["XDG_CACHE_HOME"]).rglob("diagnosis.json")
        kept.write_text("{")
        self.load()
        self.assertEqual(self.diagnose.call_count, 2)

    def test_the_date_is_that_of_the_campaign(self):
        with (self.folder / "campaign.yaml").open("a") as file:
            file.write("recorded: 2026-05-04\n")
        session, _ = self.load()
        self.assertEqual(session.date.isoformat(), "2026-05-04T00:00:00")

    def test_a_campaign_and_diagnoses_make_one_trend(self):
        other = write_diagnosis(self.folder.parent / "other", 1)
        out = self.folder.parent / "out"
        status, text, error = run_command(
            "trend", self.folder, other, "--out", out, "--no-html"
        )
        self.assertEqual(status, 0, error)
        self.assertIn("2 sessions", text)
        written = out / "diagnoses" / "monday" / "diagnosis.json"
        self.assertEqual(json.loads(written.read_text()), make_diagnosis())


class TestCommand(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.base = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.folders = [
            write_diagnosis(cls.base / f"s{i}", i, 200.0 * i) for i in range(6)
        ]
        dates = ",".join(f"2026-0{i + 1}-01" for i in range(6))
        cls.words = ("trend", *cls.folders, "--dates", dates)
        cls.out = cls.base / "out"
        cls.status, cls.text, cls.error = run_command(
            *cls.words, "--out", cls.out
        )
        cls.document = json.loads((cls.out / "trend.json").read_text())

    def test_the_drift_is_told_and_nothing_else(self):
        self.assertEqual(self.status, 0, self.error)
        kinds = [(a["kind"], a["name"]) for a in self.document["alarms"]]
        self.assertEqual(kinds, [(DRIFT, STIFFNESS)])
        self.assertIn("Contact stiffness drifts", self.text)
        row = self.document["parameters"][0]
        slope = row["tests"]["trend"]["with_scatter"]
        # 1000 N/m in the 151 days from January to June, in N/m per day.
        self.assertLess(slope["lower95"], 1000.0 / 151.0)
        self.assertGreater(slope["upper95"], 1000.0 / 151.0)

    def test_the_table_has_the_numbers_of_the_document(self):
        rows = csv.DictReader(io.StringIO((self.out / "trend.csv").read_text()))
        told = {(int(r["session"]), r["name"]): float(r["value"]) for r in rows}
        for row in [*self.document["parameters"], self.document["gap"]]:
            for point in row["points"]:
                key = point["session"] + 1, row["name"]
                self.assertEqual(told[key], point["value"])

    def test_the_page_is_whole_and_needs_nothing_else(self):
        parser = PageParser()
        page = (self.out / "trend.html").read_text()
        parser.feed(page)
        self.assertEqual((parser.open, parser.faults), ([], []))
        self.assertTrue(parser.refers)
        for target in parser.refers:
            self.assertTrue(target.startswith("data:"), target[:40])
        self.assertIn("Not a medical device", page)
        # A figure of each number, of the gap and of the share closed.
        figures = len(self.document["parameters"]) + 2
        self.assertEqual(parser.tags.count("img"), figures)

    def test_the_same_call_writes_the_same_bytes(self):
        again = self.base / "again"
        run_command(*self.words, "--out", again)
        for name in ("trend.json", "trend.csv", "trend.html"):
            self.assertEqual(
                (again / name).read_bytes(), (self.out / name).read_bytes()
            )

    def test_json_is_the_document_alone_and_the_page_can_be_left_out(self):
        out = self.base / "plain"
        status, text, _ = run_command(
            *self.words, "--out", out, "--json", "--no-html"
        )
        self.assertEqual(status, 0)
        self.assertEqual(json.loads(text), self.document)
        names = sorted(p.name for p in out.iterdir())
        self.assertEqual(names, ["trend.csv", "trend.json"])

    def test_a_known_repeatability_widens_every_interval(self):
        out = self.base / "wide"
        run_command(
            *self.words, "--out", out, "--no-html", "--repeatability", "0.1"
        )
        document = json.loads((out / "trend.json").read_text())
        self.assertEqual(document["alarms"], [])
        old = self.document["parameters"][0]["points"][0]
        new = document["parameters"][0]["points"][0]
        self.assertAlmostEqual(
            new["standard_error"],
            math.hypot(old["standard_error"], 0.1 * old["value"]),
        )

    def test_subjects_are_split_into_folders(self):
        others = [
            write_diagnosis(self.base / f"o{i}", 20 + i, subject_name="../b")
            for i in range(2)
        ]
        out = self.base / "split"
        status, _, error = run_command(
            *("trend", *self.folders[:2], *others),
            *("--out", out, "--split", "--no-html"),
        )
        self.assertEqual(status, 0, error)
        names = sorted(p.name for p in out.iterdir())
        self.assertEqual(names, ["_b", "example"])

    def test_nothing_is_written_where_the_page_cannot_be_made(self):
        out = self.base / "half"
        broken = mock.patch(
            "brace_drake.trend.page.render_trend", side_effect=ValueError
        )
        with broken, self.assertRaises(ValueError):
            run_command(*self.words, "--out", out)
        self.assertFalse(out.exists())

    def test_what_is_wrong_is_one_line_and_status_2(self):
        cases = (
            (
                (*self.folders[:2], "--dates", "0001-01-01T00:00+14:00,2026"),
                "allowed: a date from 1900 to 2199",
            ),
            ((self.base / "none",), "no such folder"),
            ((self.base,), "neither diagnosis.json nor campaign.yaml"),
            ((*self.folders[:2], "--dates", "2026-01-01"), "1 dates for 2"),
            ((*self.folders[:2], "--dates", "x,y"), "date is 'x'"),
            ((self.folders[0],), "two or more"),
        )
        for words, told in cases:
            with self.subTest(told=told):
                status, _, error = run_command(
                    "trend", *words, "--out", self.base / "bad"
                )
                self.assertEqual(status, 2)
                line = error.strip().splitlines()[-1]
                self.assertIn(told, line)
        with contextlib.redirect_stderr(io.StringIO()) as error:
            with self.assertRaises(SystemExit):
                words = ("trend", "a", "--out", "b", "--level", "0")
                make_parser().parse_args(words)
        self.assertIn("from 1e-09 to below 1", error.getvalue())


class TestDocument(unittest.TestCase):
    def test_an_effect_that_appears_raises_an_alarm_on_the_page(self):
        documents = [make_without_gap() for _ in range(4)]
        documents += [make_diagnosis() for _ in range(4)]
        document = MakeTrendDocument(make_timeline(make_sessions(documents)))
        (alarm,) = [a for a in document["alarms"] if a["of"] == "effect"]
        self.assertEqual((alarm["kind"], alarm["session"]), (APPEARS, 4))
        self.assertIn("is-alarm", render_trend(document))

    def test_gaps_of_different_motions_are_not_compared(self):
        documents = [make_diagnosis() for _ in range(3)]
        documents[2]["shrink"]["runs"] = ["another"]
        document = MakeTrendDocument(make_timeline(make_sessions(documents)))
        self.assertIsNone(document["gap"]["tests"])
        self.assertIn("different validation runs", document["gap"]["note"])

    def test_estimates_at_a_limit_or_without_an_error_are_left_out(self):
        documents = [make_diagnosis() for _ in range(3)]
        rows = [d["subject"]["parameters"][0] for d in documents]
        rows[0]["at_limit"] = True
        for key in ("standard_error", "lower95", "upper95"):
            rows[1][key] = None
        document = MakeTrendDocument(make_timeline(make_sessions(documents)))
        row = document["parameters"][0]
        self.assertIsNone(row["tests"])
        told = [p["left_out"] for p in row["points"]]
        self.assertEqual(told, ["at its limit", "without an interval", ""])
        render_trend(document)

    def test_the_widest_values_that_are_allowed_make_a_page(self):
        for error, value, alarm in (
            (1e-12, 1e12, [SCATTER]),
            (1e12, 0.0, []),
            (1e-12, 5e-324, [SCATTER]),
        ):
            documents = [make_diagnosis() for _ in range(5)]
            dates = ("1900-01-01", "2026", "2027", "2028", "2199-12-31")
            for document, date in zip(documents, dates, strict=True):
                whole = date if "-" in date else f"{date}-01-01"
                document["provenance"]["recorded"] = whole
            last = documents[3]["subject"]["parameters"][0]
            last |= {"standard_error": error, "value": value}
            last |= {"lower95": value, "upper95": value}
            with self.subTest(error=error, value=value):
                with warnings.catch_warnings():
                    warnings.simplefilter("error")
                    timeline = make_timeline(make_sessions(documents))
                    files = trend_files(MakeTrendDocument(timeline))
                self.assertEqual(len(files), 3)
                alarms = json.loads(files["trend.json"])["alarms"]
                self.assertEqual([a["kind"] for a in alarms], alarm)

    def test_names_on_the_page_are_text(self):
        documents = [
            make_diagnosis() | {"subject_name": "<b>&$x$"} for _ in range(2)
        ]
        page = render_trend(
            MakeTrendDocument(make_timeline(make_sessions(documents)))
        )
        self.assertNotIn("<b>&$", page)
        self.assertIn("&lt;b&gt;&amp;$x$", page)


if __name__ == "__main__":
    unittest.main()
