"""The report: whole, self-contained, safe, and there for any diagnosis."""

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
from brace_drake.report.tables import error_row, parameter_row, shrink_rows
from brace_drake.report.view import make_view
from brace_drake.report.words import (
    channel_text,
    parameter_text,
    percent,
    percent_interval,
    scale_of,
)

CHANNELS = (
    *(f"leg{k}_force_command_N" for k in range(1, 7)),
    *(f"leg{k}_length_m" for k in range(1, 7)),
    *(f"ring2_force_{axis}_N" for axis in "xyz"),
    "torso_y_m",
    "ring2_y_virtual_m",
)
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


def _cause(effect, block, title, explained, decision, *parameters, **more):
    return {
        "effect": effect,
        "block": block,
        "title": title,
        "explained": explained,
        "excess": 3.8 * (1.0 - explained),
        "converged": True,
        "identifiable": True,
        "decision": decision,
        "parameters": list(parameters),
        **more,
    }


def _blocks():
    ends = {
        "actuation": ("commands, lengths", "ring motion"),
        "mechanism": ("leg lengths", "ring pose"),
        "contact": ("ring, torso", "contact force"),
        "torso": ("contact force", "torso marker"),
        "sensing": ("force, lengths", "readings"),
    }
    rms = (1.03, 0.98, 6.42, 1.31, 1.01)
    return [
        {
            "block": block,
            "input": ends[block][0],
            "output": ends[block][1],
            "normalised_rms": value,
            "threshold": 1.2,
            "acquitted": value < 1.2,
            "share": max(0.0, value - 1.0) / 5.8,
        }
        for block, value in zip(ends, rms, strict=True)
    ]


def _attribution():
    shares = {"actuation": 0.0, "contact": 0.9, "torso": 0.06}
    return [
        {
            "block": block,
            "share": share,
            "lower95": 0.9 * share,
            "upper95": 1.05 * share,
            "alone": share,
            "or": ["sensing"] if block == "torso" else [],
        }
        for block, share in (shares | {"none of these": 0.04}).items()
    ]


def _cube():
    return [
        {
            "channel": channel,
            "phase": phase,
            "from_Hz": low,
            "to_Hz": 4.0 * low + 0.5,
            "share": share,
            "normalised_rms": 9.0,
            "lower95": 0.9 * share,
            "upper95": 1.1 * share,
        }
        for channel, phase, low, share in (
            ("ring2_force_y_N", "hold", 0.0, 0.6),
            ("ring2_force_y_N", "reversal", 0.5, 0.3),
            ("torso_y_m", "hold", 0.5, 0.1),
        )
    ]


def _channels():
    return [
        {
            "channel": name,
            "unit": name.rsplit("_", 1)[1],
            "floor": UNITS[name.rsplit("_", 1)[1]],
            "before": 1.2 + 9.0 * (name == "ring2_force_y_N") + 0.3 * i,
            "after": 1.0 + 0.02 * i,
            "share": 0.3 if name == "ring2_force_y_N" else 0.04,
        }
        for i, name in enumerate(CHANNELS)
    ]


def _causes():
    return [
        _cause(
            *("relaxation", "contact", "tissue relaxes under load", 0.974),
            "accepted: explains the most, and the rest by far less",
            _parameter("share", "", 0.281, 0.004),
            _parameter("relaxation_time_s", "s", 1.93, 0.06),
        ),
        _cause(
            *("hysteresis", "contact", "tissue loses work in a cycle", 0.62),
            "rejected: 35 points behind",
            _parameter("width_N", "N", 4.11, 0.09),
        ),
        _cause(
            *("posture_drift", "torso", "the patient gives way", 0.41),
            "rejected: 56 points behind",
            _parameter("drift_m", "m", 0.0021, 4e-5, at_limit=True),
        ),
        _cause(
            *("hardening", "contact", "tissue stiffens", 0.17),
            "rejected: does not reach the rest",
            _parameter("cubic_N_m3", "N/m³", 2.1e7, 3e5),
            identifiable=False,
        ),
        _cause(
            *("coulomb_friction", "actuation", "dry friction", 0.02),
            "acquitted: its block is at the floor",
            _parameter("coulomb_N", "N", 0.04, 0.03),
        ),
        _cause(
            *("command_delay", "actuation", "late commands", 0.004),
            "acquitted: its block is at the floor",
            _parameter("delay_s", "s", 0.0002, 0.00015),
            converged=False,
        ),
    ]


def _subject():
    values = (
        ("contact_stiffness_N_m", "N/m", 15000.0, 12834.0, 21.0),
        ("contact_damping_N_s_m", "N s/m", 150.0, 171.2, 2.4),
        ("posture_stiffness_y_N_m", "N/m", 2500.0, 3121.0, 8.0),
        ("posture_damping_y_N_s_m", "N s/m", 120.0, 98.4, 1.3),
        ("torso_mass_kg", "kg", 12.0, 13.42, 0.11),
        ("preload_m", "m", 0.004, 0.004412, 6e-6),
    )
    n = len(values)
    away = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    return {
        "parameters": [
            _parameter(name, unit, value, error, nominal=nominal)
            for name, unit, nominal, value, error in values
        ],
        "condition_number": 84.3,
        "correlation": ((-0.62) ** away).tolist(),
    }


def _shrink():
    return {
        "runs": ["validation_push.csv", "validation_multisine.csv"],
        "before": 4.81,
        "after": 1.06,
        "floor": 1.0,
        "closed": 0.984,
        "closed_interval": [0.979, 0.99],
        "channels": [
            {
                "channel": c["channel"],
                "unit": c["unit"],
                "before": c["before"] * c["floor"],
                "after": c["after"] * c["floor"],
                "floor": c["floor"],
                "closed": 0.97,
            }
            for c in _channels()
        ],
        "force_error_N": {
            "before": 1.31,
            "after": 0.07,
            "after_interval": [0.061, 0.083],
            "floor": 0.065,
        },
        "ring_error_mm": {"before": 0.082, "after": 0.004, "floor": 0.0035},
    }


def make_diagnosis() -> dict:
    """A diagnosis with every part there."""
    phases = ("hold", "load", "unload", "reverse")
    bands = ((0.0, 0.15), (0.15, 0.5), (0.5, 1.5), (1.5, 5.0), (5.0, 100.0))
    return {
        "format": "brace-diagnosis/1",
        "campaign": "open03_relaxation",
        "device": "bench stage 2",
        "subject_name": "open03",
        "verdict": {
            "gap": True,
            "effects": ["relaxation"],
            "blocks": ["contact"],
            "outside_library": False,
            "ambiguous_with": [],
            "probability": 0.971,
            "sentence": "There is a gap in the contact, and relaxation of the"
            " tissue explains 97 % of it.",
        },
        "where": {
            "blocks": _blocks(),
            "attribution": _attribution(),
            "cube": _cube(),
            "channels": _channels(),
            "phases": [
                {"phase": p, "before": 6.0 - i, "after": 1.05, "share": 0.25}
                for i, p in enumerate(phases)
            ],
            "bands": [
                {
                    "from_Hz": low,
                    "to_Hz": high,
                    "before": 8.0 / (1.0 + 2.0 * i),
                    "after": 1.02,
                    "share": 0.5 / 2.0**i,
                }
                for i, (low, high) in enumerate(bands)
            ],
        },
        "causes": _causes(),
        "subject": _subject(),
        "shrink": _shrink(),
        "next_experiment": {
            "why": "Relaxation and hysteresis differ most while nothing moves.",
            "motion": "Push to 8 mm in 0.2 s, hold for 20 s, release.",
        },
        "warnings": ["Run push and its repeat differ by 1.4 times the noise."],
        "receipt": {
            "data_sha256": "9f2c" * 16,
            "versions": {"brace_drake": "0.1.0", "drake": "1.51.0"},
            "seed": 7,
            "thresholds": {"acquit": 1.2, "accept": 0.9},
        },
    }


def make_trace(
    name="validation_push",
    channels=CHANNELS,
    samples=2000,
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


def strip(value, keys):
    """The value without the keys at any depth."""
    if isinstance(value, dict):
        return {k: strip(v, keys) for k, v in value.items() if k not in keys}
    if isinstance(value, list):
        return [strip(v, keys) for v in value]
    return value


def replace_numbers(value, by):
    """The value with every number replaced."""
    if isinstance(value, dict):
        return {k: replace_numbers(v, by) for k, v in value.items()}
    if isinstance(value, list):
        return [replace_numbers(v, by) for v in value]
    is_number = isinstance(value, float | int) and not isinstance(value, bool)
    return by if is_number else value


class ReportTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.diagnosis = make_diagnosis()
        cls.traces = [make_trace(), make_trace("validation_multisine")]
        cls.page = render_page(cls.diagnosis, cls.traces)
        cls.parsed = parse(cls.page)

    def use_hollow_figures(self):
        # Figures are still built, only not laid out and written.
        for module in (
            "figures",
            "trace_figures",
            "budget_figures",
            "plane_figures",
        ):
            patch = mock.patch(
                f"brace_drake.report.{module}.to_data_uri",
                return_value="data:image/svg+xml;base64,",
            )
            patch.start()
            self.addCleanup(patch.stop)

    def check_whole(self, diagnosis, traces=()):
        page = render_page(diagnosis, list(traces))
        parsed = parse(page)
        self.assertEqual(parsed.faults, [])
        self.assertEqual(parsed.open, [])
        self.assertNotIn("nan", " ".join(parsed.text).lower().split())
        return page, parsed

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

    def test_page_needs_nothing_from_outside(self):
        self.assertTrue(self.parsed.refers)
        for target in self.parsed.refers:
            self.assertTrue(target.startswith("data:image/"), target[:60])
        for word in ("http://", "https://", "@import", "url("):
            self.assertNotIn(word, self.page)
        self.assertNotIn("script", self.parsed.tags)

    def test_the_budget_is_shown_with_what_else_it_could_be(self):
        text = "".join(self.parsed.text)
        self.assertIn("The gap shared out over the blocks", text)
        self.assertIn("Channel, phase and frequency at once", text)
        self.assertIn("81 to 94 %", text)

    def test_same_diagnosis_gives_same_page(self):
        self.assertEqual(self.page, render_page(make_diagnosis(), self.traces))

    def test_page_of_full_campaign_is_small(self):
        traces = [make_trace(f"run{i}", samples=12000) for i in range(6)]
        page = render_page(self.diagnosis, traces)
        self.assertLess(len(page.encode()), 3_000_000)
        self.assertIn("2 further validation runs are", page)

    def test_hostile_names_are_shown_and_do_nothing(self):
        hostile = "<script>alert('x')</script>"
        diagnosis = make_diagnosis()
        diagnosis["subject_name"] = hostile
        diagnosis["campaign"] = f'"{hostile}'
        diagnosis["verdict"]["sentence"] = f"${hostile}"
        diagnosis["where"]["phases"][0]["phase"] = r"$\frac{$ & <b>"
        diagnosis["where"]["channels"][0]["channel"] = "$x^_N\x00"
        diagnosis["receipt"]["note"] = hostile
        trace = make_trace(f"$\\bad{{ {hostile}")
        page, parsed = self.check_whole(diagnosis, [trace])
        self.assertNotIn("<script", page)
        self.assertIn(hostile, "".join(parsed.text))

    def test_page_works_with_any_part_missing_or_none(self):
        self.use_hollow_figures()
        for key in make_diagnosis():
            diagnosis = make_diagnosis()
            del diagnosis[key]
            with self.subTest(missing=key):
                self.check_whole(diagnosis)
        with self.subTest("every part none"):
            self.check_whole(dict.fromkeys(make_diagnosis()))
        with self.subTest("nothing at all"):
            self.check_whole({})

    def test_page_works_with_inner_keys_missing(self):
        self.use_hollow_figures()
        keys = set()

        def collect(value):
            for inner in value.values() if isinstance(value, dict) else value:
                if isinstance(inner, dict | list):
                    collect(inner)
            if isinstance(value, dict):
                keys.update(value)

        collect(make_diagnosis())
        # Five at a time, as each page takes a while.
        ordered = sorted(keys - set(make_diagnosis()))
        for i in range(0, len(ordered), 5):
            some = set(ordered[i : i + 5])
            with self.subTest(keys=some):
                self.check_whole(strip(make_diagnosis(), some))

    def test_page_works_with_numbers_that_are_none_nan_or_infinite(self):
        for value in (1e300, None, math.nan, math.inf, 0.0, -1.0):
            with self.subTest(value=value):
                self.check_whole(replace_numbers(make_diagnosis(), value))
            # The first, the worst to lay out, is drawn in earnest.
            self.use_hollow_figures()

    def test_page_works_without_gap(self):
        diagnosis = make_diagnosis()
        diagnosis["verdict"].update(
            gap=False, effects=[], blocks=[], sentence="There is no gap."
        )
        diagnosis["causes"], diagnosis["shrink"] = [], None
        for row in diagnosis["where"]["channels"]:
            row["after"] = None
        trace = make_trace(with_after=False)
        page, _ = self.check_whole(diagnosis, [trace])
        self.assertIn("No gap", page)
        self.assertNotIn('<article class="card', page)

    def test_page_without_validation_runs_says_so(self):
        trace = make_trace("push", split="fit")
        page, _ = self.check_whole(make_diagnosis(), [trace])
        self.assertIn("no traces of validation runs", page)
        self.assertIn("Run push", page)

    def test_page_works_for_leg_bench(self):
        channels = ("force_command_N", "position_m")
        trace = make_trace("drive", channels)
        diagnosis = make_diagnosis()
        diagnosis["device"] = "leg bench"
        page, _ = self.check_whole(diagnosis, [trace])
        self.assertIn("Run drive", page)

    def test_page_works_for_broken_traces(self):
        hollow = make_trace("hollow")
        hollow.before[:] = np.nan
        gone = make_trace("gone")
        gone.measured[100:300] = np.nan
        dead = make_trace("dead")
        dead.floor_rms[:] = 0.0
        empty = make_trace("empty", samples=0)
        single = make_trace("single", samples=1)
        for trace in (hollow, gone, dead, empty, single):
            with self.subTest(run=trace.name):
                self.check_whole({}, [trace])

    def test_card_of_unknown_effect_is_only_its_name(self):
        self.use_hollow_figures()
        diagnosis = make_diagnosis()
        diagnosis["verdict"]["effects"] = ["gremlins"]
        page, _ = self.check_whole(diagnosis)
        self.assertIn("no card of this effect", page)

    def test_rival_is_the_runner_up(self):
        self.use_hollow_figures()
        diagnosis = make_diagnosis()
        diagnosis["verdict"]["effects"] = ["coulomb_friction"]
        diagnosis["verdict"]["ambiguous_with"] = ["viscous_leg"]
        page, _ = self.check_whole(diagnosis)
        self.assertIn("a rival here", page)
        self.assertEqual(page.count('<article class="card'), 2)

    def test_runner_up_is_what_the_verdict_does_not_contain(self):
        diagnosis = make_diagnosis()
        verdict = diagnosis["verdict"]
        diagnosis["causes"] = [
            {"effect": name} for name in ("relaxation+hardening", "force_bias")
        ]
        names = [c["name"] for c in make_cards(diagnosis, verdict)]
        self.assertEqual(names, ["relaxation", "force_bias"])
        verdict["effects"] = ["coulomb_friction", "force_scale"]
        verdict["ambiguous_with"] = ["viscous_leg+force_scale"]
        names = [c["name"] for c in make_cards(diagnosis, verdict)]
        self.assertEqual(names, [*verdict["effects"], "viscous_leg"])
        verdict["effects"], verdict["ambiguous_with"] = [], []
        roles = {c["role"] for c in make_cards(diagnosis, verdict)}
        self.assertEqual(roles, {"nearest in the library"})

    def test_an_error_is_told_with_its_interval(self):
        view = make_view(make_diagnosis(), [])["how_far"]["therapist"]
        self.assertEqual(
            [row["interval"] for row in view], ["0.061 to 0.083", ""]
        )

    def test_what_is_left_is_told_with_the_motion_it_goes_with(self):
        self.use_hollow_figures()
        diagnosis = make_diagnosis()
        row = {
            "channel": "ring2_force_y_N",
            "normalised_rms": 2.5,
            "share_of_rest": 1.0,
            "shape": "size of the speed",
            "acts_like": "a damper that is not the same in both directions",
            "takes": 0.74,
            "lower95": 0.69,
            "upper95": 0.79,
        }
        unknown = {**row, "shape": None, "acts_like": None}
        diagnosis["left"] = [row, unknown]
        page, _ = self.check_whole(diagnosis)
        self.assertIn("not the same in both directions", page)
        self.assertIn("69 to 79 %", page)
        self.assertIn("nothing simple of the motion", page)

    def test_what_was_fitted_on_the_validation_runs_is_said(self):
        self.use_hollow_figures()
        diagnosis = make_diagnosis()
        for name, words in (
            ("relaxation", "on which nothing was fitted"),
            ("breathing", "only what each run has of its own was fitted"),
            ("unheard_of", "on which nothing was fitted"),
        ):
            diagnosis["verdict"]["effects"] = [name]
            self.assertIn(words, self.check_whole(diagnosis)[0])

    def test_every_effect_and_every_form_of_one_has_its_card(self):
        for key, effect in all_effects().items():
            for told in (key, effect.name):
                card = make_card(told, "verdict", {})
                self.assertTrue(card["known"], told)
                self.assertEqual(card["block"], effect.block)
            self.assertEqual(
                make_card(key, "verdict", {})["equation"], effect.equation
            )

    def test_of_two_forms_the_one_that_was_found_is_the_verdict(self):
        diagnosis = make_diagnosis()
        verdict = diagnosis["verdict"]
        verdict["effects"], verdict["ambiguous_with"] = ["backlash"], []
        diagnosis["causes"] = [
            {"effect": "backlash (play)", "chosen": False},
            {"effect": "backlash (gap)", "chosen": True},
            {"effect": "force_lag", "chosen": False},
        ]
        cards = make_cards(diagnosis, verdict)
        self.assertEqual(
            [(c["name"], c["role"]) for c in cards],
            [("backlash (gap)", "verdict"), ("force_lag", "runner-up")],
        )
        chosen = [
            r["chosen"] for r in make_view(diagnosis, [])["which"]["causes"]
        ]
        self.assertEqual(chosen, [False, True, False])

    def test_what_a_cause_leaves_on_new_runs_is_shown_where_it_is_known(self):
        diagnosis = make_diagnosis()
        first, second = diagnosis["causes"][:2]
        first["validation"] = {"gap": 1.234, "lower95": 1.1, "upper95": 1.377}
        second["validation"] = None
        told = [
            row["validation"]
            for row in make_view(diagnosis, [])["which"]["causes"][:2]
        ]
        self.assertEqual(told[0], {"gap": "1.23", "interval": "1.10 to 1.38"})
        self.assertEqual(told[1], {"gap": "–", "interval": ""})
        self.assertIn("1.10 to 1.38", render_page(diagnosis, []))

    def test_diagnosis_is_left_as_it_was(self):
        diagnosis = make_diagnosis()
        kept = copy.deepcopy(diagnosis)
        render_page(diagnosis, self.traces[:1])
        self.assertEqual(diagnosis, kept)


class OpenTest(unittest.TestCase):
    """What the page says to be open does not contradict its verdict."""

    def make_notes(self, **explained):
        diagnosis = make_diagnosis()
        diagnosis["verdict"]["effects"] = ["clearance", "viscous_leg"]
        diagnosis["causes"] = [
            {"effect": name, "converged": False, "explained": value}
            for name, value in explained.items()
        ]
        return make_view(diagnosis, [])["notes"]

    def test_the_next_run_says_how_far_it_sets_explanations_apart(self):
        diagnosis = make_diagnosis()
        diagnosis["next_experiment"] |= {
            "file": "next_run.csv",
            "pairs": [
                {"effects": ["hysteresis", "relaxation"], "separation": 144.0}
            ],
        }
        text = " ".join(parse(render_page(diagnosis, [])).text)
        self.assertRegex(text, r"hysteresis\s+,\s+relaxation\s*: 12\b")
        self.assertIn("next_run.csv", text)

    def test_with_nothing_added_there_is_no_after(self):
        diagnosis = make_diagnosis()
        diagnosis["verdict"] |= {"effects": [], "outside_library": True}
        shrink = diagnosis["shrink"]
        shrink |= {"after": shrink["before"], "closed": None}
        shrink["closed_interval"] = None
        for row in shrink["channels"]:
            row |= {"after": row["before"], "closed": None}
        view = make_view(diagnosis, [])["how_far"]
        self.assertEqual({r["after"] for r in view["channels"]}, {"–"})
        text = "".join(parse(render_page(diagnosis, [])).text)
        self.assertIn("Nothing was added to the twin", text)
        self.assertNotIn("of the excess closed", text)

    def test_a_part_of_the_verdict_is_not_open(self):
        notes = self.make_notes(clearance=0.8, viscous_leg=0.2)
        self.assertEqual((notes["unconverged"], notes["left_early"]), ([], []))

    def test_only_what_takes_most_of_the_gap_is_not_ruled_out(self):
        notes = self.make_notes(
            hardening=0.76, coulomb_friction=0.74, force_bias=None
        )
        self.assertEqual(notes["unconverged"], ["hardening", "force_bias"])
        self.assertEqual(notes["left_early"], ["coulomb_friction"])

    def test_what_the_probability_was_calibrated_on_is_said(self):
        text = "".join(parse(render_page(make_diagnosis(), [])).text)
        self.assertIn("calibrated on simulated blind cases", text)

    def test_parameters_that_are_drawn_alike_are_one_line_of_a_card(self):
        card = make_card("anchor_error", "runner-up", {})
        self.assertEqual(len(card["parameters"]), 1)
        self.assertIn("of 36", card["parameters"][0][1])


class WriteTest(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))

    def test_report_replaces_the_old_one_and_leaves_no_draft(self):
        path = self.folder / "new" / "report.html"
        WriteReport({}, [], path)
        path.write_text("old")
        WriteReport(make_diagnosis(), [], path)
        self.assertIn("open03_relaxation", path.read_text("utf-8"))
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
                    WriteReport({}, [], path)
                message = str(caught.exception)
                self.assertIn(str(path), message)
                self.assertIn("cannot be written", message)
                self.assertNotIn("\n", message)
        self.assertEqual(file.read_text(), "kept")
        self.assertEqual(sorted(self.folder.iterdir()), [file, taken])

    def test_trace_of_wrong_shape_is_refused(self):
        whole = make_trace(samples=10)
        with self.assertRaisesRegex(OutputError, "before has shape"):
            RunTrace(
                **{**whole.__dict__, "before": whole.before[:, :2]},
            )
        with self.assertRaisesRegex(OutputError, "floor_rms has shape"):
            RunTrace(**{**whole.__dict__, "floor_rms": whole.floor_rms[:2]})


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
            (0.9999, 1.0004, "99.99 to 100.04 %"),
            (0.0, 3e-5, "within 0.01 % of 0.00 %"),
            (None, 0.1, ""),
        ):
            with self.subTest(shown=shown):
                self.assertEqual(percent_interval(0.5, low, high)[1], shown)

    def test_a_channel_that_was_at_its_floor_has_nothing_to_close(self):
        row = {"before": 1.036, "after": 0.971, "floor": 1.0, "closed": 1.81}
        self.assertEqual(error_row("a", "N", row)["closed"], "–")
        self.assertEqual(
            error_row("a", "N", row | {"before": 1.2})["closed"], "181 %"
        )

    def test_a_choice_is_shown_in_words_and_a_share_without_a_unit(self):
        row = parameter_row({"name": "pad", "unit": "1", "value": 2.0})
        self.assertEqual((row["name"], row["value"]), ("", "pad at -y"))
        row = parameter_row(_parameter("force_scale", "1", 0.031, 0.002))
        self.assertEqual((row["name"], row["unit"]), ("force scale", ""))

    def test_validation_errors_given_over_the_floor_lose_their_unit(self):
        rows = shrink_rows(
            {"channels": [{"channel": "a_N", "unit": "N", "floor": 1.0}]}
        )
        self.assertEqual(rows[0]["unit"], "× floor")


if __name__ == "__main__":
    unittest.main()
