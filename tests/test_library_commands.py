"""`effects`, `motions` and `devices` list what there is, plug-ins included."""

import json
import unittest
from dataclasses import replace

from brace_drake.cli.library.devices import shorten_names
from brace_drake.devices import register_device
from brace_drake.devices.device import DEVICES as DIAGNOSED
from brace_drake.devices.motions.library import MOTIONS, STANDARD, MakeMotion
from brace_drake.devices.registry import forget_device
from brace_drake.effects.registry import (
    all_effects,
    effects_for,
    find_effect,
    forget_effect,
    register_effect,
)
from brace_drake.recording.columns import DEVICES
from tests.commands import run_command
from tests.foreign.oven import CARD as OVEN


def listed(*words):
    """Lines of a command behind its head."""
    status, text, errors = run_command(*words)
    assert status == 0, errors
    return text.splitlines()[1:]


def as_json(*words):
    """The document that a command prints."""
    status, text, errors = run_command(*words, "--json")
    assert status == 0, errors
    return json.loads(text)


class TestEffects(unittest.TestCase):
    def test_each_effect_has_a_line_with_block_limits_and_title(self):
        lines = listed("effects")
        self.assertEqual(len(lines), len(all_effects()))
        (line,) = (n for n in lines if n.startswith("relaxation "))
        card = find_effect("relaxation")
        self.assertIn(card.title, line)
        self.assertIn(card.block, line)
        for p in card.parameters:
            self.assertIn(f"{p.name} {p.lower:g} to {p.upper:g} {p.unit}", line)

    def test_a_device_has_those_that_it_can_have(self):
        for device in ("bench stage 2", "pad bench", "leg bench"):
            found = as_json("effects", "--device", device)["effects"]
            names = {row["effect"] for row in found}
            self.assertEqual(names, set(effects_for(device)))
        found = as_json("effects", "--device", "diagram")["effects"]
        names = {row["effect"] for row in found}
        for place in ("joint of a plant", "reading of a port"):
            self.assertLessEqual(set(effects_for(place)), names)

    def test_machines_get_limits_equations_and_sources(self):
        rows = {r["effect"]: r for r in as_json("effects")["effects"]}
        for key, card in all_effects().items():
            row = rows[key]
            self.assertEqual(row["equation"], card.equation)
            limits = [(p["lower"], p["upper"]) for p in row["parameters"]]
            self.assertEqual(
                limits, list(zip(card.lower, card.upper, strict=True))
            )

    def test_an_effect_of_others_is_listed(self):
        card = replace(find_effect("relaxation"), name="creep_of_foam")
        register_effect(card)
        self.addCleanup(forget_effect, card.key)
        lines = listed("effects", "--device", "pad bench")
        self.assertTrue(any(n.startswith("creep_of_foam ") for n in lines))

    def test_an_unknown_device_is_refused_with_a_hint(self):
        status, _, errors = run_command("effects", "--device", "bench stage")
        self.assertEqual((status, errors.count("\n")), (2, 1))
        self.assertIn("did you mean bench stage 2?", errors)


class TestMotions(unittest.TestCase):
    def test_each_motion_has_a_line(self):
        lines = listed("motions")
        names = [line.split()[0] for line in lines]
        self.assertEqual(names, list(MOTIONS))
        stars = [n.split()[0] for n in lines if n.split()[1] == "*"]
        self.assertEqual(set(stars), set(STANDARD))

    def test_machines_get_how_far_and_how_fast(self):
        for row in as_json("motions")["motions"]:
            motion = MakeMotion(row["motion"])
            self.assertEqual(row["contact"], motion.contact)
            y = motion.run.channels["ring2_y_desired_m"]
            self.assertAlmostEqual(row["largest_y_m"], float(abs(y).max()))
            self.assertIn(f"{row['duration_s']:g}", ("12", "24", "33", "60"))


class TestDevices(unittest.TestCase):
    def test_each_device_has_its_channels(self):
        register_device(OVEN)
        self.addCleanup(forget_device, OVEN.name)
        rows = {r["device"]: r for r in as_json("devices")["devices"]}
        self.assertEqual(set(rows), set(DEVICES))
        self.assertEqual(
            {n for n, r in rows.items() if r["diagnosed"]}, set(DIAGNOSED)
        )
        for name, row in rows.items():
            channels = [c["channel"] for c in row["channels"]]
            self.assertEqual(channels, list(DEVICES[name].channels))
        (line,) = (n for n in listed("devices") if n.startswith("oven "))
        self.assertIn("heater_W temperature_K", line)
        lines = listed("devices")
        (line,) = (n for n in lines if n.startswith("bench stage 2 "))
        self.assertIn("leg1..6_length_m", line)
        self.assertIn("[torso_x..z_m]", line)

    def test_names_are_shortened_without_loss(self):
        for device in DEVICES.values():
            names = list(device.channels)
            whole = [n for short in shorten_names(names) for n in spread(short)]
            self.assertEqual(sorted(whole), sorted(names))
        gap = ["leg1_m", "leg3_m", "x"]
        self.assertEqual(shorten_names(gap), gap)


def spread(name):
    """The names that a short one stands for."""
    head, dots, tail = name.partition("..")
    if not dots:
        return [name]
    digits = len(head) - len(head.rstrip("0123456789")) or 1
    first, head = head[-digits:], head[:-digits]
    size = (
        next((i for i, c in enumerate(tail) if not c.isdigit()), len(tail)) or 1
    )
    last, tail = tail[:size], tail[size:]
    parts = (
        "xyz"["xyz".index(first) :]
        if first in "xyz"
        else range(int(first), int(last) + 1)
    )
    return [n for part in parts for n in spread(f"{head}{part}{tail}")]


if __name__ == "__main__":
    unittest.main()
