"""Kills an armed host at random moments and measures how the device stops.

    python tools/kill_host.py --kills 100

The host is a process of its own, ended by SIGKILL. Status 1 where the device
was not STOPPED by its watchdog within the period and one tick, by its clock.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import threading
import time

from brace_drake.link.emulator.bench_plant import BenchPlant
from brace_drake.link.emulator.describe import describe_device
from brace_drake.link.emulator.device import EmulatedDevice
from brace_drake.link.protocol.limits import DEFAULT
from brace_drake.link.protocol.words import Cause, DeviceState
from brace_drake.scenario.brace import BenchScenario

_HOST = """
import sys, time
from brace_drake.link.protocol.limits import DEFAULT
from brace_drake.link.host.link import Link
from brace_drake.link.protocol.words import Cause, DeviceState
link = Link(sys.argv[1])
link.Connect(10.0)
link.Agree(DEFAULT)
state = link.WaitForState()
if state.state == DeviceState.STOPPED:
    link.Clear(Cause(state.cause))
hold = tuple(float(v) for v in sys.argv[2].split(","))
# A spring in each leg: nothing else holds a ring for minutes.
rest = state.leg_length
def answer(packet, lost):
    if packet.values.state == DeviceState.ARMED:
        pairs = zip(hold, rest, packet.values.leg_length)
        forces = [h + 1500.0 * (a - b) for h, a, b in pairs]
        link.Command(forces, packet.values.tick)
link.on_state = answer
link.Arm()
print("armed", flush=True)
time.sleep(60.0)
"""

_TRIES = 5


def kill_once(device: EmulatedDevice, hold: str, draw) -> float | None:
    """Waited time of the watchdog, s; None where it did not stop."""
    device.plan_rest()
    firmware = device.firmware
    for _ in range(_TRIES):
        host = subprocess.Popen(
            [sys.executable, "-c", _HOST, device.terminal.path, hold],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        if host.stdout.readline().strip() == "armed":
            break
        # On a busy machine the watchdog may be there before the answer is.
        told = host.communicate()[1]
    else:
        print(told)
        return None
    time.sleep(draw.uniform(0.02, 0.2))
    os.kill(host.pid, signal.SIGKILL)
    host.wait()
    host.stdout.close()
    host.stderr.close()
    ends = time.monotonic() + 5.0
    while firmware.state == DeviceState.ARMED and time.monotonic() < ends:
        time.sleep(0.005)
    if firmware.state != DeviceState.STOPPED:
        return None
    return (
        firmware.trip.value if firmware.trip.cause == Cause.WATCHDOG else None
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    scenario = BenchScenario(time_step=5e-4)
    device = EmulatedDevice(
        BenchPlant(scenario), describe_device(scenario, "k")
    )
    thread = threading.Thread(target=device.run, daemon=True)
    thread.start()
    hold = ",".join(map(str, device.plant.hold))
    draw = random.Random(args.seed)
    waits = [kill_once(device, hold, draw) for _ in range(args.kills)]
    device.stop()
    thread.join(5.0)
    most = DEFAULT.watchdog + device.plant.period
    good = [w for w in waits if w is not None and w <= most]
    print(f"{len(good)} of {args.kills} kills ended by the watchdog in time")
    if good:
        print(f"waited {1e3 * min(good):.1f} to {1e3 * max(good):.1f} ms")
    return int(len(good) < args.kills)


if __name__ == "__main__":
    sys.exit(main())
