"""From a scan or measures to a torso, its pads, and a scenario with them."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brace_drake.errors import TorsoError
from brace_drake.output import MakeFolder, WriteBytes
from brace_drake.scenario.bench import BenchScenario
from brace_drake.scenario.load import SaveScenario
from brace_drake.torso.contact import TorsoContact, map_linear_contact
from brace_drake.torso.fitted import (
    DENSITY,
    RESOLUTION,
    FittedTorso,
    fit_torso,
    loft_surface,
)
from brace_drake.torso.folder import WriteTorso, central_inertia
from brace_drake.torso.loft import Loft
from brace_drake.torso.measures import LoadMeasures
from brace_drake.torso.parametric import make_parametric_loft
from brace_drake.torso.picture import draw_torso
from brace_drake.torso.scan import LoadScan, ScanFrame
from brace_drake.torso.sections import cut_sections

# z in T of the moving rings at rest, at T11, T7 and T4 [A: vertebral levels of
# a girl of 1.56 m; the data sheet's ring heights less that of ring 2].
RING_HEIGHTS = (-0.09, 0.0, 0.06)
PICTURE, SCENARIO = "torso.png", "personal.scenario.yaml"
_MEASURES = (".yaml", ".yml")


@dataclass(frozen=True)
class Personal:
    """A personal torso and what follows from it.

    Attributes:
        loft: Its surface, as sections.
        torso: Its solid, mass and pads.
        contact: Numbers of the hydroelastic contact.
        scenario: With the torso's numbers put in.
    """

    loft: Loft
    torso: FittedTorso
    contact: TorsoContact
    scenario: BenchScenario


def LoadSurfaceOf(path: str | Path, frame: ScanFrame = ScanFrame()) -> Loft:
    """The surface of a scan or of measures.

    Raises:
        TorsoError: One line: the file, what was measured, what is allowed.
    """
    path = Path(path)
    if path.suffix.lower() in _MEASURES:
        if frame != ScanFrame():
            raise TorsoError(
                f"{path}: measures are in m and in T; allowed: no unit, origin"
                " or axes"
            )
        return make_parametric_loft(LoadMeasures(path))
    return cut_sections(*LoadScan(path, frame), str(path))


def personalize(
    loft: Loft, scenario: BenchScenario, resolution: float = RESOLUTION
) -> Personal:
    """Fits solid, pads and scenario to a torso's surface.

    Args:
        scenario: Of the nominal bench; it stays as it is.
        resolution: Largest width of a facet, m.

    Raises:
        TorsoError: The pads have no place on it, or the mesh is too coarse.
    """
    size = (
        float(scenario.contact.pad_size[0]),
        float(scenario.contact.pad_size[2]),
    )
    torso = fit_torso(loft, RING_HEIGHTS, size, resolution)
    contact = map_linear_contact(scenario.contact, torso.mean_effective_area)
    return Personal(loft, torso, contact, put_torso(scenario, torso))


def put_torso(scenario: BenchScenario, torso: FittedTorso) -> BenchScenario:
    """A copy of the bench with the torso's mass, inertia and width.

    The bench's torso has its centre of mass at To and principal axes along T:
    it takes the moments about the centre of mass and leaves out the products.
    Its pads are symmetric: they take the mean of left and right at ring 2.
    """
    scenario = copy.deepcopy(scenario)
    scenario.torso.mass = _rounded(torso.inertia.get_mass())
    moments = np.diag(central_inertia(torso))
    scenario.torso.inertia = np.array([_rounded(i) for i in moments])
    widths = [abs(p.place.p_TP[1]) for p in torso.pads if p.place.ring == 2]
    scenario.contact.pad_offset = _rounded(np.mean(widths))
    return scenario


def _rounded(value: float) -> float:
    """Six digits: more would be noise of the mesh."""
    return float(f"{value:.6g}")


def WritePersonal(out: Path, personal: Personal) -> list[Path]:
    """Writes all files of a personal torso into a folder, and only there.

    Raises:
        OutputError: It cannot be written.
    """
    picture = draw_torso(personal.torso)
    out = MakeFolder(Path(out))
    WriteTorso(
        out,
        personal.torso,
        loft_surface(thinned(personal.loft)),
        personal.contact,
        DENSITY,
    )
    SaveScenario(personal.scenario, out / SCENARIO)
    WriteBytes(out / PICTURE, picture)
    return sorted(out / name for name in (PICTURE, SCENARIO))


def thinned(loft: Loft) -> Loft:
    """Every second section and angle: dense enough to look at and to weigh."""
    return Loft(
        loft.heights[::2],
        loft.centres[::2],
        loft.angles[::2],
        loft.radii[::2, ::2],
    )
