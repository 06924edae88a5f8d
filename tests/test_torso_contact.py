"""Hydroelastic pads on the torso in Drake against elastic foundations."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    InMemoryMesh,
    Mesh,
    ProximityProperties,
)
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from brace_drake.core.errors import TorsoError
from brace_drake.scenario.brace import BraceScenario, Contact
from brace_drake.torso.contact import (
    AddTorsoContact,
    MakeTorsoGeometry,
    check_volume,
    map_linear_contact,
)
from brace_drake.torso.fitted import fit_torso
from brace_drake.torso.folder import LoadTorso, WriteTorso
from brace_drake.torso.measures import (
    Curve,
    TorsoMeasures,
    make_parametric_loft,
)
from brace_drake.torso.meshes import obj_text
from tests.torso_blocks import (
    CONTACT,
    RINGS,
    SIZE,
    block_torso,
    curved_loft,
    flat_pad,
    press_brace,
    shift,
)
from tools.torso_contact import MakeRingsAndTorso, press_pads, read_forces


class TestFoundation(unittest.TestCase):
    def test_a_block_is_an_elastic_foundation(self):
        torso = block_torso([flat_pad(1), flat_pad(-1)])
        area = SIZE[0] * SIZE[1]
        depths = np.array([0.0005, 0.001, 0.002, 0.005, 0.01])
        motions = [shift(0.0, -d, 0.0) for d in depths]
        forces = press_pads(torso, CONTACT, motions)
        expected = CONTACT.foundation_modulus * area * depths
        np.testing.assert_allclose(forces[:, 0, 1], -expected, rtol=1e-6)
        np.testing.assert_allclose(forces[:, 0, [0, 2]], 0.0, atol=1e-6)
        # The other pad has come off.
        np.testing.assert_allclose(forces[:, 1], 0.0, atol=1e-9)

    def test_a_tilted_pad_presses_like_a_tilted_foundation(self):
        # Turned by a about z, a wide pad sinks by d + a x: the mean is d
        # while it touches all over, and its moment does not change the force.
        torso = block_torso([flat_pad(1)])
        d, a = 0.003, 0.02
        turn = RigidTransform([0.0, -d, 0.0])
        turned = RigidTransform(
            np.array(
                [
                    [np.cos(a), -np.sin(a), 0.0, 0.0],
                    [np.sin(a), np.cos(a), 0.0, -d - 0.15 * (np.cos(a) - 1)],
                    [0.0, 0.0, 1.0, 0.0],
                    [0.0, 0.0, 0.0, 1.0],
                ]
            )
        )
        straight, tilted = press_pads(torso, CONTACT, [turn, turned])[:, 0]
        self.assertAlmostEqual(tilted[1] / straight[1], np.cos(a), delta=1e-3)
        # Pressure acts along the pad's own normal.
        self.assertAlmostEqual(tilted[0] / tilted[1], -np.tan(a), delta=1e-3)

    def test_a_fitted_pad_on_a_cylinder_meets_the_closed_form(self):
        radius = 0.12
        measures = TorsoMeasures(
            np.array([-0.2, 0.2]), np.full(2, 0.24), np.full(2, 0.24), 2.0
        )
        loft = make_parametric_loft(measures)
        torso = fit_torso(loft, RINGS, SIZE, 0.02)
        # A point of the face at angle α, moved by d along the middle's
        # normal, is R - |p| deep; the pressure acts along its own normal.
        alpha = np.linspace(-1, 1, 2001) * np.arcsin(0.5 * SIZE[0] / radius)
        for d in (0.001, 0.003, 0.006):
            y, x = radius * np.cos(alpha) - d, radius * np.sin(alpha)
            depth = radius - np.hypot(x, y)
            along = np.trapezoid(depth * np.cos(alpha), alpha) * radius
            expected = CONTACT.foundation_modulus * along * SIZE[1]
            forces = press_pads(torso, CONTACT, [shift(0, -d, 0)])[0]
            for force in forces[::2]:
                self.assertLess(abs(-force[1] / expected - 1.0), 0.02)

    def test_the_default_grid_gives_the_effective_areas_within_two_percent(
        self,
    ):
        curve = Curve(cobb_deg=40.0, apex=-0.02, axial_rotation_deg=-12.0)
        for own in (Curve(), curve):
            loft = make_parametric_loft(TorsoMeasures(curve=own))
            torso = fit_torso(loft, RINGS, SIZE)
            contact = map_linear_contact(Contact(), torso.mean_effective_area)
            forces = press_pads(torso, contact, [shift(0, 0, 0)])[0]
            for pad, force in zip(torso.pads, forces, strict=True):
                k = contact.foundation_modulus * pad.effective_area
                found = -force @ pad.place.normal / contact.preload
                self.assertLess(abs(found / k - 1.0), 0.02)
            mean = np.mean(np.linalg.norm(forces, axis=1)) / contact.preload
            self.assertLess(abs(mean / Contact().stiffness - 1.0), 0.08)

    def test_dissipation_gives_the_linear_damping_at_the_preload(self):
        torso = block_torso([flat_pad(1)])
        linear = Contact()
        contact = map_linear_contact(linear, SIZE[0] * SIZE[1])
        contact = replace(contact, friction=0.0)
        diagram, plant, geometries = MakeRingsAndTorso(torso, contact, 1e-5)
        context = diagram.CreateDefaultContext()
        own = plant.GetMyMutableContextFromRoot(context)
        names = {g: n for n, g in geometries.items()}
        forces = []
        for speed in (0.0, 0.01):
            v = plant.GetVelocities(own) * 0.0
            # Spatial velocities of torso and ring: the ring's along -y.
            v[6 + 4] = -speed
            plant.SetVelocities(own, v)
            forces.append(-read_forces(plant, own, names)["ring1_left"][1])
        self.assertAlmostEqual(forces[0], 6.4, delta=0.001)
        damping = (forces[1] - forces[0]) / 0.01
        self.assertAlmostEqual(damping / linear.damping, 1.0, delta=2e-3)


class TestPlant(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.loft = make_parametric_loft(TorsoMeasures())
        cls.torso = fit_torso(cls.loft, RINGS, SIZE, 0.03)
        cls.contact = map_linear_contact(
            Contact(), cls.torso.mean_effective_area
        )

    def test_rings_stay_where_their_pads_hold_them(self):
        # Left and right press alike: nothing moves, nothing creeps.
        diagram, plant, _ = MakeRingsAndTorso(
            self.torso, self.contact, 1e-3, 0.85, 40.0
        )
        simulator = Simulator(diagram)
        simulator.AdvanceTo(0.1)
        own = plant.GetMyContextFromRoot(simulator.get_context())
        for i, height in enumerate(RINGS, start=1):
            pose = plant.EvalBodyPoseInWorld(
                own, plant.GetBodyByName(f"ring{i}")
            )
            away = pose.translation() - [0.0, 0.0, height]
            self.assertLess(np.abs(away[:2]).max(), 5e-5)
            self.assertLess(abs(away[2]), 2e-4)

    def test_momentum_is_kept(self):
        diagram, plant, _ = MakeRingsAndTorso(
            self.torso, self.contact, 1e-3, 0.85, 40.0
        )
        context = diagram.CreateDefaultContext()
        own = plant.GetMyMutableContextFromRoot(context)
        v = plant.GetVelocities(own).copy()
        for i in (1, 2, 3):
            body = plant.GetBodyByName(f"ring{i}")
            v[body.floating_velocities_start_in_v() + 4] = 0.01 * i
        plant.SetVelocities(own, v)
        simulator = Simulator(diagram, context)
        simulator.AdvanceTo(0.05)
        after = plant.GetVelocities(own)
        total = 0.0
        for name, mass in (
            ("ring1", 0.85),
            ("ring2", 0.85),
            ("ring3", 0.85),
            ("torso", 40.0),
        ):
            start = plant.GetBodyByName(name).floating_velocities_start_in_v()
            total += mass * after[start + 4]
        self.assertAlmostEqual(total, 0.85 * 0.06, delta=1e-6)
        ring = plant.GetBodyByName("ring3").floating_velocities_start_in_v()
        self.assertLess(abs(after[ring + 4]), 0.02)

    def test_some_rings_only(self):
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 1e-3)
        inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
        bodies = [plant.AddRigidBody(n, inertia) for n in ("torso", "ring2")]
        found = AddTorsoContact(
            plant,
            scene_graph,
            bodies[0],
            {2: bodies[1]},
            self.torso,
            self.contact,
        )
        self.assertEqual(sorted(found), ["ring2_left", "ring2_right", "torso"])
        with self.assertRaisesRegex(TorsoError, "ring 7 has no pads.*1, 2, 3"):
            AddTorsoContact(
                plant,
                scene_graph,
                bodies[0],
                {7: bodies[1]},
                self.torso,
                self.contact,
            )

    def test_a_brace_reads_the_forces_of_the_pads_on_its_torso(self):
        torso = fit_torso(curved_loft(), RINGS, SIZE, 0.03)
        station, simulator, pads = press_brace(torso)
        context = simulator.get_context()
        found = station.diagram.GetOutputPort("force").Eval(context)
        expected = pads.sum(axis=1).ravel()
        # Left and right are unlike here: no zeros. Half a step of the
        # converter, and what the rings have moved in a millisecond.
        self.assertGreater(np.abs(expected).max(), 0.5)
        np.testing.assert_allclose(found, expected, atol=0.05)

    def test_rings_without_hydroelastic_contact_get_no_pads(self):
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 1e-3)
        inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
        for name in ("ring1", "ring2", "ring3", "torso"):
            plant.AddRigidBody(name, inertia)
        scenario, add = BraceScenario(), MakeTorsoGeometry(self.torso)
        add(plant, scene_graph, scenario)
        torso = plant.GetBodyByName("torso")
        self.assertEqual(plant.GetCollisionGeometriesForBody(torso), [])
        scenario.contact.ring1.model = "hydroelastic"
        scenario.contact.ring3.model = "hydroelastic"
        add(plant, scene_graph, scenario)
        for name, count in (("ring1", 2), ("ring2", 0), ("ring3", 2)):
            body = plant.GetBodyByName(name)
            own = plant.GetCollisionGeometriesForBody(body)
            self.assertEqual(len(own), count)

    def test_a_hull_in_place_of_the_solid_is_refused(self):
        solid = self.torso.solid
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 1e-3)
        body = plant.AddRigidBody(
            "torso", SpatialInertia.SolidSphereWithMass(1.0, 0.1)
        )
        properties = ProximityProperties()
        AddCompliantHydroelasticProperties(1.0, 1e5, properties)
        # A surface where tetrahedra are due: Drake takes its hull.
        text = obj_text(solid.vertices, solid.triangles)
        mesh = InMemoryMesh(mesh_file=MemoryFile(text, ".obj", "torso"))
        geometry = plant.RegisterCollisionGeometry(
            body, RigidTransform(), Mesh(mesh), "torso", properties
        )
        with self.assertRaisesRegex(TorsoError, "Drake holds.*allowed"):
            check_volume(scene_graph, geometry, solid)

    def test_a_folder_holds_the_torso_and_a_model_that_drake_parses(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            solid = self.torso.solid
            surface = solid.vertices, solid.triangles
            WriteTorso(folder, self.torso, surface, self.contact, 1000.0)
            read = LoadTorso(folder)
            builder = DiagramBuilder()
            plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 1e-3)
            Parser(plant).AddModels(str(folder / "torso.sdf"))
        plant.Finalize()
        body = plant.GetBodyByName("torso")
        (geometry,) = plant.GetCollisionGeometriesForBody(body)
        check_volume(scene_graph, geometry, solid)
        ours = self.torso.inertia
        theirs = body.CalcSpatialInertiaInBodyFrame(
            plant.CreateDefaultContext()
        )
        np.testing.assert_allclose(
            theirs.CopyToFullMatrix6(), ours.CopyToFullMatrix6(), atol=1e-9
        )
        np.testing.assert_allclose(
            read.solid.vertices, solid.vertices, atol=1e-8
        )
        np.testing.assert_array_equal(read.solid.tetrahedra, solid.tetrahedra)
        self.assertAlmostEqual(read.deepest, self.torso.deepest, places=8)
        for a, b in zip(read.pads, self.torso.pads, strict=True):
            self.assertEqual(a.place.name, b.place.name)
            self.assertAlmostEqual(a.effective_area, b.effective_area, places=8)

    def test_a_folder_without_a_torso_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaisesRegex(TorsoError, r"torso\.vtk"):
                LoadTorso(folder)


if __name__ == "__main__":
    unittest.main()
