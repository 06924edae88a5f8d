"""A machine watched beside its twin: noise, alarms, onsets, causes."""

import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np
from scipy.stats import chi2, poisson

from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.library import MakeMotion
from brace_drake.devices.since import MakeTwinSince, OnsetMotion
from brace_drake.effects.registry import find_effect
from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.operation.beside import TwinBeside
from brace_drake.link.operation.live.cycles_kept import CyclesKept
from brace_drake.link.operation.live.observer import Observer
from brace_drake.link.operation.motion import desired_at_ticks
from brace_drake.link.operation.rows import Row
from brace_drake.link.operation.station import MakeControl
from brace_drake.link.protocol.limits import DEFAULT
from brace_drake.monitoring.causes import NamedCause
from brace_drake.monitoring.cycles import HOME, REST, close_cycle, repeat_cycle
from brace_drake.monitoring.detector import (
    LEVEL,
    calc_excess,
    estimate_onset,
    make_thresholds,
)
from brace_drake.monitoring.noise_model import NoiseModel, fit_noise_model
from brace_drake.monitoring.prepare import Namer, make_expected
from brace_drake.monitoring.watch import Watch
from brace_drake.recording import CheckCampaign, LoadCampaign
from brace_drake.recording.columns import BENCH
from brace_drake.scenario.brace import BenchScenario

SCENARIO = BenchScenario(time_step=5e-4)


def use_of(name, **values):
    card = find_effect(name)
    start = dict(zip(card.parameter_names, card.starts()[0], strict=True))
    return card, card.in_run(card.vector(start | values), 0)


class TestNoiseModel(unittest.TestCase):
    def test_a_known_autoregression_is_found_and_whitened(self):
        draw = np.random.default_rng(0)
        A = np.array([[0.6, 0.2], [-0.3, 0.5]])
        L = np.array([[2.0, 0.0], [1.0, 0.5]])
        e = draw.standard_normal((4, 20000, 2)) @ L.T
        r = np.zeros_like(e)
        for t in range(1, e.shape[1]):
            r[:, t] = r[:, t - 1] @ A.T + e[:, t]
        model = fit_noise_model(r, (1, 2))
        np.testing.assert_allclose(model.coefficients[:, :2], A, atol=0.03)
        z = model.whiten(r[0], None)[2:]
        np.testing.assert_allclose(np.cov(z.T), np.eye(2), atol=0.04)
        self.assertLess(abs(np.mean(z[1:] * z[:-1])), 0.02)

    def test_piece_by_piece_is_as_in_one(self):
        draw = np.random.default_rng(1)
        r = draw.standard_normal((2, 400, 3)).cumsum(axis=1)
        model = fit_noise_model(r)
        whole = model.whiten(r[0])
        second = model.whiten(r[0, 150:], r[0, :150])
        np.testing.assert_allclose(second, whole[150:], atol=1e-9)

    def test_a_channel_without_noise_is_left_out(self):
        draw = np.random.default_rng(2)
        r = draw.standard_normal((1, 500, 3)) * [1.0, 0.0, 2.0]
        model = fit_noise_model(r)
        self.assertEqual(model.whiten(r[0]).shape, (500, 2))


class TestDetector(unittest.TestCase):
    rate, channels = 100.0, 3

    def make(self, per_hour, level=0.0):
        draw = np.random.default_rng(3)
        noise = draw.standard_normal((400, 500, self.channels))
        return make_thresholds(noise, self.rate, per_hour, level)

    def count(self, series, thresholds):
        looks = range(thresholds.every, len(series), thresholds.every)
        longest = thresholds.samples[-1]
        return sum(
            calc_excess(series[max(0, i - longest) : i], thresholds) > 1.0
            for i in looks
        )

    def test_noise_alone_raises_no_more_alarms_than_stated(self):
        # A rate high enough to be counted in a fifth of an hour.
        per_hour, hours = 2000.0, 0.2
        draw = np.random.default_rng(4)
        size = round(3600 * hours * self.rate), self.channels
        told = self.count(draw.standard_normal(size), self.make(per_hour))
        # Six tests with 2000 / 36000 / 6 each: neither more than that, with
        # what is usual of Poisson's law, nor none at all.
        most = poisson.ppf(0.999, 3.0 * per_hour * hours)
        self.assertGreater(told, 0.1 * per_hour * hours)
        self.assertLess(told, most)
        self.assertLessEqual(told, 1.3 * per_hour * hours)

    def test_the_delay_of_a_step_is_that_of_its_energy(self):
        thresholds = self.make(1.0)
        draw = np.random.default_rng(5)
        step, delays = 2.0, []
        for _ in range(20):
            series = draw.standard_normal((2000, self.channels))
            series[1000:] += step
            for i in range(1010, 2000, thresholds.every):
                if calc_excess(series[:i], thresholds) > 1.0:
                    delays.append(i - 1000)
                    break
        # M of the first window, n = 25: k samples of the step make
        # c (k step)^2 / n, which passes its threshold at
        n = thresholds.samples[0]
        due = np.sqrt(thresholds.mean[0] * n / self.channels) / step
        self.assertEqual(len(delays), 20)
        self.assertLess(np.mean(delays), due + thresholds.every)
        self.assertGreater(np.mean(delays), 0.3 * due)

    def test_what_is_within_the_level_of_the_noise_is_no_alarm(self):
        draw = np.random.default_rng(6)
        series = np.sqrt(1.0 + LEVEL) * draw.standard_normal(
            (60000, self.channels)
        )
        self.assertEqual(self.count(series, self.make(0.1, LEVEL)), 0)

    def test_thresholds_are_those_of_chi_square(self):
        thresholds = self.make(1.0)
        p = 1.0 / 36000.0 / 6.0
        for n, energy in zip(
            thresholds.samples, thresholds.energy, strict=True
        ):
            self.assertAlmostEqual(chi2.sf(energy, 3 * n) / p, 1.0)

    def test_the_onset_of_a_change_is_found(self):
        draw = np.random.default_rng(7)
        series = draw.standard_normal((1500, self.channels))
        series[1400:] += 1.5
        self.assertAlmostEqual(
            estimate_onset(series, self.rate), 1400, delta=10
        )


class TestCycles(unittest.TestCase):
    def test_the_way_home_is_smooth_and_ends_at_rest(self):
        motion = MakeMotion("reversal")
        cycle = close_cycle(motion)
        y, v, a = cycle.samples.T
        self.assertEqual(len(y), 2400 + round(200 * (HOME + REST)))
        np.testing.assert_allclose(np.gradient(y, 0.005)[1:-1], v[1:-1],
                                   atol=3e-4)  # fmt: skip
        np.testing.assert_allclose(cycle.samples[-400:], 0.0, atol=1e-12)
        self.assertLess(np.max(np.abs(np.diff(v[2380:]))), 1e-3)
        self.assertLess(np.max(np.abs(a[2400:])), 0.1)
        twice = repeat_cycle(cycle, 2)
        np.testing.assert_array_equal(twice.samples[3100:], cycle.samples)


class TestSince(unittest.TestCase):
    def test_nothing_that_begins_is_the_whole_run_to_the_last_bit(self):
        twin, since = BenchTwin(SCENARIO), MakeTwinSince(SCENARIO)
        motion = twin.motion(MakeMotion("reversal_fast").run)
        nominal = np.array([p.nominal for p in twin.subject])
        whole = twin.simulate(motion, nominal)
        for onset in (0, 5, 3000):
            later = OnsetMotion(
                motion.desired, True, motion.ticks_per_sample, onset=onset
            )
            np.testing.assert_array_equal(
                since.simulate(later, nominal), whole[onset // 5 :]
            )

    def test_an_effect_that_begins_is_that_of_the_emulated_plant(self):
        onset, ticks, use = 1500, 3000, use_of("weak_leg")
        twin = MakeTwinSince(SCENARIO)
        desired = twin.motion(MakeMotion("push_fast").run).desired[:ticks]
        nominal = np.array([p.nominal for p in twin.subject])
        motion = OnsetMotion(desired, True, onset=onset)
        replayed = twin.simulate(motion, nominal, (use,))
        plant = BenchPlant(SCENARIO, seed=None)
        control, command, rows = MakeControl(SCENARIO, DEFAULT), plant.hold, []
        for i in range(ticks):
            if i == onset + 1:
                plant.begin_effects([use])
            readings = plant.advance(command).copy()
            command = control.Tick(readings, desired[i])
            if i >= onset and i % 5 == 0:
                rows.append(readings)
        np.testing.assert_allclose(replayed[:, 6:18], rows, atol=1e-8)
        self.assertGreater(np.ptp(replayed[:, 6]), 1e-4)


def plain_model(channels):
    return NoiseModel(
        np.ones(channels, dtype=bool), (1,), np.zeros((channels, channels)),
        np.eye(channels),
    )  # fmt: skip


class TestWatch(unittest.TestCase):
    cycle = 600

    def make(self, usual):
        draw = np.random.default_rng(8)
        noise = draw.standard_normal((200, 500, 2))
        thresholds = make_thresholds(noise, 100.0, 0.1)
        return Watch(plain_model(2), thresholds, 100.0, self.cycle, usual)

    def run_watch(self, usual, change, cycles=4):
        """A machine with a gap in all cycles, and more of it from a sample."""
        watch, draw = self.make(usual), np.random.default_rng(9)
        phase = np.arange(self.cycle) / self.cycle
        for i in range(cycles * self.cycle):
            row = draw.standard_normal(2)
            row += 3.0 * np.sin(2 * np.pi * phase[i % self.cycle])
            row[0] += 2.0 * change(i)
            watch.Take(row)
        return watch

    def test_what_was_there_from_the_beginning_is_usual(self):
        watch = self.run_watch(1, lambda i: 0.0)
        self.assertIsNone(watch.onset)
        self.assertTrue(watch.differs)
        self.assertIsNone(watch.since())

    def test_without_usual_cycles_it_is_a_change_at_once(self):
        self.assertLess(self.run_watch(0, lambda i: 0.0).onset, 100)

    def test_a_change_is_told_with_its_rows(self):
        begins = 2 * self.cycle + 150
        watch = self.run_watch(1, lambda i: i >= begins, 3)
        self.assertAlmostEqual(watch.onset, begins, delta=20)
        self.assertLess(watch.alarm - begins, 100)
        since = watch.since()
        self.assertEqual(since.start, 2 * self.cycle)
        self.assertEqual(len(since.rows), 3 * self.cycle - watch.onset)
        self.assertAlmostEqual(since.rows[:, 0].mean(), 2.0, delta=0.2)
        self.assertAlmostEqual(since.rows[:, 1].mean(), 0.0, delta=0.2)

    def test_what_has_gone_for_long_is_as_expected_again(self):
        ends = 2 * self.cycle
        watch = self.run_watch(1, lambda i: self.cycle + 99 < i < ends, 7)
        self.assertIsNone(watch.onset)


class Beside:
    """The emulated bench, its controller and the twin, not in real time."""

    def __init__(self, cycle, cycles, seed):
        self.plant = BenchPlant(SCENARIO, seed=seed)
        self.control = MakeControl(SCENARIO, DEFAULT)
        self.beside = TwinBeside(SCENARIO)
        motion = repeat_cycle(cycle, cycles)
        self.desired = desired_at_ticks(motion, 1000.0)

    def run(self, begins, use):
        """Ticks and differences; the effect begins at a tick."""
        command = self.plant.hold
        for i, desired in enumerate(self.desired):
            if i == begins:
                self.plant.begin_effects([use])
            readings = self.plant.advance(command).copy()
            command = self.control.Tick(readings, desired)
            row = Row(
                i, command, readings, desired, self.control.y_virtual,
                self.control.y_ring, 0.0, 0, stiffness=self.control.stiffness,
            )  # fmt: skip
            self.beside.Take(row)
            yield row, self.beside.difference


class TestFaults(unittest.TestCase):
    """Effects of the library that begin in the second cycle."""

    @classmethod
    def setUpClass(cls):
        cls.cycle = close_cycle(MakeMotion("multisine"))
        cls.expected = make_expected(SCENARIO, cls.cycle, 1, 0.1)
        cls.namer = Namer(cls.expected)

    def test_the_right_cause_is_among_the_first_three(self):
        begins = 15500 + 2000
        for name, values in (
            ("force_bias", {"force_bias_N": 0.2}),
            ("command_delay", {}),
            ("relaxation", {}),
            ("ring_mass", {}),
        ):
            with self.subTest(effect=name):
                use, watch = use_of(name, **values), self.expected.watch()
                run = Beside(self.cycle, 2, 11).run(begins, use)
                for row, difference in run:
                    if row.tick % 5 == 0:
                        watch.Take(difference)
                    if row.tick == begins + 10000:
                        break
                self.assertGreaterEqual(5 * watch.alarm, begins)
                self.assertLess(5 * watch.alarm - begins, 5000)
                causes = self.namer.Name(watch.since())
                self.assertIn(name, [c.name for c in causes[:3]])
                self.assertAlmostEqual(sum(c.probability for c in causes), 1.0)

    def test_of_next_to_nothing_nothing_is_named(self):
        since = SimpleNamespace(rows=np.zeros((10, 19)))
        self.assertEqual(self.namer.Name(since), [])


class TestObserver(unittest.TestCase):
    def test_what_is_kept_is_two_valid_campaigns_and_each_news_one_line(self):
        cycle = close_cycle(MakeMotion("push_fast"))
        expected = make_expected(SCENARIO, cycle, 1, 0.1)
        head = {
            "device": BENCH, "rate_hz": 200.0, "subject": "",
            "recorded": {}, "settled_s": REST,
        }  # fmt: skip
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        kept = CyclesKept(folder, head, cycle, (2,), 1000.0, 5)
        cause = NamedCause("force_bias", "Bias", 0.9, 0.8, {})
        naming = mock.Mock(causes=[], seen=0, is_busy=False)
        said = []
        observer = Observer(expected, naming, kept, str.upper, said.append)
        use = use_of("force_bias", force_bias_N=0.2)
        for row, difference in Beside(cycle, 3, 12).run(15500 + 4000, use):
            observer.Take(row.tick, difference)
            observer.Look([row])
            if row.tick == 15500 + 3999:
                self.assertEqual(observer.describe()["state"], "expected")
            if row.tick == 15500 + 9000:
                self.assertEqual(naming.Ask.call_count, 1)
                naming.causes = [cause]
        shown = observer.describe()
        kept.Close(True)
        self.assertEqual(len(said), 2, said)
        self.assertRegex(said[0], r"^\d\d:\d\d:\d\d not as expected")
        self.assertIn("force_bias (80%, explains 90%)", said[1])
        self.assertEqual(shown["state"], "changed")
        self.assertEqual(shown["causes"][0]["name"], "force_bias")
        for path, runs in ((folder, 2), (folder / "since", 1)):
            problems = [p.severity for p in CheckCampaign(path)]
            self.assertNotIn("error", problems)
            campaign = LoadCampaign(path)
            self.assertEqual(len(campaign.runs), runs)
            self.assertEqual(len(campaign.runs[0].time_s), len(cycle.time))


if __name__ == "__main__":
    unittest.main()
