"""Cases: which subject, which flaws, and what a perfect answer would say."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from brace_drake.withheld.faults import (
    FAULTS,
    OUTSIDE,
    SEVERITIES,
    Fault,
    severities,
    vary,
)
from brace_drake.withheld.simulator import Flaws, Subject, with_flaws
from brace_drake.withheld.tolerances import Deviations, draw_deviations

KINDS = ("none", "outside", "pair", "single")
# Shares of the kinds among many cases.
SHARES = (0.2, 0.2, 0.2, 0.4)
# Subjects are within these multiples of the nominal one.
_SUBJECT = (0.7, 1.5)
# Imperfections that every machine has, well below the noise floor.
_LEG_MASS = 0.04  # kg
_ANCHORS = 2e-6  # m
_COLOUR = 0.06


@dataclass(frozen=True)
class Case:
    """One withheld case.

    Attributes:
        kind: One of KINDS.
        faults: What is wrong with it, none to two.
        severity: Of all its faults; None where there is none.
        subject: Who or what is in the brace.
        background: Flaws that every machine has.
        changes: What the faults changed, per fault.
        off: How far the machine is off within its tolerances.
    """

    kind: str
    faults: tuple[Fault, ...]
    severity: str | None
    subject: Subject
    background: Flaws
    changes: dict[str, dict] = field(default_factory=dict)
    off: Deviations = Deviations()

    @property
    def machine(self) -> Flaws:
        """The machine before anything went wrong with it."""
        return self.without(*self.faults)

    @property
    def flaws(self) -> Flaws:
        """The machine with its faults."""
        return self.without()

    def truth(self) -> dict:
        """What a perfect diagnosis says, and what made the case."""
        outside = self.kind == "outside"
        truth = {
            "kind": self.kind,
            "severity": self.severity,
            "effects": sorted(f.name for f in self.faults if not outside),
            "outside": sorted(f.name for f in self.faults if outside),
            "blocks": sorted({f.block for f in self.faults}),
            "parameters": self.changes,
            "subject": self.subject._asdict(),
        }
        if self.off.added:
            truth["within_tolerances"] = self.off.truth()
        return truth

    def without(self, *faults: Fault) -> Flaws:
        """The flaws with some of the faults left out.

        A fault sets a number, the machine's deviation adds to that.
        """
        out, flaws = {f.name for f in faults}, self.background
        for name, change in self.changes.items():
            if name not in out:
                flaws = with_flaws(flaws, change)
        return self.off.on(flaws)


def draw_kinds(rng: np.random.Generator, count: int) -> list[str]:
    """Kinds of `count` cases in random order, in SHARES as near as can be."""
    exact = np.array(SHARES) * count
    whole = np.floor(exact).astype(int)
    rest = exact - whole
    for _ in range(count - whole.sum()):
        chance = rng.choice(len(KINDS), p=rest / rest.sum())
        whole[chance] += 1
        rest[chance] = 0.0
    kinds = [k for k, n in zip(KINDS, whole, strict=True) for _ in range(n)]
    return [str(k) for k in rng.permutation(kinds)]


def draw_subject(rng: np.random.Generator) -> Subject:
    """A subject, each number apart from the others."""
    return Subject(*(float(v * rng.uniform(*_SUBJECT)) for v in Subject()))


def draw_background(rng: np.random.Generator) -> Flaws:
    """The small imperfections of one machine."""
    return with_flaws(
        Flaws(),
        {
            "ring.leg_mass": rng.uniform(0.0, _LEG_MASS),
            "ring.lower": _ANCHORS * rng.standard_normal((6, 3)),
            "ring.upper": _ANCHORS * rng.standard_normal((6, 3)),
            "sensors.colour": rng.uniform(0.0, _COLOUR),
        },
    )


def draw_faults(
    rng: np.random.Generator, kind: str, tolerances: float = 0.0
) -> tuple[tuple[Fault, ...], str | None]:
    """Faults of a case and their severity, beside that multiple of the
    tolerances.
    """
    if kind == "none":
        return (), None
    severity = str(rng.choice(severities(tolerances)))
    if kind == "outside":
        return (OUTSIDE[rng.integers(len(OUTSIDE))],), severity
    if kind == "single":
        return (FAULTS[rng.integers(len(FAULTS))],), severity
    while True:
        pair = tuple(FAULTS[i] for i in rng.choice(len(FAULTS), 2, False))
        # Two faults that set the same number would be one.
        fields = [set(f.make(np.random.default_rng(0), 1.0)) for f in pair]
        if not fields[0] & fields[1]:
            return pair, severity


def build_case(
    rng: np.random.Generator,
    kind: str,
    faults: tuple[Fault, ...],
    severity: str | None,
    largest_command,
    tolerances: float = 0.0,
) -> Case:
    """Draws the numbers of a case.

    Args:
        rng: Of all of them.
        kind: One of KINDS.
        faults: What is wrong.
        severity: Of SEVERITIES, None without faults.
        largest_command: From a subject to the largest command, N, of the
            bench with nothing wrong.
        tolerances: Multiple of them that the machine is off by.
    """
    subject, background = draw_subject(rng), draw_background(rng)
    changes = {}
    for fault in faults:
        strength = fault.strength(SEVERITIES.index(severity), tolerances)
        change = fault.make(rng, strength * vary(rng))
        if "legs.limit" in change:
            change = {"legs.limit": strength * largest_command(subject)}
        changes[fault.name] = change
    off = draw_deviations(rng, tolerances)
    return Case(kind, faults, severity, subject, background, changes, off)
