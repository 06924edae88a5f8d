"""Faults put into recordings of the twin, and what a check says of them."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.devices.device import MakeDevice
from brace_drake.effects.registry import find_effect
from brace_drake.recording_faults import (
    all_recording_faults,
    check_recording,
)
from brace_drake.recording_faults.finding import recording_verdict
from brace_drake.recording_faults.relations.hypotheses import Hypothesis
from brace_drake.recording_faults.relations.mismatch import LawChecker
from brace_drake.recording_faults.relations.torso import answer_of
from tests.synthetic_bench import record

FORCE = "ring2_force_y_N"


def spoil(campaign, change, only=lambda run: True):
    """A campaign whose runs have other columns, from a copy of them."""
    runs = []
    for run in campaign.runs:
        columns = {n: v.copy() for n, v in run.channels.items()}
        if only(run):
            columns = change(columns) or columns
        runs.append(replace(run, channels=columns))
    return replace(campaign, runs=tuple(runs))


def is_push(run):
    return run.motion == "push"


class FaultCase(unittest.TestCase):
    """A sound campaign of the twin, and its device.

    Attributes:
        sound, device: Of the twin's own recording.
    """

    @classmethod
    def setUpClass(cls):
        # The device alone is taken from the empty campaign.
        twin = MakeDevice(cls._empty()).twin.coarse()
        cls.subject = np.array([p.nominal for p in twin.subject])
        cls.twin = twin
        cls.sound = record(twin, cls.subject, (), 0)
        cls.device = MakeDevice(cls.sound)

    @staticmethod
    def _empty():
        from pathlib import Path

        from brace_drake.recording.recording import Campaign

        return Campaign(Path("synthetic"), "bench stage 2", 200.0, "", ())

    def found(self, campaign, device=None):
        return check_recording(campaign, device or self.device)

    def assert_named(self, campaign, name, channels=None, device=None):
        """Checks that one fault is found, by name; returns it."""
        found = self.found(campaign, device)
        told = [f.sentence() for f in found]
        self.assertEqual([f.fault.name for f in found], [name], told)
        if channels is not None:
            self.assertEqual(set(found[0].channels), set(channels), told)
        return found[0]


class TestControlLaw(FaultCase):
    def test_a_sound_recording_has_no_fault(self):
        self.assertEqual(self.found(self.sound), [])

    def test_noise_through_the_law_has_a_mean_square_of_one_floor(self):
        # The virtual position integrates noise: it ends elsewhere than it
        # began, which is no jump.
        checker = LawChecker(self.device, self.sound.runs, seed=0)
        others = LawChecker(self.device, self.sound.runs, seed=7)
        for run in self.sound.runs:
            for noisy in others.replays(run):
                squares = checker.judge(noisy).squares
                self.assertTrue(np.all(squares > 0.6), squares)
                self.assertTrue(np.all(squares < 1.3), squares)

    def test_effects_of_the_machine_are_no_faults(self):
        for name in ("force_scale", "encoder_offset", "command_delay"):
            card = find_effect(name)
            values = card.starts()[0].astype(float)
            campaign = record(self.twin, self.subject, [(card, values)], 1)
            with self.subTest(name):
                self.assertEqual(self.found(campaign), [])

    def test_exchanged_lengths_are_named(self):
        a, b = "leg2_length_m", "leg3_length_m"

        def change(columns):
            columns[a], columns[b] = columns[b], columns[a]

        found = self.assert_named(
            spoil(self.sound, change), "exchanged_channels", (a, b)
        )
        self.assertTrue(found.of_all)
        self.assertGreater(found.probability, 0.9)
        self.assertIn(
            "leg 2 and leg 3 lengths exchanged in all runs", found.sentence()
        )

    def test_a_command_in_kgf_is_named_with_its_scale(self):
        name = "leg4_force_command_N"

        def change(columns):
            columns[name] = columns[name] / 9.80665

        found = self.assert_named(
            spoil(self.sound, change), "wrong_scale", (name,)
        )
        scale = found.parameters["scale"]
        self.assertAlmostEqual(scale, 1.0 / 9.80665, delta=2e-3)

    def test_a_force_of_the_wrong_sign_is_named_without_virtual_position(self):
        def change(columns):
            columns[FORCE] = -columns[FORCE]
            del columns["ring2_y_virtual_m"]

        self.assert_named(spoil(self.sound, change), "reversed_sign", (FORCE,))

    def test_forces_doubled_in_one_run_are_named_there(self):
        def change(columns):
            columns[FORCE] = 2.0 * columns[FORCE]

        found = self.assert_named(
            spoil(self.sound, change, is_push), "wrong_scale", (FORCE,)
        )
        self.assertEqual(found.runs, ("push.csv",))
        self.assertAlmostEqual(found.parameters["scale"], 2.0, delta=0.02)

    def test_a_late_force_is_named_with_its_delay(self):
        late = 10

        def change(columns):
            force = columns[FORCE]
            columns[FORCE] = np.concatenate([force[:late], force[:-late]])

        found = self.assert_named(
            spoil(self.sound, change), "skewed_channel", (FORCE,)
        )
        self.assertAlmostEqual(found.parameters["delay_s"], 0.05, delta=0.005)

    def test_a_force_by_a_fast_clock_is_named_with_its_rate(self):
        def change(columns):
            time = columns["time_s"]
            columns[FORCE] = np.interp(1.007 * time, time, columns[FORCE])

        found = self.assert_named(
            spoil(self.sound, change), "own_clock", (FORCE,)
        )
        self.assertAlmostEqual(found.parameters["rate"], 0.007, delta=5e-4)

    def test_a_zero_that_moved_in_a_run_without_force_is_named(self):
        def change(columns):
            columns[FORCE] = 0.5 + 0.02 * rng.standard_normal(
                len(columns[FORCE])
            )

        rng = np.random.default_rng(8)
        free = next(r for r in self.sound.runs if not r.contact)
        bad = spoil(self.sound, change, lambda run: run.file == free.file)
        found = self.assert_named(bad, "moved_zero", (FORCE,))
        self.assertAlmostEqual(found.parameters["offset"], 0.5, delta=0.02)

    def test_a_coarse_length_is_no_fault_where_the_ring_stands(self):
        def change(columns):
            columns["leg1_length_m"] = np.round(columns["leg1_length_m"], 4)

        self.assertEqual(self.found(spoil(self.sound, change)), [])

    def test_columns_that_no_device_declares_are_not_looked_at(self):
        def change(columns):
            columns["note"] = np.array(["x"] * len(columns[FORCE]))
            columns["temp_C"] = np.full(len(columns[FORCE]), np.nan)

        self.assertEqual(self.found(spoil(self.sound, change)), [])

        def stick(columns):
            change(columns)
            columns["torso_y_m"][500:1700] = columns["torso_y_m"][500]

        bad = spoil(self.sound, stick, is_push)
        self.assert_named(bad, "stuck_channel", ("torso_y_m",))

    def test_a_fault_that_has_no_name_is_a_warning(self):
        noise = np.random.default_rng(3)

        def change(columns):
            size = len(columns[FORCE])
            columns["leg1_force_command_N"] += np.cumsum(
                0.05 * noise.standard_normal(size)
            )

        found = self.found(spoil(self.sound, change, is_push))
        self.assertEqual([f.fault.name for f in found], ["contradiction"])
        self.assertEqual(found[0].severity, "warning")


class TestTorso(FaultCase):
    def test_a_marker_in_inches_is_named(self):
        name = "torso_y_m"

        def change(columns):
            columns[name] = columns[name] / 0.254

        found = self.assert_named(
            spoil(self.sound, change), "wrong_scale", (name,)
        )
        self.assertAlmostEqual(found.parameters["scale"], 3.94, delta=1.0)

    def test_a_marker_that_stands_still_is_stiff_without_end(self):
        run = next(r for r in self.sound.runs if is_push(r))
        law = self.device.torso_law
        # Some of them are rounded when they are averaged.
        for value in (0.0, -0.007054, 0.1, 1.0 / 3.0, *np.arange(1, 9) * 1e-3):
            still = np.full(len(run.time_s), value)
            columns = {**run.channels, law.marker: still}
            with self.subTest(value=value):
                found = answer_of(
                    replace(run, channels=columns), law, law.marker, 200.0
                )
                self.assertEqual(found, (np.inf, 0.0))

    def test_a_marker_of_noise_alone_is_told_where_it_is_pushed(self):
        def change(columns):
            noise = rng.standard_normal(len(columns["torso_y_m"]))
            columns["torso_y_m"] = 5e-5 * noise

        rng = np.random.default_rng(9)
        found = self.found(spoil(self.sound, change, lambda run: run.contact))
        told = [f for f in found if f.channels == ("torso_y_m",)]
        self.assertTrue(told)
        for finding in told:
            self.assertEqual(finding.fault.name, "contradiction")
            self.assertIn("noise alone", finding.detail)

    def test_exchanged_axes_of_the_marker_are_named(self):
        a, b = "torso_x_m", "torso_y_m"

        def change(columns):
            columns[a], columns[b] = columns[b], columns[a]

        self.assert_named(
            spoil(self.sound, change, lambda run: run.contact),
            "exchanged_channels",
            (a, b),
        )

    def test_a_free_run_called_contact_is_named(self):
        runs = [replace(r, contact=True) for r in self.sound.runs]
        found = self.assert_named(
            replace(self.sound, runs=tuple(runs)), "wrong_contact"
        )
        self.assertEqual(found.runs, ("free.csv",))

    def test_a_push_called_free_is_named(self):
        runs = [
            replace(r, contact=r.contact and not is_push(r))
            for r in self.sound.runs
        ]
        found = self.assert_named(
            replace(self.sound, runs=tuple(runs)), "wrong_contact"
        )
        self.assertEqual(found.runs, ("push.csv",))


class TestCards(FaultCase):
    def test_undoing_a_fault_gives_the_truth_back(self):
        run = self.sound.runs[1]
        a, b = "leg1_length_m", "leg2_length_m"
        x = run.channels[a]
        faults = {
            "exchanged_channels": ({a: run.channels[b], b: x}, (a, b), {}),
            "reversed_sign": ({a: 0.3 - x}, (a,), {"zero": 0.15}),
            "wrong_scale": ({a: 5.0 * x}, (a,), {"scale": 5.0}),
            "moved_zero": ({a: x + 0.01}, (a,), {"offset": 0.01}),
        }
        for name, (columns, channels, values) in faults.items():
            spoiled = replace(run, channels={**run.channels, **columns})
            card = all_recording_faults()[name]
            undone = Hypothesis(card, channels, values).undone(spoiled)
            with self.subTest(name):
                np.testing.assert_allclose(undone.channels[a], x, atol=1e-12)

    def test_every_card_says_what_to_do(self):
        for name, card in all_recording_faults().items():
            with self.subTest(name):
                self.assertTrue(card.remedy and card.signature and card.title)

    def test_a_certain_fault_is_neither_no_gap_nor_outside(self):
        def change(columns):
            columns["leg3_length_m"][:] = 0.14

        found = self.found(spoil(self.sound, change, is_push))
        verdict = recording_verdict(found)
        self.assertTrue(verdict["gap"])
        self.assertFalse(verdict["outside_library"])
        self.assertEqual(verdict["recording"][0]["fault"], "stuck_channel")
        self.assertEqual(verdict["recording"][0]["run"], "push.csv")
        self.assertIn("The recording, not the machine", verdict["sentence"])
        # Of a verdict on the machine nothing is left beside it.
        self.assertEqual(verdict["supported"], [])
        self.assertEqual(verdict["unexplained"]["share"], 0.0)
        self.assertIsNone(verdict["confirmed"])
        self.assertIsNone(verdict["contradicted"])

    def test_without_a_fault_the_verdict_is_left_alone(self):
        self.assertEqual(recording_verdict([]), {"recording": []})


if __name__ == "__main__":
    unittest.main()
