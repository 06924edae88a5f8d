"""The articulated brace as SDF models and model directives."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from brace_drake.core.output import WriteText
from brace_drake.kinematics import BraceGeometry
from brace_drake.model.articulated.links import (
    Link,
    make_bare_ring,
    make_rod,
    make_tube,
)
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_geometry

PACKAGE = "brace_drake"
DIRECTIVES = "brace.dmd.yaml"

# For drawing: straight pieces of a ring, and their radius, m.
_RING_PIECES = 24
_RING_RADIUS = 0.006

_BY = "Written by tools/write_brace_models.py from the scenario's numbers."


def leg_name(scenario: BraceScenario, i: int, k: int) -> str:
    """Model instance of leg k (0 to 5) of the stage of index i."""
    return f"stage{scenario.stages[i]}_leg{k + 1}"


def clamped_name(scenario: BraceScenario) -> str:
    """Model instance of the ring that stands still: below the lowest stage."""
    return f"clamped_ring{scenario.stages[0] - 1}"


def clamped_height(scenario: BraceScenario) -> float:
    """Of that ring in W, m."""
    return float(scenario.ring_heights[scenario.stages[0] - 1])


def calc_leg_frame(geometry: BraceGeometry, i: int, k: int) -> np.ndarray:
    """Roll, pitch, yaw of a leg at rest, which lies along z (3,), rad."""
    anchor = geometry.lower[i, k] + (geometry.rest[i - 1] if i else 0.0)
    x, y, z = geometry.rest[i] + geometry.upper[i, k] - anchor
    length = np.linalg.norm([x, y, z])
    return np.array([np.arcsin(-y / length), np.arctan2(x, z), 0.0])


def make_models(scenario: BraceScenario) -> dict[str, str]:
    """Texts of the brace's files by name: SDF of each link, and directives.

    Raises:
        ScenarioError: A ring is too light for the halves of its legs.
    """
    geometry, ring = pack_geometry(scenario), scenario.ring
    clamped = Link(ring.mass, np.zeros(3), np.diag(ring.inertia))
    name = clamped_name(scenario)
    texts = {f"{name}.sdf": _ring_sdf(name, clamped, ring.half_axes)}
    for i, name in enumerate(scenario.rings):
        link = make_bare_ring(scenario, geometry, i)
        half_axes = scenario.ring.half_axes
        texts[f"bare_{name}.sdf"] = _ring_sdf(name, link, half_axes)
    for i in range(geometry.num_stages):
        for k in range(6):
            rest = geometry.rest_lengths[6 * i + k]
            texts.setdefault(
                _leg_file(scenario, geometry, i, k), _leg_sdf(scenario, rest)
            )
    texts[DIRECTIVES] = _directives(scenario, geometry)
    return texts


def WriteBraceModels(scenario: BraceScenario, folder: Path) -> list[Path]:
    """Writes the brace's files, and the package that they name each other by.

    Raises:
        OutputError: The folder cannot be written to.
    """
    texts = make_models(scenario)
    texts["package.xml"] = (
        f'<?xml version="1.0"?>\n<!-- {_BY} -->\n<package format="2">\n'
        f"  <name>{PACKAGE}</name>\n</package>\n"
    )
    paths = []
    for name, text in texts.items():
        paths.append(Path(folder) / name)
        WriteText(paths[-1], text)
    return paths


def _leg_file(scenario, geometry, i, k) -> str:
    """One file serves a stage unless its legs differ in length."""
    own = geometry.rest_lengths[6 * i : 6 * i + 6]
    number = scenario.stages[i]
    alike = np.ptp(own) < 1e-12
    return f"leg{number}.sdf" if alike else f"leg{number}_{k + 1}.sdf"


def _number(value: float) -> str:
    # Adding 0 makes -0 a 0.
    return repr(round(float(value), 15) + 0.0)


def _numbers(values) -> str:
    return " ".join(_number(v) for v in values)


def _list(values) -> str:
    return f"[{', '.join(_number(v) for v in values)}]"


def _inertial(link: Link) -> str:
    I = link.I_LLcm  # noqa: E741
    entries = {
        "ixx": I[0, 0], "iyy": I[1, 1], "izz": I[2, 2],
        "ixy": I[0, 1], "ixz": I[0, 2], "iyz": I[1, 2],
    }  # fmt: skip
    tags = "".join(f"<{t}>{_number(v)}</{t}>" for t, v in entries.items())
    return f"""      <inertial>
        <pose>{_numbers(link.p_LoLcm)} 0 0 0</pose>
        <mass>{_number(link.mass)}</mass>
        <inertia>{tags}</inertia>
      </inertial>"""


def _cylinder_visual(name, pose, radius: float, length: float) -> str:
    return f"""      <visual name="{name}">
        <pose>{_numbers(pose)}</pose>
        <geometry><cylinder>
          <radius>{_number(radius)}</radius><length>{_number(length)}</length>
        </cylinder></geometry>
      </visual>"""


def _link_visual(name: str, link: Link, radius: float) -> str:
    """A cylinder along z with its middle at the centre of mass."""
    middle = link.p_LoLcm
    pose = [*middle, 0.0, 0.0, 0.0]
    return _cylinder_visual(name, pose, radius, 2.0 * abs(middle[2]))


def _ring_visuals(half_axes: np.ndarray) -> str:
    """The ring's ellipse in straight pieces."""
    turn = 2.0 * np.pi * np.arange(_RING_PIECES + 1) / _RING_PIECES
    ends = half_axes * np.column_stack([np.cos(turn), np.sin(turn)])
    visuals = []
    for k, (a, b) in enumerate(pairwise(ends)):
        (x, y), (dx, dy) = 0.5 * (a + b), b - a
        pose = [x, y, 0.0, 0.0, 0.5 * np.pi, np.arctan2(dy, dx)]
        length = np.hypot(dx, dy)
        visuals.append(
            _cylinder_visual(f"piece{k}", pose, _RING_RADIUS, length)
        )
    return "\n".join(visuals)


def _ring_sdf(name: str, link: Link, half_axes: np.ndarray) -> str:
    return f"""<?xml version="1.0"?>
<!-- {name} without the halves of its legs, for the articulated brace.
     {_BY} -->
<sdf version="1.9">
  <model name="{name}">
    <link name="{name}">
{_inertial(link)}
{_ring_visuals(half_axes)}
    </link>
  </model>
</sdf>
"""


def _leg_sdf(scenario: BraceScenario, rest: float) -> str:
    leg, half = scenario.leg, 0.5 * scenario.leg.stroke
    tube, rod = (f(scenario, rest - half) for f in (make_tube, make_rod))
    # A universal joint's axes are not driven.
    idle = "<limit><effort>0</effort></limit>"
    return f"""<?xml version="1.0"?>
<!-- A leg along z, at its length at rest, {rest:.6f} m: clevis on the ring
     below, tube on a universal joint, rod driven along the tube. The rod's
     origin is the ball joint on the ring above; that joint closes a loop and
     is added to the plant as a constraint.
     {_BY} -->
<sdf version="1.9">
  <model name="leg">
    <link name="clevis">
      <inertial>
        <mass>0</mass>
        <inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz></inertia>
      </inertial>
    </link>
    <link name="tube">
{_inertial(tube)}
{_link_visual("tube", tube, leg.tube_radius)}
    </link>
    <link name="rod">
      <pose>0 0 {_number(rest)} 0 0 0</pose>
{_inertial(rod)}
{_link_visual("rod", rod, leg.rod_radius)}
    </link>
    <joint name="universal" type="universal">
      <parent>clevis</parent>
      <child>tube</child>
      <axis><xyz>1 0 0</xyz>{idle}</axis>
      <axis2><xyz>0 1 0</xyz>{idle}</axis2>
    </joint>
    <joint name="drive" type="prismatic">
      <parent>tube</parent>
      <child>rod</child>
      <axis>
        <xyz>0 0 1</xyz>
        <limit>
          <lower>{_number(-half)}</lower>
          <upper>{_number(half)}</upper>
          <effort>{_number(leg.force_limit)}</effort>
        </limit>
        <dynamics><damping>{_number(leg.viscous)}</damping></dynamics>
      </axis>
    </joint>
  </model>
</sdf>
"""


def _directives(scenario: BraceScenario, geometry: BraceGeometry) -> str:
    lines = [
        "# The articulated brace: rings, and legs on the ring below. Ball",
        "# constraints between rods and the rings above close the loops:",
        "# brace_drake.model.articulated.AddArticulatedBrace adds them.",
        f"# {_BY}",
        "directives:",
    ]
    clamped, height = clamped_name(scenario), clamped_height(scenario)
    lines += [
        "- add_model:",
        f"    name: {clamped}",
        f"    file: package://{PACKAGE}/{clamped}.sdf",
        "- add_weld:",
        "    parent: world",
        f"    child: {clamped}::{clamped}",
        f"    X_PC: {{translation: {_list([0.0, 0.0, height])}}}",
    ]
    for i, name in enumerate(scenario.rings):
        place = _list(geometry.rest[i])
        lines += [
            "- add_model:",
            f"    name: {name}",
            f"    file: package://{PACKAGE}/bare_{name}.sdf",
            "    default_free_body_pose:",
            f"      {name}: {{translation: {place}}}",
        ]
    for i in range(geometry.num_stages):
        below = scenario.rings[i - 1] if i else clamped
        for k in range(6):
            p_BF = geometry.lower[i, k] - [0.0, 0.0, 0.0 if i else height]
            lines += _leg_directives(scenario, geometry, i, k, below, p_BF)
    return "\n".join(lines) + "\n"


def _leg_directives(scenario, geometry, i, k, below, p_BF) -> list[str]:
    name = leg_name(scenario, i, k)
    file = _leg_file(scenario, geometry, i, k)
    angles = _list(np.rad2deg(calc_leg_frame(geometry, i, k)))
    return [
        "- add_model:",
        f"    name: {name}",
        f"    file: package://{PACKAGE}/{file}",
        "- add_frame:",
        f"    name: {name}_foot",
        "    X_PF:",
        f"      base_frame: {below}::{below}",
        f"      translation: {_list(p_BF)}",
        f"      rotation: !Rpy {{deg: {angles}}}",
        "- add_weld:",
        f"    parent: {name}_foot",
        f"    child: {name}::clevis",
    ]
