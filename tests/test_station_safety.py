"""Stations of simulation whose commands pass a safety supervisor."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

from brace_drake.cli.options import load_motion
from brace_drake.link.device.safety_memory import SafetyMode
from brace_drake.link.protocol.limits import BY_STAGE, DEFAULT
from brace_drake.link.protocol.words import Cause
from brace_drake.model.simulate import RecordBrace
from brace_drake.scenario.brace import BenchScenario, BraceScenario
from tests.commands import run_command

FORCE = "ring2_force_y_N"


class Ended:
    """Keeps what the supervisor of a run remembers at its end."""

    def __call__(self, station, context):
        own = station.supervisor.GetMyContextFromRoot(context)
        self.memory = station.supervisor.memory(own)


def short_push(rings=(2,)):
    """The library's push until it presses."""
    run = load_motion("push", rings=rings)
    keep = run.time_s <= 6.0
    channels = {name: values[keep] for name, values in run.channels.items()}
    return type(run)(**{**vars(run), "channels": channels})


def bench():
    return BenchScenario(time_step=5e-4)


class TestSupervisedStation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.run_ = short_push()
        cls.free = RecordBrace(bench(), cls.run_)

    def test_what_keeps_the_limits_moves_as_without_a_supervisor(self):
        ended = Ended()
        held = RecordBrace(bench(), self.run_, at_end=ended, limits=DEFAULT)
        self.assertEqual(ended.memory.mode, SafetyMode.ARMED)
        for name, values in self.free.channels.items():
            np.testing.assert_array_equal(held.channels[name], values)

    def test_what_breaks_one_is_stopped_and_the_torso_pushes_it_away(self):
        least = self.free.channels[FORCE].min()
        ended = Ended()
        stopped = RecordBrace(
            bench(),
            self.run_,
            at_end=ended,
            limits=DEFAULT._replace(pad_force=9.0),
        )
        memory = ended.memory
        self.assertEqual(memory.mode, SafetyMode.STOPPED)
        self.assertEqual(memory.trip.cause, Cause.PAD_FORCE)
        self.assertLess(memory.since, 4.0)
        t, force = stopped.time_s, stopped.channels[FORCE]
        # Not above the limit by more than a tick brings, and soft within the
        # time of a release, though the reference goes on.
        self.assertGreater(force.min(), 0.85 * least)
        after = t > memory.since + DEFAULT.release_time + 0.3
        self.assertTrue(after.any())
        self.assertLess(np.abs(force[after]).max(), 0.1 * abs(least))
        hold = np.array(memory.command)
        last = [
            stopped.channels[f"leg{k}_force_command_N"][-1] for k in "123456"
        ]
        np.testing.assert_allclose(last, hold, atol=0.1)

    def test_a_whole_brace_keeps_the_limits_of_its_stages(self):
        scenario, ended = BraceScenario(time_step=5e-4), Ended()
        limits = DEFAULT._replace(**BY_STAGE)
        RecordBrace(
            scenario, short_push((1, 2, 3)), at_end=ended, limits=limits
        )
        self.assertEqual(ended.memory.mode, SafetyMode.ARMED)
        # Legs of stage 1 are longer than any of the bench may be.
        RecordBrace(
            scenario, short_push((1, 2, 3)), at_end=ended, limits=DEFAULT
        )
        self.assertEqual(ended.memory.trip.cause, Cause.LEG_STROKE)


class TestCommand(unittest.TestCase):
    def test_simulate_says_what_was_stopped_and_when(self):
        with tempfile.TemporaryDirectory() as folder:
            limits = Path(folder, "limits.yaml")
            words = ["simulate", "diagrams/bench.scenario.yaml"]
            words += ["--motion", "push", "--limits", limits]
            for i, (text, said) in enumerate(
                (
                    ("pad_force: 9\n", r"stopped at [1-9]\.\d+ s: pad force"),
                    ("pad_force: 49\n", "limits: held"),
                )
            ):
                limits.write_text(text)
                status, out, _ = run_command(
                    *words, "--out", Path(folder, f"run{i}")
                )
                self.assertEqual(status, 0)
                self.assertRegex(out, said)
