"""A twin beside a device: gaps, alarms, running estimates, the page."""

import json
import signal
import subprocess
import sys
import time
import unittest
import urllib.request

import numpy as np

from brace_drake.core.errors import OutputError
from brace_drake.devices.bench.rollout import CHANNELS
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.motions.library import MakeMotion
from brace_drake.effects.registry import find_effect
from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.emulator.make import MakePlant
from brace_drake.link.operation.beside import TwinBeside
from brace_drake.link.operation.contact_estimate import (
    ContactEstimate,
    contact_regressors,
)
from brace_drake.link.operation.motion import desired_at_ticks, place_motion
from brace_drake.link.operation.page import Page
from brace_drake.link.operation.rows import Row
from brace_drake.link.operation.station import MakeControl
from brace_drake.link.protocol.limits import DEFAULT
from brace_drake.playback.look import make_look
from brace_drake.playback.overlay import (
    DEVICE,
    TWIN,
    Overlay,
    OverlayProcess,
)
from brace_drake.scenario.brace import BraceScenario
from tests.link_bench import SCENARIO
from tests.meshcat_page import read_commands


def follow(
    motion, uses=(), subject=None, seconds=12.0, beside=None, scenario=SCENARIO
):
    """A device and its twin on a motion."""
    if scenario is SCENARIO:
        plant = BenchPlant(scenario, uses, subject, seed=4)
    else:
        plant = MakePlant(scenario, uses, seed=4)
    control = MakeControl(scenario, DEFAULT)
    beside = beside or TwinBeside(scenario, memory=6.0)
    motion = place_motion(MakeMotion(motion), scenario.stages)
    desired = desired_at_ticks(motion, 1000.0)
    command, alarmed = plant.hold, set()
    for i in range(min(len(desired), round(1000 * seconds))):
        readings = plant.advance(command).copy()
        command = control.Tick(readings, desired[i])
        row = Row(
            i, command, readings, desired[i], control.y_virtual,
            control.y_ring, 0.0, 0,
        )  # fmt: skip
        beside.Take(row)
        alarmed |= set(beside.alarms)
    return beside, alarmed


class TestBeside(unittest.TestCase):
    def test_a_device_like_its_twin_stays_in_the_band(self):
        beside, alarmed = follow("reversal_fast", seconds=8.0)
        self.assertEqual(alarmed, set())
        self.assertLess(beside.ratio.max(), 2.0)
        self.assertGreater(beside.ratio.min(), 0.5)

    def test_an_effect_raises_an_alarm_in_the_channels_that_it_reaches(self):
        card = find_effect("force_bias")
        values = {n: 0.0 for n in card.parameter_names}
        values[
            next(n for n in values if "_y" in n or n == next(iter(values)))
        ] = 0.8
        use = (card, card.vector(values))
        _, alarmed = follow("quiet_hold", (use,), seconds=4.0)
        self.assertTrue({c for c in alarmed if "force" in c})

    def test_stiffness_and_damping_of_another_subject_are_found(self):
        twin = BenchTwin(SCENARIO)
        subject = np.array([p.nominal for p in twin.subject])
        subject[0], subject[1] = 1.25 * 6400.0, 1.3 * 150.0
        beside, _ = follow("reversal_fast", subject=subject)
        k, c = beside.contact.values
        self.assertAlmostEqual(k / 8000.0, 1.0, delta=0.05)
        self.assertAlmostEqual(c / 195.0, 1.0, delta=0.15)

    def test_the_page_gets_every_channel(self):
        said = TwinBeside(SCENARIO).describe()
        self.assertEqual(tuple(said["ratio"]), CHANNELS[6:18])

    def test_the_page_gets_curves_of_device_and_twin(self):
        beside, _ = follow("push", seconds=2.5)
        said = beside.describe()
        self.assertAlmostEqual(said["time_s"], 2.499)
        device, twin = beside.readings
        self.assertEqual(
            said["signals"]["ring2_force_y_N"], (device[7], twin[7])
        )
        places = said["signals"]["ring2_y_m"]
        self.assertLess(max(places), -5e-4)
        self.assertAlmostEqual(*places, delta=5e-5)


class TestOverlay(unittest.TestCase):
    def test_both_are_shown_where_their_readings_say(self):
        for scenario, rings in ((SCENARIO, (2,)), (BraceScenario(), (1, 2, 3))):
            overlay = Overlay(scenario)
            url = overlay.meshcat.web_url()
            self.assertTrue(url.startswith("http://127.0.0.1:"), url)
            geometry, n = make_look(scenario).geometry, 6 * len(rings)
            shown = []
            for y in (-0.004, 0.003):
                X = np.zeros(n)
                X[n - 5] = y
                rest = np.zeros(9 * len(rings) + 3)
                rest[0:n], rest[-2] = geometry.at(X)[0], 0.5 * y
                shown.append(rest)
            overlay.Show(*shown)
            # Lengths of no pose leave it where it was.
            overlay.Show(np.zeros_like(shown[0]), shown[1])
            placed = {
                c["path"]: c["matrix"]
                for c in read_commands(overlay.meshcat.StaticHtml())
                if c["type"] == "set_transform"
            }
            name, i = f"ring{rings[-1]}", len(rings) - 1
            for under, y in ((DEVICE, -0.004), (TWIN, 0.003)):
                ring = np.reshape(placed[f"{under}/brace/{name}"], (4, 4)).T
                expected = geometry.rest[i] + [0.0, y, 0.0]
                np.testing.assert_allclose(ring[:3, 3], expected, atol=1e-8)
                torso = np.reshape(placed[f"{under}/torso"], (4, 4)).T
                self.assertAlmostEqual(torso[1, 3], 0.5 * y)


class TestOverlayProcess(unittest.TestCase):
    def test_it_may_be_killed_or_hang_and_nobody_waits(self):
        for number in (signal.SIGKILL, signal.SIGSTOP):
            with OverlayProcess(SCENARIO) as overlay:
                overlay.Wait()
                address = f"http://127.0.0.1:{overlay.port}/"
                with urllib.request.urlopen(address, timeout=60) as answer:
                    self.assertIn("eshcat", answer.read().decode())
                overlay._child.send_signal(number)
                begun = time.monotonic()
                # More than a pipe holds.
                for _ in range(2000):
                    overlay.Show(np.zeros(12), np.zeros(12))
                self.assertLess(time.monotonic() - begun, 10.0)
            self.assertIsNotNone(overlay._child.poll())

    def test_one_that_cannot_begin_is_not_waited_for(self):
        begun = time.monotonic()
        with OverlayProcess(SCENARIO, "no.such.host.invalid") as overlay:
            overlay.Wait()
            self.assertIsNone(overlay.port)
            # It has ended by itself, before patience did.
            self.assertIsNotNone(overlay._child.wait(10.0))
            self.assertLess(time.monotonic() - begun, 50.0)
            overlay.Show(np.zeros(12), np.zeros(12))


_OWNER = """
import gc, threading
from brace_drake.playback.write import StartLocalMeshcat, _served
class Owner:
    def __init__(self):
        self.meshcat, self.itself = StartLocalMeshcat(), self
gc.disable()
def run(what):
    thread = threading.Thread(target=what)
    thread.start()
    thread.join()
"""
_COLLECT = """
Owner()
run(gc.collect)
assert len(_served) == 1
kept = StartLocalMeshcat()
assert [m for _, m in _served] == [kept], _served
"""
# Made by a thread that has gone; in the end the interpreter's own finds it.
_LEAVE = "run(Owner)"


class TestMeshcat(unittest.TestCase):
    def test_no_other_thread_destroys_one(self):
        # Drake would end the process.
        for code in (_COLLECT, _LEAVE, _LEAVE + "\ngc.collect()"):
            done = subprocess.run(
                [sys.executable, "-c", _OWNER + code],
                capture_output=True,
                text=True,
            )
            self.assertEqual(done.returncode, 0, done.stderr)


class TestBesideABrace(unittest.TestCase):
    def test_a_brace_like_its_twin_stays_in_the_band(self):
        beside, alarmed = follow(
            "reversal_fast", seconds=4.0, scenario=BraceScenario()
        )
        self.assertEqual(alarmed, set())
        self.assertGreater(beside.ratio.min(), 0.5)
        self.assertEqual(len(beside.channels), 30)
        self.assertIn("leg18_length_m", beside.describe()["ratio"])

    def test_an_effect_and_another_subject_show_on_a_brace(self):
        card = find_effect("force_bias")
        use = (card, card.vector({"force_bias_N": 0.8}))
        _, alarmed = follow(
            "quiet_hold", (use,), seconds=2.0, scenario=BraceScenario()
        )
        rings = {f"ring{i}_force_y_N" for i in (1, 2, 3)}
        self.assertLessEqual(rings, alarmed)
        stiff = BraceScenario()
        stiff.contact.ring2.stiffness *= 1.25
        stiff.contact.ring2.damping *= 1.3
        beside = TwinBeside(BraceScenario(), memory=6.0)
        follow("reversal_fast", seconds=10.0, beside=beside, scenario=stiff)
        k, c = beside.contact.values
        self.assertAlmostEqual(k / 8000.0, 1.0, delta=0.05)
        self.assertAlmostEqual(c / 195.0, 1.0, delta=0.15)


class TestEstimate(unittest.TestCase):
    def draw(self, k, c, seconds, estimate, noise=0.0, size=2e-3, own=False):
        """Values after a sine; with `own` the readings are the instruments."""
        draw = np.random.default_rng(1)
        for t in np.arange(0.0, seconds, 1e-3):
            x = size * np.sin(2 * np.pi * 1.5 * t)
            v = size * 2 * np.pi * 1.5 * np.cos(2 * np.pi * 1.5 * t)
            force = contact_regressors(x, v, 1e-3) @ (k, c)
            seen = x + noise * draw.standard_normal()
            instrument = (seen, v) if own else (x, v)
            estimate.Update((seen, v), instrument, force)
        return estimate.values

    def make(self, memory=2.0):
        return ContactEstimate(np.array([6400.0, 150.0]), 1e-3, memory, 1e-3)

    def test_exact_readings_give_exact_values(self):
        found = self.draw(7000.0, 200.0, 30.0, self.make())
        np.testing.assert_allclose(found, [7000.0, 200.0], rtol=1e-4)

    def test_noise_of_the_regressors_does_not_bias(self):
        # Both pads touch; var x = 0.125, of the noise 0.04 mm^2: without
        # instruments k comes out at 0.76 of itself.
        noisy = {"noise": 2e-4, "size": 5e-4}
        found = self.draw(7000.0, 200.0, 40.0, self.make(20.0), **noisy)
        self.assertAlmostEqual(found[0] / 7000.0, 1.0, delta=0.02)
        self.assertAlmostEqual(found[1] / 200.0, 1.0, delta=0.03)
        plain = self.draw(
            7000.0, 200.0, 40.0, self.make(20.0), own=True, **noisy
        )
        self.assertAlmostEqual(plain[0] / 7000.0, 0.76, delta=0.04)

    def test_a_change_is_followed_within_its_memory(self):
        estimate = self.make(1.0)
        self.draw(6400.0, 150.0, 5.0, estimate)
        found = self.draw(4000.0, 150.0, 5.0, estimate)
        np.testing.assert_allclose(found, [4000.0, 150.0], rtol=0.02)

    def test_at_rest_nothing_is_learnt_and_nothing_forgotten(self):
        estimate = self.make(1.0)
        before = self.draw(7000.0, 200.0, 5.0, estimate).copy()
        for _ in range(5000):
            estimate.Update((1e-5, 0.0), (0.0, 0.0), 3.0)
        np.testing.assert_array_equal(estimate.values, before)

    def test_the_regressors_are_those_of_two_pads(self):
        for x in (-0.003, -0.0005, 0.0, 0.0004, 0.002):
            pads = [6400.0 * max(0.0, 1e-3 + s * x) for s in (1, -1)]
            force = contact_regressors(x, 0.0, 1e-3) @ (6400.0, 150.0)
            self.assertAlmostEqual(force, pads[0] - pads[1])


class TestPage(unittest.TestCase):
    def test_it_serves_the_loopback_address_and_sends_events(self):
        page = Page()
        self.addCleanup(page.Close)
        self.assertTrue(page.url.startswith("http://127.0.0.1:"))
        with urllib.request.urlopen(page.url, timeout=60) as answer:
            self.assertIn("EventSource", answer.read().decode())
        page.Show({"alarms": []})
        with urllib.request.urlopen(page.url + "events", timeout=60) as stream:
            line = stream.readline().decode()
        self.assertEqual(
            json.loads(line.removeprefix("data: ")), {"alarms": []}
        )

    def test_a_port_that_is_taken_is_said_to_be(self):
        page = Page()
        self.addCleanup(page.Close)
        number = int(page.url.rsplit(":", 1)[1].strip("/"))
        with self.assertRaises(OutputError):
            Page(port=number)


if __name__ == "__main__":
    unittest.main()
