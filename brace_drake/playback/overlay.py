"""A device and its twin in 3D while they move, in a process of their own.

Drake ends the whole process where a Meshcat meets another thread than its own:
what drives a device must not have one.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import select
import sys

import numpy as np

from brace_drake.core.child import EndChild, StartChild
from brace_drake.core.errors import KinematicsError
from brace_drake.playback.live import PlaceNow
from brace_drake.playback.look import make_look
from brace_drake.playback.scene import AddScene
from brace_drake.playback.states import states_of_readings
from brace_drake.playback.write import LookAtBrace, StartLocalMeshcat
from brace_drake.scenario.brace import BraceScenario

DEVICE, TWIN = "/device", "/twin"
_GHOST = 0.35
# A process that does not serve by then never will; one that has nothing to do
# ends so soon, s.
_BEGINS, _ENDS = 60.0, 2.0


class Overlay:
    """Both in Meshcat, at poses that their leg lengths tell.

    It belongs to the thread that has made it, as Meshcat does.

    Attributes:
        meshcat: Where it is shown.
    """

    def __init__(self, scenario: BraceScenario, host: str = "127.0.0.1"):
        """Begins to serve, with both at rest.

        Args:
            scenario: Of the twin.
            host: Address to listen on; the loopback one lets nobody else in.
        """
        self._look = make_look(scenario)
        self.meshcat = StartLocalMeshcat(host)
        for under in (DEVICE, TWIN):
            AddScene(self.meshcat, self._look, None, under)
        self.meshcat.SetProperty(TWIN, "modulated_opacity", _GHOST)
        LookAtBrace(self.meshcat, self._look)

    def Show(self, device: np.ndarray, twin: np.ndarray) -> None:
        """Takes readings of both (9 S + 3,): lengths, forces, marker.

        What has lengths that fit no pose stays where it was.
        """
        for under, readings in ((DEVICE, device), (TWIN, twin)):
            try:
                self._Place(under, readings)
            except KinematicsError:
                continue

    def _Place(self, under: str, readings: np.ndarray) -> None:
        look = self._look
        legs, torso = 6 * look.geometry.num_stages, None
        if any(look.contacts):
            torso = readings[None, -3:] + [0.0, 0.0, look.torso_rest]
        states = states_of_readings(
            look.geometry,
            np.zeros(1),
            readings[None, :legs],
            readings[None, legs:-3],
            torso,
        )
        PlaceNow(self.meshcat, look, states, under)


class OverlayProcess:
    """An overlay that may fail, hang or be killed: it is then just not seen.

    Attributes:
        port: Where it is served; None where it is not.
    """

    def __init__(self, scenario: BraceScenario, host: str = "127.0.0.1"):
        """Begins to make it; `Wait` until it is served.

        Args:
            scenario, host: As `Overlay` takes them.
        """
        self.port: int | None = None
        self._child = StartChild(__name__)
        self._pipe = self._child.stdin.fileno()
        with contextlib.suppress(OSError):
            os.write(self._pipe, pickle.dumps((scenario, host)))
        os.set_blocking(self._pipe, False)

    def Wait(self) -> None:
        """Waits until it is served, or it is clear that it will not be."""
        told = self._child.stdout
        if select.select([told], [], [], _BEGINS)[0]:
            self.port = int(told.readline() or 0) or None

    def Show(self, device: np.ndarray, twin: np.ndarray) -> None:
        """Takes readings as `Overlay`; what it has no time for is not shown."""
        # So few bytes are written as a whole, or not at all.
        with contextlib.suppress(OSError):
            os.write(self._pipe, np.concatenate([device, twin]).tobytes())

    def __enter__(self) -> OverlayProcess:
        return self

    def __exit__(self, *_) -> None:
        """Ends it."""
        EndChild(self._child, _ENDS)


def _Serve() -> None:
    """Shows what comes in until nothing more does."""
    given = sys.stdin.buffer
    scenario, host = pickle.load(given)
    overlay = Overlay(scenario, host)
    print(overlay.meshcat.port(), flush=True)
    size = 9 * len(scenario.stages) + 3
    while len(data := given.read(16 * size)) == 16 * size:
        overlay.Show(*np.frombuffer(data).reshape(2, size))


if __name__ == "__main__":
    _Serve()
