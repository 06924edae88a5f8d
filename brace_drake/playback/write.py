"""A playback as a file of its own, or in a browser on this machine."""

from __future__ import annotations

import ctypes
import html
import logging
import socket
import sys
import threading
from pathlib import Path

from pydrake.geometry import Meshcat, MeshcatParams

from brace_drake.core.output import WriteText
from brace_drake.playback.look import Look, make_look
from brace_drake.playback.scales import (
    NO_PRESSURE,
    TOP_PRESSURE,
    Scales,
    make_scales,
)
from brace_drake.playback.scene import AddScene, SetScene, make_animation
from brace_drake.playback.states import PlaybackStates
from brace_drake.scenario.load import Scenario

_FORCE = """\
<span style="color:#cc141a">&#9632;</span> force of a {what}:
    100 mm for {newtons:g} N, largest {largest:.1f} N<br>
    <span style="background:linear-gradient(90deg,{colours});
    padding:0 24px">&nbsp;</span> mean pressure of a pad's face: 0 to {top:g}
    kPa, largest {pressure:.2f} kPa<br>"""

FRAMES_PER_SECOND = 25.0
# Each Meshcat with its thread. Drake ends the process where another thread
# destroys one, as the garbage collector may, or the end of the interpreter: so
# each is held once more until its thread finds that nobody else has it.
_served: list[tuple[int, Meshcat]] = []
# References then: that one, the entry's, a loop's, a call's.
_ALONE = 4
_hold, _let_go = ctypes.pythonapi.Py_IncRef, ctypes.pythonapi.Py_DecRef
# What a headset would fetch; a page that is to be complete must not.
_OUTSIDE = "https://cdn.jsdelivr.net/npm/@webxr-input-profiles/"

# A telephone would show the page of a desk, a third of its size.
_VIEWPORT = """<head>
  <meta name="viewport" content="width=device-width, initial-scale=1">
  <style>
    #caption {
      position: fixed; left: 16px; right: 16px; top: 12px; max-width: 48em;
      font: 14px/1.45 system-ui, sans-serif; color: #1c2733;
      pointer-events: none;
    }
    /* Below the button of the controls. */
    @media (max-width: 720px) { #caption { top: 28px; } }
  </style>"""

_CAPTION = """\
  <div id="caption">
    <b>{title}</b><br>
    {force}
    axes of the world frame: <span style="color:#c01a1a">x to the front</span>,
    <span style="color:#157a15">y to the left</span>,
    <span style="color:#1a33c0">z up</span>; {seconds:.1f} s in real time
  </div>
"""


def AddPlayback(
    meshcat: Meshcat,
    scenario: Scenario,
    states: PlaybackStates,
    torso_mesh: Path | None = None,
) -> Scales:
    """Adds bench or brace of a scenario to Meshcat, moving over its states.

    Args:
        meshcat: Where to.
        scenario: Of bench or brace; `states` has as many rings.
        states: What happened.
        torso_mesh: File of a torso's surface, m, in its frame; else a plain
            elliptic one.

    Returns:
        Scales of arrows and colours.

    Raises:
        ScenarioError: The scenario's device has no rings.
    """
    look = make_look(scenario)
    scales = make_scales(look, states)
    AddScene(meshcat, look, torso_mesh)
    SetScene(look, states, scales, 0, meshcat.SetTransform, meshcat.SetProperty)
    LookAtBrace(meshcat, look)
    meshcat.SetAnimation(
        make_animation(look, states, scales, FRAMES_PER_SECOND)
    )
    return scales


def LookAtBrace(meshcat: Meshcat, look: Look) -> None:
    """Puts the camera in front of the brace, to its right and above."""
    middle = 0.5 * (look.clamped_height + look.geometry.rest[-1, 2])
    meshcat.SetCamera(Meshcat.PerspectiveCamera(fov=32.0))
    meshcat.SetCameraPose([0.98, -0.62, middle + 0.55], [0.0, 0.0, middle])


def WritePlayback(
    scenario: Scenario,
    states: PlaybackStates,
    path: str | Path,
    title: str = "",
    torso_mesh: Path | None = None,
) -> None:
    """Writes a page that plays the motion in 3D and loads nothing else.

    Args:
        scenario, states, torso_mesh: See `AddPlayback`.
        path: The file, *.html.
        title: Its heading; empty: the scenario's device.

    Raises:
        ScenarioError: The scenario's device has no rings.
        OutputError: The file cannot be written.
    """
    meshcat = StartLocalMeshcat()
    scales = AddPlayback(meshcat, scenario, states, torso_mesh)
    text = meshcat.StaticHtml().replace(_OUTSIDE, "")
    title = title or scenario.device
    caption = make_caption(states, scales, title)
    text = text.replace("Drake MeshCat", html.escape(title), 1)
    text = text.replace("<head>", _VIEWPORT, 1)
    head, body = text.split("<body>", 1)
    WriteText(Path(path), f"{head}<body>\n{caption}{body}")


def ShowPlayback(
    scenario: Scenario,
    states: PlaybackStates,
    torso_mesh: Path | None = None,
    meshcat: Meshcat | None = None,
) -> Meshcat:
    """Plays the motion in browsers on this machine, as long as the result is.

    Args:
        scenario, states, torso_mesh: See `AddPlayback`.
        meshcat: Where to; None: a new one.

    Raises:
        ScenarioError: The scenario's device has no rings.
    """
    meshcat = meshcat or StartLocalMeshcat()
    AddPlayback(meshcat, scenario, states, torso_mesh)
    return meshcat


def StartLocalMeshcat(host: str = "localhost") -> Meshcat:
    """A Meshcat that only this machine can reach, or who reaches `host`.

    Raises:
        OSError: This machine cannot listen there.
    """
    # Drake would wait for ever.
    family, *_, address = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM)[
        0
    ]
    socket.create_server(address[:2], family=family).close()
    own = threading.get_ident()
    for entry in _served[:]:
        thread, meshcat = entry
        if thread == own and sys.getrefcount(meshcat) <= _ALONE:
            _served.remove(entry)
            _let_go(ctypes.py_object(meshcat))
        del entry, meshcat
    log = logging.getLogger("drake")
    level = log.level
    # Drake tells an address that is of no use for a page on disk.
    log.setLevel(logging.WARNING)
    try:
        meshcat = Meshcat(MeshcatParams(host=host))
    finally:
        log.setLevel(level)
    _hold(ctypes.py_object(meshcat))
    _served.append((own, meshcat))
    return meshcat


def make_caption(states: PlaybackStates, scales: Scales, title: str) -> str:
    """The page's heading: what is seen, and the scales."""
    largest = float((states.pad_force**2).sum(axis=-1).max() ** 0.5)
    what = "ring on the torso, at the pad that presses"
    if states.is_of_pads:
        what = "pad on the torso"
    force = _FORCE.format(
        what=what,
        newtons=0.1 * scales.newtons_per_metre,
        largest=largest,
        colours=",".join(_css(c) for c in (NO_PRESSURE, TOP_PRESSURE)),
        top=1e-3 * scales.top,
        pressure=1e-3 * float(scales.pressures.max()),
    )
    return _CAPTION.format(
        title=html.escape(title),
        force=force if largest > 0.0 else "",
        seconds=float(states.times[-1] - states.times[0]),
    )


def _css(colour) -> str:
    return f"rgb({','.join(str(round(255 * share)) for share in colour)})"
