"""Hydroelastic contact of the bench against its linear law."""

import unittest
from dataclasses import replace

import numpy as np

from brace_drake.model.brace_station import MakeControlledBrace
from brace_drake.scenario.brace import BenchScenario, Contact
from tests.brace_runs import along_y, bench_log

FORCE_Y = 13


def cubic_push(duration=2.0, depth=-0.01):
    """The paper's cubic to 10 mm, y, y', y'' at 200 Hz."""
    time = np.linspace(0.0, duration, round(duration * 200) + 1)
    s = time / duration
    y = depth * s**2 * (3 - 2 * s)
    dy = depth * 6 * s * (1 - s) / duration
    ddy = depth * 6 * (1 - 2 * s) / duration**2
    return time, np.column_stack([y, dy, ddy])


def mapped(contact):
    """The contact with the hydroelastic numbers of its linear ones.

    See `brace_drake.scenario.brace.Contact`; the working depth is the preload.
    """
    k, c = contact.stiffness, contact.damping
    area = contact.pad_size[0] * contact.pad_size[2]
    return replace(
        contact,
        hydroelastic_modulus=k * contact.hydroelastic_thickness / area,
        hydroelastic_dissipation=c / (k * contact.preload),
    )


def simulate(model, time_step, preload=1e-3):
    scenario = BenchScenario(time_step=time_step)
    contact = Contact(model=model, preload=preload)
    scenario.contact.ring2 = mapped(contact)
    time, samples = cubic_push()
    station = MakeControlledBrace(scenario, along_y(time, samples))
    return bench_log(station, time[-1])


class TestMapping(unittest.TestCase):
    def test_scenario_defaults_are_what_the_mapping_gives(self):
        ours = Contact()
        for name in ("hydroelastic_modulus", "hydroelastic_dissipation"):
            ratio = getattr(mapped(ours), name) / getattr(ours, name)
            self.assertAlmostEqual(ratio, 1.0, places=12)


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


if __name__ == "__main__":
    unittest.main()
