"""Dry friction behind a joint that gives way."""

import unittest

import numpy as np

from brace_drake.devices.declaration import Nuisance
from brace_drake.devices.linearise import linearise_tolerances
from brace_drake.effects.actuation import coulomb_friction
from brace_drake.effects.mechanism import leg_compliance, ring_mass
from brace_drake.effects.stack import behind_joints

COMPLIANCE = np.array([8e-5, 40.0])
FORMS = [*leg_compliance.CARDS, ring_mass.CARD, *coulomb_friction.CARDS]
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
        np.testing.assert_array_equal(values, [8e-5, 40.0, 0.03])

    def test_without_a_joint_or_where_it_sticks_already_there_is_none(self):
        friction = coulomb_friction.CARD, np.array([0.03])
        sticking = leg_compliance.STICKING, np.append(COMPLIANCE, 0.1)
        for uses in ([ADDED], [sticking]):
            with self.subTest(uses=[e.key for e, _ in uses]):
                self.assertEqual(behind_joints(uses, *friction, FORMS), [])

    def test_a_tolerance_of_friction_acts_behind_the_joint(self):
        friction = Nuisance(
            "leg_dry_friction_N",
            "N",
            "actuation",
            0.03,
            ((coulomb_friction.CARD, np.array([0.03])),),
            0.0,
        )
        mass = Nuisance("ring_mass_kg", "kg", "mechanism", 0.1, (ADDED,))
        evaluator = _Recorder()
        uses = [(leg_compliance.CARD, COMPLIANCE)]
        linearise_tolerances(evaluator, [friction, mass], np.ones(1), uses)
        behind, beside = evaluator.after
        self.assertEqual([e for e, _ in behind], [leg_compliance.STICKING])
        self.assertEqual(
            [e for e, _ in beside], [leg_compliance.CARD, ring_mass.CARD]
        )
        self.assertEqual(
            [e for e, _ in evaluator.before], [leg_compliance.CARD]
        )


if __name__ == "__main__":
    unittest.main()
