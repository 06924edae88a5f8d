"""What differs from patient to patient, and where it sits in the numbers."""

from __future__ import annotations

import copy
from dataclasses import dataclass

import numpy as np

from brace_drake.laws.numbers import BraceNumbers
from brace_drake.scenario.brace import BraceScenario


@dataclass(frozen=True)
class SubjectParameter:
    """One parameter to be estimated for every subject.

    Attributes:
        name: With its unit as the last part.
        unit: SI.
        nominal: Value of the scenario.
        lower, upper: Physical limits.
        scale: Natural step of the value where its nominal value is 0.
        deviation: Standard deviation of a normal prior around the nominal
            value; 0 where it has none.
    """

    name: str
    unit: str
    nominal: float
    lower: float
    upper: float
    scale: float = 0.0
    deviation: float = 0.0

    @property
    def is_fixed(self) -> bool:
        """Whether it is held at its nominal value."""
        return self.lower == self.upper

    @property
    def unit_step(self) -> float:
        """What a fit counts the parameter in."""
        return self.scale if self.scale > 0.0 else abs(self.nominal)


# Name, unit, array of BraceNumbers, index in it or in each of its rows.
_PLACES = (
    ("contact_stiffness_N_m", "N/m", "contact", 0),
    ("contact_damping_N_s_m", "N s/m", "contact", 1),
    ("posture_stiffness_y_N_m", "N/m", "posture", 1),
    ("posture_damping_y_N_s_m", "N s/m", "posture", 4),
    ("torso_mass_kg", "kg", "torso", 0),
    ("preload_m", "m", "contact", 5),
)

# From one patient to the next numbers differ by 0.7 to 1.5 times the data
# sheet's; the limits leave room for a twentieth more, as the twin may be off.
# They are what tells an effect of contact or torso from another patient.
_LEAST, _MOST = 0.7 / 1.05, 1.5 * 1.05


def bench_subject(numbers: BraceNumbers) -> tuple[SubjectParameter, ...]:
    """Subject parameters of the bench with nominal values and limits."""
    return tuple(
        SubjectParameter(
            name,
            unit,
            value,
            value * _LEAST,
            value * _MOST,
        )
        for name, unit, array, i in _PLACES
        for value in [float(getattr(numbers, array)[..., i].flat[0])]
    )


def with_subject(numbers: BraceNumbers, values: np.ndarray) -> BraceNumbers:
    """The numbers of a subject, values in the order of `bench_subject`."""
    changed: dict[str, np.ndarray] = {}
    for value, (_, _, array, i) in zip(values, _PLACES, strict=True):
        copy = changed.setdefault(array, getattr(numbers, array).copy())
        copy[..., i] = value
    return numbers.with_changes(**changed)


def scenario_of_subject(
    scenario: BraceScenario, values: np.ndarray
) -> BraceScenario:
    """A copy of a scenario with the numbers of a subject.

    The hydroelastic numbers, which stand for stiffness k, damping c and
    preload p as well, follow in proportion to k and to c / (k p).

    Args:
        scenario: Of the nominal twin.
        values: In the order of `bench_subject`.
    """
    out = copy.deepcopy(scenario)
    contact, torso = out.contacts[0], out.torso
    k, c, p = contact.stiffness, contact.damping, contact.preload
    contact.stiffness, contact.damping = float(values[0]), float(values[1])
    torso.posture_stiffness[1] = values[2]
    torso.posture_damping[1] = values[3]
    torso.mass, contact.preload = float(values[4]), float(values[5])
    softer = contact.stiffness / k
    contact.hydroelastic_modulus *= softer
    if c > 0.0 and p > 0.0:
        change = (contact.damping / c) / (softer * contact.preload / p)
        contact.hydroelastic_dissipation *= change
    return out
