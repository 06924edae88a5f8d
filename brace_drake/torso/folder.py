"""A personal torso on disk: meshes, model, pads; written and read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from brace_drake.core.errors import TorsoError
from brace_drake.core.output import WriteText
from brace_drake.core.reading import LoadYaml
from brace_drake.torso.contact import TorsoContact
from brace_drake.torso.fitted import FittedTorso, calc_inertia
from brace_drake.torso.meshes import LoadSolid, LoadSurface, obj_text, vtk_text
from brace_drake.torso.pads import Pad, PadPlace
from brace_drake.torso.solid import deepest

SOLID, SURFACE = "torso.vtk", "torso.obj"
MODEL, PADS = "torso.sdf", "pads.yaml"

_SDF = """\
<?xml version="1.0"?>
<!-- A personal torso about To, at the centre of ring 2 at rest: x front, y
     left, z up. Homogeneous, {density:g} kg/m^3. The solid is what pads meet,
     the surface what is drawn. -->
<sdf version="1.9">
  <model name="torso">
    <link name="torso">
      <inertial>
        <pose>{com} 0 0 0</pose>
        <mass>{mass}</mass>
        <inertia>
          <ixx>{i[0]}</ixx><iyy>{i[1]}</iyy><izz>{i[2]}</izz>
          <ixy>{i[3]}</ixy><ixz>{i[4]}</ixz><iyz>{i[5]}</iyz>
        </inertia>
      </inertial>
      <visual name="surface">
        <geometry><mesh><uri>{surface}</uri></mesh></geometry>
      </visual>
      <collision name="solid">
        <geometry><mesh><uri>{solid}</uri></mesh></geometry>
        <drake:proximity_properties>
          <drake:compliant_hydroelastic/>
          <drake:hydroelastic_modulus>{modulus}</drake:hydroelastic_modulus>
          <drake:hunt_crossley_dissipation>{contact.dissipation!r}\
</drake:hunt_crossley_dissipation>
          <drake:relaxation_time>{contact.relaxation_time!r}\
</drake:relaxation_time>
          <drake:mu_static>{contact.friction!r}</drake:mu_static>
          <drake:mu_dynamic>{contact.friction!r}</drake:mu_dynamic>
        </drake:proximity_properties>
      </collision>
    </link>
  </model>
</sdf>
"""


def central_inertia(torso: FittedTorso) -> np.ndarray:
    """Inertia about the centre of mass, T axes (3, 3), kg m^2."""
    inertia = torso.inertia.Shift(torso.inertia.get_com())
    return inertia.CalcRotationalInertia().CopyToFullMatrix3()


def sdf_text(torso: FittedTorso, contact: TorsoContact, density: float) -> str:
    """The torso as a model that Drake's parser reads beside its meshes."""
    moments = central_inertia(torso)
    entries = moments[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    return _SDF.format(
        density=density,
        com=" ".join(repr(float(c)) for c in torso.inertia.get_com()),
        mass=repr(float(torso.inertia.get_mass())),
        i=[repr(float(value)) for value in entries],
        surface=SURFACE,
        solid=SOLID,
        modulus=repr(float(contact.foundation_modulus * torso.deepest)),
        contact=contact,
    )


def WriteTorso(
    folder: Path,
    torso: FittedTorso,
    surface: tuple[np.ndarray, np.ndarray],
    contact: TorsoContact,
    density: float,
) -> None:
    """Writes meshes, model and pads into a folder that exists.

    Raises:
        OutputError: It cannot be written.
    """
    folder = Path(folder)
    WriteText(folder / SURFACE, obj_text(*surface))
    WriteText(folder / SOLID, vtk_text(torso.solid))
    for pad in torso.pads:
        text = obj_text(pad.vertices, pad.triangles)
        WriteText(folder / _face(pad.place), text)
    WriteText(folder / PADS, _pads_text(torso, contact))
    WriteText(folder / MODEL, sdf_text(torso, contact, density))


def _face(place: PadPlace) -> str:
    return f"{place.name}.obj"


def _pads_text(torso: FittedTorso, contact: TorsoContact) -> str:
    document = {
        "ring_heights": torso.ring_heights.tolist(),
        "contact": {
            "foundation_modulus": float(contact.foundation_modulus),
            "dissipation": float(contact.dissipation),
            "friction": float(contact.friction),
            "preload": float(contact.preload),
        },
        "pads": [
            {
                "name": pad.place.name,
                "ring": pad.place.ring,
                "side": "left" if pad.place.side > 0 else "right",
                "position": pad.place.p_TP.tolist(),
                "normal": pad.place.normal.tolist(),
                "across": pad.place.across.tolist(),
                "surface_normal": pad.surface_normal.tolist(),
                "size": [float(x) for x in pad.place.size],
                "effective_area": pad.effective_area,
                "face": _face(pad.place),
            }
            for pad in torso.pads
        ],
    }
    head = (
        "# Pads that fit the torso, in T: origin at the centre of ring 2 at\n"
        "# rest, x front, y left, z up. m, m^2; contact: N/m^3, s/m, 1, m.\n"
    )
    return head + yaml.safe_dump(document, sort_keys=False)


def LoadTorso(folder: str | Path) -> FittedTorso:
    """Reads what `WriteTorso` wrote.

    Raises:
        TorsoError: A file is missing or not as it was written.
    """
    folder = Path(folder)
    solid = LoadSolid(folder / SOLID)
    surface = LoadSurface(folder / SURFACE)
    path = folder / PADS
    document = LoadYaml(path, TorsoError)
    try:
        heights = np.array(document["ring_heights"], dtype=float)
        pads = [_load_pad(folder, entry) for entry in document["pads"]]
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        line = " ".join(str(error).split())
        raise TorsoError(f"{path}: no pads: {line}") from error
    return FittedTorso(
        solid, deepest(solid), pads, heights, calc_inertia(*surface)
    )


def _load_pad(folder: Path, entry: dict) -> Pad:
    place = PadPlace(
        int(entry["ring"]),
        1 if entry["side"] == "left" else -1,
        np.array(entry["position"], dtype=float),
        np.array(entry["normal"], dtype=float),
        np.array(entry["across"], dtype=float),
        tuple(entry["size"]),
    )
    return Pad(place, *LoadSurface(folder / entry["face"]))
