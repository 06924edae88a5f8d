"""Dry friction behind a joint that gives way."""

import unittest

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.linearise import linearise_tolerances
from brace_drake.effects.actuation import (
    backlash,
    coulomb_friction,
    viscous_leg,
)
from brace_drake.effects.mechanism import leg_compliance, ring_mass
from brace_drake.effects.stack import (
    behind_joints,
    modify_numbers,
    stack_effects,
)
from brace_drake.scenario.brace import BenchScenario
from brace_drake.scenario.brace_numbers import pack_bench
from brace_drake.selection.tolerated import holds_another

COMPLIANCE, TICK = np.array([8e-5]), 0.005
FORMS = [*leg_compliance.CARDS, ring_mass.CARD, *coulomb_friction.CARDS]
FRICTION = Nuisance(
    "leg_dry_friction_N",
    "N",
    "actuation",
    0.03,
    ((coulomb_friction.CARD, np.array([0.03])),),
    0.0,
)
ADDED = (ring_mass.CARD, np.array([0.1]))


class _Recorder:
    """An evaluator that tells friction behind a joint from that on the ring."""

    effects, count = FORMS, 3

    def changes(self, subject, before, after):
        self.before, self.after = before, after
        return [np.arange(3.0) + i for i in range(len(after))]


class TestBehindJoints(unittest.TestCase):
    def test_friction_goes_into_the_form_of_the_joint_that_has_it(self):
        uses = [ADDED, (leg_compliance.CARD, COMPLIANCE)]
        (found,) = behind_joints(
            uses, coulomb_friction.CARD, np.array([0.03]), FORMS
        )
        self.assertIs(found[0], ADDED)
        effect, values = found[1]
        self.assertIs(effect, leg_compliance.STICKING)
        np.testing.assert_array_equal(values, [8e-5, 0.03])

    def test_without_a_joint_or_where_it_sticks_already_there_is_none(self):
        friction = coulomb_friction.CARD, np.array([0.03])
        sticking = leg_compliance.STICKING, np.append(COMPLIANCE, 0.1)
        for uses in ([ADDED], [sticking]):
            with self.subTest(uses=[e.key for e, _ in uses]):
                self.assertEqual(behind_joints(uses, *friction, FORMS), [])

    def test_friction_in_a_joint_is_an_effect_beyond_its_tolerance(self):
        sticking = leg_compliance.STICKING
        for use, expected in (
            ((sticking, np.array([8e-5, 0.08])), False),
            ((sticking, np.array([8e-5, 0.1])), True),
            ((leg_compliance.CARD, COMPLIANCE), False),
            ((coulomb_friction.CARD, np.array([0.1])), False),
        ):
            with self.subTest(effect=use[0].key, values=use[1]):
                self.assertEqual(holds_another(use, [FRICTION]), expected)

    def test_a_tolerance_of_friction_acts_behind_the_joint(self):
        mass = Nuisance("ring_mass_kg", "kg", "mechanism", 0.1, (ADDED,))
        evaluator = _Recorder()
        uses = [(leg_compliance.CARD, COMPLIANCE)]
        linearise_tolerances(evaluator, [FRICTION, mass], np.ones(1), uses)
        behind, beside = evaluator.after
        self.assertEqual([e for e, _ in behind], [leg_compliance.STICKING])
        self.assertEqual(
            [e for e, _ in beside], [leg_compliance.CARD, ring_mass.CARD]
        )
        self.assertEqual(
            [e for e, _ in evaluator.before], [leg_compliance.CARD]
        )

    def read(self, card, size, extra, command, ticks):
        """Lengths read of held rings whose drives have other friction (T, 6),
        friction of the drives (6,), and what their legs carry at rest (6,).
        """
        uses = [
            (card, np.array([size])),
            (viscous_leg.CARD, np.array([extra])),
        ]
        nominal = pack_bench(BenchScenario())
        numbers = modify_numbers(nominal, uses)
        stack = stack_effects(uses, numbers)["sensing"]
        states, read = stack.initial[0].copy(), np.zeros((ticks, 6))
        held, force, values = np.full(6, command), np.zeros(3), stack.parameters
        for k, lengths in enumerate(read):
            stack.laws[0](
                k * TICK, TICK, held, lengths, force, values[0], states
            )
        at_rest = card.constants(numbers)[0, 6:]
        return read, nominal.viscous + extra, at_rest

    def test_a_released_drive_returns_at_the_rate_of_its_own_friction(self):
        # What stretched the springs at rest decays with C b.
        card, c = leg_compliance.CARD, COMPLIANCE[0]
        times = TICK * np.arange(40)[:, None]
        for extra in (0.0, 20.0, -30.0):
            read, b, at_rest = self.read(card, c, extra, 0.0, 40)
            with self.subTest(extra=extra):
                np.testing.assert_allclose(
                    read,
                    c * at_rest * np.exp(-times / (c * b)),
                    rtol=1e-9,
                    atol=1e-15,
                )

    def test_in_a_gap_a_drive_runs_at_the_speed_of_its_own_friction(self):
        gap = next(c for c in backlash.CARDS if c.form == "gap")
        for extra in (0.0, 20.0, -30.0):
            read, b, _ = self.read(gap, 2e-3, extra, -0.01, 10)
            with self.subTest(extra=extra):
                np.testing.assert_allclose(
                    np.diff(read, axis=0),
                    -0.01 * TICK / np.tile(b, (9, 1)),
                    rtol=1e-9,
                )


if __name__ == "__main__":
    unittest.main()
