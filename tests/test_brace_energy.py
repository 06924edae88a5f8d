"""Work of the legs against what the brace stores and what dampers take."""

import unittest

import numpy as np
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.scenario.brace_numbers import pack_brace
from tests.brace_energy import EnergyBook
from tests.brace_runs import brace, run
from tests.brace_servo import BraceServo
from tests.test_articulated import MOTION


def swing(seconds):
    """To MOTION and back once a second."""
    turns = np.arange(2 * seconds + 1)
    X = np.outer(np.append(MOTION, np.zeros(36)), turns % 2)
    return PiecewisePolynomial.CubicWithContinuousSecondDerivatives(
        0.5 * turns, X, np.zeros(54), np.zeros(54)
    )


def settle(mechanism, contact, time_step, seconds=1):
    """Stored, work, lost, J, of a run that swings."""
    scenario = brace(mechanism, contact, time_step=time_step)
    servo = BraceServo(pack_brace(scenario))
    station = MakeBraceStation(scenario, servo, swing(seconds))
    book = EnergyBook(station, scenario)
    run(station.diagram, seconds, book)
    return book.settle(time_step)


class TestEnergy(unittest.TestCase):
    def assert_balanced(self, cases, within):
        """Within a share of the work, and better as the step is finer."""
        gaps = []
        for case in cases:
            stored, work, lost = settle(*case)
            self.assertGreater(work, 0.01)
            gaps.append(abs(stored + lost - work) / work)
        self.assertLess(gaps[0], within)
        # Of first order in the step.
        self.assertAlmostEqual(gaps[0] / gaps[1], 2.0, delta=0.3)

    def test_the_task_space_brace_in_contact_keeps_its_accounts(self):
        steps = (5e-4, 2.5e-4)
        cases = [("task_space", "linear", step) for step in steps]
        self.assert_balanced(cases, 1e-3)

    def test_the_free_task_space_brace_keeps_its_accounts(self):
        cases = [("task_space", "none", step) for step in (1e-3, 5e-4)]
        self.assert_balanced(cases, 5e-3)

    def test_the_articulated_brace_keeps_its_accounts(self):
        cases = [("articulated", "none", step) for step in (1e-3, 5e-4)]
        self.assert_balanced(cases, 5e-3)


if __name__ == "__main__":
    unittest.main()
