"""The brace in Meshcat: shapes, and how they move."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from pydrake.geometry import (
    Box,
    Cylinder,
    Mesh,
    Meshcat,
    MeshcatAnimation,
    MeshcatCone,
    Rgba,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix

from brace_drake.playback.look import Look
from brace_drake.playback.meshes import make_ring_mesh, make_torso_mesh
from brace_drake.playback.scales import Scales, colour_of
from brace_drake.playback.states import PlaybackStates, transform

_CLAMPED, _RING = Rgba(0.33, 0.37, 0.42), Rgba(0.16, 0.42, 0.72)
_TUBE, _ROD, _JOINT = (
    Rgba(0.80, 0.82, 0.85),
    Rgba(0.55, 0.58, 0.62),
    Rgba(0.25, 0.27, 0.30),
)
_PAD, _TORSO = Rgba(0.93, 0.62, 0.18), Rgba(0.93, 0.77, 0.66, 0.6)
_FORCE = Rgba(0.80, 0.08, 0.10)
_AXES = {
    "x": Rgba(0.8, 0.1, 0.1),
    "y": Rgba(0.1, 0.6, 0.1),
    "z": Rgba(0.1, 0.2, 0.8),
}

# m. Half axes of a ring's section; of arms, joints, axes and arrows.
_RADIAL, _VERTICAL = 0.011, 0.006
_ARM, _JOINT_RADIUS, _AXIS = 0.004, 0.007, 0.0015
_AXIS_LENGTH, _AXIS_START = 0.05, (0.20, -0.20)
_SHAFT, _HEAD_RADIUS, _HEAD = 0.004, 0.010, 0.020
# A torso drawn without a scan: its depth to its width, and what it is longer
# than the brace, m.
_DEPTH, _BELOW, _ABOVE = 0.72, 0.05, 0.09

# Sets what moves, at a frame: a path and its pose, or its property.
SetPose = Callable[[str, RigidTransform], None]


def leg_anchors(look: Look, rings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of all legs in W, lower and upper (6 S, 3), m, at poses (S, 7)."""
    lower, upper, X_WL = [], [], RigidTransform()
    for i, pose in enumerate(rings):
        X_WR = transform(pose)
        lower.append((X_WL @ look.geometry.lower[i].T).T)
        upper.append((X_WR @ look.geometry.upper[i].T).T)
        X_WL = X_WR
    return np.vstack(lower), np.vstack(upper)


def AddScene(
    meshcat: Meshcat, look: Look, torso_mesh: Path | None, under: str = ""
) -> None:
    """Adds all shapes; `SetScene` then puts them in their places.

    Args:
        meshcat: Where to.
        look: Sizes.
        torso_mesh: File of a torso's surface (.obj, .gltf), m, in its frame;
            None: an elliptic trunk that touches the pads.
        under: Path that all of it lies under, such as "/twin".
    """
    meshcat.SetProperty("/Background", "top_color", [1.0, 1.0, 1.0])
    meshcat.SetProperty("/Background", "bottom_color", [0.86, 0.89, 0.93])
    meshcat.SetProperty("/Axes", "visible", False)
    meshcat.SetProperty("/Grid", "visible", False)
    _AddWorldAxes(meshcat, look.clamped_height)
    height = RigidTransform([0.0, 0.0, look.clamped_height])
    clamped = f"{under}/brace/clamped"
    _AddRing(meshcat, clamped, look, _CLAMPED)
    meshcat.SetTransform(clamped, height)
    joints = look.geometry.lower[0] - height.translation()
    _AddJoints(meshcat, clamped, look, joints)
    for i, (name, contact) in enumerate(
        zip(look.rings, look.contacts, strict=True)
    ):
        path = f"{under}/brace/{name}"
        _AddRing(meshcat, path, look, _RING)
        joints = look.geometry.upper[i]
        if i + 1 < len(look.rings):
            joints = np.vstack([joints, look.geometry.lower[i + 1]])
        _AddJoints(meshcat, path, look, joints)
        if contact is not None:
            for side, s in (("left", 1.0), ("right", -1.0)):
                _AddPad(meshcat, f"{path}/{side}_pad", look, contact, s)
                _AddArrow(meshcat, f"{under}/forces/{name}_{side}")
    for k, rest in enumerate(look.geometry.rest_lengths):
        _AddLeg(meshcat, f"{under}/brace/leg{k + 1}", look, rest)
    if any(look.contacts):
        _AddTorso(meshcat, f"{under}/torso", look, torso_mesh)


def SetScene(
    look: Look,
    states: PlaybackStates,
    scales: Scales,
    sample: int,
    set_transform: SetPose,
    set_property: Callable,
    under: str = "",
) -> None:
    """Puts all that moves in its place at a sample of the states.

    Args:
        look: Sizes.
        states: What happened.
        sample: Of the states.
        set_transform, set_property: Of Meshcat, or of an animation's frame.
        under: As in `AddScene`.
    """
    rings = states.rings[sample]
    lower, upper = leg_anchors(look, rings)
    for k, (a, b) in enumerate(zip(lower, upper, strict=True)):
        R = RotationMatrix.MakeFromOneVector(b - a, 2)
        leg = f"{under}/brace/leg{k + 1}"
        set_transform(f"{leg}/tube", RigidTransform(R, a))
        set_transform(f"{leg}/rod", RigidTransform(R, b))
    for i, (name, pose) in enumerate(zip(look.rings, rings, strict=True)):
        X_WR, contact = transform(pose), look.contacts[i]
        set_transform(f"{under}/brace/{name}", X_WR)
        if contact is None:
            continue
        for side, s in enumerate((1.0, -1.0)):
            tip = X_WR @ np.array([0.0, s * _pad_back(contact), 0.03])
            word = ("left", "right")[side]
            arrow = states.pad_force[sample, i, side] / scales.newtons_per_metre
            path = f"{under}/forces/{name}_{word}"
            _SetArrow(path, tip, arrow, set_transform, set_property)
            share = scales.pressures[sample, i, side] / scales.top
            colour = [*colour_of(share), 1.0]
            body = f"{under}/brace/{name}/{word}_pad/body"
            set_property(body, "color", colour)
    if states.torso is not None and any(look.contacts):
        set_transform(f"{under}/torso", transform(states.torso[sample]))


def make_animation(
    look: Look,
    states: PlaybackStates,
    scales: Scales,
    frames_per_second: float,
) -> MeshcatAnimation:
    """The motion, in real time, again and again."""
    animation = MeshcatAnimation(frames_per_second)
    for frame, sample in enumerate(states.frames(frames_per_second)):

        def set_transform(path, X, frame=frame):
            animation.SetTransform(frame, path, X)

        def set_property(path, name, value, frame=frame):
            if name == "color":
                # The viewer animates what its 3D objects have themselves.
                path, name = f"{path}/<object>", "material.color"
                value = value[0:3]
            animation.SetProperty(frame, path, name, value)

        SetScene(look, states, scales, sample, set_transform, set_property)
    animation.set_autoplay(True)
    animation.set_loop_mode(MeshcatAnimation.LoopMode.kLoopRepeat)
    animation.set_repetitions(1000)
    return animation


def _pad_back(contact) -> float:
    """Distance of a pad's outer face from the ring's centre, m."""
    return contact.pad_offset - contact.preload + contact.pad_size[1]


def _AddRing(meshcat, path: str, look: Look, colour: Rgba) -> None:
    vertices, faces = make_ring_mesh(look.half_axes, _RADIAL, _VERTICAL)
    meshcat.SetTriangleMesh(f"{path}/body", vertices, faces, colour)


def _AddJoints(meshcat, path: str, look: Look, joints: np.ndarray) -> None:
    """Joints of legs, on arms that reach out to the ring's body."""
    middle = look.half_axes - _RADIAL
    for k, p in enumerate(joints):
        at = f"{path}/joint{k + 1}"
        meshcat.SetObject(f"{at}/ball", Sphere(_JOINT_RADIUS), _JOINT)
        meshcat.SetTransform(f"{at}/ball", RigidTransform(p))
        end = p / np.linalg.norm(p[:2] / middle)
        _AddBar(meshcat, f"{at}/arm", p, end, _ARM, _JOINT)


def _AddBar(meshcat, path, a, b, radius: float, colour: Rgba) -> None:
    length = np.linalg.norm(b - a)
    if length < 1e-6:
        return
    R = RotationMatrix.MakeFromOneVector(b - a, 2)
    meshcat.SetObject(path, Cylinder(radius, length), colour)
    meshcat.SetTransform(path, RigidTransform(R, 0.5 * (a + b)))


def _AddLeg(meshcat, path: str, look: Look, rest: float) -> None:
    """Tube from its lower end and rod to its upper, along z of their frames."""
    closed = max(rest - 0.5 * look.leg.stroke, 0.5 * rest)
    for part, radius, colour, s in (
        ("tube", look.leg.tube_radius, _TUBE, 0.5),
        ("rod", look.leg.rod_radius, _ROD, -0.5),
    ):
        # Drawn thinner: tubes of neighbours would meet at their joints.
        shape = Cylinder(0.75 * radius, closed)
        meshcat.SetObject(f"{path}/{part}/body", shape, colour)
        middle = RigidTransform([0.0, 0.0, s * closed])
        meshcat.SetTransform(f"{path}/{part}/body", middle)


def _AddPad(meshcat, path: str, look: Look, contact, s: float) -> None:
    meshcat.SetObject(f"{path}/body", Box(*contact.pad_size), _PAD)
    back = _pad_back(contact)
    middle = [0.0, s * (back - 0.5 * contact.pad_size[1]), 0.0]
    meshcat.SetTransform(f"{path}/body", RigidTransform(middle))
    ends = np.array([[0.0, s * back, 0.0], [0.0, s * look.half_axes[1], 0.0]])
    ends[1, 1] -= s * _RADIAL
    _AddBar(meshcat, f"{path}/arm", *ends, _ARM, _JOINT)


def _AddArrow(meshcat, path: str) -> None:
    """A shaft of length 1 along -z from the arrow's neck, and a head."""
    meshcat.SetObject(f"{path}/shaft/body", Cylinder(_SHAFT, 1.0), _FORCE)
    meshcat.SetTransform(f"{path}/shaft/body", RigidTransform([0, 0, -0.5]))
    # A cone's tip is its origin, and it opens along z.
    cone = MeshcatCone(_HEAD, _HEAD_RADIUS, _HEAD_RADIUS)
    meshcat.SetObject(f"{path}/head/body", cone, _FORCE)
    down = RigidTransform(RotationMatrix.MakeXRotation(np.pi))
    meshcat.SetTransform(f"{path}/head/body", down)


def _SetArrow(path, tip, arrow, set_transform, set_property) -> None:
    """The arrow ends at its tip and is as long as the vector `arrow`, m."""
    length = float(np.linalg.norm(arrow))
    shown = length > 1e-4
    R = RotationMatrix()
    if shown:
        R = RotationMatrix.MakeFromOneVector(arrow, 2)
    head = min(1.0, length / _HEAD) if shown else 1e-3
    shaft = max(length - _HEAD, 1e-4)
    neck = tip - R.col(2) * (length - shaft)
    set_transform(f"{path}/head", RigidTransform(R, tip))
    set_transform(f"{path}/shaft", RigidTransform(R, neck))
    set_property(f"{path}/head", "scale", [head] * 3)
    set_property(f"{path}/shaft", "scale", [head, head, shaft])


def _AddTorso(meshcat, path: str, look: Look, torso_mesh: Path | None) -> None:
    if torso_mesh is not None:
        meshcat.SetObject(f"{path}/body", Mesh(str(torso_mesh)), _TORSO)
    else:
        width = min(c.pad_offset for c in look.contacts if c is not None)
        ends = look.clamped_height - _BELOW, look.geometry.rest[-1, 2] + _ABOVE
        vertices, faces = make_torso_mesh(
            width, _DEPTH * width, *(z - look.torso_rest for z in ends)
        )
        meshcat.SetTriangleMesh(f"{path}/body", vertices, faces, _TORSO)
    rest = RigidTransform([0.0, 0.0, look.torso_rest])
    meshcat.SetTransform(path, rest)


def _AddWorldAxes(meshcat, height: float) -> None:
    """Directions of the axes of W, drawn outside the clamped ring."""
    for axis, (name, colour) in enumerate(_AXES.items()):
        start, end = np.array([*_AXIS_START, height]), np.zeros(3)
        end[axis] = _AXIS_LENGTH
        _AddBar(meshcat, f"/axes/{name}", start, start + end, _AXIS, colour)
