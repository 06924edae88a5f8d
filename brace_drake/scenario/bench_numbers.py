"""Numbers of the compiled twin of a scenario, and of its diagram."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from brace_drake.laws.numbers import BraceNumbers
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import (
    pack_brace,
    pack_contact,
    pack_rings,
)
from brace_drake.scenario.control_numbers import ControlNumbers, pack_control


def pack_bench(scenario: BraceScenario) -> BraceNumbers:
    """Arrays of the nominal twin that a scenario describes.

    It knows the linear law of contact alone, whatever the model.

    Raises:
        KinematicsError: Legs without length, or a stage singular at rest.
    """
    contact = np.array([pack_contact(c) for c in scenario.contacts])
    return pack_brace(scenario).with_changes(contact=contact)


def pack_plant(brace: BraceScenario, numbers: BraceNumbers) -> BraceNumbers:
    """The numbers without those contacts that the plant resolves itself."""
    contact = numbers.contact.copy()
    for own, model in zip(contact, brace.contacts, strict=True):
        if model.model != "linear":
            own[0:2] = 0.0
    return numbers.with_changes(contact=contact)


def pack_bench_control(
    brace: BraceScenario, numbers: BraceNumbers
) -> ControlNumbers:
    """Arrays of the bench's controller, arguments as above."""
    control = pack_control(brace.control, pack_rings(brace))
    return replace(control, law=numbers.control)
