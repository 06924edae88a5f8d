"""Sets of effects that a search has come by, and those that it goes on from."""

from __future__ import annotations

from collections.abc import Sequence

from brace_drake.effects.card import Effect
from brace_drake.identification.fits import CandidateFit
from brace_drake.selection import thresholds
from brace_drake.selection.criterion import Criterion, refined
from brace_drake.selection.search.candidate import Candidate
from brace_drake.selection.search.linearisation import Linearisation
from brace_drake.selection.search.screening import Say, others, screen


def beam_of(
    criterion: Criterion, known: Sequence[CandidateFit], number: int
) -> list[CandidateFit]:
    """The sets that leave least, of which larger ones are made; none of effects
    by the dozen, and none again.
    """
    ended = sorted(refined(known), key=criterion.score)
    best: dict[frozenset[str], CandidateFit] = {}
    for fit in ended:
        best.setdefault(keys_of(fit.effects), fit)
    able = [
        f
        for f in refined([*best.values()])
        if 0 < len(criterion.findings(f)) <= number
        and not f.is_flexible
        and not any(has_one_more(larger, f) for larger in ended)
    ]
    if not able:
        return []
    most = thresholds.NEAR * max(0.0, able[0].excess)
    near = [f for f in able if f is able[0] or f.excess <= most]
    return near[: thresholds.BEAM if number == 1 else 1]


def untried(
    lines: Linearisation, known: Sequence[CandidateFit]
) -> list[Effect]:
    """Effects that in no form were led to their end beside a fit yet."""
    base, mine = lines.base, keys_of(lines.base.effects)
    larger = ended_beside(base, known)
    done = {e.cause for f in larger for e in f.effects if e.key not in mine}
    more = others(lines.evaluator.effects, base)
    return [e for e in more if e.cause not in done]


def screen_fresh(
    lines: Linearisation,
    effects: Sequence[Effect],
    known: Sequence[CandidateFit],
    say: Say,
    most: float,
) -> list[Candidate]:
    """The base of a linearisation with each further effect, of those that were
    not led to their end before, that is predicted to leave less than `most`.

    Args:
        lines: Where the search sets out from.
        effects: Those that may be added.
        known: Fits before.
        say: Progress.
        most: Sum of squares above noise, strained.
    """
    base = lines.base
    done = {keys_of(f.effects) for f in known if f.refined}
    more = others(effects, base)
    fresh = [e for e in more if keys_of((*base.effects, e)) not in done]
    return [c for c in screen(lines, fresh, say) if c.predicted < most]


def ended_beside(
    base: CandidateFit, fits: Sequence[CandidateFit]
) -> list[CandidateFit]:
    """Those that were led to their end and have one effect more than a base."""
    return [f for f in fits if f.refined and has_one_more(f, base)]


def has_one_more(fit: CandidateFit, base: CandidateFit) -> bool:
    """Whether a fit has just one effect more than a base."""
    is_larger = len(fit.effects) == len(base.effects) + 1
    return is_larger and keys_of(base.effects) <= keys_of(fit.effects)


def keys_of(effects: Sequence[Effect]) -> frozenset[str]:
    """Their keys, which tell forms of one effect apart."""
    return frozenset(e.key for e in effects)
