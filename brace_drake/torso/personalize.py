"""From a scan or measures to a torso, its pads, and scenarios with them."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brace_drake.core.errors import TorsoError
from brace_drake.core.output import MakeFolder, WriteBytes
from brace_drake.scenario.brace import BraceScenario, Contact
from brace_drake.scenario.load import SaveScenario
from brace_drake.torso.contact import TorsoContact, map_linear_contact
from brace_drake.torso.fitted import (
    DENSITY,
    PAD_RESOLUTION,
    RESOLUTION,
    FittedTorso,
    fit_torso,
    loft_surface,
)
from brace_drake.torso.folder import WriteTorso, central_inertia
from brace_drake.torso.loft import Loft
from brace_drake.torso.measures import LoadMeasures, make_parametric_loft
from brace_drake.torso.picture import draw_torso
from brace_drake.torso.scan import LoadScan, ScanFrame
from brace_drake.torso.sections import cut_sections

# z in T of the moving rings at rest, at T11, T7 and T4, for a bench, which has
# one ring only [A: vertebral levels of a girl of 1.56 m; those of the brace].
RING_HEIGHTS = (-0.09, 0.0, 0.06)
PICTURE = "torso.png"
_MEASURES = (".yaml", ".yml")
_AS_IS = ScanFrame()


@dataclass(frozen=True)
class Personal:
    """A personal torso and what follows from it.

    Attributes:
        loft: Its surface, as sections.
        torso: Its solid, mass and pads.
        contact: Numbers of the hydroelastic contact.
        scenarios: By file name, with the torso's numbers put in.
    """

    loft: Loft
    torso: FittedTorso
    contact: TorsoContact
    scenarios: dict[str, BraceScenario]


def LoadSurfaceOf(path: str | Path, frame: ScanFrame = _AS_IS) -> Loft:
    """The surface of a scan or of measures.

    Raises:
        TorsoError: One line: the file, what was measured, what is allowed.
    """
    path = Path(path)
    if path.suffix.lower() in _MEASURES:
        if frame != _AS_IS:
            raise TorsoError(
                f"{path}: measures are in m and in T; allowed: no unit, origin"
                " or axes"
            )
        return make_parametric_loft(LoadMeasures(path))
    return cut_sections(*LoadScan(path, frame), str(path))


def personalize(
    loft: Loft,
    scenarios: Mapping[str, BraceScenario],
    resolution: float = RESOLUTION,
    pad_resolution: float = PAD_RESOLUTION,
) -> Personal:
    """Fits solid, pads and scenarios to a torso's surface.

    Args:
        loft: The surface in T.
        scenarios: By file name; they stay as they are. The first one's contact
            at ring 2 gives the size of the pads and the contact's numbers, and
            its rings' heights, where it has three, where the pads sit.
        resolution: Largest width of a facet, m.
        pad_resolution: The same under pads.

    Raises:
        TorsoError: The pads have no place on it, or the mesh is too coarse.
    """
    for name, value in (
        ("resolution", resolution),
        ("resolution under pads", pad_resolution),
    ):
        if not 0.001 <= value <= 0.1:
            raise TorsoError(f"{name} is {value:g} m; allowed: 0.001 to 0.1")
    first = next(iter(scenarios.values()))
    linear = ring_contacts(first)[2]
    heights = ring_heights(first)
    size = float(linear.pad_size[0]), float(linear.pad_size[2])
    torso = fit_torso(loft, heights, size, resolution, pad_resolution)
    contact = map_linear_contact(linear, torso.mean_effective_area)
    return Personal(
        loft,
        torso,
        contact,
        {name: put_torso(s, torso) for name, s in scenarios.items()},
    )


def ring_contacts(scenario: BraceScenario) -> dict[int, Contact]:
    """Contacts of a scenario by the number of their ring."""
    return {i: getattr(scenario.contact, f"ring{i}") for i in (1, 2, 3)}


def ring_heights(scenario: BraceScenario) -> np.ndarray:
    """z in T of the moving rings at rest (3,), m."""
    return scenario.ring_heights[1:] - scenario.ring_heights[2]


def put_torso(scenario: BraceScenario, torso: FittedTorso) -> BraceScenario:
    """A copy of a scenario with the torso's mass, inertia and widths.

    A scenario's torso has its centre of mass at To and principal axes along T:
    it takes the moments about the centre of mass and leaves out the products.
    A ring's pads are symmetric there: they take the mean of left and right.
    """
    scenario = copy.deepcopy(scenario)
    scenario.torso.mass = _rounded(torso.inertia.get_mass())
    moments = np.diag(central_inertia(torso))
    scenario.torso.inertia = np.array([_rounded(i) for i in moments])
    for ring, contact in ring_contacts(scenario).items():
        own = [p.place.p_TP[1] for p in torso.pads if p.place.ring == ring]
        contact.pad_offset = _rounded(np.mean(np.abs(own)))
    return scenario


def _rounded(value: float) -> float:
    """Six digits: more would be noise of the mesh."""
    return float(f"{value:.6g}")


def WritePersonal(out: Path, personal: Personal) -> None:
    """Writes all files of a personal torso into a folder, and only there.

    Raises:
        OutputError: It cannot be written.
    """
    picture = draw_torso(personal.torso)
    out = MakeFolder(Path(out))
    surface = loft_surface(thinned(personal.loft))
    WriteTorso(out, personal.torso, surface, personal.contact, DENSITY)
    for name, scenario in personal.scenarios.items():
        SaveScenario(scenario, out / name)
    WriteBytes(out / PICTURE, picture)


def thinned(loft: Loft) -> Loft:
    """Every second section and angle: dense enough to look at and to weigh."""
    return Loft(
        loft.heights[::2],
        loft.centres[::2],
        loft.angles[::2],
        loft.radii[::2, ::2],
    )
