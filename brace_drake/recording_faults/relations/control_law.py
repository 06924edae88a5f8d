"""Runs that do not follow their controller's law, and what explains them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brace_drake.recording.recording import Run
from brace_drake.recording_faults.finding import MOST_PROBABLE, Finding
from brace_drake.recording_faults.library.runs import (
    contradiction,
    other_geometry,
)
from brace_drake.recording_faults.relations.hypotheses import Hypothesis
from brace_drake.recording_faults.relations.mismatch import (
    LawChecker,
    Mismatch,
)
from brace_drake.recording_faults.relations.search import FaultSearch, Tried

# Part of the mismatch that a fault may leave, as undoing it is not exact.
_LEFT = 0.02
# Of a first fault of two: the least part that it takes away.
_HALF_WAY = 0.3
# How the probability falls with the mismatch that is left: no floor is exact.
_SHARP, _ALIKE = 8.0, 0.1
# Runs without an explanation after which no other is searched.
_MOST_SEARCHES = 3
# More than encoders are off, m, and legs of which that is told.
_REST_M, _REST_LEGS = 0.010, 3


def find_law_faults(checker: LawChecker, runs: Sequence[Run]) -> list[Finding]:
    """Faults of the runs that contradict the control law.

    Args:
        checker: Of the campaign.
        runs: Those to look at.
    """
    judged = [(run, checker.judge(run)) for run in runs]
    bad = [(r, m) for r, m in judged if m is not None and not m.is_sound]
    # The clearest first: what it shows is tried on the others.
    bad.sort(key=lambda rm: -rm[1].total)
    chains: list[tuple[tuple[Hypothesis, ...], float]] = []
    of_chain: dict[int, list[Finding]] = {}
    found: list[Finding] = []
    for run, before in bad:
        if _has_other_numbers(checker, run, before):
            found.append(_of_other_numbers(checker, run, before))
            continue
        k = _known_chain(checker, run, before, chains)
        if k is None:
            # What several runs have not told, one more does not either; and a
            # machine has the geometry of one run in all.
            is_moved = _has_moved(found) and _is_moved(checker, run)
            if len(found) < _MOST_SEARCHES and not is_moved:
                chain, probability = explain(checker, run, before)
                if _is_elsewhere(checker, run, chain):
                    chain = ()
            else:
                chain, probability = (), 0.0
            if not chain:
                found.append(_unexplained(checker, run, before))
                continue
            chains.append((chain, probability))
            k = len(chains) - 1
        of_chain.setdefault(k, []).append((run, before))
    _sharpen(checker, chains, of_chain)
    sound = [r for r, m in judged if m is not None and m.is_sound]
    for k, members in of_chain.items():
        found += _findings(checker, *chains[k], members, sound, len(runs))
    return found


def _is_restored(before: Mismatch, after: Mismatch | None) -> bool:
    if after is None:
        return False
    left = after.total - 1.0
    return after.is_sound or left < _LEFT * (before.total - 1.0)


def _sharpen(checker, chains, of_chain) -> None:
    """Numbers of a fault anew from the run that they fit worst, where that
    leaves less over all runs: a run at rest tells no scale.
    """
    for k, members in of_chain.items():
        chain, _ = chains[k]
        if len(members) < 2 or not any(h.parameters for h in chain):
            continue
        left = _totals(checker, chain, members)
        worst = int(np.argmax(left))
        run, before = members[worst]
        if checker.judge(_undo_all(chain, run)).is_sound:
            continue
        again, probability = explain(checker, run, before)
        if _kind(again) != _kind(chain):
            continue
        if sum(_totals(checker, again, members)) < sum(left):
            chains[k] = (again, probability)


def _kind(chain) -> tuple:
    return tuple((h.fault.name, h.channels) for h in chain)


def _totals(checker, chain, members) -> list[float]:
    """What a chain leaves of each of its runs."""
    judged = [checker.judge(_undo_all(chain, r)) for r, _ in members]
    return [np.inf if m is None else m.total for m in judged]


def _known_chain(checker, run, before, chains) -> int | None:
    """A chain of faults of another run that explains this one too."""
    for k, (chain, _) in enumerate(chains):
        undone = run
        for h in chain:
            if not set(h.channels) <= set(run.channels):
                break
            undone = h.undone(undone)
        else:
            if _is_restored(before, checker.judge(undone)):
                return k
    return None


def explain(
    checker: LawChecker, run: Run, before: Mismatch
) -> tuple[tuple[Hypothesis, ...], float]:
    """One fault that restores a run, or two; none where nothing does.

    Returns:
        The faults, to be undone in their order, and their probability.
    """
    tried = FaultSearch(checker, run, before).all()
    if not tried:
        return (), 0.0
    best = tried[0]
    if _is_restored(before, best.mismatch):
        best = _simplest(tried)
        return (best.hypothesis,), probability_of(best, tried)
    if best.mismatch.total > (1.0 - _HALF_WAY) * before.total:
        return (), 0.0
    undone = best.hypothesis.undone(run)
    again = FaultSearch(checker, undone, best.mismatch).all()
    if again and _is_restored(before, again[0].mismatch):
        second = _simplest(again)
        chain = (best.hypothesis, second.hypothesis)
        return chain, 0.9 * probability_of(second, again)
    return (), 0.0


def _simplest(tried: Sequence[Tried]) -> Tried:
    """Of those that leave as little as the best, the one of fewest numbers."""
    least = tried[0].mismatch.total
    alike = [t for t in tried if t.mismatch.total <= 1.01 * least + 0.01]
    return min(
        alike,
        key=lambda t: (
            sum(v != 0.0 for v in t.hypothesis.parameters.values()),
            len(t.hypothesis.channels),
            t.mismatch.total,
        ),
    )


def probability_of(best: Tried, tried: Sequence[Tried]) -> float:
    """Of a fault among its rivals, by what each leaves."""

    def weight(t: Tried) -> float:
        return float((_ALIKE + t.mismatch.total) ** -_SHARP)

    mine = (best.hypothesis.fault.name, best.hypothesis.channels)
    others: dict[tuple, float] = {}
    for t in tried:
        kind = (t.hypothesis.fault.name, t.hypothesis.channels)
        if kind == mine or kind[1] == mine[1]:
            continue
        others[kind] = max(others.get(kind, 0.0), weight(t))
    own = weight(best)
    return MOST_PROBABLE * own / (own + sum(others.values()))


def _findings(checker, chain, probability, members, sound, number):
    """A finding for each fault of a chain, over the runs that show it."""
    shown = [run for run, _ in members]
    before = float(np.mean([m.total for _, m in members]))
    undone = [_undo_all(chain, run) for run in shown]
    after = float(np.mean([checker.judge(r).total for r in undone]))
    files = [r.file for r in shown]
    # Runs that show nothing of it may have it too, where it would not show.
    silent = len(shown) > 1 and all(_hides(checker, chain, r) for r in sound)
    of_all = len(shown) + len(sound) * silent == number and number > 1
    if of_all:
        files += [r.file for r in sound]
    detail = (
        "commands and readings contradict the control law by"
        f" {before**0.5:.3g} noise floors, {after**0.5:.3g} with it undone"
    )
    return [
        Finding(
            h.fault,
            tuple(files),
            h.channels,
            dict(h.parameters),
            probability,
            detail,
            of_all=of_all,
            before=before,
            after=after,
        )
        for h in chain
    ]


def _undo_all(chain, run: Run) -> Run:
    for h in chain:
        run = h.undone(run)
    return run


def _hides(checker, chain, run: Run) -> bool:
    """Whether a sound run would be sound with the faults undone too."""
    if not all(set(h.channels) <= set(run.channels) for h in chain):
        return True
    found = checker.judge(_undo_all(chain, run))
    return found is not None and found.is_sound


def _has_moved(findings: Sequence[Finding]) -> bool:
    """Whether a run of another geometry is among findings."""
    return any(f.fault is other_geometry.CARD for f in findings)


def _is_moved(checker: LawChecker, run: Run) -> bool:
    """Whether legs begin where no error of an encoder puts them."""
    gross = np.abs(checker.law.rest_error(run)) > _REST_M
    return np.count_nonzero(gross) >= _REST_LEGS


def _is_elsewhere(checker: LawChecker, run: Run, chain) -> bool:
    """Whether lengths at rest are another geometry's, and no fault of the
    channels brings the law to its floor.
    """
    if not _is_moved(checker, run):
        return False
    found = checker.judge(_undo_all(chain, run))
    return found is None or not found.is_sound


def _has_other_numbers(checker: LawChecker, run: Run, before: Mismatch) -> bool:
    """Whether a run follows a controller of the declared kind."""
    law = checker.law
    if law.is_exact:
        return False
    other = run.stack(law.outputs) - law.refitted(run)
    return _is_restored(before, checker.weigh(run, other))


def _of_other_numbers(checker: LawChecker, run: Run, before: Mismatch):
    return Finding(
        contradiction.CARD,
        (run.file,),
        checker.law.outputs,
        {},
        0.8,
        "it follows a controller of other gains, or of another velocity, than"
        " the scenario's",
        severity="warning",
        before=before.total,
    )


def _unexplained(checker: LawChecker, run: Run, before: Mismatch) -> Finding:
    """Another geometry where the lengths at rest say so, else no name."""
    worst = int(np.nanargmax(before.squares))
    name, size = checker.law.outputs[worst], before.squares[worst] ** 0.5
    if _is_moved(checker, run):
        largest = float(np.abs(checker.law.rest_error(run)).max())
        return Finding(
            other_geometry.CARD,
            (run.file,),
            (),
            {"largest_m": largest},
            0.95,
            f"leg lengths at rest differ by up to {1e3 * largest:.3g} mm",
            before=before.total,
        )
    return Finding(
        contradiction.CARD,
        (run.file,),
        (name,),
        {},
        0.8,
        f"it is {size:.3g} noise floors off what the controller makes of"
        " the recorded readings and reference",
        severity="warning",
        is_decisive=checker.law.is_exact,
        before=before.total,
    )
