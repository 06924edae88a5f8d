"""Pads as points of their faces, and the forces of single pads."""

import functools
import unittest
from dataclasses import replace

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from brace_drake.core.errors import ScenarioError, TorsoError
from brace_drake.model.brace_station import MakeBraceStation
from brace_drake.scenario.brace import BenchScenario, BraceScenario, Contact
from brace_drake.scenario.check import CheckScenario
from brace_drake.torso.contact import map_linear_contact
from brace_drake.torso.faces import make_point_pad
from brace_drake.torso.fitted import fit_torso
from brace_drake.torso.pads import Pad
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
from tools.torso_contact import press_pads


@functools.cache
def pressed(points, elsewhere, under_pads):
    """Forces of pads, whole or of points, at three poses on a mesh."""
    torso = fit_torso(curved_loft(), RINGS, SIZE, elsewhere, under_pads)
    linear = Contact(pad_points=list(points))
    numbers = map_linear_contact(linear, torso.mean_effective_area)
    motions = [shift(0, 0, 0), shift(0.003, -0.002, 0), shift(0, 0, 0.003)]
    return press_pads(torso, replace(numbers, friction=0.0), motions)


class TestPoints(unittest.TestCase):
    def test_points_of_a_pad_press_like_its_whole_face(self):
        # Pressure is linear over the face, and Gauss's sums are exact then:
        # forces, also of a tilted pad, and the dissipation.
        torso, tilt = block_torso([flat_pad(1)]), 0.02
        R = RotationMatrix.MakeZRotation(tilt)
        # About the middle of the face, which sinks by 3 mm.
        p = [0.15 * np.sin(tilt), 0.147 - 0.15 * np.cos(tilt), 0.0]
        motions = [shift(0.0, -0.003, 0.0), RigidTransform(R, p)]
        whole = press_pads(torso, CONTACT, motions)
        expected = -CONTACT.foundation_modulus * SIZE[0] * SIZE[1] * 0.003
        self.assertAlmostEqual(whole[0, 0, 1] / expected, 1.0, places=6)
        for points in ((2, 2), (2, 4), (5, 3)):
            contact = replace(CONTACT, points=points)
            found = press_pads(torso, contact, motions)
            np.testing.assert_allclose(found, whole, rtol=2e-4, atol=1e-3)

    def test_a_pad_without_a_face_under_a_point_is_refused(self):
        pad = flat_pad(1)
        half = Pad(pad.place, pad.vertices, pad.triangles[:1])
        with self.assertRaisesRegex(TorsoError, "no face under one of its"):
            make_point_pad(half, 2, 2)

    def test_forces_of_whole_pads_converge_with_the_mesh(self):
        errors = self.errors_of((0, 0), [(0.03, None), (0.02, None)])
        self.assertLess(errors[1], 0.6 * errors[0])
        self.assertLess(errors[1], 0.01)
        self.assertLess(errors[0], 0.02)

    def test_forces_of_points_converge_to_those_of_whole_pads(self):
        errors = self.errors_of((2, 4), [(0.025, 0.012), (0.025, 0.005)])
        self.assertLess(errors[1], 0.6 * errors[0])
        self.assertLess(errors[1], 0.015)

    def errors_of(self, points, resolutions):
        """Of all forces, against those of whole pads on a fine mesh."""
        finest = pressed((0, 0), 0.01, None)
        size = np.linalg.norm(finest)
        return [
            np.linalg.norm(pressed(points, *each) - finest) / size
            for each in resolutions
        ]

    def test_points_that_are_no_grid_are_refused(self):
        for points in ([2, 0], [2], [11, 2], [-1, -1]):
            scenario = BenchScenario()
            scenario.contact.ring2.pad_points = points
            with self.assertRaisesRegex(ScenarioError, "pad_points.*1 to 10"):
                CheckScenario(scenario)


class TestPadForces(unittest.TestCase):
    def test_each_pad_presses_as_it_does_alone_and_all_as_the_ring_reads(self):
        torso = fit_torso(curved_loft(), RINGS, SIZE, 0.03)
        station, simulator, alone = press_brace(torso, log_pads=True)
        context = simulator.get_context()
        ring = station.diagram.GetOutputPort("force").Eval(context)
        log = station.pad_sink.FindLog(context)
        self.assertEqual(log.data().shape[0], 18)
        pads = log.data()[:, 0].reshape(3, 2, 3)
        # The plant solves the step that it begins there.
        np.testing.assert_allclose(pads, alone, rtol=5e-4, atol=1e-4)
        self.assertGreater(np.abs(alone).max(), 5.0)
        # What the rings have moved in a millisecond, and the converter.
        np.testing.assert_allclose(ring, pads.sum(axis=1).ravel(), atol=0.05)

    def test_no_pads_are_logged_where_the_plant_resolves_no_contact(self):
        station = MakeBraceStation(BraceScenario(), log_pads=True)
        self.assertIsNone(station.pad_sink)
