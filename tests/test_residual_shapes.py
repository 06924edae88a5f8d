"""What a fit leaves is told by the motion that it goes with."""

import unittest
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from brace_drake.core.cosine_transform import to_frequency
from brace_drake.devices.device import MakeDevice
from brace_drake.effects.registry import find_effect
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import fit_effects
from brace_drake.identification.nominal_fit import fit_nominal
from brace_drake.identification.prepare import estimate_floors, prepare_runs
from brace_drake.isolation.residual_shapes import (
    SHAPES,
    describe_rest,
    motion_shapes,
)
from brace_drake.recording import LoadCampaign

_ROOT = Path(__file__).resolve().parent.parent
_EMPS = _ROOT.parent / "shared" / "real" / "emps"
RATE, SAMPLES = 100.0, 1201


class Run(SimpleNamespace):
    """A run of two channels, the second not recorded, in white noise."""

    def weigh(self, residual):
        return to_frequency(residual)[:, self.used].ravel()


class TestToy(unittest.TestCase):
    def setUp(self):
        self.generator = np.random.default_rng(5)
        time = np.arange(SAMPLES) / RATE
        self.position = 0.01 * np.sin(1.3 * time) + 2e-3 * np.sin(5.3 * time)
        self.shapes = motion_shapes(self.position, RATE)
        used = np.array([True, False])
        self.run = Run(
            used=used,
            run=SimpleNamespace(time_s=time),
            measured=np.zeros((SAMPLES, 2)),
            weights=np.ones((SAMPLES, 2)),
        )

    def left(self, series, known=("constant", "speed")):
        """Rows of a fit that can take what is known already."""

        def column(values):
            return self.run.weigh(np.column_stack([values, 0.0 * values]))

        residual = column(series)
        jacobian = np.column_stack([column(self.shapes[k]) for k in known])
        scale = np.linalg.norm(jacobian, axis=0)
        q, _ = np.linalg.qr(jacobian / scale)
        residual = residual - q @ (q.T @ residual)
        fit = SimpleNamespace(
            uses=(),
            subject=None,
            solution=SimpleNamespace(residual=residual, jacobian=jacobian),
        )
        evaluator = SimpleNamespace(
            ends=[len(residual)],
            prepared=[self.run],
            twin=SimpleNamespace(channels=("force_N", "other_N")),
            noise_level=lambda uses: 1.0,
        )
        motion = SimpleNamespace(position=self.position)
        return describe_rest(evaluator, fit, lambda *_: motion, RATE, 0)

    def noise(self):
        return self.generator.standard_normal(SAMPLES)

    def test_each_shape_is_told_from_the_others(self):
        for shape in SHAPES:
            if shape in ("constant", "speed"):
                continue
            series = self.shapes[shape] - np.mean(self.shapes[shape])
            series = 10.0 * series / np.std(series) + self.noise()
            with self.subTest(shape=shape):
                (row,) = self.left(series)
                self.assertEqual(row["channel"], "force_N")
                self.assertEqual(row["shape"], shape)
                self.assertGreater(row["takes"], 0.98)
                self.assertLessEqual(row["lower95"], row["takes"])
                self.assertGreaterEqual(row["upper95"], row["takes"])

    def test_noise_alone_leaves_nothing_to_tell(self):
        self.assertEqual(self.left(self.noise()), [])

    def test_what_goes_with_no_motion_is_not_given_a_shape(self):
        time = np.arange(SAMPLES) / RATE
        series = 5.0 * np.sin(2.0 * np.pi * 6.0 * time) + self.noise()
        (row,) = self.left(series)
        self.assertIsNone(row["shape"])
        self.assertLess(row["takes"], 0.1)
        # A sine of amplitude 5 in noise of 1: 1 + 25 / 2.
        self.assertAlmostEqual(row["normalised_rms"], np.sqrt(13.5), delta=0.1)

    def test_half_a_shape_takes_half(self):
        time = np.arange(SAMPLES) / RATE
        size = self.shapes["size of the speed"]
        size = np.sqrt(50.0) * (size - size.mean()) / size.std()
        series = size + 10.0 * np.sin(2.0 * np.pi * 6.0 * time) + self.noise()
        (row,) = self.left(series)
        self.assertEqual(row["shape"], "size of the speed")
        self.assertAlmostEqual(row["takes"], 0.5, delta=0.03)


@unittest.skipUnless(_EMPS.is_dir(), f"no recordings of EMPS in {_EMPS}")
class TestEmps(unittest.TestCase):
    """A real drive, whose viscous friction is not the same both ways."""

    def test_dry_friction_first_then_an_asymmetry_of_the_viscous(self):
        campaign = LoadCampaign(_EMPS)
        device = MakeDevice(campaign)
        twin = device.twin
        nominal = np.array([p.nominal for p in twin.subject])
        floors, _ = estimate_floors(twin, campaign, nominal, 0)
        runs = prepare_runs(
            twin, campaign.split("fit"), floors, campaign.rate_hz, 0
        )
        evaluator = Evaluator(twin, runs, 2)
        coulomb = find_effect("coulomb_friction")
        for fit, shape, least in (
            (fit_nominal(evaluator), "direction", 0.9),
            (
                fit_effects(evaluator, [coulomb], coulomb.starts()),
                "size of the speed",
                0.6,
            ),
        ):
            (row,) = describe_rest(
                evaluator, fit, device.motion_signals, campaign.rate_hz, 0
            )
            self.assertEqual(row["channel"], "force_command_N")
            self.assertEqual(row["shape"], shape)
            self.assertGreater(row["lower95"], least)


if __name__ == "__main__":
    unittest.main()
