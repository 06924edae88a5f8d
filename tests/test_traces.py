"""Traces of a diagnosis: what was not recorded, or tells nothing, is not
drawn.
"""

import unittest
from types import SimpleNamespace

import numpy as np

from brace_drake.document.traces import MakeTraces
from brace_drake.identification.gap import RunComparison
from brace_drake.recording.recording import Run

CHANNELS = ("ring2_force_y_N", "torso_y_m")
SAMPLES = 50


def traces_of(run, active=(True, True), trust=1.0):
    """Of a nominal twin that is by far most off in the second channel."""
    floor = SimpleNamespace(rms=np.ones(2), edges=None, density=None)
    prepared = SimpleNamespace(
        run=run, measured=trust * run.stack(CHANNELS), floor=floor
    )
    before = np.column_stack([np.full(SAMPLES, 2.0), np.full(SAMPLES, 10.0)])
    return MakeTraces(
        SimpleNamespace(
            validation_runs=[RunComparison(prepared, before, None)],
            fit_runs=[],
            law=None,
            nominal=SimpleNamespace(subject=None),
            device=SimpleNamespace(
                twin=SimpleNamespace(
                    channels=CHANNELS,
                    recorded=lambda run: run.has(CHANNELS),
                    written=lambda run: run.stack(CHANNELS),
                    active=lambda run: np.array(active),
                ),
                motion_signals=lambda prepared, subject: SimpleNamespace(
                    travel=None, travel_name=""
                ),
            ),
        )
    )


def run_with(**channels):
    time = 0.01 * np.arange(SAMPLES)
    return Run(
        file="push.csv",
        contact=True,
        motion="push",
        repeat_of=None,
        split="validation",
        channels={"time_s": time, **channels},
    )


class TestTraces(unittest.TestCase):
    def test_a_channel_that_was_not_recorded_is_no_measurement(self):
        force = np.ones(SAMPLES)
        found = traces_of(run_with(**{CHANNELS[0]: force}))
        self.assertTrue(np.isnan(found[0].measured[:, 1]).all())
        np.testing.assert_array_equal(found[0].measured[:, 0], force)
        self.assertEqual(found[0].worst_channel(), 0)

    def test_a_sample_that_does_not_count_is_drawn_as_it_was_read(self):
        force = np.linspace(1.0, 2.0, SAMPLES)
        (found,) = traces_of(run_with(**{CHANNELS[0]: force}), trust=0.5)
        np.testing.assert_array_equal(found.measured[:, 0], force)
        # The twin is as far off as it is where a sample counts half.
        error = found.measured[:, 0] - found.before[:, 0]
        np.testing.assert_allclose(error, 0.5 * force - 2.0)

    def test_a_channel_that_tells_nothing_in_a_run_is_not_shown(self):
        force, marker = np.ones(SAMPLES), 1e-4 * np.ones(SAMPLES)
        run = run_with(**dict(zip(CHANNELS, (force, marker), strict=True)))
        self.assertEqual(traces_of(run)[0].worst_channel(), 1)
        found = traces_of(run, active=(True, False))
        self.assertEqual(found[0].worst_channel(), 0)
        self.assertEqual(found[0].ranked_channels(), [0])


if __name__ == "__main__":
    unittest.main()
