"""An episode's own numbers: a subject, a motion, draws of noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from brace_drake.effects.stack import Use
from brace_drake.learning.subjects import (
    NOMINAL,
    Subject,
    draw_subject,
    uses_of,
)
from brace_drake.learning.task import LearningTask
from brace_drake.scenario.brace_numbers import BraceNumbers


@dataclass(frozen=True)
class Episode:
    """What a loop is set up with.

    Attributes:
        subject: As drawn.
        force_law: See `kernels.num_law`.
        torso: Mass and principal moments (4,).
        uses: Effects with their parameters.
        way: What the motion adds to the start (6n,).
        draws: Standard normal, at each tick (ticks, 9n + 3), or (0, 9n + 3).
    """

    subject: Subject
    force_law: np.ndarray
    torso: np.ndarray
    uses: tuple[Use, ...]
    way: np.ndarray
    draws: np.ndarray


def draw_episode(
    task: LearningTask,
    numbers: BraceNumbers,
    torso: np.ndarray,
    ticks: int,
    generator: np.random.Generator,
    subject: Subject | None = None,
) -> Episode:
    """Draws an episode.

    Args:
        task: With arrays of all rings.
        numbers: Of the scenario.
        torso: Mass and principal moments of the scenario (4,).
        ticks: Control ticks of a whole episode.
        generator: Of all draws.
        subject: In place of a drawn one.
    """
    drawn = draw_subject(task.subjects, generator)
    subject = drawn if subject is None else subject
    width = 9 * numbers.num_stages + 3
    rows = ticks + 1 if task.readings == "noisy" else 0
    factors = {**NOMINAL.factors, **subject.factors}
    return Episode(
        subject=subject,
        force_law=_scale_numbers(numbers, factors).force_law,
        torso=torso * factors["torso_mass"],
        uses=tuple(uses_of(task.subjects, subject)),
        way=task.displacement * factors["displacement"],
        draws=generator.standard_normal((rows, width)),
    )


def _scale_numbers(
    numbers: BraceNumbers, factors: dict[str, float]
) -> BraceNumbers:
    contact, posture = numbers.contact.copy(), numbers.posture.copy()
    contact[:, 0] *= factors["contact_stiffness"]
    contact[:, 1] *= factors["contact_damping"]
    contact[:, 5] *= factors["preload"]
    for first in (0, 6):
        posture[first : first + 3] *= factors["posture_stiffness"]
        posture[first + 3 : first + 6] *= factors["posture_damping"]
    return replace(numbers, contact=contact, posture=posture)
