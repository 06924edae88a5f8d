"""A bench or brace in 3D while it is simulated."""

from __future__ import annotations

from pathlib import Path

from pydrake.systems.framework import Context

from brace_drake.model.brace_station import BraceStation
from brace_drake.playback.look import make_look
from brace_drake.playback.scales import Scales, calc_pressures
from brace_drake.playback.scene import AddScene, SetScene
from brace_drake.playback.states import PlaybackStates, states_of_now
from brace_drake.playback.write import LookAtBrace, StartLocalMeshcat
from brace_drake.scenario.load import Scenario

# Of arrows, N/m, and of pads' colours, Pa, as the largest are not yet known.
SCALE, TOP_PRESSURE = 200.0, 5000.0


class LiveScene:
    """Serves a scene whose parts are put where they are, again and again.

    Attributes:
        meshcat: Where it is shown.
    """

    def __init__(self, scenario: Scenario, torso_mesh: Path | None = None):
        """Begins to serve, on this machine alone.

        Raises:
            ScenarioError: The scenario's device has no rings.
        """
        self._look = make_look(scenario)
        self.meshcat = StartLocalMeshcat()
        AddScene(self.meshcat, self._look, torso_mesh)
        LookAtBrace(self.meshcat, self._look)

    def Show(self, station: BraceStation, context: Context) -> None:
        """Puts all in its place; what `SimulateBrace` may call as `watch`."""
        states = states_of_now(station, context, self._look.rings)
        PlaceNow(self.meshcat, self._look, states)


def PlaceNow(meshcat, look, states: PlaybackStates, under: str = "") -> None:
    """Puts a scene in its place at the first sample, with fixed scales."""
    pressures = calc_pressures(states.rings, states.pad_force, look.contacts)
    SetScene(
        look, states, Scales(SCALE, pressures, TOP_PRESSURE), 0,
        meshcat.SetTransform, meshcat.SetProperty, under,
    )  # fmt: skip
