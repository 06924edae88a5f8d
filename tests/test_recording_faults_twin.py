"""Runs of another subject, by quadratics and twins whose answer is known."""

import unittest
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from brace_drake.devices.device import MakeDevice
from brace_drake.effects.registry import find_effect
from brace_drake.recording import LoadCampaign
from brace_drake.recording.recording import Run
from brace_drake.recording_faults.against_twin import judge_campaign
from brace_drake.recording_faults.against_twin.readings import Reading
from brace_drake.recording_faults.against_twin.sensors import Bars, named
from brace_drake.recording_faults.against_twin.subjects import divide
from tests.shared_data import EXAMPLE


def fit_of(z, seed, rows=400):
    """A run's fit that ends at z, noise alone left."""
    noise = np.random.default_rng(seed)
    solution = SimpleNamespace(
        jacobian=30.0 * noise.standard_normal((rows, len(z))),
        residual=noise.standard_normal(rows),
    )
    evaluator = SimpleNamespace(count=rows)
    scaled = np.array(z, dtype=float)
    return SimpleNamespace(
        solution=solution, evaluator=evaluator, scaled=scaled, level=1.0
    )


class TestOtherSubjects(unittest.TestCase):
    def test_runs_of_another_subject_are_divided_from_the_rest(self):
        one, two = [1.0, 1.0, 1.0], [1.2, 0.9, 1.0]
        subjects = [one, two, one, one, two]
        fits = [fit_of(z, i) for i, z in enumerate(subjects)]
        found = divide(fits)
        self.assertEqual(found.others, (1, 4))
        self.assertGreater(found.one, 5.0)
        self.assertLess(abs(found.two), 0.2)
        np.testing.assert_allclose(found.first, one, atol=1e-9)
        np.testing.assert_allclose(found.second, two, atol=1e-9)

    def test_one_subject_gains_little_by_two(self):
        noise = np.random.default_rng(9)
        fits = [
            fit_of(1.0 + 1e-3 * noise.standard_normal(3), i) for i in range(5)
        ]
        found = divide(fits)
        self.assertLess(found.one - found.two, 0.1)

    def test_runs_that_show_nothing_of_the_subject_are_divided_too(self):
        fits = [fit_of([1.0, 2.0], i) for i in range(3)]
        for fit in fits[:2]:
            fit.solution.jacobian *= 0.0
        found = divide(fits)
        self.assertLess(found.one - found.two, 1e-9)

    def test_a_single_run_is_not_divided(self):
        self.assertIsNone(divide([fit_of([1.0], 0)]))


class TestValidationRuns(unittest.TestCase):
    def judged(self, factor, *files):
        """Faults of a twin's campaign in which runs, of the files or of the
        validation, have another posture by a factor.
        """
        campaign = LoadCampaign(EXAMPLE)
        if files:
            fit = campaign.split("fit")
            campaign = replace(campaign, runs=tuple(fit))
        device = MakeDevice(campaign)
        twin = device.twin
        subject = np.array([p.nominal for p in twin.subject])
        names = [p.name for p in twin.subject]
        other = subject.copy()
        other[names.index("posture_stiffness_y_N_m")] *= factor
        runs = []
        for i, run in enumerate(campaign.runs):
            is_other = run.split != "fit" or run.file in files
            values = other if is_other else subject
            rng = np.random.default_rng([3, i])
            columns = twin.simulate(twin.motion(run), values, (), rng).T
            made = dict(zip(twin.channels, columns, strict=True))
            runs.append(replace(run, channels={**run.channels, **made}))
        found, misfit = judge_campaign(
            replace(campaign, runs=tuple(runs)), device, jobs=2
        )
        if not files:
            self.assertLess(misfit, 0.05)
        return found

    def test_one_subject_in_all_runs_is_no_fault(self):
        self.assertEqual(self.judged(1.0), [])

    def test_another_subject_in_the_validation_run_is_named(self):
        (found,) = self.judged(1.4)
        self.assertEqual(found.fault.name, "other_subject")
        self.assertEqual(found.runs, ("validation_push.csv",))
        device = MakeDevice(LoadCampaign(EXAMPLE))
        nominal = {p.name: p.nominal for p in device.twin.subject}
        name = "posture_stiffness_y_N_m"
        ratio = found.parameters[name] / nominal[name]
        self.assertAlmostEqual(ratio, 1.4, delta=0.1)

    def test_two_subjects_in_the_fit_runs_are_named(self):
        (found,) = self.judged(1.4, "stairs.csv")
        self.assertEqual(found.fault.name, "other_subject")
        self.assertEqual(found.runs, ("stairs.csv",))
        self.assertTrue(found.is_certain)


def reading_of(file, late, seed, sigma=5e-5):
    """A marker that is late by so many samples, beside the twin's."""
    time = np.arange(800) / 200.0
    y = 0.003 * np.sin(2.0 * np.pi * 0.5 * time)
    noise = sigma * np.random.default_rng(seed).standard_normal(len(y))
    channels = {"time_s": time, "torso_y_m": np.roll(y, late) + noise}
    prepared = SimpleNamespace(
        run=Run(file, True, "push", None, "fit", channels),
        used=np.array([True]),
        weights=np.full((len(y), 1), 1.0 / sigma),
        floor=SimpleNamespace(
            rms=np.array([sigma]), density=np.array([[sigma**2]])
        ),
    )
    return Reading(prepared, y[:, None], ("torso_y_m",))


def force_of(small, leak, scale, sigma=0.02):
    """A force of the twin's noise, with what leaks into it, as recorded."""
    time = np.arange(800) / 200.0
    sine = np.sin(2.0 * np.pi * 0.5 * time)
    noise = sigma * np.random.default_rng(1).standard_normal(len(time))
    name = "ring2_force_x_N"
    read = scale * ((small + leak) * sine + noise)
    prepared = SimpleNamespace(
        run=Run("push.csv", True, "push", None, "fit",
                {"time_s": time, name: read}),
        used=np.array([True]),
        weights=np.full((len(time), 1), 1.0 / sigma),
        floor=SimpleNamespace(
            rms=np.array([sigma]), density=np.array([[sigma**2]])
        ),
    )  # fmt: skip
    return Reading(prepared, small * sine[:, None], (name,))


class TestScaledReadings(unittest.TestCase):
    def named(self, *force):
        reading = force_of(*force)
        bars = Bars(10.0, 3.0, 0.02)
        return list(named([reading], reading.names, bars, 1))

    def test_a_reading_in_another_unit_is_named_with_its_scale(self):
        (found,) = self.named(0.3, 0.0, 1000.0)
        self.assertEqual(found.fault.name, "wrong_scale")
        self.assertAlmostEqual(found.parameters["scale"], 1000.0, delta=20.0)

    def test_what_leaks_in_beside_the_usual_noise_is_no_other_unit(self):
        self.assertEqual(self.named(1e-3, 0.3, 1.0), [])


class TestFewRuns(unittest.TestCase):
    def judged(self, file, edit, uses=()):
        """Faults of a twin's campaign, the marker of one of its runs edited
        along the push, or that of all in all axes.
        """
        campaign = LoadCampaign(EXAMPLE)
        device = MakeDevice(campaign)
        twin, runs = device.twin, []
        subject = np.array([p.nominal for p in twin.subject])
        for i, run in enumerate(campaign.runs):
            rng = np.random.default_rng([5, i])
            columns = twin.simulate(twin.motion(run), subject, uses, rng).T
            made = dict(zip(twin.channels, columns, strict=True))
            if file is None or run.file == file:
                for name in ("torso_x_m", "torso_y_m", "torso_z_m"):
                    if file is None or name == "torso_y_m":
                        made[name] = edit(made[name])
            runs.append(replace(run, channels={**run.channels, **made}))
        found, _ = judge_campaign(
            replace(campaign, runs=tuple(runs)), device, jobs=2
        )
        return found

    def test_a_marker_that_is_late_in_one_run_is_named_with_its_delay(self):
        (found,) = self.judged("stairs.csv", lambda y: np.roll(y, 10))
        self.assertEqual(found.fault.name, "skewed_channel")
        self.assertEqual(found.runs, ("stairs.csv",))
        # Delays are tried at some sizes alone.
        self.assertAlmostEqual(found.parameters["delay_s"], 0.05, delta=0.016)

    def test_a_marker_that_is_late_in_all_runs_is_named_with_its_delay(self):
        (found,) = self.judged(None, lambda y: np.roll(y, 4))
        self.assertEqual(found.fault.name, "skewed_channel")
        self.assertTrue(found.of_all)
        self.assertAlmostEqual(found.parameters["delay_s"], 0.02, delta=0.0051)

    def test_a_marker_that_fits_nothing_else_in_one_run_is_told(self):
        def swing(y):
            time = np.arange(len(y)) / 200.0
            return y + 3e-4 * np.sin(2.0 * np.pi * 1.3 * time)

        (found,) = self.judged("push.csv", swing)
        self.assertEqual(found.fault.name, "contradiction")
        self.assertEqual(found.runs, ("push.csv",))
        self.assertEqual(found.channels, ("torso_y_m",))

    def test_a_marker_that_was_moved_before_one_run_is_named_with_its_way(self):
        (found,) = self.judged("push.csv", lambda y: y + 3e-4)
        self.assertEqual(found.fault.name, "moved_zero")
        self.assertEqual(found.runs, ("push.csv",))
        self.assertAlmostEqual(found.parameters["offset"], 3e-4, delta=3e-5)

    def test_several_runs_are_named_by_file_where_others_are_sound(self):
        late = "a.csv", "b.csv"
        readings = [reading_of(file, 8, seed) for seed, file in enumerate(late)]
        bars, names = Bars(4.0, 1.5, 0.0), ("torso_y_m",)
        for count, is_all in ((5, False), (2, True)):
            (found,) = named(readings, names, bars, count)
            self.assertEqual(found.fault.name, "skewed_channel")
            self.assertEqual((found.runs, found.of_all), (late, is_all))

    def test_what_a_machine_does_in_one_run_is_no_fault(self):
        card = find_effect("force_drift")
        uses = [(card, np.array([0.01]))]
        self.assertEqual(self.judged("", None, uses), [])


if __name__ == "__main__":
    unittest.main()
