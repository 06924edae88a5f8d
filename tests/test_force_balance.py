"""Whose errors the balance of the leg forces shows."""

import unittest
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from brace_drake.devices.bench.ring_way import slope
from brace_drake.devices.device import Bench
from brace_drake.effects.card import Effect
from brace_drake.effects.registry import find_effect
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.isolation.block_tests import run_block_tests
from brace_drake.isolation.force_balance import (
    explain_imbalance,
    suspected_part,
)
from brace_drake.laws.hooks import plug
from tests.synthetic_bench import RATE, SyntheticBench


@plug("ring")
def push_back(t, dt, p_R, r_R, V, F, p, x):
    """A soft stop from a place along y on: stiffness p[0], place p[1]."""
    F[4] += p[0] * max(0.0, p[1] - p_R[1])


STOP = Effect(
    name="soft_stop",
    block="mechanism",
    title="a soft stop",
    equation="F_y = k max(0, y_0 - y)",
    source="this test",
    parameters=(),
    laws={"ring": push_back},
    signature="",
    impostors={},
    experiment="",
)


def cut(channels, count):
    """The first so many samples of every channel."""
    return {name: values[:count] for name, values in channels.items()}


def explained(**shares):
    """Rows as they are told from."""
    return [{"block": b, "explained": share} for b, share in shares.items()]


class TestBalance(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.bench = SyntheticBench()
        campaign = SimpleNamespace(rate_hz=RATE)
        cls.device = Bench(campaign, cls.bench.twin.scenario)

    def rows(self, *uses, keep=slice(None)):
        """Rows of each block, of a recording with effects, of some runs."""
        evaluator = self.bench.evaluator(uses)
        nominal, tests = fit_nominal(evaluator), self.device.block_tests
        rows = run_block_tests(evaluator, tests, nominal, 0)
        drives = {r["block"]: r for r in rows}["actuation"]
        return explain_imbalance(self.device, evaluator.prepared[keep], drives)

    def check(self, rows, block, title, size, off=0.05):
        """Checks block, first error and its size."""
        self.assertEqual(suspected_part(rows), block)
        row = {r["block"]: r for r in rows}[block]
        self.assertGreater(row["explained"], 0.97)
        first = row["errors"][0]
        self.assertEqual(first["title"], title)
        self.assertLess(abs(first["size"] / size - 1.0), off)

    def test_effects_of_the_library_are_found_with_their_size(self):
        for name, values, block, title, size in (
            ("viscous_leg", [40.0], "actuation", "damping of the drives", 40.0),
            ("weak_leg", [3.0, 0.2], "actuation", "gain of leg 3", -0.2),
            ("ring_mass", [0.1], "mechanism", "mass of the ring", 0.1),
            (
                "force_bias",
                [0.4],
                "sensing",
                "offset of the read force y",
                0.4,
            ),
            ("force_lag", [0.03], "sensing", "lag of the read force y", 0.03),
            (
                "force_scale",
                [0.25],
                "sensing",
                "share of the read force that is not there",
                0.2,
            ),
        ):
            with self.subTest(name):
                use = find_effect(name), np.array(values)
                self.check(self.rows(use), block, title, size)

    def test_a_stop_of_the_ring_is_told_from_drives_and_reading(self):
        rows = self.rows((STOP, np.array([400.0, -0.003])))
        title = "force along y where y is below -3.00 mm"
        self.check(rows, "mechanism", title, 400.0)

    def test_runs_of_one_kind_are_enough_for_what_shows_in_them(self):
        use = find_effect("viscous_leg"), np.array([40.0])
        for keep in (slice(0, 1), slice(1, None)):
            rows = self.rows(use, keep=keep)
            self.assertEqual(suspected_part(rows), "actuation")
            drives = {r["block"]: r for r in rows}["actuation"]
            self.assertGreater(drives["explained"], 0.97)
        reading = {r["block"]: r for r in self.rows(use, keep=slice(0, 1))}
        found = reading["sensing"]
        self.assertEqual((found["explained"], found["errors"]), (0.0, []))

    def test_runs_of_less_than_a_second_are_left_out(self):
        evaluator = self.bench.evaluator(
            (), lambda run: replace(run, channels=cut(run.channels, 150))
        )
        drives = {"normalised_rms": 2.0, "acquitted": False}
        prepared = evaluator.prepared
        self.assertEqual(explain_imbalance(self.device, prepared, drives), [])

    def test_a_spline_keeps_the_rates_that_neighbours_lose(self):
        time = np.arange(200) / 20.0
        values = np.sin(2.0 * np.pi * 4.0 * time)
        exact = 8.0 * np.pi * np.cos(2.0 * np.pi * 4.0 * time)
        off = (slope(values, 20.0) - exact)[10:-10]
        self.assertLess(np.abs(off).max(), 0.03 * np.abs(exact).max())

    def test_of_noise_alone_there_is_nothing_to_tell(self):
        self.assertEqual(self.rows(), [])

    def test_drives_are_named_unless_others_take_nearly_all_of_it(self):
        for shares, block in (
            (explained(actuation=0.5, mechanism=0.99), "mechanism"),
            (explained(actuation=0.5, mechanism=0.89), "actuation"),
            (explained(actuation=0.98, mechanism=0.985), "actuation"),
            (
                explained(actuation=0.4, mechanism=0.94, sensing=1.0),
                "sensing",
            ),
            (
                explained(actuation=0.4, mechanism=1.0, sensing=0.99),
                "mechanism",
            ),
            ([], "actuation"),
        ):
            with self.subTest(shares):
                self.assertEqual(suspected_part(shares), block)


if __name__ == "__main__":
    unittest.main()
