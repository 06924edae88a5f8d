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
from brace_drake.isolation.force_balance import DRIVES, explain_imbalance
from brace_drake.isolation.imposed_motion import ImposedMotionFit
from brace_drake.isolation.phases import motion_phases
from brace_drake.isolation.repair_shares import share_repairs
from brace_drake.isolation.small_errors import attribute_errors
from brace_drake.selection.decision import Verdict


def locate_gap(
    device: Device,
    evaluator: Evaluator,
    nominal: CandidateFit,
    verdict: Verdict,
    tests: list[dict],
    imposed: ImposedMotionFit | None,
    compared: Sequence[RunComparison],
    seed: int,
) -> dict:
    """The gap by block, channel, phase of the motion and band.

    Shares of blocks are those of repairing them, else, where no effect
    explains the gap, of what their small errors could do.

    Args:
        device: Of the campaign.
        evaluator: Over the fit runs.
        nominal: The nominal fit.
        verdict: What explains the gap.
        tests: Rows of `run_block_tests`.
        imposed: What answers to an imposed motion, where it was asked.
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
    balance, attribution, cells = [], [], []
    drives = next((r for r in tests if r["block"] == DRIVES), None)
    if verdict.outside_library and drives:
        balance = explain_imbalance(device, prepared, drives)
    if winner is not None:
        rivals = verdict.ambiguous_with
        attribution = share_repairs(evaluator, nominal, winner, rivals, seed)
    elif verdict.gap:
        errors = device.small_errors()
        attribution = attribute_errors(evaluator, nominal, errors, seed)
    if verdict.gap:
        channels = evaluator.twin.channels
        cells = gap_cells(compared, phases, channels, rate, seed)
    return {
        "blocks": tests,
        "contact_side": imposed.row() if imposed else None,
        "balance": balance,
        "attribution": attribution,
        "attribution_by": "repair" if winner else "errors",
        "channels": channel_budget(compared, evaluator.twin.channels),
        "phases": phase_budget(compared, phases),
        "bands": band_budget(compared, rate),
        "cube": cells,
    }
