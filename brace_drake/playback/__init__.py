"""Runs played back in 3D."""

from brace_drake.playback.states import (
    PlaybackStates,
    place_on_pads,
    states_of_readings,
    states_of_run,
)
from brace_drake.playback.write import AddPlayback, ShowPlayback, WritePlayback

__all__ = [
    "AddPlayback",
    "PlaybackStates",
    "ShowPlayback",
    "WritePlayback",
    "place_on_pads",
    "states_of_readings",
    "states_of_run",
]
