"""The controllers in the diagram of the whole brace."""

import unittest

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.trajectories import PiecewisePolynomial

from brace_drake.kinematics import find_task_coordinates
from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.model.systems.brace_controllers import MakeController
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_rings
from brace_drake.scenario.controllers import TAGS


def hold(scenario, seconds, X_d, **inputs):
    """Runs a scenario with a constant reference; diagram and context."""
    controller = MakeController(scenario.control, pack_rings(scenario))
    desired = np.concatenate([X_d, np.zeros(2 * len(X_d))])
    station = MakeBraceStation(
        scenario, controller, PiecewisePolynomial(desired[:, None])
    )
    simulator = Simulator(station.diagram)
    context = simulator.get_mutable_context()
    for name, values in inputs.items():
        station.diagram.GetInputPort(name).FixValue(context, values)
    simulator.AdvanceTo(seconds)
    return station.diagram, context


class TestStation(unittest.TestCase):
    def test_every_controller_stays_where_it_starts(self):
        for tag in TAGS:
            scenario = BraceScenario()
            scenario.control.tag = tag
            scenario.start.ring3[5] = 0.004
            rings = pack_rings(scenario)
            diagram, context = hold(scenario, 0.3, rings.start)
            lengths = diagram.GetOutputPort("leg_length").Eval(context)
            X = find_task_coordinates(rings.geometry, lengths)
            with self.subTest(tag=tag):
                # Friction of the pads turns the ring back a little.
                np.testing.assert_allclose(X, rings.start, atol=1e-4)

    def test_three_rings_push_and_give_way_as_their_impedance_says(self):
        X_d = np.zeros(18)
        X_d[[1, 7, 13]] = -0.0005, -0.002, 0.001
        for tag in TAGS:
            scenario = BraceScenario()
            scenario.control.tag = tag
            rings = pack_rings(scenario)
            diagram, context = hold(scenario, 1.5, X_d)
            output = {
                name: diagram.GetOutputPort(name).Eval(context)
                for name in ("leg_length", "force", "virtual", "impedance")
            }
            X = find_task_coordinates(rings.geometry, output["leg_length"])
            force, K = output["force"][1::3], output["impedance"][37::6]
            on, wanted = K > 0.0, X_d.copy()
            if tag == "mraic":
                # Whatever it takes, the ring shows the reference.
                K = scenario.control.impedance.stiffness
            wanted[1::6][on] -= force[on] / K[on]
            with self.subTest(tag=tag):
                self.assertGreater(np.abs(force).max(), 2.0)
                self.assertEqual(on.sum(), 0 if tag in ("idc", "pid") else 3)
                # Friction of pads tilts the rings, and no torque is measured.
                off = np.abs(X - wanted).reshape((6, 3))
                self.assertLess(off[0::2].max(), 1.5e-4)  # m
                self.assertLess(off[1::2].max(), 2e-3)  # rad

    def test_one_stage_is_pushed_as_far_as_its_impedance_lets_it(self):
        scenario = BraceScenario(stages=[2])
        X_d = np.zeros(6)
        X_d[1] = -0.002
        diagram, context = hold(scenario, 2.0, X_d)
        force = diagram.GetOutputPort("force").Eval(context)
        virtual = diagram.GetOutputPort("virtual").Eval(context)
        self.assertLess(force[1], -1.0)
        self.assertAlmostEqual(
            X_d[1] - virtual[1], force[1] / 6000.0, delta=1e-5
        )

    def test_a_policy_reaches_the_stiffness_from_outside(self):
        scenario = BraceScenario()
        scenario.control.tag = "vpic"
        scenario.control.impedance.coordinates = ["y2"]
        diagram, context = hold(
            scenario, 0.2, np.zeros(18), stiffness=np.full(18, 20000.0)
        )
        K = diagram.GetOutputPort("impedance").Eval(context)[36:]
        self.assertEqual(list(np.flatnonzero(K)), [7])
        self.assertEqual(K[7], 20000.0)


if __name__ == "__main__":
    unittest.main()
