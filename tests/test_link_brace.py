"""A whole brace on the link: its plant, its limits, host and device."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.core.errors import (
    CampaignError,
    LimitsError,
    ScenarioError,
)
from brace_drake.devices.motions.library import MakeMotion, SafeMotion
from brace_drake.devices.motions.parts import ramp
from brace_drake.effects.registry import find_effect
from brace_drake.kinematics import static_leg_forces
from brace_drake.laws.loop.force_left import calc_forces_left
from brace_drake.laws.stages import place_rings
from brace_drake.link.device.guards import check_force, check_stroke
from brace_drake.link.device.limits_file import LoadLimits
from brace_drake.link.device.stuck import check_stuck, count_travel
from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.emulator.brace_plant import BracePlant
from brace_drake.link.operation.motion import (
    desired_at_ticks,
    motion_of_rings,
    place_motion,
)
from brace_drake.link.operation.station import MakeControl
from brace_drake.link.protocol.limits import DEFAULT, SHARED, refuse_wider
from brace_drake.link.protocol.limits import shared_values as values_of
from brace_drake.link.protocol.words import Cause, DeviceState, Reason
from brace_drake.model.simulate import SimulateBrace
from brace_drake.scenario.brace import BenchScenario, BraceScenario
from brace_drake.scenario.brace_numbers import geometry_of, pack_brace
from tests.link_bench import Lockstep, begin, wave

RINGS = (1, 2, 3)
SCENARIO = BraceScenario()
LIMITS = LoadLimits(None, RINGS)


def short_push(depth=-0.006, rise=0.2, seconds=0.4):
    time = np.arange(round(200 * seconds)) / 200.0
    samples = ramp(time, 0.05, rise, depth)
    return SafeMotion("push", "", True, "push", time, samples)


def use(name, **values):
    card = find_effect(name)
    return card, card.in_run(card.vector(values), 0)


class TestPlant(unittest.TestCase):
    def test_with_the_hosts_control_it_is_the_diagram(self):
        motion = short_push()
        desired = desired_at_ticks(place_motion(motion, RINGS), 1000.0)
        for tag in ("pic", "mraic", "pid"):
            control = replace(SCENARIO.control, tag=tag)
            scenario = replace(SCENARIO, control=control)
            log = SimulateBrace(scenario, motion.run)
            host = MakeControl(SCENARIO, LIMITS, tag)
            plant = BracePlant(SCENARIO, seed=None)
            u, y, lengths = plant.hold, [], []
            for row in desired:
                readings = plant.advance(u).copy()
                y.append(plant.bodies[5:20:7].copy())
                lengths.append(readings[0:18])
                u = host.Tick(readings, row).copy()
            with self.subTest(tag=tag):
                N = len(y[::5])
                np.testing.assert_allclose(
                    y[::5], log.X[:N, :, 1], rtol=0, atol=1e-9
                )
                np.testing.assert_allclose(
                    lengths[::5], log.leg_length[:N], rtol=0, atol=1e-9
                )
                self.assertGreater(np.ptp(y, axis=0).min(), 1e-4)

    def test_stage_two_alone_with_effects_is_the_bench_bit_by_bit(self):
        uses = (
            use("coulomb_friction", coulomb_N=0.6),
            use("relaxation", arm_stiffness_N_m=2e3, relaxation_time_s=0.5),
        )
        bench = BenchPlant(BenchScenario(time_step=5e-4), uses, seed=3)
        brace = BracePlant(replace(SCENARIO, stages=[2]), uses, seed=3)
        np.testing.assert_allclose(brace.hold, bench.hold, rtol=1e-12)
        t = np.arange(300) * 1e-3
        for i in range(300):
            u = np.array(bench.hold) + 2.0 * np.sin(20.0 * t[i])
            np.testing.assert_allclose(
                brace.advance(u), bench.advance(u), rtol=0, atol=1e-12
            )

    def test_the_weight_of_every_ring_is_carried_at_rest(self):
        plant = BracePlant(SCENARIO, seed=None)
        plant.with_torso = False
        first = plant.advance(plant.hold).copy()
        for _ in range(300):
            readings = plant.advance(plant.hold)
        np.testing.assert_allclose(readings[:18], first[:18], atol=1e-9)
        rest = geometry_of(pack_brace(SCENARIO)).rest_lengths
        np.testing.assert_allclose(first[:18], rest, rtol=1e-12)

    def test_effects_of_the_library_act_on_every_stage_alike(self):
        offsets = {f"offset{k}_m": 1e-4 * k for k in range(1, 7)}
        uses = (
            use("force_bias", force_bias_N=0.8),
            use("encoder_offset", **offsets),
        )
        plain = BracePlant(SCENARIO, seed=5)
        with_effects = BracePlant(SCENARIO, uses, seed=5)
        away = with_effects.advance(plain.hold) - plain.advance(plain.hold)
        expected = np.zeros(30)
        expected[:18] = np.tile(1e-4 * np.arange(1, 7), 3)
        expected[[19, 22, 25]] = 0.8
        # Readings are rounded after the effects: to 10 um and 0.0244 N.
        np.testing.assert_allclose(away[:18], expected[:18], atol=1.01e-5)
        np.testing.assert_allclose(away[18:27], expected[18:27], atol=0.025)

    def test_each_stage_has_a_memory_of_its_own_in_an_effect(self):
        # Only stage 3 is driven: bristles of the others must not bend.
        friction = (use("coulomb_friction", coulomb_N=2.0),)
        plant = BracePlant(SCENARIO, friction, seed=None)
        plant.with_torso = False
        hold = np.array(plant.hold)
        first = plant.advance(hold).copy()
        u = hold.copy()
        u[12:18] += 4.0
        for _ in range(20):
            readings = plant.advance(u)
        moved = np.abs(readings[:18] - first[:18]).reshape((3, 6)).max(axis=1)
        self.assertGreater(moved[2], 1e-5)
        # What reaches them is the reaction, which friction holds: micrometres.
        self.assertLess(moved[0], 0.2 * moved[2])

    def test_what_has_no_compiled_law_is_refused_in_a_line(self):
        hydro = replace(SCENARIO, contact=BraceScenario().contact)
        hydro.contact.ring3.model = "hydroelastic"
        legs = replace(SCENARIO, mechanism="articulated")
        for make, error, words in (
            (lambda: BracePlant(hydro), ScenarioError, "contact.ring3.model"),
            (lambda: BracePlant(legs), ScenarioError, "'task_space'"),
        ):
            with self.assertRaisesRegex(error, words) as caught:
                make()
            self.assertNotIn("\n", str(caught.exception))

    def test_rings_that_were_put_back_leave_the_torso_where_it_is(self):
        plant = BracePlant(SCENARIO, seed=None)
        plant.advance(plant.hold)
        self.assertFalse(plant.is_away)
        plant.bodies[5], plant.bodies[26] = 0.001, 0.002
        plant.advance(plant.hold)
        self.assertTrue(plant.is_away)
        torso = plant.bodies[26]
        plant.put_rings_back()
        self.assertEqual(plant.bodies[5], 0.0)
        self.assertEqual(plant.bodies[26], torso)


class TestLimits(unittest.TestCase):
    def test_a_leg_is_judged_by_the_stroke_of_its_stage(self):
        lengths = np.repeat([0.18, 0.14, 0.13], 6)
        self.assertIsNone(check_stroke(LIMITS, lengths))
        lengths[12] = 0.18
        trip = check_stroke(LIMITS, lengths)
        self.assertEqual((trip.cause, trip.index), (Cause.LEG_STROKE, 12))
        self.assertEqual(trip.limit, 0.159)
        one_for_all = LIMITS._replace(leg_longest=0.2)
        self.assertIsNone(check_stroke(one_for_all, lengths))

    def test_limits_are_those_of_the_devices_stages(self):
        self.assertEqual(LIMITS.leg_shortest, (0.160, 0.116, 0.110))
        self.assertEqual(LoadLimits().leg_shortest, DEFAULT.leg_shortest)
        upper = LoadLimits(None, (2, 3))
        self.assertEqual(upper.leg_longest, (0.166, 0.159))
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "limits.yaml"
            file.write_text("leg_longest: 0.2\n")
            one = LoadLimits(file, RINGS)
            self.assertEqual(one, LIMITS._replace(leg_longest=0.2))
            file.write_text("leg_longest: [0.2, 0.1]\n")
            with self.assertRaisesRegex(LimitsError, "leg_longest has 2"):
                LoadLimits(file, RINGS)
            file.write_text("leg_longest: [0.2, 0.1, 0.2]\n")
            with self.assertRaisesRegex(LimitsError, "0.116 m; .* 0.1$"):
                LoadLimits(file, RINGS)
            file.write_text("leg_force: [1, 2, 3]\n")
            with self.assertRaisesRegex(LimitsError, "a number"):
                LoadLimits(file, RINGS)
        same = {"leg_shortest": 0.1, "leg_longest": 0.2}
        self.assertEqual(LIMITS._replace(**same), DEFAULT._replace(**same))

    def test_at_rest_every_leg_has_room_of_half_a_stroke(self):
        rest = geometry_of(pack_brace(SCENARIO)).rest_lengths.reshape((3, 6))
        np.testing.assert_allclose(
            rest.min(axis=1) - LIMITS.leg_shortest, 0.025, atol=1e-3
        )
        np.testing.assert_allclose(
            LIMITS.leg_longest - rest.max(axis=1), 0.025, atol=1e-3
        )

    def test_a_wider_stage_is_refused_by_both_sides(self):
        wide = LIMITS._replace(leg_longest=(0.209, 0.166, 0.165))
        allowed = values_of(LIMITS, 3)
        with self.assertRaisesRegex(LimitsError, r"0\.165 m, .* 0\.159"):
            refuse_wider(wide, allowed, stages=3)
        device = Lockstep(LIMITS, BracePlant(SCENARIO), scenario=SCENARIO)
        echo = device.agree(wide)
        self.assertEqual(echo.reason, Reason.LIMIT_TOO_WIDE)
        self.assertEqual(SHARED[echo.index].name, "leg_longest")

    def test_the_ring_that_presses_too_much_is_named(self):
        force = np.zeros(9)
        force[7] = 60.0
        trip = check_force(LIMITS._replace(total_force=100.0), force)
        self.assertEqual((trip.cause, trip.index), (Cause.PAD_FORCE, 2))
        force[[1, 4, 7]] = 30.0
        trip = check_force(LIMITS, force)
        self.assertEqual((trip.cause, trip.value), (Cause.TOTAL_FORCE, 90.0))

    def test_a_held_stage_is_not_stuck_while_another_travels(self):
        zeros, still = (0.0,) * 18, (False,) * 18
        length = tuple([0.0] * 6 + [0.004] * 5 + [0.0] + [0.0] * 6)
        trip = check_stuck(0.003, zeros, zeros, still, length)
        self.assertEqual((trip.cause, trip.index), (Cause.STUCK_LEG, 11))
        all_move = tuple([0.0] * 6 + [0.004] * 6 + [0.0] * 6)
        self.assertIsNone(check_stuck(0.003, zeros, zeros, still, all_move))
        origin, moved = count_travel(0.003, zeros, zeros, still, all_move)
        self.assertEqual(origin, all_move)
        self.assertEqual(moved, still)


class TestForceLeft(unittest.TestCase):
    def test_it_is_the_force_that_static_legs_put_on_each_ring(self):
        numbers = pack_brace(SCENARIO)
        geometry, draw = geometry_of(numbers), np.random.default_rng(2)
        X = draw.normal(scale=[[2e-3] * 3 + [0.02] * 3] * 3).ravel()
        wrench = draw.normal(scale=5.0, size=(3, 6))
        weights = numbers.ring[:, 4].copy()
        W = wrench.copy()
        W[:, 2] += weights
        f = static_leg_forces(geometry, X, W.ravel())
        poses, found = np.empty((3, 7)), np.empty(9)
        place_rings(X, geometry.rest, poses)
        calc_forces_left(
            poses, np.zeros((3, 6)), f, numbers.viscous, weights,
            geometry.lower, geometry.upper, found,
        )  # fmt: skip
        np.testing.assert_allclose(
            found, wrench[:, :3].ravel(), rtol=0, atol=1e-9
        )


class TestMotions(unittest.TestCase):
    def test_one_ring_moves_and_the_others_are_held(self):
        motion = MakeMotion("push")
        placed = place_motion(motion, RINGS, 3)
        np.testing.assert_array_equal(placed.samples[:, :, 2], motion.samples)
        self.assertFalse(placed.samples[:, :, :2].any())
        desired = desired_at_ticks(placed, 1000.0)
        self.assertEqual(desired.shape, (11996, 3, 3))
        middle = desired_at_ticks(place_motion(motion, RINGS), 1000.0)
        np.testing.assert_array_equal(middle[:, :, 1], desired[:, :, 2])
        alone = place_motion(motion, (2,)).samples
        np.testing.assert_array_equal(alone[:, :, 0], motion.samples)
        with self.assertRaisesRegex(CampaignError, "no ring 1; .* 2, 3"):
            place_motion(motion, (2, 3), 1)

    def test_a_reference_may_move_several_rings(self):
        run = short_push().run
        more = {
            name.replace("ring2", "ring3"): 0.5 * values
            for name, values in run.channels.items()
            if name.startswith("ring2")
        }
        run = replace(run, channels=run.channels | more)
        motion = motion_of_rings(run, RINGS)
        np.testing.assert_array_equal(
            motion.samples[:, :, 2], 0.5 * motion.samples[:, :, 1]
        )
        with self.assertRaisesRegex(CampaignError, "moves ring 3"):
            motion_of_rings(run, (1, 2))


class TestSession(unittest.TestCase):
    def start(self, **more):
        device = Lockstep(
            LIMITS, BracePlant(SCENARIO), scenario=SCENARIO, **more
        )
        desired = np.zeros((1000, 3, 3))
        desired[:, :, 1] = wave(0.006, 1.0)
        control = MakeControl(SCENARIO, LIMITS)
        return device, begin(device, control, LIMITS, desired)

    def test_the_middle_ring_follows_and_its_neighbours_give_way_little(self):
        device, session = self.start()
        device.run(1500)
        self.assertTrue(session.done, session.trip)
        y = np.array([row.y_ring for row in session.rows])
        y_virtual = np.array([row.y_virtual for row in session.rows])
        self.assertLess(y[:, 1].min(), -0.002)
        self.assertLess(np.abs(y - y_virtual).max(), 2e-3)
        # They have the pads' force alone, against 6000 N/m.
        self.assertLess(np.abs(y[:, [0, 2]]).max(), 0.5 * np.abs(y[:, 1]).max())
        self.assertEqual(session.rows[-1].command.shape, (18,))

    def test_a_dead_host_ends_in_the_watchdogs_stop_and_no_stiffness(self):
        device, _ = self.start()
        device.run(900)
        self.assertEqual(device.firmware.state, DeviceState.ARMED)
        device.host_is_dead = True
        device.run(round(1e3 * LIMITS.watchdog) + 2)
        self.assertEqual(device.firmware.state, DeviceState.STOPPED)
        self.assertEqual(device.firmware.trip.cause, Cause.WATCHDOG)
        device.run(round(1e3 * LIMITS.release_time) + 1)
        damping = np.abs(np.subtract(device._u, device.plant.hold)).max()
        most = LIMITS.release_damping * np.abs(device.firmware._speed).max()
        self.assertLessEqual(damping, most + 1e-9)

    def test_rings_found_away_are_brought_home_softly(self):
        host = MakeControl(SCENARIO, LIMITS)
        plant = BracePlant(SCENARIO, seed=None)
        plant.with_torso = False
        plant.bodies[5], plant.bodies[12] = 0.003, -0.002
        host.Reset()
        host.GoHome(400)
        u, y, forces = plant.hold, [], []
        for _ in range(1400):
            u = host.Tick(plant.advance(u), np.zeros((3, 3))).copy()
            y.append(plant.bodies[5:20:7].copy())
            forces.append(u - plant.hold)
        np.testing.assert_allclose(y[0], [0.003, -0.002, 0], atol=1e-5)
        self.assertLess(np.abs(forces[0]).max(), 1.0)
        np.testing.assert_allclose(y[-1], 0.0, atol=2e-5)


if __name__ == "__main__":
    unittest.main()
