"""Looks for a way around PROTOCOL.md: all short sequences, then a long run.

    python tools/check_link_model.py --depth 6
    python tools/check_link_model.py --depth 4 --frames 1000000 --seed 1

The device is the emulator's own state machine, its messages real bytes. From
each of the roots a breadth-first search tries what a host may send, whether it
arrives, is lost, comes late or again, and what may happen to the device; a
random run has so many frames, sequence numbers go round in it, and each frame
may come again however old it is. After each step every invariant must hold.
Status 1, and the way there, where one does not.
"""

import argparse
import copy
import math
import random
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from typing import NamedTuple

from brace_drake.link.device.firmware import Firmware
from brace_drake.link.device.ticks import SESSION, Identity, Measured
from brace_drake.link.protocol.codec import Packet, make_codec
from brace_drake.link.protocol.limits import (
    DEFAULT,
    SHARED,
    first_wider,
    shared_values,
)
from brace_drake.link.protocol.messages import BY_NAME
from brace_drake.link.protocol.words import (
    TICK,
    TRANSITIONS,
    Cause,
    DeviceState,
)

ARMED, FAULT, STOPPED = (
    DeviceState.ARMED,
    DeviceState.FAULT,
    DeviceState.STOPPED,
)
_IDENTITY = Identity(
    "m", "i", "f", 1, 1e3, 0.0, 0.0, 0.0, (0.0,) * 3, *[(0.0,) * 18] * 2
)
_HOLD = (2.0,) * 6
# Readings move a little to and fro: at most so fast, m/s.
_STEP, _FASTEST = 1e-6, 2e-3
_MARKS = ("LIMITS", "COMMAND", "ARM", "CLEAR", "DISARM", "STOP")


def _limits(**changes):
    return lambda world: shared_values(DEFAULT._replace(**changes))


def _command(value):
    return lambda world: {
        "mode": 0, "tick": world.device.tick_count, "values": (value,) * 6,
    }  # fmt: skip


def _latched(world):
    return {"cause": int(world.device.trip.cause)}


# What a host may send: label, message, its values.
SENDS: dict[str, tuple[str, Callable]] = {
    "hello": ("HELLO_REQUEST", lambda world: {"nonce": 1}),
    "limits": ("LIMITS", _limits()),
    "wide": ("LIMITS", _limits(leg_force=41.0)),
    "brake": ("LIMITS", _limits(release_damping=2e4)),
    "arm": ("ARM", lambda world: {"nonce": 1}),
    "disarm": ("DISARM", lambda world: {"nonce": 1}),
    "stop": ("STOP", lambda world: {"cause": int(Cause.STOP_KEY)}),
    "clear": ("CLEAR", _latched),
    "clear other": ("CLEAR", lambda world: {"cause": int(Cause.JUMP)}),
    "command": ("COMMAND", _command(5.0)),
    "nan": ("COMMAND", _command(math.nan)),
    "heartbeat": ("HEARTBEAT", lambda world: {"echo_us": 0}),
}
# Of these it may lose one, that then comes late or never.
LOST = ("limits", "arm", "disarm", "stop", "clear", "command")
# What may happen: seconds until the next tick, what changes before it.
EVENTS: dict[str, tuple[float, dict]] = {
    "tick": (1e-3, {}),
    "late": (DEFAULT.watchdog + 1e-2, {}),
    "over": (SESSION + 0.1, {}),
    "estop": (1e-3, {"estop": True}),
    "estop off": (1e-3, {"estop": False}),
    "drive fault": (1e-3, {"drive_fault": True}),
    "drive good": (1e-3, {"drive_fault": False}),
    "pushed": (1e-3, {"pushed": True}),
    "let go": (1e-3, {"pushed": False}),
}
# Where searches begin.
ROOTS = (
    (),
    ("tick", "limits"),
    ("tick", "limits", "arm", "command", "tick"),
    ("tick", "limits", "arm", "disarm"),
    ("tick", "limits", "arm", "command", "tick", "stop", "tick"),
    ("tick", "limits", "arm", "estop", "estop off", "over", "limits"),
)


class Frame(NamedTuple):
    """A frame that the host has sent.

    Attributes:
        label: Of SENDS.
        number: In the order of sending, from 1.
        packet: What it says.
        session: That it is sealed with; None without seal.
        came: Whether it has come to the device before.
    """

    label: str
    number: int
    packet: Packet
    session: int | None
    came: bool


class Broken(AssertionError):
    """An invariant that does not hold."""


class World:
    """A device, the frames on their way to it, and what must hold.

    Attributes:
        device: The real one.
        frames: Sent so far.
        armings: From which frame each arming came.
        seen: Transitions gone.
    """

    def __init__(self, firmware: type[Firmware] = Firmware):
        self.device = firmware(_IDENTITY, DEFAULT, _HOLD, 1)
        self.frames: list[Frame] = []
        self.now, self.number = 0.0, 0
        self.estop = self.drive_fault = self.pushed = False
        # Of the session: the newest frame that was accepted, and when.
        self.newest, self.heard, self.fed = 0, 0.0, 0.0
        # When a release began, and from which forces; those of the last tick.
        self.released, self.begun, self.given = -1e9, _HOLD, _HOLD
        self.armings: Counter = Counter()
        self.seen: set = set()

    def copy(self) -> "World":
        """The same, that goes its own way; what was seen is shared."""
        other = copy.copy(self)
        other.frames = list(self.frames)
        other.device = copy.copy(self.device)
        other.device._pending = list(self.device._pending)
        return other

    def actions(self) -> Iterator[tuple[str, object]]:
        """All that may happen next."""
        yield from (("send", label) for label in SENDS)
        yield from (("lose", label) for label in LOST)
        yield from (("again", i) for i in self._kinds())
        yield from (("event", name) for name in EVENTS)

    def do(self, how: str, what) -> None:
        """Takes an action.

        Raises:
            Broken: An invariant does not hold after it.
        """
        if how == "event":
            self._tick(*EVENTS[what])
            return
        if how == "again":
            i = what
        else:
            i = len(self.frames)
            self.frames.append(self._make(what))
        if how != "lose":
            frame = self.frames[i]
            self._deliver(frame)
            self.frames[i] = frame._replace(came=True)

    def _make(self, label: str) -> Frame:
        name, values = SENDS[label]
        self.number += 1
        stamp = round(1e6 * self.now) + self.number
        session = 0 if name == "LIMITS" else self.device.session
        codec = make_codec(1)
        data = codec.encode(name, values(self), self.number, stamp, session)
        packet = codec.decode(data[1:-1])
        sealed = session if BY_NAME[name].sealed else None
        return Frame(label, self.number, packet, sealed, False)

    def _deliver(self, frame: Frame) -> None:
        device, name = self.device, frame.packet.name
        state, session, trip = device.state, device.session, device.trip
        accepted, rejected = device.accepted, device.rejected
        device.receive(frame.packet, self.now)
        taken = device.rejected == rejected and state != DeviceState.BOOT
        fresh = not frame.came and frame.number > self.newest
        ours = frame.session in (None, session) or name == "LIMITS"
        self._check_way(state, name)
        sealed = frame.session is not None and (name != "LIMITS" or session)
        if sealed and not fresh:
            self._hold(not taken, "a frame that is not fresh is accepted")
        if sealed and name != "LIMITS":
            right = frame.session == session != 0
            self._hold(right or not taken, "a frame of no or another session")
        if device.state == ARMED != state:
            self.armings[fresh and name == "ARM"] += 1
            self._hold(fresh and name == "ARM", "armed without a fresh ARM")
            safe = not (self.estop or self.drive_fault or self.pushed)
            self._hold(safe, "armed beyond a limit")
        if state in (STOPPED, FAULT) and device.state != state:
            told = frame.packet.values.cause == trip.cause
            self._hold(told, "a stop ended without its cause")
            safe = not (self.estop or self.drive_fault or self.pushed)
            self._hold(safe, "a stop ended, and its cause is there")
        if device.session != session:
            self._hold(taken and name == "LIMITS", "a session by no LIMITS")
            self._hold(device.session != 0, "a session of number 0")
            self.newest = frame.number
        elif name in _MARKS and session and ours:
            self.newest = max(self.newest, frame.number)
        moved = device.accepted > accepted
        self._hold(not moved or state == ARMED, "a command and not armed")
        if taken and BY_NAME[name].feeds != "nothing" and device.session:
            self.heard = self.now
        if moved or device.state == ARMED != state:
            self.fed = self.now
        if state == ARMED != device.state:
            self.released, self.begun = self.now, self.given
        self._check_limits()

    def _tick(self, seconds: float, changes: dict) -> None:
        vars(self).update(changes)
        self.now += seconds
        device, state, session = (
            self.device,
            self.device.state,
            self.device.session,
        )
        away = _STEP * (device.tick_count % 2)
        force = (0.0, 200.0 * self.pushed, 0.0)
        legs, faults = (0.141 + away,) * 6, (self.estop, self.drive_fault)
        device.tick(Measured(legs, force, None, *faults), self.now)
        self._check_way(state, TICK)
        self._hold(device.session in (0, session), "a session by no LIMITS")
        if device.session:
            self._hold(self.now - self.heard <= SESSION, "a session too long")
        if self.estop or self.drive_fault:
            self._hold(device.state == FAULT, "no fault by e-stop or drive")
        if device.state == ARMED:
            self._hold(not self.pushed, "armed beyond a limit")
            waited = self.now - self.fed
            self._hold(waited <= DEFAULT.watchdog, "armed beyond the watchdog")
        if state == ARMED != device.state:
            self.released, self.begun = self.now, self.given
        self._check_force(device.leg_force(self.now))

    def _check_force(self, u) -> None:
        """Nothing but what carries the weight, the release, and damping."""
        state, limits = self.device.state, self.device.limits
        before, self.given = self.given, u
        if state == ARMED:
            step = limits.leg_force_rate * 1e-3 + 1e-9
            for f, last in zip(u, before, strict=True):
                good = abs(f) <= limits.leg_force and abs(f - last) <= step
                self._hold(good, "a force beyond its limit, or its rate")
            return
        if state == FAULT:
            self._hold(not any(u), "a drive with power in FAULT")
            self.begun = self.given = _HOLD
            return
        s = min(1.0, (self.now - self.released) / limits.release_time)
        left = 1.0 - s * s * (3.0 - 2.0 * s)
        most = limits.release_damping * _FASTEST + 1e-9
        for f, h, begun in zip(u, _HOLD, self.begun, strict=True):
            away = abs(f - h - left * (begun - h))
            self._hold(away <= most, "force but release damping, not armed")

    def _check_limits(self) -> None:
        held = {s.name: getattr(self.device.limits, s.name) for s in SHARED}
        good = all(limit.allows(held[limit.name]) for limit in SHARED)
        held = shared_values(self.device.limits)
        own = self.device.own_limits
        self._hold(good and first_wider(held, own) is None, "limits too wide")

    def _check_way(self, state: DeviceState, on: str) -> None:
        after = self.device.state
        if after == state:
            return
        ways = [
            t for t in TRANSITIONS
            if state in t.before and t.after == after and t.on == on
        ]  # fmt: skip
        self._hold(bool(ways), f"{state.name} to {after.name} on {on}")
        self.seen.update(ways)

    def _hold(self, is_true: bool, what: str) -> None:
        if not is_true:
            raise Broken(what)

    def key(self) -> tuple:
        """What decides all that may follow: worlds of one key are one."""
        device = self.device
        kinds = self._kinds()
        waits = [self.now - at for at in (self.heard, self.fed, self.released)]
        return (
            device.state, device.trip.cause, device.session != 0, device._mode,
            self.estop, self.drive_fault, self.pushed,
            # So coarse that no search of less than 20 steps can tell.
            device.session and round(10.0 * min(waits[0], 3.0)),
            device.state == ARMED and round(100.0 * waits[1]),
            waits[2] < DEFAULT.release_time, device._command == _HOLD,
            tuple(kinds.values()),
        )  # fmt: skip

    def _kinds(self) -> dict[int, tuple]:
        """Frames that can still come, one of each kind: place and kind."""
        kinds: dict[tuple, int] = {}
        for i, frame in enumerate(self.frames):
            name, session = frame.packet.name, self.device.session
            if name not in _MARKS:
                continue
            kind = (name, frame.label, frame.number)
            if frame.session not in (None, 0, session):
                kind = (name, "of another session")
            elif frame.number <= self.newest:
                kind = (name, "old")
            kinds[kind] = i
        order = sorted((i, kind[:2]) for kind, i in kinds.items())
        return {i: (*kind, self.frames[i].came) for i, kind in order}


class Found(NamedTuple):
    """What a search has found: distinct worlds, steps, and where it broke."""

    worlds: int
    steps: int
    seen: frozenset
    broken: str = ""


def search(
    depth: int, root: tuple[str, ...], firmware: type[Firmware] = Firmware
) -> Found:
    """All sequences of so many actions behind those of a root."""
    begin = World(firmware)
    for label in root:
        begin.do("event" if label in EVENTS else "send", label)
    known, steps = {begin.key()}, 0
    level = [(begin, ())]
    for left in reversed(range(depth)):
        after = []
        for world, way in level:
            for action in world.actions():
                steps += 1
                then = world.copy()
                try:
                    then.do(*action)
                except Broken as error:
                    told = " > ".join(f"{h} {w}" for h, w in (*way, action))
                    return Found(
                        len(known), steps, frozenset(begin.seen),
                        f"{error}: {' > '.join(root)} > {told}",
                    )  # fmt: skip
                key = then.key()
                if key in known:
                    continue
                known.add(key)
                if left:
                    after.append((then, (*way, action)))
        level = after
    return Found(len(known), steps, frozenset(begin.seen))


# What a host does next in a state; by and by it does something else.
_GUIDE = {
    DeviceState.BOOT: ("event", "tick"),
    DeviceState.HELLO: ("send", "limits"),
    DeviceState.DISARMED: ("send", "arm"),
    ARMED: ("send", "command"),
    STOPPED: ("send", "clear"),
    FAULT: ("send", "clear"),
}
_KEPT, _RARE = 5000, 1e-5


def run_long(
    frames: int, seed: int, firmware: type[Firmware] = Firmware
) -> dict[str, int]:
    """So many frames of a host and a line that repeats any of them.

    Returns:
        What was counted, by name.

    Raises:
        Broken: An invariant does not hold.
    """
    draw, world = random.Random(seed), World(firmware)
    counts = dict.fromkeys(("frames", "again", "sessions"), 0)
    rare = {"limits", "over"}
    odd = [a for a in world.actions() if a[1] not in rare]
    while counts["frames"] < frames:
        chance, session = draw.random(), world.device.session
        is_far = world.estop or world.drive_fault or world.pushed
        if chance < _RARE:
            action = draw.choice((("send", "limits"), ("event", "over")))
        elif chance < 0.4:
            action = ("event", "tick")
        elif chance < 0.75:
            action = _GUIDE[world.device.state]
            if not session and action != ("event", "tick"):
                action = ("send", "limits")
        elif chance < 0.95 and world.frames:
            action = ("again", draw.randrange(len(world.frames)))
        elif is_far and chance < 0.98:
            good = ("estop off", "drive good", "let go")
            action = ("event", draw.choice(good))
        elif chance > 0.98:
            action = draw.choice(odd)
        else:
            continue
        world.do(*action)
        counts["frames"] += action[0] in ("send", "again")
        counts["again"] += action[0] == "again"
        counts["sessions"] += world.device.session not in (0, session)
        if len(world.frames) > _KEPT:
            # Any age stays, so that numbers go round.
            i = draw.randrange(_KEPT)
            world.frames[i] = world.frames.pop()
    counts["numbers went round"] = world.number >> 16
    counts["armings"] = sum(world.armings.values())
    counts["armings without a fresh ARM"] = world.armings[False]
    counts["ways seen"] = len(world.seen)
    return counts


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--depth", type=int, default=4)
    parser.add_argument("--frames", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    seen, worlds, steps, broken = set(), 0, 0, False
    for root in ROOTS:
        begun = time.perf_counter()
        found = search(args.depth, root)
        took = time.perf_counter() - begun
        seen |= found.seen
        worlds, steps = worlds + found.worlds, steps + found.steps
        print(
            f"{found.worlds:8} worlds, {found.steps:9} steps, {took:5.0f} s:"
            f" {args.depth} actions behind {' > '.join(root) or 'boot'}",
            flush=True,
        )
        if found.broken:
            broken = True
            print(f"broken: {found.broken}")
    ways = f"{len(seen)} of {len(TRANSITIONS)} ways of the table"
    print(f"{worlds} worlds, {steps} steps; {ways}")
    try:
        for name, number in run_long(args.frames, args.seed).items():
            print(f"{number:8} {name}")
    except Broken as error:
        broken = True
        print(f"broken: {error}")
    return int(broken)


if __name__ == "__main__":
    sys.exit(main())
