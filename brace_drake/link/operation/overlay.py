"""Device and twin in one scene in 3D: the twin is a ghost."""

from __future__ import annotations

import numpy as np

from brace_drake.core.errors import KinematicsError
from brace_drake.playback.live import PlaceNow
from brace_drake.playback.look import make_look
from brace_drake.playback.scene import AddScene
from brace_drake.playback.states import states_of_readings
from brace_drake.playback.write import LookAtBrace, StartLocalMeshcat
from brace_drake.scenario.brace import BraceScenario

DEVICE, TWIN = "/device", "/twin"
_GHOST = 0.35


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
