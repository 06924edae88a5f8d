"""Any Drake diagram: machines of other equations, closed forms, bad input."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

import brace_drake as bd
from brace_drake.core.errors import CampaignError, ScenarioError
from brace_drake.devices.device import MakeDevice
from brace_drake.devices.diagram.factory import call_factory, find_factory
from brace_drake.devices.diagram.joint_forces import solve_speed
from brace_drake.effects.registry import effects_for
from brace_drake.effects.series import pass_series
from brace_drake.recording import LoadCampaign, WriteCampaign
from brace_drake.recording.importing.mapped import ImportCampaign
from brace_drake.scenario.effects import describe_use
from brace_drake.scenario.load import LoadScenario, SaveScenario
from tests.foreign.campaigns import SETUPS, make_campaign
from tests.foreign.diagrams import MakeArm, MakeCartPole, MakePendulum
from tests.foreign.machines import Fault

MAKERS = {"cart_pole": MakeCartPole, "arm": MakeArm, "pendulum": MakePendulum}
HERE = Path(__file__).resolve().parent


def off_in_noise(name: str, fault: Fault, *effects) -> np.ndarray:
    """What a twin with effects leaves of a machine, in its readings' noise.

    Args:
        name: Of the machine.
        fault: Of the machine.
        effects: Keys of the effects, each with its parameters.
    """
    campaign = make_campaign(name, fault, 1)
    twin = MakeDevice(campaign, diagram=MAKERS[name]).twin
    cards = twin.effects()
    uses = [(cards[key], np.array(values)) for key, values in effects]
    subject = np.array(SETUPS[name].true_dampings(1))
    noise = np.array([twin.scenario.noise[n] for n in twin.channels])
    rest = [
        twin.simulate(twin.motion(run), subject, uses) - twin.measured(run)
        for run in campaign.runs[:2]
    ]
    return np.sqrt(np.mean(np.concatenate(rest) ** 2, axis=0)) / noise


class TestReplay(unittest.TestCase):
    def test_nominal_diagrams_agree_with_equations_by_hand(self):
        for name in MAKERS:
            with self.subTest(name):
                self.assertLess(off_in_noise(name, Fault()).max(), 1.1)

    def test_a_payload_is_one_by_other_equations(self):
        load = (0.05, 0.4)
        fault = Fault("payload", 1, load)
        found = off_in_noise("cart_pole", fault, ("payload (pole)", load))
        self.assertLess(found.max(), 1.1)
        self.assertGreater(off_in_noise("cart_pole", fault).max(), 10.0)

    def test_effects_on_the_command_are_those_of_another_simulator(self):
        for kind, values in (
            ("command_delay", (0.043,)),
            ("command_lag", (0.08,)),
            ("command_gain", (-0.15,)),
            ("command_deadzone", (0.5,)),
            ("saturation", (2.0,)),
            ("rate_limit", (20.0,)),
        ):
            fault = Fault(kind, 0, values)
            with self.subTest(kind):
                found = off_in_noise(
                    "cart_pole", fault, (f"{kind} (force)", values)
                )
                self.assertLess(found.max(), 3.0)

    def test_dry_friction_of_a_joint_leaves_a_hundredth(self):
        fault = Fault("coulomb_friction", 0, (0.6, 1e-3))
        alone = off_in_noise("cart_pole", fault)
        found = off_in_noise(
            "cart_pole", fault, ("coulomb_friction (slide)", (0.6,))
        )
        self.assertLess(found.max(), 0.03 * alone.max())


class TestLaws(unittest.TestCase):
    def test_the_speed_of_a_linear_force_is_exact(self):
        # v = v_0 - a v.
        for a in (1e-3, 1.0, 1e6):
            found = solve_speed(lambda v, a=a: -a * v, 2.0)
            self.assertAlmostEqual(found, 2.0 / (1.0 + a), delta=1e-6)

    def test_dry_friction_that_can_hold_stops_it(self):
        found = solve_speed(lambda v: -0.5 * np.tanh(1e6 * v), 0.3)
        self.assertAlmostEqual(found, 0.0, delta=1e-5)
        found = solve_speed(lambda v: -0.5 * np.tanh(1e6 * v), 0.8)
        self.assertAlmostEqual(found, 0.3, delta=1e-6)

    def test_a_signal_is_late_by_its_delay(self):
        dt = 1e-3
        t = dt * np.arange(2000)
        found = self.passed("command_delay", np.sin(t), dt, 0.0457)
        wanted = np.sin(np.maximum(t - 0.0457, 0.0))
        np.testing.assert_allclose(found, wanted, atol=1e-6)

    def test_a_lag_follows_a_ramp_as_its_solution_does(self):
        dt, tau = 1e-2, 0.05
        t = dt * np.arange(100)
        found = self.passed("sensor_lag", t, dt, tau)
        wanted = t - tau * (1.0 - np.exp(-t / tau))
        np.testing.assert_allclose(found, wanted, atol=1e-12)

    def test_a_held_signal_changes_once_in_its_period(self):
        t = 1e-3 * np.arange(1000)
        found = self.passed("sensor_hold", t, 1e-3, 0.05)
        np.testing.assert_allclose(found, 0.05 * np.floor(t / 0.05 + 1e-9))

    @staticmethod
    def passed(name, sent, dt, *values):
        place = name.split("_")[0]
        way = {"command": "command of a port", "sensor": "reading of a port"}
        card = effects_for(way[place])[f"{name} (signal)"]
        return pass_series(sent, dt, 1.0, [(card, np.array(values))])


class TestFit(unittest.TestCase):
    def test_the_fit_finds_the_dampings_of_a_machine_of_other_equations(self):
        campaign = make_campaign("pendulum", Fault(), 5)
        found = bd.fit(campaign, diagram=MakePendulum, progress=False).document
        self.assertLess(found["mean_square"], 1.2)
        true = SETUPS["pendulum"].true_dampings(5)
        for p, value in zip(found["parameters"], true, strict=True):
            self.assertEqual(p["unit"], "N m s/rad")
            error = abs(p["value"] - value)
            self.assertLess(error, 4.0 * p["standard_error"] + 1e-4 * value)


class TestScenario(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.campaign = make_campaign("cart_pole", Fault(), 1)
        cls.device = MakeDevice(cls.campaign, diagram=MakeCartPole)

    def test_effects_sit_on_ports_joints_and_bodies(self):
        keys = set(self.device.twin.effects())
        wanted = {
            "command_delay (force)",
            "sensor_scale (pole_speed)",
            "coulomb_friction (hinge)",
            "payload (pole)",
        }
        self.assertLessEqual(wanted, keys)

    def test_readings_that_differ_by_their_unit_have_effects_of_their_own(self):
        campaign = make_campaign("pendulum", Fault(), 1)
        twin = MakeDevice(campaign, diagram=MakePendulum).twin
        card = twin.effects()["sensor_scale (arm_rad)"]
        self.assertIn("sensor_scale (arm_rad_s)", twin.effects())
        motion = twin.motion(campaign.runs[0])
        subject = np.array([p.nominal for p in twin.subject])
        before = twin.simulate(motion, subject)
        after = twin.simulate(motion, subject, ((card, np.array([0.2])),))
        np.testing.assert_allclose(after[:, 0], 1.2 * before[:, 0])
        np.testing.assert_array_equal(after[:, 1:], before[:, 1:])

    def test_a_joint_moves_as_far_as_it_was_read_to(self):
        # Without the spring the nominal arm turns far away.
        spring = Fault("joint_spring", 0, (0.03,))
        campaign = make_campaign("pendulum", spring, 1)
        sizes = MakeDevice(campaign, diagram=MakePendulum).twin.scenario.joints
        read = [r.channels["arm_rad"] for r in campaign.split("fit")]
        half = 0.5 * np.ptp(np.concatenate(read))
        self.assertAlmostEqual(sizes["turn"].travel, half)

    def test_a_repaired_scenario_comes_back_the_same(self):
        twin = self.device.twin
        subject = np.array([2.0, 0.003])
        card = twin.effects()["coulomb_friction (slide)"]
        uses = [(card, np.array([0.7]))]
        scenario = twin.scenario_of(subject)
        scenario.effects = [describe_use(*uses[0])]
        with tempfile.TemporaryDirectory() as folder:
            SaveScenario(scenario, Path(folder) / "a.yaml")
            loaded = LoadScenario(Path(folder) / "a.yaml")
        again = MakeDevice(self.campaign, loaded, MakeCartPole).twin
        motion = twin.motion(self.campaign.runs[0])
        nominal = np.array([p.nominal for p in again.subject])
        np.testing.assert_allclose(
            again.simulate(motion, nominal),
            twin.simulate(motion, subject, uses),
            atol=1e-9,
        )

    def test_a_campaign_comes_back_from_its_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "one"
            WriteCampaign(self.campaign, path)
            loaded = LoadCampaign(path)
        self.assertEqual(loaded.ports, self.campaign.ports)
        for one, other in zip(loaded.runs, self.campaign.runs, strict=True):
            np.testing.assert_allclose(
                one.stack(loaded.ports.columns),
                other.stack(loaded.ports.columns),
                atol=1e-5,
            )


class TestBadInput(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.campaign = make_campaign("cart_pole", Fault(), 1)

    def fails(self, **changes) -> str:
        ports = replace(self.campaign.ports, **changes)
        campaign = replace(self.campaign, ports=ports)
        with self.assertRaises(ScenarioError) as raised:
            MakeDevice(campaign, diagram=MakeCartPole)
        text = str(raised.exception)
        self.assertNotIn("\n", text)
        return text

    def test_a_port_that_is_not_there_is_named(self):
        text = self.fails(inputs={"forces": ("force_N",)})
        self.assertIn("no port 'forces'", text)
        self.assertIn("did you mean force?", text)

    def test_a_port_of_another_size_is_named(self):
        text = self.fails(outputs={"state": ("cart_m",)})
        self.assertIn("4 elements, and 1 columns", text)

    def test_an_input_port_that_the_map_leaves_open_is_named(self):
        self.assertIn("input port force", self.fails(inputs={}))

    def test_a_joint_that_is_not_there_is_named(self):
        self.assertIn("'hinges'", self.fails(start={"hinges": "pole_rad"}))

    def test_no_function_says_how_to_name_one(self):
        with self.assertRaisesRegex(ScenarioError, "--diagram"):
            MakeDevice(self.campaign)

    def test_a_function_that_fails_is_told_in_one_line(self):
        def fails(numbers):
            return numbers["mass"]

        with self.assertRaisesRegex(ScenarioError, "KeyError: 'mass'"):
            call_factory(fails, {})
        with self.assertRaisesRegex(ScenarioError, "returns a int"):
            call_factory(lambda: 3, {})

        def leaves(numbers):
            raise SystemExit(0)

        with self.assertRaisesRegex(ScenarioError, "SystemExit: 0"):
            call_factory(leaves, {})

    def test_functions_are_found_by_module_and_by_file(self):
        path = HERE / "foreign" / "diagrams.py"
        found = find_factory(f"{path}:MakeCartPole")
        self.assertEqual(found.__name__, "MakeCartPole")
        for name, message in (
            ("arm", "module:function"),
            ("nosuch:Make", "no module nosuch"),
            (f"{path}:MakeCartPoles", "did you mean"),
        ):
            with self.assertRaisesRegex(ScenarioError, message):
                find_factory(name)

    def test_faults_of_the_section_are_errors_of_the_campaign(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "one"
            WriteCampaign(self.campaign, path)
            text = (path / "campaign.yaml").read_text()
            for old, new, message in (
                ("outputs:", "outputz:", "diagram.outputs is missing"),
                ("cart_mass_kg: 1.0", "cart_mass_kg: heavy", "map of numbers"),
                ("- 0.0004", "- 0.02", "limits"),
                ("- pole_rad\n", "- cart_m\n", "each once"),
            ):
                with self.subTest(new):
                    self.assertIn(old, text)
                    broken = text.replace(old, new, 1)
                    (path / "campaign.yaml").write_text(broken)
                    with self.assertRaisesRegex(CampaignError, message):
                        LoadCampaign(path)

    def test_a_map_makes_a_campaign_of_a_labs_own_columns(self):
        ports = {
            "inputs": {"force": ["force_N"]},
            "outputs": {"state": ["cart_m", "pole_rad"]},
        }
        head = {
            "format": "brace-import/1",
            "device": "diagram",
            "diagram": ports,
            "columns": {
                "time_s": "t",
                "force_N": "u",
                "cart_m": {"from": "x", "unit": "mm"},
                "pole_rad": "angle",
            },
            "runs": [{"file": "a.csv", "split": "fit"}],
        }
        with tempfile.TemporaryDirectory() as folder:
            rows = [f"{i / 100},{i % 3},{i},{i / 7}" for i in range(50)]
            text = "\n".join(["t,u,x,angle", *rows])
            (Path(folder) / "a.csv").write_text(text)
            path = Path(folder) / "map.yaml"
            path.write_text(yaml.safe_dump(head))
            campaign = ImportCampaign(path)
            (run,) = campaign.runs
            np.testing.assert_allclose(
                run.channels["cart_m"], np.arange(50) / 1e3
            )
            self.assertEqual(
                campaign.ports.columns, ("force_N", "cart_m", "pole_rad")
            )
            del head["columns"]["pole_rad"]
            path.write_text(yaml.safe_dump(head))
            with self.assertRaisesRegex(CampaignError, "no pole_rad"):
                ImportCampaign(path)
            head["diagram"] = {"inputs": {}}
            path.write_text(yaml.safe_dump(head))
            with self.assertRaisesRegex(CampaignError, "diagram.outputs"):
                ImportCampaign(path)

    def test_a_diagram_is_for_campaigns_of_one(self):
        other = replace(self.campaign, device="axis", ports=None)
        with self.assertRaisesRegex(CampaignError, "device: diagram"):
            MakeDevice(other, diagram=MakeCartPole)


if __name__ == "__main__":
    unittest.main()
