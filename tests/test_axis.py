"""One axis: closed forms, its units, known causes, real machines."""

import tempfile
import unittest
from dataclasses import replace
from pathlib import Path

import numpy as np

from brace_drake.core.errors import CampaignError
from brace_drake.devices.axis.twin import simulate_axis
from brace_drake.devices.device import MakeDevice
from brace_drake.diagnosis import diagnose
from brace_drake.effects.registry import find_effect
from brace_drake.recording import LoadCampaign, WriteCampaign
from brace_drake.recording.importing.mapped import ImportCampaign
from brace_drake.recording_faults import check_recording
from brace_drake.scenario.axis.units import AxisUnits
from brace_drake.scenario.effects import describe_use
from brace_drake.scenario.load import LoadScenario, SaveScenario
from tests.axis_recordings import RATE, dry_friction, make_campaign, stroke
from tests.shared_data import SHARED

MASS, VISCOUS, STIFFNESS, OFFSET = 3.0, 40.0, 900.0, -2.0
MAPS = Path(__file__).resolve().parent / "data" / "machines"


def linear(path, inputs=None):
    """Force of mass, damper, spring and offset (N,)."""
    law = np.array([STIFFNESS, VISCOUS, MASS])
    return path @ law + OFFSET


def replayed(name, path, t, *values):
    """What an effect adds to the force on a path (N,)."""
    uses = [(find_effect(name), np.array(values, dtype=float))]
    none = np.zeros((len(t), 0))
    return simulate_axis(np.zeros(4), t, path, none, 1e-3, uses)


def estimates(diagnosis) -> dict[str, float]:
    """Values of the winner's parameters by name."""
    fit = diagnosis.verdict.winner
    return {
        name: value
        for effect, values in fit.uses
        for name, value in zip(effect.parameter_names, values, strict=True)
    }


class TestLaws(unittest.TestCase):
    def test_the_force_is_that_of_mass_damper_spring_and_offset(self):
        t, path = stroke(0.05, 0.3)
        law = np.array([MASS, VISCOUS, STIFFNESS, OFFSET])
        found = simulate_axis(law, t, path, np.zeros((len(t), 0)), 1e-2)
        np.testing.assert_allclose(found, linear(path), atol=1e-12)

    def test_extra_inputs_add_their_gains(self):
        t, path = stroke(0.05, 0.3)
        inputs = np.column_stack([np.sin(t), np.cos(t)])
        law = np.array([MASS, VISCOUS, STIFFNESS, OFFSET, 3.0, -5.0])
        found = simulate_axis(law, t, path, inputs, 1e-2)
        wanted = linear(path) + inputs @ np.array([3.0, -5.0])
        np.testing.assert_allclose(found, wanted, atol=1e-12)

    def test_friction_behind_play_slides_where_it_cannot_hold(self):
        t, path = stroke(0.01, 0.3)
        level, stiffness, play = 5.0, 8e3, 2e-3
        found = replayed(
            "friction_behind_play", path, t, level, stiffness, play
        )
        wanted = dry_friction(path[:, 0], level, stiffness, play)
        # Both are exact on what they are given; one has ten times the points.
        np.testing.assert_allclose(found, wanted, atol=0.02 * level)
        self.assertAlmostEqual(np.abs(found).max(), level)

    def test_gradual_friction_comes_near_its_level_exponentially(self):
        # Along a straight way: F_c (1 - exp(-y / w)); turned round there,
        # (F_1 + F_c) exp(-(y_1 - y) / w) - F_c.
        level, way = 5.0, 2e-3
        there = np.linspace(0.0, 3e-3, 200)
        y = np.concatenate([there, there[-2::-1]])
        t, still = np.arange(len(y)) / RATE, np.zeros(len(y))
        path = np.column_stack([y, still, still])
        rising = level * (1.0 - np.exp(-there / way))
        back = np.exp((there[-2::-1] - there[-1]) / way)
        wanted = np.append(rising, (rising[-1] + level) * back - level)
        for name, values in (
            ("coulomb_friction (gradual)", (level, way)),
            ("load_friction (gradual)", (level, 0.0, way, 0.0)),
        ):
            with self.subTest(effect=name):
                found = replayed(name, path, t, *values)
                # The force is read at the end of each way, of four parts.
                np.testing.assert_allclose(found, wanted, atol=0.01 * level)

    def test_a_loop_of_dry_friction_takes_four_levels_for_each_way(self):
        # Four times the level for each turning point less what play and
        # elasticity leave out.
        t, path = stroke(0.01, 0.3)
        level, stiffness, play = 5.0, 8e3, 2e-3
        found = replayed(
            "friction_behind_play", path, t, level, stiffness, play
        )
        work = np.trapezoid(found, path[:, 0])
        wanted = dry_friction(path[:, 0], level, stiffness, play)
        self.assertAlmostEqual(
            work / np.trapezoid(wanted, path[:, 0]), 1.0, delta=0.02
        )
        self.assertGreater(work, 0.0)

    def test_cogging_repeats_with_its_pitch(self):
        y = np.linspace(0.0, 0.01, 500)
        t, still = np.arange(500) / RATE, np.zeros(500)
        path = np.column_stack([y, still, still])
        found = replayed("cogging", path, t, 0.3, -0.4, 0.002)
        wanted = 0.3 * np.cos(2e3 * np.pi * y / 2.0)
        wanted -= 0.4 * np.sin(2e3 * np.pi * y / 2.0)
        np.testing.assert_allclose(found, wanted, atol=1e-10)

    def test_a_relaxing_spring_forgets_a_step(self):
        t = np.arange(400) / RATE
        y = np.where(t > 0.0, 0.004, 0.0)
        path = np.column_stack([y, 0.0 * y, 0.0 * y])
        arm, tau = 500.0, 0.7
        found = replayed("relaxing_spring", path, t, arm, tau)
        # From the second sample on, which has seen one period of the ramp.
        ratio = found[5:-1] / found[4:-2]
        np.testing.assert_allclose(ratio, np.exp(-1.0 / RATE / tau), rtol=1e-9)
        self.assertAlmostEqual(found[1], arm * 0.004, delta=0.02)


class TestUnits(unittest.TestCase):
    def test_units_scale_by_their_powers(self):
        units = AxisUnits(length=2.0, force=30.0)
        for unit, scale in (
            ("N", 30.0),
            ("m", 2.0),
            ("N s/m", 15.0),
            ("N/m^3", 3.75),
            ("m/s", 2.0),
            ("s", 1.0),
            ("1", 1.0),
            ("kg", 15.0),
        ):
            self.assertAlmostEqual(units.scale(unit), scale, msg=unit)

    def test_a_rotary_axis_has_angles_and_torques(self):
        units = AxisUnits(is_rotary=True)
        self.assertEqual(units.unit("N s/m"), "N m s/rad")
        self.assertEqual(units.unit("kg"), "kg m^2")
        self.assertEqual(
            units.name("viscous_N_s_m", "N s/m"), "viscous_N_m_s_rad"
        )
        self.assertEqual(units.name("backlash_m", "m"), "backlash_rad")

    def test_a_machine_a_thousand_times_as_strong_has_the_same_verdict(self):
        def force(path, inputs, size):
            y = path[:, 0]
            return size * (linear(path) + dry_friction(y, 6.0, 1e4, 0.003))

        for size in (1.0, 1000.0):
            with self.subTest(size=size):
                campaign = make_campaign(
                    lambda p, i, s=size: force(p, i, s), 0.05 * size
                )
                found = diagnose(campaign, jobs=1)
                self.assertEqual(
                    found.verdict.effects, ("friction_behind_play",)
                )
                values = estimates(found)
                self.assertAlmostEqual(
                    values["coulomb_N"] / size, 6.0, delta=0.1
                )
                self.assertAlmostEqual(values["backlash_m"], 0.003, delta=1e-4)


class TestAnswers(unittest.TestCase):
    def test_a_linear_machine_has_no_gap_and_its_numbers(self):
        found = diagnose(make_campaign(linear), jobs=1)
        self.assertFalse(found.verdict.gap)
        named = {p.name: p for p in found.estimates.parameters}
        for name, value in (
            ("mass_kg", MASS),
            ("viscous_N_s_m", VISCOUS),
            ("stiffness_N_m", STIFFNESS),
            ("offset_N", OFFSET),
        ):
            row = named[name]
            with self.subTest(name=name):
                self.assertLess(
                    abs(row.value - value), 5.0 * row.standard_error
                )

    def test_each_law_of_one_joint_is_named(self):
        def with_load(path, inputs):
            level = 2.0 + 1.5 * inputs["input_pressure_bar"][0]
            return (
                linear(path)
                + 8.0 * inputs["input_pressure_bar"]
                + (dry_friction(path[:, 0], level, 2e4, 0.0))
            )

        def warm(path, inputs):
            less = -0.8 * (inputs["input_temperature_degC"] - 30.0)
            return linear(path) + less * path[:, 1]

        own = {
            "load_friction": ("input_pressure_bar", (1.0, 3.0, 6.0, 4.5)),
            "load_viscous": (
                "input_temperature_degC",
                (22.0, 31.0, 44.0, 38.0),
            ),
        }
        cases = {
            "cogging": lambda p, i: (
                linear(p) + 1.2 * np.sin(2.0 * np.pi * p[:, 0] / 0.0071 + 0.4)
            ),
            "stiffening": lambda p, i: linear(p) + 4e5 * p[:, 0] ** 3,
            "asymmetric_viscous": lambda p, i: (
                linear(p) + 30.0 * np.abs(p[:, 1])
            ),
            "load_friction": with_load,
            "load_viscous": warm,
        }
        for name, force in cases.items():
            with self.subTest(effect=name):
                inputs = None
                if name in own:

                    def inputs(i, name=name):
                        column, values = own[name]
                        return {column: values[i]}

                found = diagnose(make_campaign(force, inputs=inputs), jobs=1)
                self.assertEqual(found.verdict.effects, (name,))
                if name == "load_friction":
                    values = estimates(found)
                    self.assertAlmostEqual(
                        values["growth_N_bar"], 1.5, delta=0.05
                    )
                if name == "load_viscous":
                    values = estimates(found)
                    self.assertAlmostEqual(
                        values["damping_N_s_m_degC"], -0.8, delta=0.02
                    )
                if name == "cogging":
                    pitch = estimates(found)["pitch_m"]
                    self.assertAlmostEqual(pitch, 0.0071, delta=2e-5)

    def test_friction_that_builds_up_bit_by_bit_has_its_numbers(self):
        def dahl(y, level, way):
            force, at, out = 0.0, y[0], np.zeros(len(y))
            for i, position in enumerate(y):
                step, at = position - at, position
                end = np.copysign(level, step)
                force = end + (force - end) * np.exp(-abs(step) / way)
                out[i] = force
            return out

        def force(path, inputs):
            return linear(path) + dahl(path[:, 0], 6.0, 3e-3)

        found = diagnose(make_campaign(force), jobs=1)
        self.assertEqual(found.verdict.effects, ("coulomb_friction",))
        values = estimates(found)
        self.assertAlmostEqual(values["coulomb_N"], 6.0, delta=0.1)
        self.assertAlmostEqual(values["presliding_m"], 3e-3, delta=1e-4)
        self.assertGreater(found.shrinkage["closed"], 0.97)

    def test_a_small_mass_is_fitted_beside_friction_that_hides_it(self):
        def force(path, inputs):
            rub = dry_friction(path[:, 0], 16.0, 5e4, 0.0)
            return path @ np.array([0.0, 90.0, 3.0]) + rub

        found = diagnose(make_campaign(force), jobs=1)
        self.assertEqual(found.verdict.effects, ("coulomb_friction",))
        names = [p.name for p in found.evaluator.twin.subject]
        values = dict(zip(names, found.verdict.winner.subject, strict=True))
        self.assertAlmostEqual(values["mass_kg"], 3.0, delta=0.1)
        self.assertAlmostEqual(values["viscous_N_s_m"], 90.0, delta=2.0)

    def test_a_rotary_machine_answers_in_its_units(self):
        found = diagnose(
            make_campaign(
                lambda p, i: linear(p) + dry_friction(p[:, 0], 6.0, 1e4, 3e-3),
                kind="rotary",
            ),
            jobs=1,
        )
        self.assertEqual(found.verdict.effects, ("friction_behind_play",))
        self.assertAlmostEqual(
            estimates(found)["backlash_rad"], 3e-3, delta=1e-4
        )

    def test_a_payload_of_an_arm_shows_as_weight_and_as_mass(self):
        def force(path, inputs):
            angle = 40.0 * path[:, 0]
            weight = 4.0 * np.sin(angle) + 1.5 * np.cos(angle)
            return 80.0 * path[:, 2] + 120.0 * path[:, 1] + weight

        # Strokes of two radians; the arm was stated with half of its mass.
        campaign = make_campaign(force, kind="rotary", nominal={"mass_kg": 1.0})
        runs = [
            replace(
                r,
                channels=r.channels
                | {"position_rad": 40.0 * r.channels["position_rad"]},
            )
            for r in campaign.runs
        ]
        found = diagnose(replace(campaign, runs=tuple(runs)), jobs=1)
        self.assertEqual(found.verdict.effects, ("unbalanced_weight",))
        values = estimates(found)
        self.assertAlmostEqual(values["sine_N_m"], 4.0, delta=0.05)
        self.assertAlmostEqual(values["cosine_N_m"], 1.5, delta=0.1)

    def test_a_number_that_is_stated_as_none_is_not_fitted(self):
        campaign = make_campaign(linear, nominal={"viscous_N_s_m": 0.0})
        names = [p.name for p in MakeDevice(campaign).twin.subject]
        self.assertNotIn("viscous_N_s_m", names)
        self.assertIn("stiffness_N_m", names)

    def test_runs_without_a_force_are_refused_in_one_line(self):
        campaign = make_campaign(linear)
        (first, *rest) = campaign.runs
        less = {n: v for n, v in first.channels.items() if n != "force_N"}
        campaign = replace(
            campaign, runs=(replace(first, channels=less), *rest)
        )
        with self.assertRaisesRegex(CampaignError, "position_m and force_N"):
            MakeDevice(campaign)

    def test_a_force_that_gives_work_has_its_sign_turned(self):
        campaign = make_campaign(lambda p, i: -linear(p))
        found = check_recording(campaign, MakeDevice(campaign))
        self.assertEqual({f.fault.name for f in found}, {"reversed_sign"})

    def test_a_repaired_axis_comes_back_from_its_file(self):
        campaign = make_campaign(linear)
        twin = MakeDevice(campaign).twin
        card = twin.effects()["friction_behind_play"]
        values = np.array([6.0, 1e4, 0.003])
        scenario = twin.scenario_of(np.array([p.nominal for p in twin.subject]))
        scenario.effects = [describe_use(card, values)]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "axis.scenario.yaml"
            SaveScenario(scenario, path)
            back = MakeDevice(campaign, LoadScenario(path)).twin
        motion = twin.motion(campaign.runs[0])
        subject = np.array([p.nominal for p in twin.subject])
        wanted = twin.simulate(motion, subject, [(card, values)])
        np.testing.assert_allclose(
            back.simulate(motion, subject), wanted, atol=1e-9
        )


class TestRealMachines(unittest.TestCase):
    def diagnosed(self, name):
        """The diagnosis of a machine by its committed map."""
        data = SHARED / "real" / name
        if not data.is_dir():
            self.skipTest(f"../shared/real/{name} is not on this machine")
        with tempfile.TemporaryDirectory() as folder:
            here = Path(folder) / name
            here.mkdir()
            for file in data.glob("*.csv"):
                (here / file.name).symlink_to(file)
            text = (MAPS / f"{name}.map.yaml").read_text()
            (here / "map.yaml").write_text(text)
            out = Path(folder) / "campaign"
            WriteCampaign(ImportCampaign(here / "map.yaml"), out)
            return diagnose(LoadCampaign(out), jobs=2)

    def check(self, found, effect):
        """Checks that one effect is named and its validation confirms it."""
        self.assertEqual(found.verdict.effects, (effect,))
        self.assertFalse(found.verdict.contradicted)
        self.assertGreater(found.shrinkage["closed"], 0.5)

    def test_a_friction_damper_has_play(self):
        found = self.diagnosed("friction_damper")
        self.check(found, "friction_behind_play")
        values = estimates(found)
        # Published: 4.2 mm with a spread of 0.5 over conditions, 6 MN/m.
        self.assertAlmostEqual(1e3 * values["backlash_m"], 4.2, delta=0.6)
        stiffness = values["stiffness_N_m"]
        self.assertAlmostEqual(1e-6 * stiffness, 6.0, delta=1.0)

    def test_a_seal_s_friction_grows_with_pressure(self):
        found = self.diagnosed("pneumatic_seal")
        self.check(found, "load_friction")
        # 0.84 N/bar with what the pressure itself differs by between both
        # directions, 0.2 N/bar.
        growth = estimates(found)["growth_N_bar"]
        self.assertAlmostEqual(growth, 0.64, delta=0.1)

    def test_a_cable_driven_tool_s_friction_grows_with_its_load(self):
        found = self.diagnosed("cable_driven_tool")
        self.check(found, "load_friction")
        self.assertGreater(estimates(found)["growth_N_m_N_m"], 0.1)


if __name__ == "__main__":
    unittest.main()
