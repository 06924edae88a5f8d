"""A picture of a torso with its pads: from the front, from the left, above."""

from __future__ import annotations

import io

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from brace_drake.torso.fitted import FittedTorso

# Title, and the axes of T that run right, up and towards the eye.
_VIEWS = (
    ("from the front", (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    ("from the left", (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    ("from above", (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)),
)
_SKIN, _PAD = np.array([0.93, 0.78, 0.68]), np.array([0.16, 0.38, 0.62])


def draw_torso(torso: FittedTorso) -> bytes:
    """The picture as PNG. Axes in metres, in T; rings are dotted lines."""
    figure = Figure(figsize=(11.0, 5.2), layout="constrained")
    canvas = FigureCanvasAgg(figure)
    for axes, view in zip(figure.subplots(1, 3), _VIEWS, strict=True):
        _draw_view(axes, torso, *view)
    data = io.BytesIO()
    canvas.print_png(data)
    return data.getvalue()


def _draw_view(axes, torso: FittedTorso, title, right, up) -> None:
    right, up = np.array(right), np.array(up)
    eye = np.cross(right, up)
    _draw_faces(
        axes, torso.solid.vertices, torso.solid.triangles, right, up, eye, _SKIN
    )
    for pad in torso.pads:
        # A pad's triangles face the torso: turn them to the eye, and lift them.
        vertices = pad.vertices + 0.004 * pad.place.normal
        triangles = pad.triangles[:, ::-1]
        _draw_faces(axes, vertices, triangles, right, up, eye, _PAD)
    if up[2]:
        for i, height in enumerate(torso.ring_heights, start=1):
            axes.axhline(height, linestyle=":", color="0.3", linewidth=0.8)
            axes.text(
                0.01,
                height,
                f"ring {i}",
                fontsize=7,
                va="bottom",
                transform=axes.get_yaxis_transform(),
            )
    names = ["xyz"[int(np.argmax(np.abs(axis)))] for axis in (right, up)]
    for label, axis, name in (
        (axes.set_xlabel, right, names[0]),
        (axes.set_ylabel, up, names[1]),
    ):
        label(f"{'-' if axis.sum() < 0 else ''}{name}, m")
    axes.set_title(title, fontsize=10)
    axes.set_aspect("equal")
    axes.autoscale_view()


def _draw_faces(axes, vertices, triangles, right, up, eye, colour) -> None:
    """Triangles that face the eye, the far ones first, lit from there."""
    corners = vertices[triangles]
    normals = np.cross(
        corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    )
    facing = normals @ eye / np.linalg.norm(normals, axis=1)
    seen = np.flatnonzero(facing > 0.0)
    seen = seen[np.argsort((corners[seen] @ eye).mean(axis=1))]
    flat = np.stack([corners[seen] @ right, corners[seen] @ up], axis=-1)
    shade = 0.45 + 0.55 * facing[seen]
    colours = np.clip(shade[:, None] * colour, 0.0, 1.0)
    axes.add_collection(
        PolyCollection(
            flat, facecolors=colours, edgecolors=0.9 * colours, linewidths=0.3
        )
    )
