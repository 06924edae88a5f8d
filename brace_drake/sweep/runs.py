"""One run of a scenario's twin over a motion, as recorded channels.

A bench or brace under PIC with linear pads is simulated by the compiled
rollout, which a test holds to Drake's diagram; any other by the diagram itself.
Drives, pads and axes have compiled twins that answer to a recorded motion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from brace_drake.core.errors import BraceError, CampaignError
from brace_drake.core.reading import ReadBytes, in_file
from brace_drake.devices.axis.follower import AxisFollower
from brace_drake.devices.axis.twin import AxisTwin
from brace_drake.devices.bench.recorded_motion import ring_poses
from brace_drake.devices.bench.rollout import draw_noise, simulate_bench
from brace_drake.devices.bench.twin import BenchTwin
from brace_drake.devices.brace.twin import BraceTwin
from brace_drake.devices.leg_bench.twin import LegBenchTwin
from brace_drake.devices.motions.library import MakeMotion
from brace_drake.devices.motions.reference import (
    LoadReference,
    references_of_rings,
)
from brace_drake.devices.pad_bench.twin import PadBenchTwin
from brace_drake.effects.stack import modify_numbers, stack_effects
from brace_drake.recording.columns import (
    AXIS,
    BENCH,
    BRACE,
    BRACE_STAGES,
    LEG_BENCH,
    PAD_BENCH,
)
from brace_drake.recording.recording import Run
from brace_drake.recording.table import parse_table
from brace_drake.scenario.brace import BraceScenario
from brace_drake.scenario.brace_numbers import pack_rings

DEVICES = (BENCH, BRACE, LEG_BENCH, PAD_BENCH, AXIS)


@dataclass(frozen=True)
class Simulated:
    """What a run has brought forth.

    Attributes:
        time: (N,), s.
        channels: By column, each (N,).
        rings: y of each moving ring and what it was asked (N, S), m; None of
            other devices.
        asked: See `rings`; NaN where a ring has no reference.
    """

    time: np.ndarray
    channels: dict[str, np.ndarray]
    rings: np.ndarray | None = None
    asked: np.ndarray | None = None


def LoadMotion(text: str, scenario: Any) -> Run:
    """A motion of the library by name, or a file of one.

    Of a bench or brace a file is a reference; of other devices a recording in
    CSV, whose imposed or commanded channel is taken.

    Raises:
        CampaignError: There is none, or the device needs a file.
    """
    is_file = text.endswith(".csv") or Path(text).is_file()
    if isinstance(scenario, BraceScenario):
        if is_file:
            return LoadReference(text, BRACE_STAGES)
        return MakeMotion(text).run
    if not is_file:
        raise CampaignError(
            f"--motion {text}: motions of the library are of a bench or brace;"
            f" allowed for a {scenario.device}: a recording of it (*.csv)"
        )
    with in_file(text, CampaignError):
        data = ReadBytes(text)
    columns, problems = parse_table(data, text, {"time_s"})
    errors = [p for p in problems if p.severity == "error"]
    if errors:
        raise CampaignError(str(errors[0]).removeprefix("error: "))
    if "time_s" not in columns or len(columns["time_s"]) < 2:
        raise CampaignError(f"{text}: no column time_s with two rows or more")
    path = Path(text)
    return Run(path.name, True, path.stem, None, "fit", columns)


def make_simulator(
    scenario: Any,
) -> Callable[[Any, Run, int | None], Simulated]:
    """What simulates a scenario of this device, with a seed of its noise.

    Raises:
        CampaignError: There is no twin that could be swept.
    """
    if isinstance(scenario, BraceScenario):
        return _run_compiled if _is_compiled(scenario) else _run_diagram
    if scenario.device not in DEVICES:
        raise CampaignError(
            f"a {scenario.device!r} cannot be swept; allowed:"
            f" {', '.join(DEVICES)}"
        )
    return _run_replay


def _is_compiled(scenario: BraceScenario) -> bool:
    models = {contact.model for contact in scenario.contacts}
    is_plain = scenario.mechanism == "task_space"
    is_pic = scenario.control.tag == "pic"
    return is_plain and is_pic and models <= {"linear", "none"}


def _run_compiled(
    scenario: BraceScenario, run: Run, seed: int | None
) -> Simulated:
    twin = (BenchTwin if scenario.device == BENCH else BraceTwin)(scenario)
    # Not `twin.simulate`, whose subject has the same pads at every ring.
    numbers = modify_numbers(twin.numbers, twin.carried)
    motion = twin.motion(run)
    noise = None
    if seed is not None:
        generator = np.random.default_rng(seed)
        noise = draw_noise(numbers, len(motion.desired), generator)
    plug_ins = stack_effects(twin.carried, numbers)
    log = simulate_bench(numbers, motion, twin.time_step, plug_ins, noise)
    channels = dict(zip(twin.channels, log.T, strict=False))
    time = np.arange(len(log)) * motion.ticks_per_sample
    time = time / scenario.control.rate
    return _of_brace(scenario, run, twin.numbers, time, channels)


def _run_diagram(
    scenario: BraceScenario, run: Run, seed: int | None
) -> Simulated:
    from brace_drake.model.simulate import RecordBrace
    from brace_drake.scenario.brace_numbers import pack_brace

    recorded = RecordBrace(scenario, run, noise_seed=seed)
    channels = {k: v for k, v in recorded.channels.items() if k != "time_s"}
    numbers = pack_brace(scenario)
    return _of_brace(scenario, run, numbers, recorded.time_s, channels)


def _of_brace(scenario, run: Run, numbers, time, channels) -> Simulated:
    """With the way of each ring, from the lengths of its legs."""
    lengths = np.column_stack(
        [v for k, v in channels.items() if k.endswith("_length_m")]
    )
    _check_stroke(scenario, lengths, time)
    poses, _ = ring_poses(numbers, lengths)
    asked = np.full((len(time), len(scenario.stages)), np.nan)
    at = run.time_s - run.time_s[0]
    for i, own in references_of_rings(run, scenario.stages, "scenario"):
        asked[:, i] = np.interp(time, at, own[:, 0])
    return Simulated(time, channels, poses[:, 1::6], asked)


def _check_stroke(scenario, lengths: np.ndarray, time: np.ndarray) -> None:
    """Refuses what no real leg can do."""
    rest = np.ravel(pack_rings(scenario).geometry.rest_lengths)
    off = np.abs(lengths - rest)
    if off.max() <= scenario.leg.stroke / 2.0:
        return
    sample = int(np.argmax(off.max(axis=1) > scenario.leg.stroke / 2.0))
    raise BraceError(
        f"a leg is {1e3 * off[sample].max():.1f} mm from its length at rest at"
        f" {time[sample]:.3f} s; its stroke allows"
        f" {500.0 * scenario.leg.stroke:g} mm"
    )


def _run_replay(scenario: Any, run: Run, seed: int | None) -> Simulated:
    """A drive, pad or axis that answers to a recorded motion."""
    twin = _replay_twin(scenario)
    usual = np.array([p.nominal for p in twin.subject])
    generator = None if seed is None else np.random.default_rng(seed)
    try:
        log = twin.simulate(twin.motion(run), usual, (), generator)
    except KeyError as error:
        raise CampaignError(f"{run.file}: no column {error.args[0]}") from None
    # A drive's log is at its own samples; all begin with the run.
    time = run.time_s - run.time_s[0]
    time = np.linspace(time[0], time[-1], len(log))
    return Simulated(time, dict(zip(twin.channels, log.T, strict=True)))


def _replay_twin(scenario: Any):
    if scenario.device == PAD_BENCH:
        return PadBenchTwin(scenario)
    if scenario.device == LEG_BENCH:
        return LegBenchTwin(scenario)
    return (AxisTwin if scenario.is_imposed else AxisFollower)(scenario)


def with_contact(run: Run, scenario: Any) -> Run:
    """A run without the torso where the scenario has none."""
    torso = getattr(scenario, "torso", None)
    present = torso is None or torso.present
    return run if present else replace(run, contact=False)
