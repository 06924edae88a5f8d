"""Every card of the library, and each law against its closed form."""

import itertools
import math
import unittest
from dataclasses import replace
from importlib.metadata import EntryPoint
from unittest import mock

import numpy as np

from brace_drake.core.errors import EffectError
from brace_drake.devices.bench.rollout import Motion
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.effects import registry
from brace_drake.effects.registry import (
    ENTRY_POINTS,
    all_effects,
    choice_words,
    effects_for,
    find_effect,
    forget_effect,
    register_effect,
)
from brace_drake.effects.stack import stack_effects
from brace_drake.laws.hooks import MAX_EFFECTS
from brace_drake.scenario.brace import BenchScenario
from brace_drake.withheld.faults import FAULTS


def push(duration=2.0, depth=-0.004):
    """A smooth push and its derivatives at 1 kHz (ticks, 3)."""
    t = np.arange(round(duration * 1000) + 1) / 1000.0
    s, w = np.sin(np.pi * t / duration), np.pi / duration
    c = np.cos(np.pi * t / duration)
    y = depth * s**2
    return np.column_stack(
        [y, 2 * depth * w * s * c, 2 * depth * w**2 * (c**2 - s**2)]
    )


class TestCards(unittest.TestCase):
    def test_every_card_has_source_equation_signature_and_experiment(self):
        for name, card in all_effects().items():
            with self.subTest(effect=name):
                for text in (
                    card.source,
                    card.equation,
                    card.signature,
                    card.experiment,
                    card.title,
                ):
                    self.assertGreater(len(text), 8)
                self.assertTrue(card.impostors)
                self.assertTrue(card.remedy)

    def test_every_start_lies_within_its_limits(self):
        for name, card in all_effects().items():
            for p in card.parameters:
                # A discrete parameter may well be at a limit.
                for start in p.starts if not p.choices else ():
                    with self.subTest(effect=name, parameter=p.name):
                        self.assertLessEqual(p.lower, start)
                        self.assertLess(start, p.upper)

    def test_devices_have_the_effects_whose_places_they_have(self):
        names = {
            device: {card.name for card in effects_for(device).values()}
            for device in ("bench stage 2", "leg bench", "pad bench", "axis")
        }
        of_diagram = {
            "joint of a plant",
            "body of a plant",
            "command of a port",
            "reading of a port",
            "two encoders",
        }
        every = [
            e for e in all_effects().values() if not of_diagram & set(e.needs)
        ]
        of_joint = {e.name for e in every if "one joint" in e.needs}
        of_servo = {e.name for e in every if "commanded motion" in e.needs}
        self.assertEqual(
            names["bench stage 2"],
            {
                e.name
                for e in every
                if not {"one joint", "commanded motion"} & set(e.needs)
            },
        )
        alone = {
            e.name
            for e in every
            if (e.block == "actuation" or "one joint" in e.needs)
            and e.name != "weak_leg"
            and e.name not in of_servo
            and not {"angle", "extra input"} & set(e.needs)
        }
        self.assertEqual(names["leg bench"], alone)
        self.assertLessEqual(of_joint, names["axis"])
        # Nothing is commanded where a motion is imposed.
        self.assertNotIn("command_delay", names["axis"])
        self.assertEqual(
            {e.block for e in effects_for("pad bench").values()},
            {"contact", "sensing"},
        )
        self.assertNotIn("encoder_offset", names["pad bench"])

    def test_an_unknown_effect_is_answered_with_the_closest_name(self):
        with self.assertRaisesRegex(EffectError, "mean coulomb_friction"):
            find_effect("coulomb_frictoin")
        with self.assertRaises(EffectError) as caught:
            find_effect("fooo")
        self.assertNotIn("did you mean", str(caught.exception))
        self.assertIn("; there are", str(caught.exception))

    def test_a_value_outside_its_limits_is_refused_by_name(self):
        card = find_effect("command_delay")
        with self.assertRaisesRegex(EffectError, r"delay_s is 1, allowed 0"):
            card.vector({"delay_s": 1.0})

    def test_more_effects_than_the_twin_carries_are_refused(self):
        card = find_effect("force_bias")
        with self.assertRaisesRegex(EffectError, f"at most {MAX_EFFECTS}"):
            stack_effects([(card, np.zeros(1))] * (MAX_EFFECTS + 1))


class TestOwnEffects(unittest.TestCase):
    card = replace(find_effect("force_bias"), name="own_bias")

    def test_an_effect_from_outside_is_one_of_all_until_it_is_forgotten(self):
        register_effect(self.card)
        try:
            self.assertIs(find_effect("own_bias"), self.card)
            self.assertIn("own_bias", effects_for("bench stage 2"))
            with self.assertRaisesRegex(EffectError, "registered twice"):
                register_effect(self.card)
        finally:
            forget_effect("own_bias")
        self.assertNotIn("own_bias", all_effects())
        with self.assertRaisesRegex(EffectError, "not added"):
            forget_effect("own_bias")

    def test_the_library_can_be_neither_replaced_nor_forgotten(self):
        with self.assertRaisesRegex(EffectError, "registered twice"):
            register_effect(find_effect("force_bias"))
        with self.assertRaisesRegex(EffectError, "not added"):
            forget_effect("force_bias")

    def test_an_installed_package_adds_its_own(self):
        self.addCleanup(registry._library.cache_clear)
        for value, problem in (
            ("tests.test_effects:OWN_BIAS", None),
            ("tests.test_effects:push", "no effect's card"),
            ("tests.test_effects:absent", "absent"),
        ):
            point = EntryPoint("own", value, ENTRY_POINTS)
            registry._library.cache_clear()
            with (
                self.subTest(value=value),
                mock.patch("importlib.metadata.entry_points") as points,
            ):
                points.return_value = [point]
                if problem is None:
                    self.assertIs(find_effect("own_bias"), OWN_BIAS)
                else:
                    with self.assertRaisesRegex(EffectError, problem):
                        all_effects()
                points.assert_called_with(group=ENTRY_POINTS)


OWN_BIAS = TestOwnEffects.card


class TestLibrary(unittest.TestCase):
    def test_the_blind_test_draws_every_effect_in_its_block(self):
        known = effects_for("bench stage 2").values()
        blocks = {card.name: card.block for card in known}
        self.assertEqual(blocks, {f.name: f.block for f in FAULTS})

    def test_impostors_are_effects_too(self):
        names = {card.name for card in all_effects().values()}
        for key, card in all_effects().items():
            with self.subTest(effect=key):
                self.assertLessEqual(set(card.impostors), names - {card.name})

    def test_a_choice_that_is_more_than_a_number_has_words(self):
        self.assertEqual(choice_words("pad", 1.0), "pad at +y")
        self.assertIsNone(choice_words("pad", 7.0))
        self.assertIsNone(choice_words("leg", 1.0))


class TestAllEffects(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.twin = BenchTwin(BenchScenario(), 5e-4)
        cls.motion = Motion(push(), True)
        cls.subject = np.array([p.nominal for p in cls.twin.subject])
        cls.nominal = cls.twin.simulate(cls.motion, cls.subject)

    def test_zero_strength_changes_nothing(self):
        for name, card in effects_for("bench stage 2").items():
            with self.subTest(effect=name):
                log = self.replay(card, card.off())
                np.testing.assert_allclose(log, self.nominal, atol=1e-9)

    def test_every_effect_at_a_start_changes_the_recording(self):
        for name, card in effects_for("bench stage 2").items():
            starts = card.starts()
            if card.spread is not None:
                starts = [np.full(len(card.parameters), 1e-3)]
            with self.subTest(effect=name):
                change = 0.0
                for values in starts:
                    log = self.replay(card, values)
                    self.assertTrue(np.all(np.isfinite(log)))
                    change = max(change, np.abs(log - self.nominal).max())
                self.assertGreater(change, 1e-6)

    def replay(self, card, values):
        """The run with an effect, run parameters at 0."""
        uses = [(card, card.in_run(values, 0))]
        return self.twin.simulate(self.motion, self.subject, uses)

    def test_the_same_noise_seed_gives_the_same_recording(self):
        for name, card in effects_for("bench stage 2").items():
            values = card.in_run(card.starts()[0], 0)
            with self.subTest(effect=name):
                first, second = (
                    self.twin.simulate(
                        self.motion,
                        self.subject,
                        [(card, values)],
                        np.random.default_rng(5),
                    )
                    for _ in range(2)
                )
                np.testing.assert_array_equal(first, second)


class TestLaws(unittest.TestCase):
    def test_sliding_friction_is_the_coulomb_force_against_the_motion(self):
        for key in ("coulomb_friction", "coulomb_friction (without creep)"):
            law = find_effect(key).laws["drive"]
            f, x, p = np.zeros(1), np.zeros(6), np.array([1.5])
            for _ in range(2000):
                f[0] = 0.0
                law(0.0, 2e-4, f, f, np.array([-0.01]), f, f, p, x)
            self.assertAlmostEqual(f[0], 1.5, places=6)

    def test_stribeck_friction_falls_from_breakaway_to_coulomb(self):
        for key in ("stribeck_friction", "stribeck_friction (without creep)"):
            law = find_effect(key).laws["drive"]
            p = np.array([1.5, 1.0, 2e-3])
            for speed in (2e-4, 2e-3, 2e-2):
                f, x = np.zeros(1), np.zeros(6)
                for _ in range(4000):
                    f[0] = 0.0
                    law(0.0, 2e-4, f, f, np.array([speed]), f, f, p, x)
                want = 1.5 + math.exp(-((speed / 2e-3) ** 2))
                with self.subTest(key=key, speed=speed):
                    self.assertAlmostEqual(f[0], -want, places=6)

    def test_breakaway_fades_over_some_travel_and_not_at_once(self):
        # A LuGre bristle of one stiffness (Canudas de Wit et al. 1995): from
        # slow to fast at once it still has the slow deflection.
        card = find_effect("stribeck_friction")
        p, dt = np.array([1.0, 1.0, 1e-3]), 1e-6
        x, f = np.zeros(6), np.zeros(1)

        def slide(speed, steps):
            forces = []
            for _ in range(steps):
                f[0] = 0.0
                card.laws["drive"](0, dt, f, f, np.array([speed]), f, f, p, x)
                forces.append(-f[0])
            return np.array(forces)

        slide(1e-4, 500_000)
        forces = slide(0.01, 5_000)
        stiffness, level = 2.0 / 5e-6, 1.0
        length = level / stiffness
        travel = 0.01 * dt * np.arange(1, 5_001)
        slow = 1.0 + math.exp(-(0.1**2))
        z_end, z_begin = level / stiffness, slow / stiffness
        z = z_end + (z_begin - z_end) * np.exp(-travel / length)
        rate = 0.01 * (1.0 - z * stiffness / level)
        want = stiffness * z + min(1.5e-3 * stiffness, 600.0) * rate
        np.testing.assert_allclose(forces, want, atol=0.01)

    def test_without_creep_a_trembling_drive_stays_below_its_friction(self):
        # Dupont et al. 2002: a load of half the friction, and a tremble.
        def creep(key):
            law = find_effect(key).laws["drive"]
            dt, mass, x = 1e-4, 1.0, np.zeros(6)
            p = np.array([2.0, 0.5, 2e-3])
            v, place, places = 0.0, 0.0, []
            for step in range(20_000):
                load = 1.0 + 0.2 * np.sin(2.0 * np.pi * 20.0 * step * dt)
                f = np.zeros(1)
                law(step * dt, dt, f, f, np.array([v]), f, f, p, x)
                v += dt * (load + f[0]) / mass
                place += dt * v
                places.append(place)
            # Over the last second, in deflections at which it slides.
            return (places[-1] - places[-10_001]) / 5e-6

        for name in ("coulomb_friction", "stribeck_friction"):
            with self.subTest(name=name):
                self.assertGreater(creep(name), 1.0)
                holding = creep(f"{name} (without creep)")
                self.assertLess(abs(holding), 1e-3)

    def test_what_changes_commands_acts_on_what_is_left_of_them(self):
        gain, limit = (
            find_effect(k) for k in ("force_gain", "saturation (drive)")
        )
        friction = find_effect("coulomb_friction")
        u, law, rate = np.full(6, 8.0), np.full(6, 20.0), np.full(6, 0.01)

        def force(*uses):
            plug_in = stack_effects(uses)["drive"]
            memory, f = plug_in.fresh_memory(), u - law * rate
            for _ in range(2000):
                f[:] = u - law * rate
                for act, p, x in zip(
                    plug_in.laws, plug_in.parameters, memory, strict=True
                ):
                    act(0.0, 2e-4, u, u, rate, law, f, p, x)
            return f[0]

        # 8 N cut to 5 N, a tenth of it lost; or 7.2 N cut to 5 N.
        cut, lost = (limit, np.array([5.0])), (gain, np.array([-0.1]))
        self.assertAlmostEqual(force(cut, lost), 4.5 - 0.2)
        self.assertAlmostEqual(force(lost, cut), 5.0 - 0.2)
        # Friction does not reach the limit, whatever is named first.
        for uses in itertools.permutations((cut, (friction, np.array([1.0])))):
            self.assertAlmostEqual(force(*uses), 5.0 - 0.2 - 1.0, places=6)

    def test_a_delayed_command_arrives_after_its_dead_time(self):
        law = find_effect("command_delay").laws["drive"]
        dt, delay = 2.5e-4, 3.5e-3
        x, p, rate = np.zeros(64 * 6), np.array([delay]), np.zeros(6)
        seen = []
        for step in range(80):
            t = step * dt
            tick = int(np.floor(t / 1e-3 + 1e-6))
            u = np.full(6, float(tick + 1))
            f = u.copy()
            law(t, dt, u, rate, rate, u, f, p, x)
            seen.append(f[0])
        # At 10 ms the command of 6.5 ms is in force, that of tick 6.
        self.assertAlmostEqual(seen[40], 7.0, places=9)
        self.assertEqual(seen[0], 0.0)

    def test_an_arm_under_constant_speed_relaxes_exponentially(self):
        law = find_effect("relaxation").laws["contact"]
        k, tau, dt, v = 2000.0, 0.5, 1e-4, 0.01
        x, p, N = np.zeros(2), np.array([k, tau]), np.zeros(1)
        for step in range(7001):
            N[0] = 0.0
            depth = np.array([v * step * dt, v])
            law(0.0, dt, 0, depth, np.zeros(6), N, p, x)
        exact = k * tau * v * (1.0 - np.exp(-0.7 / tau))
        self.assertAlmostEqual(N[0] / exact, 1.0, delta=2 * dt / tau)

    def test_a_scaled_and_biased_force_is_read_as_such(self):
        F = np.array([1.0, -2.0, 3.0])
        none = np.zeros(6)
        args = (0.0, 1e-3, none, none, F)
        scale, bias = find_effect("force_scale"), find_effect("force_bias")
        scale.laws["sensing"](*args, np.array([0.1]), none)
        bias.laws["sensing"](*args, np.array([0.5]), none)
        np.testing.assert_allclose(F, [1.1, -1.7, 3.3])

    def test_hardening_is_cubic_in_the_depth(self):
        law = find_effect("hardening").laws["contact"]
        N = np.zeros(1)
        d = np.array([0.002, 0.0])
        law(0.0, 1e-3, 0, d, np.zeros(6), N, np.array([1e9]), np.zeros(1))
        self.assertAlmostEqual(N[0], 8.0)


if __name__ == "__main__":
    unittest.main()
