"""Hydroelastic contact of the bench against its linear law."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.devices.motions.reference import MakeReference
from brace_drake.model.contact_mapping import (
    map_hydroelastic_to_linear,
    map_linear_to_hydroelastic,
    measure_hydroelastic,
    with_mapped_hydroelastic,
)
from brace_drake.model.simulate import SimulateBench
from brace_drake.model.station import MakeBenchStation
from brace_drake.scenario.bench import BenchScenario, Contact

FORCE_Y = 13


def cubic_push(duration=2.0, depth=-0.01):
    """The paper's cubic to 10 mm, y, y', y'' at 200 Hz."""
    time = np.linspace(0.0, duration, round(duration * 200) + 1)
    s = time / duration
    y = depth * s**2 * (3 - 2 * s)
    dy = depth * 6 * s * (1 - s) / duration
    ddy = depth * 6 * (1 - 2 * s) / duration**2
    return time, np.column_stack([y, dy, ddy])


def simulate(model, time_step, layout="pic", preload=None):
    scenario = BenchScenario(time_step=time_step)
    scenario.control.layout = layout
    scenario.contact.model = model
    if preload is not None:
        scenario.contact.preload = preload
        scenario.contact = with_mapped_hydroelastic(scenario.contact)
    time, samples = cubic_push()
    station = MakeBenchStation(scenario, MakeReference(time, samples))
    return SimulateBench(station, time[-1])


class TestMapping(unittest.TestCase):
    def test_there_and_back_is_where_it_began(self):
        there = map_linear_to_hydroelastic(6400.0, 150.0, 0.0048, 0.02, 0.001)
        back = map_hydroelastic_to_linear(*there, 0.0048, 0.02, 0.001)
        np.testing.assert_allclose(back, (6400.0, 150.0), rtol=1e-14)

    def test_scenario_defaults_are_what_the_mapping_gives(self):
        mapped, contact = with_mapped_hydroelastic(Contact()), Contact()
        for name in ("hydroelastic_modulus", "hydroelastic_dissipation"):
            self.assertAlmostEqual(
                getattr(mapped, name) / getattr(contact, name), 1.0, places=12
            )

    def test_pressing_measures_the_linear_stiffness_and_damping(self):
        measured = measure_hydroelastic(Contact())
        self.assertAlmostEqual(measured.stiffness, 6400.0, delta=0.01)
        # The press moves on by one step of 10 us, that is k h = 0.064.
        self.assertAlmostEqual(measured.damping, 150.0, delta=0.1)
        self.assertLess(measured.nonlinearity, 1e-6)

    def test_damping_grows_with_depth(self):
        measured = measure_hydroelastic(Contact(), (0.001, 0.002))
        ratio = measured.damping_at_depth[1] / measured.damping_at_depth[0]
        self.assertAlmostEqual(ratio, 2.0, delta=0.002)

    def test_another_subject_maps_as_well(self):
        contact = with_mapped_hydroelastic(
            replace(Contact(), stiffness=9000.0, damping=100.0, preload=0.0007)
        )
        measured = measure_hydroelastic(contact)
        self.assertAlmostEqual(measured.stiffness, 9000.0, delta=0.1)
        self.assertAlmostEqual(measured.damping, 100.0, delta=0.2)


class TestPush(unittest.TestCase):
    def assert_close(self, linear, hydroelastic, within):
        f, g = linear[:, FORCE_Y], hydroelastic[:, FORCE_Y]
        rms = np.sqrt(np.mean((f - g) ** 2) / np.mean(f**2))
        self.assertLess(rms, within)
        peak, other = np.abs(f).max(), np.abs(g).max()
        self.assertLess(abs(peak - other) / peak, within)
        self.assertGreater(peak, 10.0)

    def test_force_y_of_a_push_is_that_of_the_linear_law(self):
        linear = simulate("linear", 5e-4)
        for time_step in (1e-3, 5e-4):
            with self.subTest(time_step=time_step):
                log = simulate("hydroelastic", time_step)
                # Asked for: 5 %. What is left is the force's age of a step.
                self.assert_close(linear, log, 0.005)

    def test_the_other_axes_stay_quiet(self):
        log = simulate("hydroelastic", 1e-3)
        steps = np.abs(np.diff(log[20:, [12, 14]], axis=0)).max()
        # No limit cycle: far below the reading noise of 0.03 N.
        self.assertLess(steps, 0.003)

    def test_a_pad_that_lifts_off_keeps_the_force_within_five_per_cent(self):
        linear = simulate("linear", 5e-4, preload=0.0004)
        log = simulate("hydroelastic", 1e-3, preload=0.0004)
        self.assert_close(linear, log, 0.05)

    def test_both_layouts_agree(self):
        pic = simulate("hydroelastic", 1e-3)
        blocks = simulate("hydroelastic", 1e-3, "blocks")
        np.testing.assert_allclose(pic, blocks, rtol=0, atol=1e-8)


if __name__ == "__main__":
    unittest.main()
