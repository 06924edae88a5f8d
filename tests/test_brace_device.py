"""The whole brace as a device: against Drake's diagram, stage by stage."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.devices.brace.tolerances import (
    brace_tolerances,
    brace_uses_off,
)
from brace_drake.devices.brace.twin import BraceTwin, brace_channels
from brace_drake.devices.device import MakeDevice
from brace_drake.effects.stack import modify_numbers, stack_effects
from brace_drake.effects.stage_cards import stage_cards
from brace_drake.model.simulate import RecordBrace
from brace_drake.recording import Campaign, Run
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_bench
from brace_drake.scenario.effects import describe_use
from brace_drake.scenario.load import LoadScenario, SaveScenario

RATE = 200.0
STAGES = [1, 2, 3]


def reference(duration_s: float = 0.5, contact: bool = True) -> Run:
    """All rings move along y, each at a frequency of its own."""
    t = np.arange(round(duration_s * RATE) + 1) / RATE
    channels = {"time_s": t}
    for ring in STAGES:
        w, size = 2.0 * np.pi * (0.8 + 0.3 * ring), 2e-3
        channels[f"ring{ring}_y_desired_m"] = size * (1 - np.cos(w * t))
        channels[f"ring{ring}_vy_desired_m_s"] = size * w * np.sin(w * t)
        channels[f"ring{ring}_ay_desired_m_s2"] = size * w * w * np.cos(w * t)
    return Run("push.csv", contact, "push", None, "fit", channels)


def use(key: str, **values: float):
    """An effect of the whole brace with named parameters."""
    card = stage_cards("brace", STAGES)[key]
    return card, card.vector(values)


def recorded(uses=(), contact: bool = True) -> tuple[BraceTwin, Run]:
    """A twin, and a recording of Drake's diagram with effects."""
    twin = BraceTwin(BraceScenario())
    run = reference(contact=contact)
    return twin, RecordBrace(twin.scenario, run, uses=uses)


class TestTwin(unittest.TestCase):
    def assert_same(self, key=None, **values):
        uses = (use(key, **values),) if key else ()
        twin, run = recorded(uses)
        subject = np.array([p.nominal for p in twin.subject])
        found = twin.simulate(twin.motion(run), subject, uses)
        measured, active = twin.measured(run), twin.active(run)
        np.testing.assert_allclose(
            found[:, active], measured[:, active], rtol=1e-7, atol=1e-8
        )

    def test_a_replay_is_that_of_drakes_diagram(self):
        self.assert_same()

    def test_so_is_one_with_an_effect_of_a_single_stage(self):
        for key, values in (
            ("viscous_leg, stage 1", {}),
            ("force_scale, stage 3", {}),
            ("hardening, stage 2", {}),
        ):
            name, stage = key.split(", ")
            card = stage_cards("brace", STAGES)[f"{name} ({stage})"]
            values = dict(
                zip(
                    card.parameter_names,
                    [p.typical for p in card.parameters],
                    strict=True,
                )
            )
            with self.subTest(key):
                self.assert_same(card.key, **values)

    def test_only_the_stage_that_has_it_is_read_otherwise(self):
        twin, run = recorded()
        subject = np.array([p.nominal for p in twin.subject])
        motion = twin.motion(run)
        bias = use("force_bias (stage 3)", force_bias_N=2.0)
        far = twin.simulate(motion, subject, (bias,))
        near = twin.simulate(motion, subject)
        # At first: later the ring yields to what is read, and with it all.
        moved = (far - near)[0]
        names = np.array(brace_channels(twin.scenario))
        self.assertAlmostEqual(moved[names == "ring3_force_y_N"][0], 2.0)
        is_read = ~np.char.endswith(names, "command_N")
        is_read &= ~np.char.endswith(names, "virtual_m")
        others = is_read & (names != "ring3_force_y_N")
        np.testing.assert_array_equal(moved[others], 0.0)

    def test_a_ring_without_reference_is_held(self):
        twin, run = recorded()
        channels = {
            n: v for n, v in run.channels.items() if not n.startswith("ring3_")
        }
        motion = twin.motion(replace(run, channels=channels))
        self.assertEqual(motion.columns, (1, 7, 13))
        self.assertFalse(motion.desired[:, :, 2].any())
        self.assertTrue(motion.desired[:, :, 0].any())


class TestStages(unittest.TestCase):
    def test_numbers_change_in_one_stage_alone(self):
        numbers = pack_bench(BraceScenario())
        heavier = use("ring_mass (stage 2)", added_mass_kg=0.2)
        changed = modify_numbers(numbers, [heavier])
        np.testing.assert_allclose(
            changed.ring[:, 0] - numbers.ring[:, 0], [0.0, 0.2, 0.0]
        )
        for field in ("lower", "upper", "viscous", "contact", "control"):
            np.testing.assert_array_equal(
                getattr(changed, field), getattr(numbers, field)
            )

    def test_laws_are_off_in_other_stages(self):
        bias = use("force_bias (stage 1)", force_bias_N=0.4)
        rows = stack_effects([bias])["sensing"].parameters[0]
        np.testing.assert_array_equal(rows, [[0.4], [0.0], [0.0]])

    def test_every_stage_is_off_by_numbers_of_its_own(self):
        scenario = BraceScenario()
        numbers = pack_bench(scenario)
        off = {"stage1_ring_mass_kg": 0.01, "stage3_ring_mass_kg": -0.02}
        changed = modify_numbers(numbers, brace_uses_off(scenario, off))
        np.testing.assert_allclose(
            changed.ring[:, 0] - numbers.ring[:, 0], [0.01, 0.0, -0.02]
        )

    def test_tolerances_are_those_of_the_bench_for_each_stage(self):
        scenario = BraceScenario()
        names = [n.name for n in brace_tolerances(scenario)]
        self.assertEqual(len(names), len(set(names)))
        own = [n.removeprefix("stage1_") for n in names if "stage1_" in n]
        self.assertEqual(len(names), 3 * len(own))
        self.assertIn("ring_mass_kg", own)

    def test_effects_of_legs_and_torso_are_not_of_all_stages(self):
        keys = set(stage_cards("brace", STAGES))
        self.assertIn("weak_leg (stage 2)", keys)
        self.assertNotIn("weak_leg", keys)
        self.assertIn("reflex", keys)
        self.assertNotIn("reflex (stage 1)", keys)
        self.assertIn("hardening", keys)
        self.assertEqual(
            set(stage_cards("bench stage 2", [2])) & {"hardening (stage 2)"},
            set(),
        )

    def test_a_scenario_with_an_effect_of_a_stage_comes_back(self):
        scenario = BraceScenario()
        effect = use("force_lag (stage 2)", lag_s=0.05)
        scenario.effects = [describe_use(*effect)]
        with tempfile.TemporaryDirectory() as folder:
            SaveScenario(scenario, Path(folder) / "a.yaml")
            loaded = LoadScenario(Path(folder) / "a.yaml")
        (card, values), *_ = BraceTwin(loaded).carried
        self.assertEqual(
            (card.key, card.stage), ("force_lag (stage 2)", (1, 3))
        )
        np.testing.assert_allclose(values, [0.05])


class TestDevice(unittest.TestCase):
    def test_quantities_are_forces_and_ways_of_all_rings(self):
        run = recorded()[1]
        campaign = Campaign(Path("one"), "brace", RATE, "one", (run,))
        device = MakeDevice(campaign)
        found = device.quantities(device.twin.measured(run))
        self.assertEqual(found["force_error_N"].shape[1], 9)
        # Stiff impedance: rings follow to a fraction of a millimetre.
        for i, ring in enumerate(STAGES):
            asked = 1e3 * run.channels[f"ring{ring}_y_desired_m"]
            way = found["ring_error_mm"][:, 3 * i + 1]
            self.assertLess(np.abs(way - asked).max(), 0.5 * np.ptp(asked))


if __name__ == "__main__":
    unittest.main()
