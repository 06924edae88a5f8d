"""Plans: signatures against closed forms, and the library's alike pairs."""

import json
import tempfile
import unittest
from itertools import combinations
from pathlib import Path

import numpy as np

from brace_drake.cli.diagnosis.plan import format_plan
from brace_drake.core.errors import CampaignError
from brace_drake.core.resources import scenario_path
from brace_drake.design.confusable import ALIKE, reason_of
from brace_drake.design.plan import plan_campaign, standard_errors
from brace_drake.design.signature import size_of_one_floor, sizes_of
from brace_drake.devices.subject import SubjectParameter
from brace_drake.devices.twin import ReplayTwin
from brace_drake.effects.card import Effect, EffectParameter
from brace_drake.effects.registry import all_effects, effects_for, find_effect
from brace_drake.recording.recording import Run
from tests.commands import run_command

RATE, SIGMA = 200.0, 0.1
TIME = np.arange(400) / RATE
# Whole periods about the middles of samples: each is one frequency of the
# cosine transform, orthogonal to the others, and of mean square 1 / 2.
WAVES = {
    n: np.cos(2.0 * np.pi * n * (TIME + 0.5 / RATE)) for n in (1, 2, 3, 4, 5)
}


def card(name, *names, upper=1e6):
    parameters = tuple(
        EffectParameter(n, "1", 0.0, upper, (1.0,), n) for n in names
    )
    return Effect(
        name,
        "contact",
        name,
        "",
        "",
        parameters,
        "",
        {"first": "by its sound"} if name == "twin" else {},
        "a run",
        modify=lambda numbers, values: numbers,
    )


# What each parameter adds to the recording.
SHAPES = {
    "first": [WAVES[1]],
    "twin": [2.0 * WAVES[1]],
    "other": [WAVES[2]],
    "half": [WAVES[1] + np.sqrt(3.0) * WAVES[2]],
    "absorbed": [WAVES[4]],
    "leaning": [WAVES[3] + WAVES[4]],
    "double": [WAVES[5], 2.0 * WAVES[5]],
}
CARDS = {
    name: card(name, *(f"p{i}" for i in range(len(shapes))))
    for name, shapes in SHAPES.items()
}


class LinearTwin(ReplayTwin):
    """y = phi w_4 + sum of p_i shapes_i, read with white noise."""

    channels, device, carried = ("y",), "toy", ()
    subject = (
        SubjectParameter("phi", "1", 1.0, -1e9, 1e9),
        SubjectParameter("unseen", "1", 1.0, 0.0, 2.0),
    )

    def __init__(self):
        """It has no scenario."""

    def scenario_of(self, subject):
        return None

    def with_subject(self, values):
        return None

    def _replay(self, numbers, motion, subject, uses, generator):
        raise NotImplementedError

    def coarse(self):
        return self

    def finer(self):
        return self

    def motion(self, run):
        return None

    def active(self, run):
        return np.array([True])

    def simulate(self, motion, subject, uses=(), generator=None):
        y = subject[0] * WAVES[4]
        for effect, values in uses:
            for p, shape in zip(values, SHAPES[effect.name], strict=True):
                y = y + p * shape
        if generator is not None:
            y = y + SIGMA * generator.standard_normal(len(y))
        return y[:, None]


def plan_toy(*names):
    run = Run("r.csv", True, "toy", None, "fit", {"time_s": TIME})
    cards = [CARDS[name] for name in names]
    return plan_campaign(LinearTwin(), [run], RATE, cards, jobs=1)


class TestLinearTwin(unittest.TestCase):
    def test_identical_signatures_have_cosine_one_and_are_listed(self):
        plan = plan_toy("first", "twin", "other")
        cosines = np.array(plan["cosines"])
        np.testing.assert_allclose(np.diag(cosines), 1.0)
        self.assertAlmostEqual(cosines[0, 1], 1.0)
        # Waves lie in different bins of the spectrum.
        self.assertAlmostEqual(cosines[0, 2], 0.0)
        (pair,) = plan["pairs"]
        self.assertEqual(pair["effects"], ["first", "twin"])
        self.assertIn("by its sound", pair["reason"])

    def test_an_angle_of_sixty_degrees_is_found(self):
        plan = plan_toy("first", "half")
        # Up to the noise of the floor, which weighs the two waves.
        self.assertAlmostEqual(plan["cosines"][0][1], 0.5, delta=0.15)
        self.assertEqual(plan["pairs"], [])

    def test_the_size_makes_a_gap_of_one_floor(self):
        (row,) = plan_toy("first")["effects"]
        # Half of the values count, those up to 50 Hz of 100, and p^2 / 2 is
        # all in them: the mean square in floors is p^2 / sigma^2. The floor of
        # a band of one bin comes from twelve draws: one part in seven.
        self.assertAlmostEqual(row["gap_floors"], 1.0, delta=0.25)
        expected = row["gap_floors"] * SIGMA
        self.assertAlmostEqual(row["size"] / expected, 1.0, delta=0.4)
        norm = row["norm_per_unit"]
        self.assertAlmostEqual(norm, row["norm"] / row["size"])
        # |p w_1| / sigma = p sqrt(N / 2) / sigma.
        expected = np.sqrt(len(TIME) / 2) / SIGMA
        self.assertAlmostEqual(norm / expected, 1.0, delta=0.4)
        self.assertAlmostEqual(row["least_size"] * norm, 5.0)

    def test_the_subject_takes_up_its_part(self):
        plan = plan_toy("absorbed", "leaning", "first")
        gone, leaning, first = plan["effects"]
        self.assertLess(gone["norm"], 1e-3)
        self.assertIsNone(gone["least_size"])
        self.assertEqual(plan["unseen"], ["absorbed"])
        per_unit = leaning["norm_per_unit"] / first["norm_per_unit"]
        self.assertAlmostEqual(per_unit, 1.0, delta=0.4)

    def test_what_the_runs_do_not_determine_is_named(self):
        rows = plan_toy("double", "other")["undetermined"]
        named = {(r["of"], r["parameter"]) for r in rows}
        self.assertEqual(
            named, {("subject", "unseen"), ("double", "p0"), ("double", "p1")}
        )
        (unseen,) = (r for r in rows if r["of"] == "subject")
        self.assertIsNone(unseen["standard_error"])

    def test_a_plan_of_nothing_is_refused(self):
        with self.assertRaisesRegex(CampaignError, "one motion at least"):
            plan_campaign(LinearTwin(), [], RATE, [])

    def test_the_plan_is_printed_with_pairs_and_doubts(self):
        text = format_plan(plan_toy("first", "twin", "double"))
        self.assertIn("not told apart: first and twin (|cos| 1.000)", text)
        self.assertIn("not determined: unseen of subject", text)


class TestParts(unittest.TestCase):
    def test_the_size_is_found_for_powers_and_thresholds(self):
        laws = {
            "linear": lambda s: 7.0 * s,
            "cubic": lambda s: 1e-6 * s**3,
            "threshold": lambda s: max(0.0, 300.0 * (s - 0.9)),
        }
        for name, law in laws.items():
            with self.subTest(law=name):
                found = law(size_of_one_floor(law, 1e6))
                self.assertGreater(found, 0.5)
                self.assertLess(found, 2.0)
        self.assertEqual(size_of_one_floor(lambda s: 1e-3 * s, 2.0), 2.0)
        broken = size_of_one_floor(lambda s: np.inf if s > 0.1 else 2 * s, 9.0)
        self.assertLessEqual(broken, 0.1)

    def test_standard_errors_are_those_of_the_normal_equations(self):
        columns = np.random.default_rng(2).standard_normal((50, 3))
        columns[:, 1] *= 1e6
        expected = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))
        np.testing.assert_allclose(standard_errors(columns), expected)
        columns[:, 2] = 0.0
        self.assertTrue(np.isinf(standard_errors(columns)[2]))

    def test_size_one_is_where_searches_start_and_zero_no_effect(self):
        for key in ("coulomb_friction", "relaxation", "weak_leg", "saturation"):
            effect = find_effect(key)
            at, off = sizes_of(effect), effect.off()
            with self.subTest(effect=key):
                lead = 1 if key == "weak_leg" else 0
                self.assertEqual(at(0.0)[lead], off[lead])
                self.assertIn(at(1.0)[lead], effect.parameters[lead].starts)


class TestLibrary(unittest.TestCase):
    """The alike pairs of the library on three motions."""

    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            cls.code, cls.text, _ = run_command(
                *("plan", "--motions", "free_reversal,stairs,multisine"),
                *("--out", folder),
            )
            cls.plan = json.loads((Path(folder) / "plan.json").read_text())

    def cosine(self, first, second):
        """The largest |cos| over the forms of two effects, of which none has
        the other in it.
        """
        forms = [find_effect(r["effect"]) for r in self.plan["effects"]]
        return max(
            self.plan["cosines"][i][j]
            for i, a in enumerate(forms)
            for j, b in enumerate(forms)
            if (a.name, b.name) == (first, second)
            and a.name not in b.contains
            and b.name not in a.contains
        )

    def test_every_effect_is_in_the_plan_and_can_be_seen(self):
        self.assertEqual(self.code, 0)
        keys = list(effects_for("bench stage 2"))
        self.assertEqual([r["effect"] for r in self.plan["effects"]], keys)
        for row in self.plan["effects"]:
            with self.subTest(effect=row["effect"]):
                self.assertGreater(row["norm"], 50.0)

    def test_alike_pairs_are_those_that_are_listed(self):
        names = dict.fromkeys(
            r["effect"].split(" (")[0] for r in self.plan["effects"]
        )
        for first, second in combinations(names, 2):
            cosine = self.cosine(first, second)
            with self.subTest(first=first, second=second, cosine=cosine):
                # Three motions only: hysteresis and a drift of the posture
                # come to 0.88, over all motions of a campaign to 0.50.
                if frozenset((first, second)) in ALIKE:
                    self.assertGreater(cosine, 0.65)
                else:
                    self.assertLess(cosine, 0.9)

    def test_listed_pairs_name_effects_of_the_library(self):
        names = {e.name for e in all_effects().values()}
        for pair, reason in ALIKE.items():
            self.assertLessEqual(pair, names)
            first, second = (find_effect(name) for name in pair)
            self.assertEqual(reason_of(first, second), reason)

    def test_an_effect_that_has_another_in_it_says_so(self):
        for effect in all_effects().values():
            for name in effect.contains:
                reason = reason_of(effect, find_effect(name))
                self.assertIn(f"{name} is a part of", reason)
                self.assertEqual(reason, reason_of(find_effect(name), effect))

    def test_a_hold_without_torso_cannot_tell_gain_from_mass(self):
        # Either changes the force that carries the ring, and nothing else.
        with tempfile.TemporaryDirectory() as folder:
            words = ["--effects", "force_gain,ring_mass,relaxation"]
            _, said, _ = run_command(
                "plan", "--motions", "free_hold", "--out", folder, *words
            )
            plan = json.loads((Path(folder) / "plan.json").read_text())
        (pair,) = plan["pairs"]
        self.assertEqual(pair["effects"], ["force_gain", "ring_mass"])
        self.assertGreater(pair["cosine"], 0.99)
        self.assertEqual(plan["unseen"], ["relaxation"])
        named = {r["parameter"] for r in plan["undetermined"]}
        self.assertIn("contact_stiffness_N_m", named)
        self.assertIn("a deep push", said)

    def test_the_table_names_every_effect(self):
        for row in self.plan["effects"]:
            self.assertIn(row["effect"], self.text)


class TestCommand(unittest.TestCase):
    def test_problems_are_told_in_one_line(self):
        leg = str(scenario_path("leg_bench.scenario.yaml"))
        cases = {
            ("--motions", "psh"): "did you mean push",
            ("--references", "/none"): "no reference",
            ("--effects", "couloumb"): "coulomb_friction",
            ("--scenario", leg): "this is a 'leg bench'",
        }
        for words, part in cases.items():
            with self.subTest(words=words):
                status, _, error = run_command("plan", *words)
                self.assertEqual(status, 2)
                self.assertEqual(error.count("\n"), 1)
                self.assertIn(part, error)


if __name__ == "__main__":
    unittest.main()
