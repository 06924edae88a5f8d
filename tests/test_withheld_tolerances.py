"""Withheld cases of machines that are off within their tolerances."""

import json
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

from brace_drake.withheld.cases import build_case, draw_faults
from brace_drake.withheld.faults import FAULTS, OUTSIDE
from brace_drake.withheld.make import make_cases, size_of
from brace_drake.withheld.simulator import Flaws
from brace_drake.withheld.tolerances import ToleranceError, draw_deviations
from tests.commands import run_command

BY_NAME = {fault.name: fault for fault in FAULTS}
# By name: the number that the fault sets, and 8 tolerances of it.
LEAST = {
    "coulomb_friction": ("legs.coulomb", 0.24),
    "stribeck_friction": ("legs.breakaway", 0.24),
    "viscous_leg": ("legs.viscous", 12.0),
    "command_delay": ("legs.delay", 4),
    "ring_mass": ("ring.mass", 0.12),
    "force_bias": ("sensors.bias", 0.16),
    "force_scale": ("sensors.scale", 0.048),
    "encoder_offset": ("sensors.lengths", 4e-4),
    "anchor_error": ("ring.lower", 4e-4),
    "weak_leg": ("legs.gain", 0.03),
    "force_gain": ("legs.gain", 0.03),
}


def make(names, severity="medium", tolerances=1.0, seed=0):
    """A case with these faults."""
    faults = tuple(BY_NAME[name] for name in names)
    kind = ("none", "single", "pair")[len(faults)]
    rng = np.random.default_rng(seed)
    return build_case(
        rng, kind, faults, severity, lambda subject: 8.0, tolerances
    )


class TestDraws(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rng = np.random.default_rng(0)
        # Twice the tolerances; 2000 draws tell a deviation to 1.6 %.
        drawn = [draw_deviations(rng, 2.0).added for _ in range(2000)]
        cls.drawn = {
            name: np.array([one[name] for one in drawn]) for name in drawn[0]
        }

    def test_numbers_deviate_by_their_tolerances(self):
        for name, deviation in (
            ("ring.mass", 0.03),
            ("legs.viscous", 3.0),
            ("legs.coulomb", 0.06),
            ("sensors.scale", 0.012),
            ("sensors.bias", 0.04),
            ("ring.lower", 1e-4),
            ("ring.upper", 1e-4),
        ):
            values = self.drawn[name]
            spread = np.sqrt(np.mean(values**2, axis=0))
            with self.subTest(name=name):
                np.testing.assert_allclose(spread, deviation, rtol=0.08)
                if name != "legs.coulomb":
                    mean = np.abs(np.mean(values, axis=0))
                    self.assertLess(np.max(mean), 0.1 * deviation)

    def test_friction_is_never_negative(self):
        friction = self.drawn["legs.coulomb"]
        self.assertGreaterEqual(np.min(friction), 0.0)
        # The mean of a half normal distribution.
        mean = 0.06 * np.sqrt(2.0 / np.pi)
        self.assertAlmostEqual(np.mean(friction) / mean, 1.0, delta=0.06)

    def test_the_delay_is_a_fair_coins(self):
        self.assertEqual(set(self.drawn["legs.delay"]), {0, 2})
        self.assertAlmostEqual(
            np.mean(self.drawn["legs.delay"] == 2), 0.5, delta=0.04
        )

    def test_each_coordinate_of_each_anchor_has_its_own(self):
        anchors = np.concatenate(
            [self.drawn["ring.lower"], self.drawn["ring.upper"]], axis=1
        )
        related = np.corrcoef(anchors.reshape(2000, 36).T) - np.eye(36)
        self.assertLess(np.max(np.abs(related)), 0.12)

    def test_without_tolerances_nothing_is_drawn(self):
        rng = np.random.default_rng(0)
        self.assertEqual(draw_deviations(rng, 0.0).added, {})
        untouched = np.random.default_rng(0)
        self.assertEqual(rng.integers(10**9), untouched.integers(10**9))


class TestCase(unittest.TestCase):
    def test_without_tolerances_cases_are_those_of_ever(self):
        rng = np.random.default_rng(0)
        faults, severity = draw_faults(rng, "pair")
        case = build_case(rng, "pair", faults, severity, lambda _: 8.0)
        # As drawn before there were tolerances.
        self.assertEqual(severity, "large")
        gap = 0.001536956143405813
        self.assertEqual(
            case.truth()["parameters"],
            {
                "hardening": {"pads.cubic": 2836294556.120028},
                "clearance": {"pads.gap": [gap, gap]},
            },
        )
        self.assertNotIn("within_tolerances", case.truth())
        self.assertEqual(case.subject.stiffness, 4689.784442553317)
        self.assertEqual(case.flaws.ring.leg_mass, 0.021744999658616915)
        self.assertEqual(case.machine, case.background)
        self.assertEqual(rng.integers(10**9), 48546489)

    def test_the_label_holds_what_the_machine_is_off(self):
        case = make([])
        machine, background = case.machine, case.background
        told = case.truth()["within_tolerances"]
        json.dumps(told, allow_nan=False)
        expected = {
            "leg_viscous_N_s_m": machine.legs.viscous,
            "ring_mass_kg": machine.ring.mass,
            "force_scale": machine.sensors.scale,
            "force_bias_N": machine.sensors.bias,
            "leg_dry_friction_N": machine.legs.coulomb,
            "command_delay_s": machine.legs.delay * 1e-3,
            "anchor_spread_m": 5e-5,
        }
        self.assertEqual(told, expected)
        self.assertIsInstance(machine.legs.delay, int)
        moved = np.subtract(machine.ring.lower, background.ring.lower)
        self.assertAlmostEqual(np.std(moved) / 5e-5, 1.0, delta=0.5)
        # The rest of the machine is what it was.
        self.assertEqual(machine.ring.leg_mass, background.ring.leg_mass)
        self.assertEqual(machine.torso, background.torso)
        self.assertEqual(machine.pads, background.pads)

    def test_a_fault_adds_to_what_the_machine_is_off(self):
        for name, (number, _) in LEAST.items():
            case = make([name], seed=3)
            part, field = number.split(".")
            found = getattr(getattr(case.flaws, part), field)
            set_to = case.changes[name][number]
            off = case.off.added.get(number, 0.0)
            with self.subTest(fault=name):
                np.testing.assert_allclose(
                    found, np.add(set_to, off), rtol=1e-12
                )

    def test_stribeck_friction_slides_with_the_friction_of_both(self):
        case = make(["stribeck_friction"], "large")
        fault = case.changes["stribeck_friction"]
        told = case.truth()["within_tolerances"]["leg_dry_friction_N"]
        legs = case.flaws.legs
        self.assertEqual(legs.coulomb, fault["legs.coulomb"] + told)
        self.assertEqual(legs.breakaway, fault["legs.breakaway"])

    def test_without_a_fault_a_machine_is_off_as_before(self):
        case = make(["viscous_leg", "force_bias"])
        viscous, bias = case.faults
        off = case.off.added
        left = case.without(viscous)
        self.assertEqual(left.legs.viscous, off["legs.viscous"])
        self.assertEqual(left.sensors, case.flaws.sensors)
        self.assertEqual(case.without(bias).sensors, case.machine.sensors)

    def test_sizes_are_measured_on_the_machine_as_it_is(self):
        case = make(["viscous_leg", "force_bias"])
        with mock.patch("brace_drake.withheld.make.measure") as measure:
            size_of(case, [])
        pairs = [call.args[2:4] for call in measure.call_args_list]
        self.assertEqual(
            pairs,
            [
                (Flaws(), case.background),
                (case.machine, case.flaws),
                *((case.without(f), case.flaws) for f in case.faults),
            ],
        )
        self.assertNotEqual(case.machine.legs.viscous, 0.0)


class TestFaults(unittest.TestCase):
    def test_those_with_a_tolerance_are_the_ones_expected(self):
        self.assertEqual(
            {fault.name for fault in FAULTS if fault.tolerance > 0.0},
            set(LEAST),
        )
        self.assertFalse(any(fault.tolerance for fault in OUTSIDE))

    def test_a_fault_lies_far_outside_its_tolerance(self):
        for name, (number, least) in LEAST.items():
            for factor in (1.0, 2.0):
                for severity in ("medium", "large"):
                    sizes = [
                        self.size(make([name], severity, factor, seed), number)
                        for seed in range(20)
                    ]
                    # A spread is told by all draws together, to 4 %.
                    if name == "anchor_error":
                        sizes = [np.sqrt(np.mean(np.square(sizes)))]
                    with self.subTest(name=name, severity=severity):
                        self.assertGreaterEqual(
                            min(sizes), factor * least * (1.0 - 1e-9)
                        )

    @staticmethod
    def size(case, number):
        """How far a case's fault goes from no fault."""
        values = np.asarray(next(iter(case.changes.values()))[number])
        if number == "legs.gain":
            values = 1.0 - values
        if number == "ring.lower":
            return np.std(values)
        return np.max(np.abs(values))

    def test_a_fault_that_is_far_outside_keeps_its_strength(self):
        for name in ("coulomb_friction", "viscous_leg", "force_bias"):
            plain = make([name], "large", 0.0).changes
            self.assertEqual(make([name], "large", 1.0).changes, plain)

    def test_no_fault_is_small(self):
        rng = np.random.default_rng(0)
        for kind in ("single", "pair", "outside"):
            drawn = {draw_faults(rng, kind, 0.5)[1] for _ in range(40)}
            self.assertEqual(drawn, {"medium", "large"})


class TestCommand(unittest.TestCase):
    def run_make(self, *more):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.out = folder / "cases"
        return run_command(
            *("withheld", "make", "--cases", 1, "--out", self.out),
            *("--vault", folder / "vault.json", *more),
        )

    def test_the_factor_is_handed_on(self):
        for more, factor in (
            ((), 0.0),
            (("--tolerances",), 1.0),
            (("--tolerances", 2.5), 2.5),
        ):
            name = "brace_drake.withheld.make.make_cases"
            with mock.patch(name) as made:
                self.assertEqual(self.run_make(*more)[0], 0)
            self.assertEqual(made.call_args.args[-1], factor)

    def test_another_factor_is_refused_in_one_line(self):
        for factor in ("nan", "inf", "-1", "5.1"):
            try:
                status, _, errors = self.run_make("--tolerances", factor)
            except SystemExit as stop:
                # The parser itself refuses what is no number.
                self.assertIn(factor, ("nan", "inf"))
                self.assertEqual(stop.code, 2)
                self.assertFalse(self.out.exists())
                continue
            message = errors[errors.index("brace-drake:") :]
            with self.subTest(factor=factor):
                self.assertEqual(status, 2)
                self.assertIn("tolerances", message)
                self.assertEqual(message.count("\n"), 1)
                self.assertFalse(self.out.exists())
        with self.assertRaises(ToleranceError):
            make_cases(Path("no"), Path("where"), 1, tolerances=-0.1)


if __name__ == "__main__":
    unittest.main()
