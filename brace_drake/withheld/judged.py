"""One case: its truth beside the answer, and whether they agree."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

OUTSIDE, UNNAMED, RECORDING = "outside", "unnamed", "recording"
# A wrong name with a higher probability is a serious error.
_SURE = 0.8


def label(verdict: dict | None) -> str:
    """A verdict in a word: none, failed, or the effects named joined by +, with
    outside as the last of them where something is left that the library has
    not; unnamed where a method names no effects; recording where the recording
    is at fault, not the machine.
    """
    if verdict is None:
        return "failed"
    if verdict.get("recording"):
        return RECORDING
    if not verdict["gap"]:
        return "none"
    if verdict["effects"] is None:
        return UNNAMED
    return _joined(verdict["effects"], verdict["outside_library"])


def _joined(effects: Iterable[str], outside: bool) -> str:
    """Effects as one word; without any, outside."""
    names = sorted(effects)
    return "+".join([*names, OUTSIDE] if outside or not names else names)


def _name_of(cause: str) -> str:
    """Of an effect that is told with its place."""
    return cause.partition(" (")[0]


@dataclass(frozen=True)
class Judged:
    """A case with its answer.

    Attributes:
        name: Of the case.
        truth: As it was sealed.
        verdict: As diagnosed, None where the diagnosis failed.
        closed: Share of the gap that the diagnosis closed, if it says so.
        seconds: CPU time that it took, if that is known.
    """

    name: str
    truth: dict
    verdict: dict | None
    closed: float | None = None
    seconds: float | None = None

    @property
    def kind(self) -> str:
        """none, single, pair or outside."""
        return self.truth["kind"]

    @property
    def severity(self) -> str | None:
        """small, medium, large; None with nothing wrong."""
        return self.truth["severity"]

    @property
    def expected(self) -> str:
        """The right answer in a word."""
        if self.kind in ("none", OUTSIDE):
            return self.kind
        return _joined(self.truth["effects"], outside=False)

    @property
    def given(self) -> str:
        """The answer in a word."""
        return label(self.verdict)

    @property
    def right(self) -> bool:
        """Whether the answer is the right one, in full."""
        return self.given == self.expected

    @property
    def named(self) -> set[str]:
        """Effects that the verdict names first."""
        return set(self.verdict["effects"] or ()) if self.verdict else set()

    @property
    def names_effects(self) -> bool:
        """Whether the method names effects at all."""
        return self.given != UNNAMED

    @property
    def errs_surely(self) -> bool:
        """Whether an effect or a recording fault is named that is not there,
        and held probable.
        """
        wrong = self.named - set(self.truth["effects"])
        errs = bool(wrong) or self.given == RECORDING
        return errs and (self.probability or 0.0) > _SURE

    @property
    def answers(self) -> list[str]:
        """The verdict and all it calls possible, each a word like `given`."""
        verdict = self.verdict
        if verdict is None or self.given in (
            "none",
            OUTSIDE,
            UNNAMED,
            RECORDING,
            "failed",
        ):
            return []
        outside = verdict["outside_library"]
        rivals = verdict.get("ambiguous_with", [])
        others = (_joined(map(_name_of, r.split("+")), outside) for r in rivals)
        return list(dict.fromkeys([self.given, *others]))

    @property
    def covered(self) -> bool:
        """Whether the right answer is among those called possible."""
        return self.expected in self.answers

    @property
    def accused(self) -> set[str]:
        """Blocks where the verdict says that the gap lies."""
        return set(self.verdict["blocks"]) if self.verdict else set()

    @property
    def blocks_right(self) -> bool:
        """Whether exactly the right blocks are accused."""
        return self.accused == set(self.truth["blocks"])

    @property
    def accuses_rightly(self) -> bool:
        """Whether a block is accused, and none that is innocent."""
        return bool(self.accused) and self.accused <= set(self.truth["blocks"])

    @property
    def probability(self) -> float | None:
        """How sure the diagnosis is."""
        return self.verdict["probability"] if self.verdict else None

    @property
    def floors(self) -> float | None:
        """How many noise floors the gap has once the subject is refitted."""
        faults = self.truth["floors"]["faults"]
        return faults["refitted"] if faults else None

    def is_detectable(self, least: float) -> bool:
        """Whether the gap stands out by so many floors."""
        return self.floors is not None and self.floors >= least

    def is_each_detectable(self, least: float) -> bool:
        """Whether each of two effects stands out so far beside the other;
        not where their truth does not tell.
        """
        beside = self.truth["floors"].get("beside")
        return bool(beside) and all(
            size["refitted"] >= least for size in beside.values()
        )
