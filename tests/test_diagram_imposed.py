"""A plant that is moved as it was recorded: torques by equations of others."""

import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.core.errors import ScenarioError
from brace_drake.devices.choice import Choice
from brace_drake.devices.device import MakeDevice
from brace_drake.devices.diagram.imposed import MakeJointPath
from brace_drake.diagnosis import diagnose
from brace_drake.document.document import MakeDocument
from brace_drake.recording.ports import Ports, parse_ports
from brace_drake.recording.recording import Campaign, Run
from tests.foreign import machines
from tests.foreign.diagrams import MakeArm

RATE, SECONDS = 200.0, 6.0
DAMPING = (0.3, 0.2)
NOISE_RAD, NOISE_N_M = 2e-4, 2e-3
JOINTS = ("shoulder", "elbow")
NUMBERS = {
    f"{j}_damping_N_m_s_rad": d for j, d in zip(JOINTS, DAMPING, strict=True)
}
PORTS = Ports(
    imposed={j: f"{j}_rad" for j in JOINTS},
    forces={j: f"{j}_torque_N_m" for j in JOINTS},
    numbers=NUMBERS,
    fitted={name: (0.1 * d, 5.0 * d) for name, d in NUMBERS.items()},
)


def move(generator) -> np.ndarray:
    """Sums of three sines of both joints: q, q', q'' (3, 2, N)."""
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    rate = 2.0 * np.pi * generator.uniform(0.1, 1.0, (2, 3, 1))
    size = generator.uniform(0.2, 0.5, (2, 3, 1))
    angle = rate * t + generator.uniform(0.0, 2.0 * np.pi, (2, 3, 1))
    waves = (np.sin(angle), rate * np.cos(angle), -(rate**2) * np.sin(angle))
    return np.array([(size * w).sum(axis=1) for w in waves])


def make_campaign(
    load=(0.0, 0.0), is_noisy=True, friction=(0.0, 0.0), noise_N_m=NOISE_N_M
) -> Campaign:
    """An arm that another controller has moved, with a load on its hand and
    dry friction at its joints.
    """
    arm, runs = machines.arm(DAMPING, load), []
    generator = np.random.default_rng(4)
    for i, split in enumerate(("fit", "fit", "fit", "validation")):
        q, v, a = move(generator)
        tau = np.transpose(
            [
                arm.mass(q[:, k]) @ a[:, k] + arm.bias(q[:, k], v[:, k])
                for k in range(q.shape[1])
            ]
        )
        noise = is_noisy * generator.standard_normal((2, *q.shape))
        channels = {"time_s": np.arange(q.shape[1]) / RATE}
        for j, joint in enumerate(JOINTS):
            channels[f"{joint}_rad"] = q[j] + NOISE_RAD * noise[0, j]
            dry = friction[j] * np.tanh(v[j] / 0.01)
            torque = tau[j] + dry + noise_N_m * noise[1, j]
            channels[f"{joint}_torque_N_m"] = torque
        runs.append(Run(f"{i}.csv", True, f"{i}", None, split, channels))
    return Campaign(
        Path("arm"), "diagram", RATE, "arm", tuple(runs), ports=PORTS
    )


class TestPath(unittest.TestCase):
    def test_a_quintic_has_the_acceleration_that_it_has(self):
        t = np.linspace(0.0, 2.0, 400)
        y = np.polynomial.Polynomial([0.1, -1.0, 0.3, 0.5, -0.2, 0.03])
        path = MakeJointPath(t, y(t), 1e-6).path()
        wanted = np.column_stack([y(t), y.deriv()(t), y.deriv(2)(t)])
        np.testing.assert_allclose(path, wanted, atol=2e-4)


class TestTorques(unittest.TestCase):
    def test_torques_are_those_of_lagranges_equations(self):
        campaign = make_campaign(is_noisy=False)
        twin = MakeDevice(campaign, diagram=MakeArm).twin
        run = campaign.runs[0]
        found = twin.simulate(twin.motion(run), np.array(DAMPING))
        wanted = twin.measured(run)
        np.testing.assert_allclose(found, wanted, atol=0.01)

    def test_a_payload_and_friction_take_what_they_take(self):
        load, friction = (0.3, 0.25), 0.5
        campaign = make_campaign(load, is_noisy=False)
        twin = MakeDevice(campaign, diagram=MakeArm).twin
        effects, run = twin.effects(), campaign.runs[0]
        motion, subject = twin.motion(run), np.array(DAMPING)
        uses = [(effects["payload (lower)"], np.array(load))]
        loaded = twin.simulate(motion, subject, uses)
        np.testing.assert_allclose(loaded, twin.measured(run), atol=0.015)
        uses += [
            (effects["coulomb_friction (elbow)"], np.array([friction, 1e-4]))
        ]
        more = twin.simulate(motion, subject, uses) - loaded
        speed = motion.paths({})["elbow"][:, 1]
        # Where its bristles have gone over, and the motion is known.
        fast = (np.abs(speed) > 0.3) & (motion.trust()[:, 0] == 1.0)
        np.testing.assert_allclose(more[:, 0], 0.0, atol=1e-12)
        np.testing.assert_allclose(
            more[fast, 1], friction * np.sign(speed[fast]), atol=5e-3
        )


class TestDiagnosis(unittest.TestCase):
    def test_an_arm_as_it_should_be_has_no_gap(self):
        found = diagnose(make_campaign(), jobs=1, diagram=MakeArm)
        self.assertFalse(found.verdict.gap)
        for parameter, wanted in zip(
            found.estimates.parameters, DAMPING, strict=True
        ):
            self.assertAlmostEqual(parameter.value, wanted, delta=0.01)

    def test_a_load_in_its_hand_is_weighed(self):
        found = diagnose(
            make_campaign((0.3, 0.25)), jobs=1, diagram=MakeArm
        ).verdict
        self.assertEqual(found.effects, ("payload (lower)",))
        ((_, values),) = found.winner.uses
        np.testing.assert_allclose(values, (0.3, 0.25), rtol=0.02)

    def test_dry_friction_at_two_joints_is_two_causes(self):
        friction = (0.6, 0.3)
        campaign = make_campaign(friction=friction, noise_N_m=0.06)
        names = ("coulomb_friction", "joint_spring", "sensor_offset")
        found = diagnose(
            campaign, jobs=1, diagram=MakeArm, choice=Choice(effects=names)
        )
        causes = [f"coulomb_friction ({joint})" for joint in JOINTS]
        self.assertCountEqual(found.verdict.effects, causes)
        sizes = {e.cause: v[0] for e, v in found.verdict.winner.uses}
        for cause, wanted in zip(causes, friction, strict=True):
            self.assertAlmostEqual(sizes[cause], wanted, delta=0.1 * wanted)
        document = MakeDocument(found)["verdict"]
        self.assertEqual(document["effects"], ["coulomb_friction"] * 2)
        places = [row["form"] for row in document["supported"]]
        self.assertCountEqual(places, JOINTS)


class TestBadInput(unittest.TestCase):
    def test_a_joint_that_is_not_there_is_named(self):
        ports = replace(PORTS, imposed={"sholder": "shoulder_rad"}, forces={})
        campaign = replace(make_campaign(), ports=ports)
        with self.assertRaisesRegex(ScenarioError, "imposed: .*'sholder'"):
            MakeDevice(campaign, diagram=MakeArm)

    def test_ports_and_imposed_joints_exclude_each_other(self):
        both = {"imposed": {"a": "a_rad"}, "forces": {"a": "a_N_m"}}
        self.assertEqual(parse_ports(both)[1], [])
        for section, name in (
            ({}, "diagram.outputs"),
            ({"imposed": {"a": "a_rad"}}, "diagram.forces"),
            ({"forces": {"a": "a_N_m"}}, "diagram.imposed"),
            ({**both, "outputs": {"y": ["y"]}}, "diagram.outputs"),
            ({**both, "forces": {"b": "b_N_m"}}, "diagram.forces"),
            ({**both, "forces": {"a": "a_rad"}}, "diagram.columns of ports"),
        ):
            with self.subTest(section=section):
                (fault,) = parse_ports(section)[1]
                self.assertEqual(fault.name, name)


if __name__ == "__main__":
    unittest.main()
