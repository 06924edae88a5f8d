"""Where the gap lies: all that isolates it, put together."""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.devices.declaration import Device
from brace_drake.identification.evaluation import Evaluator
from brace_drake.identification.fits import CandidateFit
from brace_drake.identification.gap import RunComparison
from brace_drake.isolation.budget import (
    band_budget,
    channel_budget,
    gap_cells,
    phase_budget,
)
from brace_drake.isolation.phases import motion_phases
from brace_drake.isolation.repair_shares import share_repairs
from brace_drake.selection.decision import Verdict


def locate_gap(
    device: Device,
    evaluator: Evaluator,
    nominal: CandidateFit,
    verdict: Verdict,
    repair: CandidateFit | None,
    tests: list[dict],
    compared: Sequence[RunComparison],
    seed: int,
) -> dict:
    """The gap by block, channel, phase of the motion and band.

    Shares of blocks are those of repairing them; where nothing was found that
    repairs the gap, there are none.

    Args:
        device: Of the campaign.
        evaluator: Over the fit runs.
        nominal: The nominal fit.
        verdict: What explains the gap.
        repair: With all that was found, a law included; None without.
        tests: Rows of `run_block_tests`.
        compared: The fit runs, replayed before and after the repair.
        seed: Of all draws.
    """
    winner, prepared, rate = verdict.winner, evaluator.prepared, device.rate
    signals = [device.motion_signals(p, nominal.subject) for p in prepared]
    phases = []
    for c, motion in zip(compared, signals, strict=True):
        breath, run = None, c.prepared.run
        if winner and winner.has_run_parameters and motion.force is not None:
            # What its repair changes while the brace holds still.
            breath = (c.after - c.before)[:, motion.force]
        measured = c.prepared.measured
        phases.append(
            motion_phases(motion, measured, rate, run.contact, breath)
        )
    attribution, cells = [], []
    if repair is not None:
        rivals = verdict.ambiguous_with
        attribution = share_repairs(evaluator, nominal, repair, rivals, seed)
    if verdict.gap:
        channels = evaluator.twin.channels
        cells = gap_cells(compared, phases, channels, rate, seed)
    return {
        "blocks": tests,
        "attribution": attribution,
        "channels": channel_budget(compared, evaluator.twin.channels),
        "phases": phase_budget(compared, phases),
        "bands": band_budget(compared, rate),
        "cube": cells,
    }
