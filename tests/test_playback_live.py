"""A run in 3D as it goes on."""

import re
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

import brace_drake
from brace_drake.core.resources import scenario_path
from brace_drake.devices.motions.reference import COLUMNS
from brace_drake.model.simulate import RecordBrace
from brace_drake.playback.live import LiveScene
from brace_drake.playback.states import states_of_now, states_of_run
from brace_drake.recording.recording import Run
from brace_drake.scenario.brace import BenchScenario, BraceScenario
from tests.commands import run_command
from tests.meshcat_page import read_commands
from tests.test_playback import write_reference


def short_motion(ring=2, seconds=0.3):
    """4 mm along y and what is left of the way."""
    t = np.arange(0.0, seconds + 1e-9, 0.005)
    y = -0.004 * (t / seconds) ** 2
    v, a = -0.008 * t / seconds**2, np.full(len(t), -0.008 / seconds**2)
    channels = {"time_s": t, **dict(zip(COLUMNS, (y, v, a), strict=True))}
    return Run("short.csv", True, "short", None, "fit", channels)


class TestLive(unittest.TestCase):
    def watched(self, record, scenario, rings, **options):
        """States at each look, and those of the log at the end."""
        seen, ended = [], []
        run = record(
            scenario,
            short_motion(),
            watch=lambda *now: seen.append(states_of_now(*now, rings)),
            at_end=lambda *end: ended.append(end),
            **options,
        )
        force = [
            run.channels[f"{r}_force_{axis}_N"] for r in rings for axis in "xyz"
        ]
        return seen, states_of_run(*ended[0], rings, np.transpose(force))

    def test_what_is_shown_is_what_the_log_has_at_that_time(self):
        hydroelastic = BraceScenario(stages=[2], time_step=1e-3)
        hydroelastic.contact.ring2.model = "hydroelastic"
        for record, scenario, options in (
            (RecordBrace, BenchScenario(time_step=1e-3), {}),
            (RecordBrace, hydroelastic, {"log_pads": True}),
        ):
            seen, log = self.watched(record, scenario, ["ring2"], **options)
            # 25 looks a second, the first at rest.
            times = np.concatenate([states.times for states in seen])
            np.testing.assert_allclose(times, 0.04 * np.arange(8), atol=2e-3)
            for states in seen[1:]:
                at = int(np.argmin(np.abs(log.times - states.times[0])))
                # A plant step at 30 mm/s, and what a step adds to a force.
                for name, atol in (
                    ("rings", 1e-4),
                    ("torso", 1e-4),
                    ("pad_force", 0.4),
                ):
                    np.testing.assert_allclose(
                        getattr(states, name)[0],
                        getattr(log, name)[at],
                        atol=atol,
                    )
                self.assertEqual(states.is_of_pads, log.is_of_pads)
            self.assertGreater(np.ptp([s.rings[0, 0, 5] for s in seen]), 1e-3)

    def test_the_scene_moves_with_the_run(self):
        scenario, y = BenchScenario(time_step=1e-3), []
        scene = LiveScene(scenario)

        def Watch(station, context):
            scene.Show(station, context)
            (now,) = (
                command["matrix"]
                for command in read_commands(scene.meshcat.StaticHtml())
                if command["type"] == "set_transform"
                and command["path"].endswith("/brace/ring2")
            )
            y.append(now[13])

        RecordBrace(scenario, short_motion(), watch=Watch)
        self.assertLess(y[-1], -1e-3)
        self.assertTrue((np.diff(y) <= 1e-6).all())

    def test_simulate_shows_the_run_as_it_goes_on(self):
        with tempfile.TemporaryDirectory() as folder:
            reference = write_reference(Path(folder, "push.csv"))
            shown = []

            def Show(scene, station, context):
                shown.append(context.get_time())

            with (
                mock.patch.object(LiveScene, "Show", Show),
                mock.patch("builtins.input", side_effect=EOFError),
            ):
                scenario = scenario_path("bench.scenario.yaml")
                status, out, _ = run_command(
                    *("simulate", scenario, "--motion", reference),
                    *("--out", Path(folder, "run"), "--meshcat"),
                )
            self.assertEqual(status, 0)
            self.assertRegex(out, "^live at http://localhost")
            self.assertGreater(len(shown), 5)


class TestMeshcat(unittest.TestCase):
    def test_one_place_alone_makes_one_and_keeps_it(self):
        # A thread that did not make it would end the process with it.
        package = Path(brace_drake.__file__).parent
        made = [
            path.relative_to(package).as_posix()
            for path in sorted(package.rglob("*.py"))
            if re.search(r"\b(Start)?Meshcat\(", path.read_text())
        ]
        self.assertEqual(made, ["playback/write.py"])
