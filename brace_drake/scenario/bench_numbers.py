"""Numbers of the compiled twin of a scenario."""

from __future__ import annotations

import numpy as np

from brace_drake.laws.numbers import BraceNumbers
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_brace, pack_contact


def pack_bench(scenario: BraceScenario) -> BraceNumbers:
    """Arrays of the nominal twin that a scenario describes.

    It knows the linear law of contact alone, whatever the model.

    Raises:
        KinematicsError: Legs without length, or a stage singular at rest.
    """
    contact = np.array([pack_contact(c) for c in scenario.contacts])
    return pack_brace(scenario).with_changes(contact=contact)
