"""The report: whole, self-contained, safe, and there for any verdict."""

import copy
import math
import tempfile
import unittest
from html.parser import HTMLParser
from pathlib import Path
from unittest import mock

import numpy as np

from brace_drake.core.errors import OutputError
from brace_drake.effects.registry import all_effects
from brace_drake.report import RunTrace, WriteReport
from brace_drake.report.cards import make_card, make_cards
from brace_drake.report.page import render_page
from brace_drake.report.summary import failed_row, render_summary, summary_row
from brace_drake.report.view import make_view
from brace_drake.report.words import (
    channel_text,
    error_row,
    parameter_row,
    parameter_text,
    percent,
    percent_interval,
    scale_of,
)
from tests.diagnoses import (
    STORED,
    make_diagnosis,
    make_partly,
    make_partly_withdrawn,
    make_unexplained,
    make_withdrawn,
    make_without_gap,
)

CHANNELS = tuple(row["channel"] for row in STORED["where"]["channels"])
UNITS = {"N": 0.05, "m": 2e-6}
VOID = {"wbr", "meta", "img", "br", "link", "hr", "input", "col"}


class PageParser(HTMLParser):
    """Checks that tags are balanced and gathers what they refer to."""

    def __init__(self):
        super().__init__()
        self.open, self.faults, self.refers, self.text = [], [], [], []
        self.tags = []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.refers += [v for k, v in attrs if k in ("src", "href", "data")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open[-1] != tag:
            self.faults.append((tag, self.getpos()))
        else:
            self.open.pop()

    def handle_data(self, data):
        if not self.open or self.open[-1] not in ("script", "style"):
            self.text.append(data)


def parse(page: str) -> PageParser:
    parser = PageParser()
    parser.feed(page)
    parser.close()
    return parser


def _parameter(name, unit, value, error, **more):
    return {
        "name": name,
        "unit": unit,
        "value": value,
        "standard_error": error,
        "lower95": value - 1.96 * error,
        "upper95": value + 1.96 * error,
        "at_limit": False,
        **more,
    }


def make_trace(
    name="validation_push",
    channels=CHANNELS,
    samples=800,
    split="validation",
    with_after=True,
) -> RunTrace:
    """A run whose gap decays after every step of the reference."""
    rng = np.random.default_rng(3)
    time = np.arange(samples) / 200.0
    floor = np.array([UNITS[n.rsplit("_", 1)[1]] for n in channels])
    motion = np.tanh(3.0 * np.sin(1.2 * time))[:, None]
    gap = (np.exp(-(time % 2.6)) * np.sign(motion[:, 0]))[:, None]
    size = floor * np.where(np.char.find(channels, "force_y") >= 0, 30, 6)
    truth = motion * floor * 400.0 + gap * size
    noise = rng.normal(size=truth.shape) * floor
    return RunTrace(
        name=name,
        split=split,
        time_s=time,
        channels=channels,
        measured=truth + noise,
        before=truth - gap * size,
        after=truth - 0.03 * gap * size if with_after else None,
        floor_rms=floor,
        position=1e-2 * motion[:, 0],
        floor_density=(np.array([0.0, 100.0]), floor[None, :] ** 2),
    )


def use_hollow_figures(test):
    """Figures are still built in a test, only not laid out and written."""
    for name in (
        "bars.to_data_uri",
        "budget.to_data_uri",
        "law.to_data_uri",
        "traces.to_png_uri",
    ):
        patch = mock.patch(
            f"brace_drake.report.figures.{name}",
            return_value="data:image/svg+xml;base64,",
        )
        test.enterContext(patch)


class ReportTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.diagnosis = make_diagnosis()
        cls.traces = [make_trace(), make_trace("validation_multisine")]
        cls.page = render_page(cls.diagnosis, cls.traces)
        cls.parsed = parse(cls.page)

    def check_whole(self, diagnosis, traces=()):
        page = render_page(diagnosis, list(traces))
        parsed = parse(page)
        self.assertEqual(parsed.faults, [])
        self.assertEqual(parsed.open, [])
        text = "".join(parsed.text)
        for word in ("nan", "None"):
            self.assertNotRegex(text, rf"\b{word}\b(?! is needed|\.)")
        return page, " ".join(text.split())

    def test_page_is_balanced_html(self):
        self.assertTrue(self.page.startswith("<!DOCTYPE html>"))
        self.assertEqual(self.parsed.faults, [])
        self.assertEqual(self.parsed.open, [])

    def test_page_says_verdict_and_names_every_effect(self):
        text = "".join(self.parsed.text)
        self.assertIn(self.diagnosis["verdict"]["sentence"], text)
        for cause in self.diagnosis["causes"]:
            with self.subTest(cause=cause["effect"]):
                self.assertIn(cause["effect"], text)
        self.assertIn("ot a medical device", text)

    def test_each_named_effect_has_its_own_support(self):
        text = " ".join("".join(self.parsed.text).split())
        for row in self.diagnosis["verdict"]["supported"]:
            self.assertIn(percent(row["probability"]), text)
            ends = row["closes_interval"]
            share, interval = percent_interval(row["closes"], *ends)
            self.assertIn(f"{share}{interval}", text)

    def test_what_was_screened_only_is_no_row_of_those_searched(self):
        _, tail = self.page.split("screened only")
        names = [
            c["effect"] for c in self.diagnosis["causes"] if not c["searched"]
        ]
        self.assertTrue(names)
        for name in names:
            self.assertIn(name.replace("+", " + "), tail)

    def test_what_is_within_a_tolerance_is_no_verdict(self):
        use_hollow_figures(self)
        diagnosis = make_without_gap()
        diagnosis["causes"][0]["chosen"] = True
        page, _ = self.check_whole(diagnosis)
        self.assertNotIn('<span class="chip win">verdict', page)
        self.assertIn('<span class="chip">within tolerances', page)

    def test_what_is_within_a_tolerance_beside_the_verdict_is_told(self):
        use_hollow_figures(self)
        diagnosis = make_diagnosis()
        (chosen,) = [c for c in diagnosis["causes"] if c["chosen"]]
        chosen["effect"] += "+coulomb_friction"
        friction = {
            **chosen["parameters"][0],
            "name": "coulomb_N",
            "unit": "N",
            "value": 0.0224,
            "standard_error": 0.0003,
        }
        chosen["parameters"] = [*chosen["parameters"], friction]
        _, text = self.check_whole(diagnosis)
        self.assertRegex(text, r"dry friction \(coulomb 0\.0224\d* N\)")
        self.assertIn("so it is no finding", text)

    def test_a_fault_of_the_recording_is_shown(self):
        use_hollow_figures(self)
        diagnosis = make_diagnosis()
        told = "The recording, not the machine: a late clock in push (p .90)."
        fault = {"fault": "wrong_clock", "run": "push", "probability": 0.9}
        fault |= {"channel": None, "parameters": {"rate_ratio": 0.997}}
        fault |= {"sentence": told, "remedy": "state the rate <as it is>"}
        diagnosis["verdict"]["recording"] = [fault]
        _, text = self.check_whole(diagnosis)
        self.assertIn(told, text)
        self.assertIn("state the rate <as it is>", text)

    def test_an_effect_withdrawn_by_itself_leaves_the_others(self):
        use_hollow_figures(self)
        diagnosis = make_partly_withdrawn()
        why = diagnosis["verdict"]["contradicted"]
        _, text = self.check_whole(diagnosis)
        self.assertIn(f"contradict what the fit runs said: {why}.", text)
        self.assertIn("with what is named the gap goes from", text)

    def test_a_repair_that_breaks_down_confirms_nothing(self):
        use_hollow_figures(self)
        diagnosis = make_diagnosis()
        diagnosis["verdict"]["confirmed"] = None
        diagnosis["shrink"] |= {"closed": None, "closed_interval": None}
        diagnosis["shrink"]["after"] = diagnosis["shrink"]["before"]
        _, text = self.check_whole(diagnosis)
        self.assertIn("neither confirm nor contradict", text)

    def test_page_needs_nothing_from_outside(self):
        self.assertTrue(self.parsed.refers)
        for target in self.parsed.refers:
            self.assertTrue(target.startswith("data:image/"), target[:60])
        # The chart library's licence names where it is from.
        page = self.page.replace("https://github.com/leeoniya/uPlot", "")
        for word in ("http://", "https://", "@import", "url(", "fetch("):
            self.assertNotIn(word, page)
        self.assertIn("default-src 'none'", page)

    def test_the_chart_library_comes_with_its_licence(self):
        self.assertIn("Copyright (c) 2022 Leon Sorokin", self.page)

    def test_the_budget_is_shown_with_its_intervals(self):
        text = "".join(self.parsed.text)
        self.assertIn("Residual power by block", text)
        self.assertIn("Residual power by channel, phase", text)
        row = self.diagnosis["where"]["attribution"][0]
        interval = percent_interval(*(row[k] for k in ("share", "lower95")), 1)
        self.assertIn(interval[1], text)

    def test_same_diagnosis_gives_same_page(self):
        self.assertEqual(self.page, render_page(make_diagnosis(), self.traces))

    def test_page_of_ten_runs_of_12_s_is_small(self):
        traces = [make_trace(f"run{i}", samples=2400) for i in range(10)]
        page = render_page(self.diagnosis, traces)
        self.assertLess(len(page.encode()), 3_000_000)
        self.assertEqual(page.count('<div class="run" data-run'), 11)

    def test_every_kind_of_verdict_has_its_page(self):
        use_hollow_figures(self)
        for diagnosis, badge, words in (
            (
                make_diagnosis(),
                "Gap",
                ("of the gap closed", "The validation runs confirm it"),
            ),
            (
                make_partly(),
                "Gap, partly explained",
                (
                    "66.0 to 70.0 %",
                    "31 % of the gap is left, in actuation; it goes with",
                    "−2.8",
                ),
            ),
            (
                make_withdrawn(),
                "Withdrawn",
                (
                    "contradict what the fit runs said",
                    "from 2.49 to 2.61 times the floor. It is withdrawn.",
                ),
            ),
            (
                make_unexplained(),
                "Outside the library",
                (
                    "Nothing was added to the twin",
                    "not the same in both directions",
                    "69 to 79 %",
                    "nothing simple of the motion",
                    "next_run.csv",
                    "hysteresis, relaxation: 12 ",
                ),
            ),
            (
                make_without_gap(),
                "No gap",
                ("no effect is needed", "nothing to shrink", "no validation"),
            ),
        ):
            with self.subTest(badge):
                page, text = self.check_whole(diagnosis, [make_trace("run")])
                self.assertIn(f'<span class="badge">{badge}</span>', page)
                for word in words:
                    self.assertIn(word, text)

    def test_a_next_motion_in_words_has_its_place(self):
        use_hollow_figures(self)
        document = copy.deepcopy(STORED)
        document["next_experiment"] = {"why": "so", "motion": "slow stairs"}
        page = render_page(document, [])
        self.assertIn("slow stairs", page)

    def test_nothing_in_it_is_taken_for_markup_or_mathematics(self):
        hostile = "<script>alert('x')</script>"
        diagnosis = make_diagnosis()
        diagnosis["subject_name"] = hostile
        diagnosis["campaign"] = f'"{hostile}'
        diagnosis["verdict"]["sentence"] = f"${hostile}"
        diagnosis["where"]["phases"][0]["phase"] = r"$\frac{$ & <b>"
        diagnosis["where"]["channels"][0]["channel"] = "$x^_N\x00"
        diagnosis["provenance"]["note"] = hostile
        trace = make_trace(f"$\\bad{{ {hostile}")
        page, text = self.check_whole(diagnosis, [trace])
        self.assertNotIn("<script>alert", page)
        self.assertEqual(page.count("<script"), 2)
        self.assertEqual(page.count("</script"), 2)
        self.assertIn(hostile, text)

    def test_a_channel_that_was_not_recorded_is_drawn_without_it(self):
        use_hollow_figures(self)
        hollow, gone = make_trace("hollow"), make_trace("gone")
        hollow.measured[:, 0] = np.nan
        gone.measured[:] = np.nan
        for trace in (hollow, gone, make_trace("alone", with_after=False)):
            with self.subTest(run=trace.name):
                self.check_whole(make_diagnosis(), [trace])

    def test_rival_is_the_runner_up(self):
        use_hollow_figures(self)
        diagnosis = make_diagnosis()
        diagnosis["causes"][0]["effect"] = "coulomb_friction"
        diagnosis["verdict"]["effects"] = ["coulomb_friction"]
        diagnosis["verdict"]["ambiguous_with"] = ["viscous_leg"]
        page, _ = self.check_whole(diagnosis)
        self.assertIn("a rival here", page)
        self.assertEqual(page.count('<article class="card'), 2)

    def names_of_cards(self, chosen, ambiguous, *others):
        verdict = {"gap": True, "ambiguous_with": ambiguous}
        verdict["effects"] = [p.split(" (")[0] for p in chosen.split("+") if p]
        rows = [(chosen, True)] if chosen else []
        rows += [(name, False) for name in others]
        causes = [
            {"effect": name, "chosen": is_chosen, "searched": True}
            for name, is_chosen in rows
        ]
        cards = make_cards(causes, verdict)
        return [(card["name"], card["role"]) for card in cards]

    def test_runner_up_is_what_the_verdict_does_not_contain(self):
        self.assertEqual(
            self.names_of_cards(
                "relaxation", [], "relaxation+hardening", "force_bias"
            ),
            [("relaxation", "verdict"), ("force_bias", "runner-up")],
        )
        self.assertEqual(
            self.names_of_cards(
                "coulomb_friction+force_scale", ["viscous_leg+force_scale"]
            ),
            [
                ("coulomb_friction", "verdict"),
                ("force_scale", "verdict"),
                ("viscous_leg", "runner-up"),
            ],
        )
        self.assertEqual(
            self.names_of_cards("", [], "force_bias"),
            [("force_bias", "nearest in the library")],
        )

    def test_another_form_of_the_verdict_is_no_runner_up(self):
        self.assertEqual(
            self.names_of_cards(
                "backlash (gap)", [], "backlash (play)", "force_lag"
            ),
            [("backlash (gap)", "verdict"), ("force_lag", "runner-up")],
        )

    def test_what_was_fitted_on_the_validation_runs_is_said(self):
        use_hollow_figures(self)
        diagnosis = make_diagnosis()
        for name, words in (
            ("relaxation", "on which nothing was fitted"),
            ("breathing", "only what each run has of its own was fitted"),
        ):
            diagnosis["causes"][0]["effect"] = name
            self.assertIn(words, self.check_whole(diagnosis)[1])

    def test_every_effect_and_every_form_of_one_has_its_card(self):
        verdict = {"effects": [], "ambiguous_with": []}
        for key, effect in all_effects().items():
            for told in (key, effect.name):
                card = make_card(told, "verdict", verdict)
                self.assertEqual(card["effect"].block, effect.block)
            card = make_card(key, "verdict", verdict)
            self.assertEqual(card["effect"].equation, effect.equation)

    def test_parameters_that_are_drawn_alike_are_one_line_of_a_card(self):
        verdict = {"effects": [], "ambiguous_with": []}
        card = make_card("anchor_error", "runner-up", verdict)
        self.assertEqual(len(card["parameters"]), 1)
        self.assertIn("of 36", card["parameters"][0][1])

    def test_diagnosis_is_left_as_it_was(self):
        # The page of `setUpClass`, with all its figures, is made from it.
        self.assertEqual(self.diagnosis, STORED)


class OpenTest(unittest.TestCase):
    """What the page says to be open does not contradict its verdict."""

    def setUp(self):
        use_hollow_figures(self)

    def make_open(self, **explained):
        diagnosis = make_diagnosis()
        diagnosis["verdict"]["effects"] = ["clearance", "viscous_leg"]
        first, *causes = diagnosis["causes"]
        first |= {"effect": "clearance+viscous_leg", "explained": 0.75}
        diagnosis["causes"] = [first] + [
            cause
            | {
                "effect": name,
                "searched": True,
                "converged": False,
                "explained": value,
            }
            for cause, (name, value) in zip(
                causes, explained.items(), strict=False
            )
        ]
        view = make_view(diagnosis, [])
        return view["unconverged"], view["left_early"]

    def test_a_part_of_the_verdict_is_not_open(self):
        found = self.make_open(clearance=0.8, viscous_leg=0.2)
        self.assertEqual(found, ([], []))

    def test_only_what_explains_as_much_as_the_verdict_is_not_ruled_out(self):
        found = self.make_open(hardening=0.76, coulomb_friction=0.74)
        self.assertEqual(found, (["hardening"], ["coulomb_friction"]))

    def test_without_a_gap_nothing_is_open(self):
        diagnosis = make_without_gap()
        for cause in diagnosis["causes"]:
            cause |= {"searched": True, "converged": False, "explained": 1.0}
        view = make_view(diagnosis, [])
        self.assertEqual((view["unconverged"], view["left_early"]), ([], []))


class SummaryTest(unittest.TestCase):
    def test_every_campaign_has_its_row_and_its_verdict(self):
        rows = [
            summary_row("a", make_diagnosis()),
            summary_row("b", make_unexplained()),
            summary_row("c", make_without_gap()),
            summary_row("d", make_partly()),
            summary_row("e", make_withdrawn()),
            failed_row("f", "no <runs>"),
        ]
        kinds = [
            "gap",
            "outside the library",
            "no gap",
            "gap, partly explained",
            "withdrawn",
            "failed",
        ]
        self.assertEqual([row["verdict"] for row in rows], kinds)
        self.assertEqual(rows[0]["closed"], STORED["shrink"]["closed"])
        self.assertEqual(rows[2]["closed"], "")
        parsed = parse(render_summary(rows))
        self.assertEqual((parsed.faults, parsed.open), ([], []))
        self.assertIn("no <runs>", "".join(parsed.text))


class WriteTest(unittest.TestCase):
    def setUp(self):
        use_hollow_figures(self)
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def test_report_replaces_the_old_one_and_leaves_no_draft(self):
        path = self.folder / "new" / "report.html"
        WriteReport(make_diagnosis(), [], path)
        path.write_text("old")
        WriteReport(make_diagnosis(), [], path)
        self.assertIn("bench stage 2", path.read_text("utf-8"))
        self.assertEqual(list(path.parent.iterdir()), [path])

    def test_report_that_cannot_be_written_is_one_clear_line(self):
        # A file where a folder is needed binds root as well.
        file = self.folder / "file"
        file.write_text("kept")
        taken = self.folder / "taken"
        (taken / "inside").mkdir(parents=True)
        for path in (file / "report.html", taken):
            with self.subTest(path=path.name):
                with self.assertRaises(OutputError) as caught:
                    WriteReport(make_diagnosis(), [], path)
                message = str(caught.exception)
                self.assertRegex(message, f"{path.name}|{path.parent}")
                self.assertRegex(message, "cannot (be written|write)")
                self.assertNotIn("\n", message)
        self.assertEqual(file.read_text(), "kept")
        self.assertEqual(sorted(self.folder.iterdir()), [file, taken])


class WordsTest(unittest.TestCase):
    def test_digits_follow_the_standard_error(self):
        row = parameter_row(_parameter("coulomb_N", "N", 3.01842, 0.0213))
        self.assertEqual(row["name"], "coulomb")
        self.assertEqual(row["value"], "3.018")
        self.assertEqual(row["interval"], "2.977 to 3.060")

    def test_lengths_and_times_take_a_readable_unit(self):
        self.assertEqual(scale_of("m", [2e-6]), (1e6, "µm"))
        self.assertEqual(scale_of("m", [0.004]), (1e3, "mm"))
        self.assertEqual(scale_of("s", [0.004]), (1e3, "ms"))
        self.assertEqual(scale_of("N", [0.004]), (1.0, "N"))
        self.assertEqual(scale_of("m", [math.nan]), (1.0, "m"))

    def test_names_lose_unit_and_underscores(self):
        self.assertEqual(
            channel_text("leg3_force_command_N"), "Leg 3 force command"
        )
        self.assertEqual(parameter_text("damping_N_s_m", "N s/m"), "damping")

    def test_percentages_are_honest_near_the_ends(self):
        self.assertEqual(percent(0.974), "97 %")
        self.assertEqual(percent(0.99996), "> 99.9 %")
        self.assertEqual(percent(0.004), "0.4 %")
        self.assertEqual(percent(-0.12), "−12 %")
        self.assertEqual(percent(None), "–")

    def test_intervals_have_the_digits_that_tell_their_ends_apart(self):
        for low, high, shown in (
            (0.62, 0.74, "62 to 74 %"),
            (0.981, 0.997, "98.1 to 99.7 %"),
            (0.9999, 1.0004, "99.99 to 100.00 %"),
            (0.0, 3e-5, "within 0.01 % of 0.00 %"),
            (None, 0.1, ""),
        ):
            with self.subTest(shown=shown):
                self.assertEqual(percent_interval(0.5, low, high)[1], shown)

    def test_a_channel_that_was_at_its_floor_has_nothing_to_close(self):
        row = {"before": 1.036, "after": 0.971, "floor": 1.0, "closed": 1.81}
        row["after_interval"] = [0.9, 1.1]
        self.assertEqual(error_row("a", "N", row)["closed"], "–")
        shown = error_row("a", "N", row | {"before": 1.2})
        self.assertEqual(shown["closed"], "100 %")
        self.assertEqual(shown["interval"], "0.9 to 1.1")

    def test_a_choice_is_shown_in_words_and_a_share_without_a_unit(self):
        row = parameter_row(_parameter("pad", "1", 2.0, 0.0))
        self.assertEqual((row["name"], row["value"]), ("", "pad at -y"))
        row = parameter_row(_parameter("force_scale", "1", 0.031, 0.002))
        self.assertEqual((row["name"], row["unit"]), ("force scale", ""))


if __name__ == "__main__":
    unittest.main()
