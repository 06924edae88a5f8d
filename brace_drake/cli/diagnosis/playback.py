"""Options of commands that can play a run back in 3D."""

from __future__ import annotations

import argparse
from pathlib import Path


def AddPlaybackOptions(parser: argparse.ArgumentParser) -> None:
    """Adds --html and --meshcat."""
    parser.add_argument(
        "--html",
        metavar="FILE",
        help="also write a 3D playback with forces and pressures of the pads, a"
        " page that needs no network",
    )
    parser.add_argument(
        "--meshcat",
        action="store_true",
        help="show it in a browser on this machine: a simulation as it runs, in"
        " real time, and what has ended again and again until Enter",
    )


def wants_playback(args: argparse.Namespace) -> bool:
    """Whether a run has to be kept for a playback."""
    return bool(args.html or args.meshcat)


def PlayStates(
    args: argparse.Namespace,
    scenario,
    states,
    title: str,
    torso_mesh: Path | None = None,
    meshcat=None,
) -> None:
    """Does what --html and --meshcat ask for.

    Args:
        args: With the options of `AddPlaybackOptions`.
        scenario: Of bench or brace.
        states: PlaybackStates of a run.
        title: Of the page.
        torso_mesh: File of the torso's surface; else a plain one is drawn.
        meshcat: That has shown it live; None: a new one.

    Raises:
        OutputError: The page cannot be written.
    """
    from brace_drake.playback import ShowPlayback, WritePlayback

    if args.html:
        WritePlayback(scenario, states, args.html, title, torso_mesh=torso_mesh)
        print(f"playback: {args.html}")
    if args.meshcat:
        meshcat = ShowPlayback(scenario, states, torso_mesh, meshcat)
        try:
            input(f"playing at {meshcat.web_url()}; Enter ends it. ")
        except EOFError:
            print("\nno terminal to wait at: ended")
