"""Copies of a brace side by side against each of them alone."""

import math
import unittest
from dataclasses import replace

import numpy as np
from numba import njit

from brace_drake.devices.bench.rollout import Motion, simulate_bench
from brace_drake.devices.bench.rollout_copies import (
    MachineRun,
    simulate_copies,
)
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.brace.twin import BraceTwin
from brace_drake.devices.run_memory import RunMemory
from brace_drake.devices.twin import Request
from brace_drake.effects.actuation import (
    backlash,
    command_delay,
    coulomb_friction,
    stribeck_friction,
)
from brace_drake.effects.mechanism import leg_compliance
from brace_drake.effects.stack import stack_effects
from brace_drake.effects.unknown import parts_of_term, terms_for
from brace_drake.effects.within_tolerances import WITHIN_TOLERANCES
from brace_drake.laws.control.brace_control import K_P, LIMIT
from brace_drake.laws.lanes import elementary
from brace_drake.laws.lanes.arrays import floats_of, lanes_of, stack_copies
from brace_drake.laws.lanes.functions import every, lead, some, where
from brace_drake.laws.lanes.kinds import COUNT
from brace_drake.laws.linear_solve import solve_in_place
from brace_drake.laws.plug_in import make_effects_of
from brace_drake.scenario.brace import BenchScenario, BraceScenario


@njit
def _functions_of_lanes(x, y, out):
    _functions(lanes_of(x), lanes_of(y), lanes_of(out))


@njit
def _functions(x, y, out):
    for i in range(x.shape[0]):
        out[i, 0] = elementary.exp(x[i])
        out[i, 1] = elementary.tanh(x[i])
        out[i, 2] = elementary.sin(x[i])
        out[i, 3] = elementary.cos(x[i])
        out[i, 4] = elementary.atan2(y[i], x[i])


@njit
def _arithmetic(a, b, out):
    a, b, out = lanes_of(a), lanes_of(b), lanes_of(out)
    out[0] = a[0] + 2 * b[0] - 1.0 / a[0]
    out[1] = where(a[0] > b[0], a[0], -b[0])
    out[2] = max(min(a[0], b[0]), 0.0)
    out[3] = abs(a[0]) * math.sqrt(abs(b[0]))
    out[4] = 0.5 * round(a[0] / 0.5)
    out[5] = lead(a[0])
    out[6] = 1.0 if every(a[0] > -9.0) and not every(a[0] > b[0]) else 0.0
    out[7] = 1.0 if some(a[0] > b[0]) and not some(a[0] != a[0]) else 0.0
    floats_of(out)[8, 1] = 7.0


@njit
def _solve_lanes(A, b):
    return solve_in_place(lanes_of(A), lanes_of(b))


def sway(seconds: float, with_torso: bool = True, columns=(1,)) -> Motion:
    t, w = np.arange(0.0, seconds, 1e-3), 2.0 * np.pi * 0.5
    y = -0.004 + 0.004 * np.cos(w * t)
    rate, second = -0.004 * w * np.sin(w * t), -0.004 * w * w * np.cos(w * t)
    desired = np.stack([y, rate, second], axis=-1)[:, :, None]
    ways = np.repeat(desired, len(columns), axis=-1)
    return Motion(np.ascontiguousarray(ways), with_torso, columns=columns)


class TestLanes(unittest.TestCase):
    def setUp(self):
        self.random = np.random.default_rng(0)

    def test_arithmetic_is_that_of_each_copy(self):
        a, b = self.random.normal(size=(2, 1, COUNT))
        out = np.zeros((9, COUNT))
        _arithmetic(a, b, out)
        a, b = a[0], b[0]
        expected = [
            a + 2 * b - 1.0 / a,
            np.where(a > b, a, -b),
            np.maximum(np.minimum(a, b), 0.0),
            np.abs(a) * np.sqrt(np.abs(b)),
            0.5 * np.rint(a / 0.5),
            np.full(COUNT, a[0]),
            np.full(COUNT, float(not np.all(a > b))),
            np.full(COUNT, float(np.any(a > b))),
        ]
        np.testing.assert_array_equal(out[:8], expected)
        self.assertEqual(out[8, 1], 7.0)

    def test_elementary_functions_are_those_of_numpy_and_alike_in_lanes(self):
        for size in (0.01, 0.3, 0.7, 3.0, 30.0, 300.0):
            x, y = self.random.uniform(-size, size, (2, 3000, COUNT))
            y[::2] *= 0.1
            x[::3] = abs(x[::3])
            lanes = np.zeros((3000, 5, COUNT))
            floats = np.zeros((COUNT, 3000, 5))
            _functions_of_lanes(x, y, lanes)
            for k in range(COUNT):
                _functions(x[:, k].copy(), y[:, k].copy(), floats[k])
            known = [np.exp(x), np.tanh(x), np.sin(x), np.cos(x)]
            known.append(np.arctan2(y, x))
            with self.subTest(size=size):
                np.testing.assert_array_equal(lanes, np.moveaxis(floats, 0, -1))
                np.testing.assert_allclose(
                    lanes, np.stack(known, axis=1), rtol=1e-15, atol=0.0
                )

    def test_linear_equations_are_solved_copy_by_copy(self):
        A = self.random.normal(size=(COUNT, 6, 6))
        # Copies that change rows where others do not.
        A[1, 0, 0] = A[2, 3, 3] = 0.0
        x = self.random.normal(size=(COUNT, 6))
        b = np.einsum("kij,kj->ki", A, x)
        lanes_A, lanes_b = stack_copies(list(A)), stack_copies(list(b))
        self.assertTrue(_solve_lanes(lanes_A, lanes_b))
        np.testing.assert_allclose(lanes_b.T, x, rtol=1e-9)
        for k in range(COUNT):
            alone = b[k].copy()
            solve_in_place(A[k].copy(), alone)
            np.testing.assert_array_equal(lanes_b[:, k], alone)

    def test_a_singular_copy_is_told(self):
        A = self.random.normal(size=(COUNT, 6, 6))
        A[3, 5] = A[3, 4]
        b = [np.ones(6)] * COUNT
        self.assertFalse(_solve_lanes(stack_copies(list(A)), stack_copies(b)))


class TestCopies(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.twin = BenchTwin(BenchScenario(), 5e-4)
        cls.usual = np.array([p.nominal for p in cls.twin.subject])

    def assert_alike(self, machines, motion, step, noise=None):
        runs = [MachineRun(*machine, motion, noise) for machine in machines]
        self.assert_runs_alike(runs, step)

    def assert_runs_alike(self, runs, step):
        together = simulate_copies(runs, step)
        for (numbers, plugs, motion, noise), log in zip(
            runs, together, strict=True
        ):
            alone = simulate_bench(numbers, motion, step, plugs, noise)
            np.testing.assert_array_equal(log, alone)

    def test_runs_of_any_motion_length_and_noise_go_side_by_side(self):
        numbers = self.twin.with_subject(self.usual)
        none = stack_effects(())
        motions = [
            sway(0.7), sway(1.1), sway(0.9, with_torso=False), sway(1.3),
            replace(sway(0.8), settled_ticks=300),
            replace(sway(1.2), desired=0.5 * sway(1.2).desired),
        ]  # fmt: skip
        breath = self.twin.effects()["breathing"]
        values = breath.in_run(breath.starts()[0], 0)
        moved = stack_effects([(breath, values)], numbers)
        runs = [
            MachineRun(numbers, own, motion)
            for motion in motions
            for own in (none, moved)
        ]
        for motion in motions[::-1]:
            noise = self.random.normal(size=(len(motion.desired), 12))
            noise *= numbers.noise_sigma
            runs.append(MachineRun(numbers, none, motion, noise))
        self.assert_runs_alike(runs, 5e-4)

    def test_copies_are_what_each_is_alone_to_the_last_bit(self):
        subjects = [
            self.usual * (1.0 + 0.1 * self.random.normal(size=len(self.usual)))
            for _ in range(6)
        ]
        machines = [
            (self.twin.with_subject(s), stack_effects(())) for s in subjects
        ]
        for motion in (sway(2.0), sway(2.0, with_torso=False)):
            self.assert_alike(machines, motion, 5e-4)

    def setUp(self):
        self.random = np.random.default_rng(1)

    def test_every_effect_acts_on_a_copy_as_alone_beside_other_effects(self):
        numbers = self.twin.with_subject(self.usual)
        machines = [(numbers, stack_effects(()))]
        for effect in self.twin.effects().values():
            values = effect.in_run(effect.starts()[0], 0)
            uses = [(effect, values)]
            own = numbers
            if effect.modify is not None:
                own = effect.modify(numbers, values)
            machines.append((own, stack_effects(uses, own)))
        noise = self.random.normal(size=(800, 12)) * numbers.noise_sigma
        self.assert_alike(machines, sway(0.8), 5e-4, noise)

    def test_an_effect_of_the_frame_goes_beside_a_machine_without_any(self):
        numbers = self.twin.with_subject(self.usual)
        anchors = self.twin.effects()["anchor_error"]
        values = 1e-4 * self.random.normal(size=len(anchors.parameters))
        own = anchors.modify(numbers, values)
        machines = [
            (own, stack_effects([(anchors, values)], own)),
            (numbers, stack_effects(())),
        ]
        self.assert_alike(machines, sway(0.4), 5e-4)

    def test_laws_made_for_lanes_act_on_all_copies_at_once_as_on_each(self):
        size = len(WITHIN_TOLERANCES.parameters)
        off = np.zeros((3, size))
        # No friction or delay, both, and one of them.
        off[0, 1:6] = [1.0, 0.0, 0.01, 0.1, 0.0]
        off[1, 1:6] = [2.0, 0.4, 0.02, 0.2, 0.0017]
        off[2, 1:6] = [3.0, 0.0, 0.03, 0.3, 0.004]
        stribeck = [[0.2, 0.8, 0.002], [0.0, 0.3, 0.01], [0.0, 0.0, 0.001]]
        self.assert_at_once(WITHIN_TOLERANCES, off)
        self.assert_at_once(stribeck_friction.CARD, stribeck)
        self.assert_at_once(stribeck_friction.WITHOUT_CREEP, stribeck)
        self.assert_at_once(command_delay.CARD, [[0.0], [0.002], [0.0123]])
        held = [[0.2], [0.0], [1.5], [3.0]]
        self.assert_at_once(coulomb_friction.WITHOUT_CREEP, held)
        loose = [[3e-4, 30.0, 0.5], [0.0, 40.0, 0.0], [5e-4, 40.0, 0.0]]
        self.assert_at_once(backlash.STICKING, loose)
        elastic = [[2e-5, 30.0, 0.5], [0.0, 40.0, 0.0], [1e-4, 40.0, 0.0]]
        self.assert_at_once(leg_compliance.STICKING, elastic)

    def test_every_effect_acts_on_all_copies_at_once_as_on_each(self):
        for effect in self.twin.effects().values():
            starts = [np.array(values) for values in effect.starts()]
            more = [np.where(v == np.rint(v), v, 1.3 * v) for v in starts]
            self.assert_at_once(effect, [*starts, *more, effect.off()][:5])

    def test_terms_of_one_place_act_at_once_whatever_their_forms(self):
        numbers = self.twin.with_subject(self.usual)
        of_place = {}
        for term in terms_for("bench stage 2").values():
            place, _ = parts_of_term(term)
            of_place.setdefault(place.key, []).append(term)
        for place, alike in of_place.items():
            machines = []
            for term in alike:
                uses = [(term, np.array(term.starts()[0]))]
                machines.append((numbers, stack_effects(uses, numbers)))
            with self.subTest(place=place):
                self.assert_together(machines)

    def assert_at_once(self, effect, values):
        """Copies with an effect of any strength take one call of its laws."""
        machines = []
        for v in values:
            own = effect.in_run(np.array(v, dtype=float), 0)
            numbers = self.twin.with_subject(self.usual)
            if effect.modify is not None:
                numbers = effect.modify(numbers, own)
            machines.append((numbers, stack_effects([(effect, own)], numbers)))
        with self.subTest(effect=effect.name, form=effect.form):
            self.assert_together(machines)

    def assert_together(self, machines):
        """One call for all copies, each what it is alone."""
        noise = self.random.normal(size=(700, 12))
        noise *= machines[0][0].noise_sigma
        at_once = make_effects_of([plug for _, plug in machines[:2]], 1, COUNT)
        self.assertTrue(at_once.together[0])
        self.assert_alike(machines, sway(0.7), 5e-4, noise)

    def test_rings_of_a_whole_brace_go_side_by_side_too(self):
        twin = BraceTwin(BraceScenario(), 5e-4)
        usual = np.array([p.nominal for p in twin.subject])
        machines = [
            (twin.with_subject(usual * f), stack_effects(()))
            for f in (1.0, 0.9, 1.2)
        ]
        rings = len(twin.scenario.stages)
        columns = tuple(6 * i + 1 for i in range(rings))
        self.assert_alike(machines, sway(0.5, columns=columns), 5e-4)

    def test_a_copy_that_breaks_down_leaves_the_others_as_they_are(self):
        good = self.twin.with_subject(self.usual)
        control = good.control.copy()
        control[[K_P, LIMIT]] *= 1e6  # no loop is stable so
        bad = good.with_changes(control=control)
        none = stack_effects(())
        motion = sway(2.0)
        runs = [MachineRun(one, none, motion) for one in (good, bad)]
        logs = simulate_copies(runs, 5e-4)
        alone = simulate_bench(good, motion, 5e-4)
        np.testing.assert_array_equal(logs[0], alone)
        self.assertIsNone(logs[1])

    def test_points_of_a_twin_come_as_they_would_one_by_one(self):
        motion = sway(1.0)
        effects = self.twin.effects()
        uses = [
            (effects[k], effects[k].starts()[0])
            for k in ("coulomb_friction", "relaxation", "ring_mass")
        ]
        requests = [
            Request(motion, self.usual, own, seed)
            for own in ((), *((use,) for use in uses))
            for seed in (None, (4, 2), (4, 3))
        ]
        found = self.twin.simulate_each(requests)
        for (_, subject, own, seed), log in zip(requests, found, strict=True):
            generator = None if seed is None else np.random.default_rng(seed)
            fresh = BenchTwin(BenchScenario(), 5e-4)
            alone = fresh.simulate(motion, subject, own, generator)
            np.testing.assert_array_equal(log, alone)


class TestMemory(unittest.TestCase):
    def test_what_is_asked_for_twice_is_computed_once(self):
        memory, asked = RunMemory(), []

        def compute(places):
            asked.append(list(places))
            return [np.full(2, float(i)) for i in places]

        first = memory.recall_each(["a", "b", "a"], compute)
        again = memory.recall_each(["b", "c"], compute)
        memory.recall_each([None, "c", None], compute)
        memory.recall_each([None], compute)
        self.assertEqual(asked, [[0, 1], [1], [0, 2], [0]])
        self.assertEqual([x[0] for x in first], [0.0, 1.0, 0.0])
        self.assertEqual([x[0] for x in again], [1.0, 1.0])
        with self.assertRaises(ValueError):
            first[0][0] = 3.0


if __name__ == "__main__":
    unittest.main()
