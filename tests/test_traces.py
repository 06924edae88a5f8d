"""Traces of a diagnosis: what was not recorded is not drawn."""

import unittest
from types import SimpleNamespace

import numpy as np

from brace_drake.document.traces import MakeTraces
from brace_drake.identification.gap import RunComparison
from brace_drake.recording.recording import Run

CHANNELS = ("ring2_force_y_N", "torso_y_m")
SAMPLES = 50


class TestTraces(unittest.TestCase):
    def test_a_channel_that_was_not_recorded_is_no_measurement(self):
        force = np.ones(SAMPLES)
        time = 0.01 * np.arange(SAMPLES)
        run = Run(
            file="push.csv",
            contact=True,
            motion="push",
            repeat_of=None,
            split="validation",
            channels={"time_s": time, CHANNELS[0]: force},
        )
        floor = SimpleNamespace(rms=np.ones(2), edges=None, density=None)
        prepared = SimpleNamespace(
            run=run, measured=run.stack(CHANNELS), floor=floor
        )
        # A nominal twin that is by far most off where nothing was recorded.
        before = np.column_stack([force + 1.0, force + 9.0])
        found = MakeTraces(
            SimpleNamespace(
                validation_runs=[RunComparison(prepared, before, None)],
                fit_runs=[],
                law=None,
                nominal=SimpleNamespace(subject=None),
                device=SimpleNamespace(
                    twin=SimpleNamespace(
                        channels=CHANNELS,
                        recorded=lambda run: run.has(CHANNELS),
                    ),
                    motion_signals=lambda prepared, subject: SimpleNamespace(
                        travel=None, travel_name=""
                    ),
                ),
            )
        )
        self.assertTrue(np.isnan(found[0].measured[:, 1]).all())
        np.testing.assert_array_equal(found[0].measured[:, 0], force)
        self.assertEqual(found[0].worst_channel(), 0)


if __name__ == "__main__":
    unittest.main()
