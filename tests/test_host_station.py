"""The station with a device against the stations of simulation."""

import unittest

import numpy as np

from brace_drake.link.operation.control import HostControl, MakeHostStation
from brace_drake.link.protocol.limits import DEFAULT
from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.model.systems.brace_controllers import MakeController
from brace_drake.model.systems.device_station import DeviceStation
from brace_drake.scenario.brace import BenchScenario, BraceScenario
from brace_drake.scenario.brace_numbers import pack_rings


class TestDeviceStation(unittest.TestCase):
    def test_it_has_the_ports_of_a_station_without_a_controller(self):
        for stages in ([2], [1, 2, 3]):
            scenario = BraceScenario(stages=stages)
            simulated = MakeBraceStation(scenario).diagram
            device = DeviceStation(len(stages))
            for i in range(device.num_input_ports()):
                port = device.get_input_port(i)
                there = simulated.GetInputPort(port.get_name())
                self.assertEqual(port.size(), there.size())
            names = []
            for i in range(device.num_output_ports()):
                port = device.get_output_port(i)
                there = simulated.GetOutputPort(port.get_name())
                self.assertEqual(port.size(), there.size())
                names.append(port.get_name())
            self.assertEqual(names, ["leg_length", "force", "marker"])

    def test_it_shows_the_readings_that_it_was_given_last(self):
        device = DeviceStation(3)
        context = device.CreateDefaultContext()
        for seed in (0, 1):
            readings = np.random.default_rng(seed).normal(size=30)
            device.SetReadings(context, readings)
            found = [
                device.GetOutputPort(name).Eval(context)
                for name in ("leg_length", "force", "marker")
            ]
            np.testing.assert_array_equal(np.concatenate(found), readings)


class TestHostStation(unittest.TestCase):
    def test_its_controller_is_connected_as_in_simulation(self):
        scenario = BraceScenario(stages=[2])
        rings = pack_rings(scenario)
        diagram, _ = MakeHostStation(
            MakeController(scenario.control, rings), 1, 1e-3
        )
        self.assertEqual(diagram.num_input_ports(), 1)
        self.assertEqual(diagram.GetInputPort("desired").size(), 18)
        simulated = MakeBraceStation(
            scenario, MakeController(scenario.control, rings)
        ).diagram
        for name in ("leg_command", "virtual", "impedance", "estimate"):
            self.assertEqual(
                diagram.GetOutputPort(name).size(),
                simulated.GetOutputPort(name).size(),
            )

    def test_a_bench_is_controlled_as_the_brace_of_its_stage(self):
        lengths = HostControl(BenchScenario())._geometry.rest_lengths
        readings = np.concatenate([lengths + 2e-4, [0.1, -2.0, 0.2, 0, 0, 0]])
        commands = []
        for scenario in (BenchScenario(), BraceScenario(stages=[2])):
            control = HostControl(scenario, DEFAULT)
            for i in range(20):
                command = control.Tick(readings, np.array([-1e-5 * i, 0, 0]))
            commands.append(command.copy())
        np.testing.assert_allclose(*commands, atol=1e-9)
        self.assertGreater(np.ptp(commands[0]), 0.1)
