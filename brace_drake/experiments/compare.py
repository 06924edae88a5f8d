"""All controllers of the brace on one reference, and the paper beside them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace

import numpy as np

from brace_drake.core.resources import scenario_path
from brace_drake.devices.motions.reference import (
    LoadReference,
    reference_columns,
)
from brace_drake.experiments.scores import Push, Score, score_push
from brace_drake.experiments.tables import TABLE_1_PIC as PAPER
from brace_drake.model.simulate import BraceLog, OnProgress, SimulateBrace
from brace_drake.recording.recording import Run
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.controllers import TAGS
from brace_drake.scenario.load import LoadScenario

# Opens a progress bar of a run under a label.
OpenBar = Callable[[Run, str], AbstractContextManager[OnProgress | None]]

PAPER_BRACE = "paper_brace.scenario.yaml"
PAPER_PIC = "paper_pic.scenario.yaml"
PAPER_EXPERIMENT = "paper_experiment.scenario.yaml"
# Of a spring pushed along the cubic 3 t^2 - 2 t^3, over what it has at the end:
# rms of the force, and of its distance from the end, sqrt(13 / 35) both.
SPRING_SHARE = math.sqrt(13.0 / 35.0)


@dataclass(frozen=True)
class ControllerRun:
    """A controller on a reference: who, where, how well, and the log.

    Attributes:
        tag: Of the controller.
        setting: Words for the table.
        score: Of the ring that is pushed; its stiffness is not known.
        peak_leg: Greatest force of any leg, N.
        ring: Its index, from below.
        log: Of the run.
    """

    tag: str
    setting: str
    score: Score
    peak_leg: float
    ring: int
    log: BraceLog


def score_log(log: BraceLog, ring: int) -> Score:
    """Measures of a ring, by its index from below.

    Poses are the plant's own, forces are as read.
    """
    error = log.desired[:, 0, ring, :3] - log.X[:, ring, :3]
    rate = log.desired[:, 1, ring, 1] - log.v[:, ring, 1]
    unknown = np.full(len(log.time), np.nan)
    push = Push(
        log.time, error[:, [1, 0, 2]], rate, log.force[:, ring, 1], unknown
    )
    return score_push(push)


def LoadPush() -> Run:
    """The paper's reference: 10 mm along -y in 12 s, a cubic polynomial."""
    return LoadReference(scenario_path("paper_push.csv"))


def pushed_ring(scenario: BraceScenario, run: Run) -> int:
    """Index, from below, of the ring whose reference goes furthest."""
    ways = []
    for ring in scenario.stages:
        y = run.channels.get(reference_columns(ring)[0], np.zeros(1))
        ways.append(float(np.ptp(y)))
    return int(np.argmax(ways))


def compare_controllers(
    scenario: BraceScenario,
    run: Run,
    tags: Sequence[str] = TAGS,
    setting: str = "",
    noise_seed: int | None = None,
    open_bar: OpenBar | None = None,
) -> list[ControllerRun]:
    """Runs controllers on the same plant, reference and noise.

    Args:
        scenario: Of the brace; its own tag is not used.
        run: With a reference.
        tags: Of the controllers.
        setting: Words for the table.
        noise_seed: Of the instruments' noise; None: exact readings.
        open_bar: For progress.

    Raises:
        BraceError: A controller's numbers are refused, or its run broke down.
    """
    open_bar = open_bar or (lambda run, label: nullcontext())
    ring, found = pushed_ring(scenario, run), []
    for tag in tags:
        tagged = replace(scenario, control=replace(scenario.control, tag=tag))
        with open_bar(run, tag) as on_progress:
            log = SimulateBrace(tagged, run, noise_seed, on_progress)
        leg = float(np.abs(log.drive_force).max())
        score = score_log(log, ring)
        found.append(ControllerRun(tag, setting, score, leg, ring, log))
    return found


def RunPaper(
    noise_seed: int | None = None, open_bar: OpenBar | None = None
) -> list[ControllerRun]:
    """The paper's two experiments on stage 2, sections 4.2 and 4.1."""
    found = []
    for name, setting in (
        (PAPER_PIC, "stage 2, section 4.2"),
        (PAPER_EXPERIMENT, "stage 2, section 4.1"),
    ):
        scenario = LoadScenario(scenario_path(name))
        tag = scenario.control.tag
        found += compare_controllers(
            scenario, LoadPush(), (tag,), setting, noise_seed, open_bar
        )
    return found


def explain_table_1(pic: Score, scenario: BraceScenario) -> list[str]:
    """Why PIC's row differs from the paper's Table 1, by the numbers.

    Args:
        pic: Of the paper's scenario.
        scenario: The paper's.
    """
    stiffness = float(np.ravel(scenario.control.impedance.stiffness)[1])
    posture = float(scenario.torso.posture_stiffness[1])
    gain = float(np.ravel(scenario.control.inner.kp)[0]) * scenario.ring.mass
    force = stiffness * PAPER.y_rms
    end = abs(pic.force_end)
    return [
        f"Force and y: an impedance of {stiffness:g} N/m gives way by F / K, so"
        f" the paper's {1e3 * PAPER.y_rms:.3f} mm are a force of"
        f" {force:.2f} N rms, and its {PAPER.force_rms:.3f} N about the final"
        f" value are {100 * PAPER.force_rms / force:.0f} % of that: there the"
        " force is nearly the same from the start of the push to its end. Here"
        f" a posture spring of {posture:g} N/m is pushed along the cubic, and"
        f" for any spring both are sqrt(13/35) = {SPRING_SHARE:.3f} of the end"
        f" value, {end:.2f} N: {SPRING_SHARE * end:.2f} N (run:"
        f" {pic.force_rms:.2f} N) and"
        f" {1e3 * SPRING_SHARE * end / stiffness:.3f} mm (run:"
        f" {1e3 * pic.y_rms:.3f} mm, the rest is the lag of the inner loop)."
        " No stiffness of the posture meets both entries; a torso that leans on"
        f" the pad with {force:.2f} N throughout would.",
        f"Velocity: the paper's {1e3 * PAPER.vy_rms:.3f} mm/s include the jump"
        " of 2.8 mm/s with which its run starts (its Figure 9). Here ring and"
        " torso start at rest, the pads just touching:"
        f" {1e3 * pic.vy_rms:.3f} mm/s.",
        f"x and z: with K_P M = {gain:.0f} N/m the paper's"
        f" {1e3 * PAPER.x_rms:.3f} and {1e3 * PAPER.z_rms:.3f} mm are"
        f" {gain * PAPER.x_rms:.2f} and {gain * PAPER.z_rms:.2f} N that its"
        f" controller does not know of; here {1e3 * gain * pic.x_rms:.1f} and"
        f" {1e3 * gain * pic.z_rms:.1f} mN are left, as ring, legs and"
        " controller share their numbers and the pads push along y.",
    ]
