"""Emulated devices in threads of their own, for tests of the link."""

import contextlib
import threading
import time

import numpy as np

from brace_drake.devices.motions.library import SafeMotion
from brace_drake.devices.motions.parts import ramp
from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.emulator.describe import describe_device
from brace_drake.link.emulator.device import EmulatedDevice
from brace_drake.link.operation.recorder import Recorder
from brace_drake.link.protocol.limits import DEFAULT
from brace_drake.link.protocol.words import DeviceState
from brace_drake.scenario.brace import BenchScenario

SCENARIO = BenchScenario(time_step=5e-4)
# A machine that tests share is late at times.
PATIENT = DEFAULT._replace(stale=5.0, lost_messages=1000.0)
# The same as the text of a file of limits.
PATIENT_LIMITS = "stale: 5.0\nlost_messages: 1000\n"


@contextlib.contextmanager
def emulated(
    prepare=lambda device: None,
    scenario=SCENARIO,
    limits=DEFAULT,
    uses=(),
    patience=20.0,
):
    """An emulated device that runs in a thread of its own.

    It waits for a host that is late for `patience`, s, of real time.
    """
    device = EmulatedDevice(
        BenchPlant(scenario, uses),
        describe_device(scenario, "test-1"),
        limits,
        host_paced=patience,
    )
    prepare(device)
    thread = threading.Thread(target=device.run, daemon=True)
    thread.start()
    try:
        yield device
    finally:
        device.stop()
        thread.join(5.0)


def short_push(seconds=1.0):
    """A motion of 4 mm onto the pads, and a stand."""
    time_s = np.arange(round(200 * seconds)) / 200.0
    samples = ramp(time_s, 0.1, 0.6, -0.004)
    return SafeMotion("push", "4 mm", True, "push", time_s, samples)


def open_recorder(device, out):
    """A recorder of what an emulated device does."""
    return Recorder(device.terminal.path, SCENARIO, PATIENT, out)


class NoKeys:
    """A console that nobody touches."""

    is_terminal = False

    def pressed(self):
        return False


def wait_for(condition, seconds=60.0):
    """Whether it holds, now or within so many seconds."""
    ends = time.monotonic() + seconds
    while time.monotonic() < ends:
        if condition():
            return True
        time.sleep(0.01)
    return False


def assert_device_stops(test, device, cause):
    """It has stopped, or does once it has read what the host has sent."""
    firmware = device.firmware
    test.assertTrue(wait_for(lambda: firmware.state == DeviceState.STOPPED))
    test.assertEqual(firmware.trip.cause, cause)
