"""A session: what one diagnosis says, as far as a trend needs it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from brace_drake.core.errors import CampaignError, quoted
from brace_drake.core.places import real_path
from brace_drake.core.reading import LoadJson
from brace_drake.recording.fields import take
from brace_drake.trend import form

DIAGNOSIS = "diagnosis.json"
# Years of a recording; no zone of the earth and no axis of time leaves those
# that a date can have.
_YEARS = range(1900, 2200)
_DATE = (
    f"a date from {_YEARS[0]} to {_YEARS[-1]}, as in 2026-03-31 or"
    " 2026-03-31T14:30"
)


@dataclass(frozen=True)
class Estimate:
    """A parameter as one session estimates it.

    Attributes:
        name, unit: As diagnosis.json has them.
        of: The effect that it is of; "subject" of the subject.
        value, error: In that unit; no error where the data say nothing of it.
        lower95, upper95: Its interval.
        nominal: Of the scenario, for a subject.
        at_limit: Whether the fit ended at a limit, where intervals mean little.
    """

    name: str
    unit: str
    of: str
    value: float
    error: float | None
    lower95: float | None
    upper95: float | None
    nominal: float | None
    at_limit: bool

    @property
    def why_left_out(self) -> str:
        """Why it cannot be compared with others; empty where it can."""
        if self.at_limit:
            return "at its limit"
        if self.error is None or not self.error > 0.0:
            return "without an interval"
        return ""


@dataclass(frozen=True)
class NamedEffect:
    """An effect that a verdict names, with its own probability."""

    name: str
    title: str
    probability: float
    closes: float | None
    parameters: tuple[Estimate, ...]


@dataclass(frozen=True)
class Session:
    """One diagnosis of a machine.

    Attributes:
        name, folder: Where it was found.
        date: Of the recording; None where it is not known.
        device, subject: What was recorded.
        scenario: Text that is the same for the same nominal twin.
        data_sha256: Of the recordings.
        sentence, probability, gap, outside, faulty: The verdict; faulty where
            the recording itself has a fault that explains the gap.
        effects: That the verdict names.
        ambiguous: Effects that could stand in their place.
        parameters: Of the subject.
        shrink: Numbers of the gap on validation runs; empty without such.
    """

    name: str
    folder: Path
    date: datetime | None
    device: str
    subject: str
    scenario: str
    data_sha256: str
    sentence: str
    probability: float
    gap: bool
    outside: bool
    faulty: bool
    effects: tuple[NamedEffect, ...]
    ambiguous: tuple[str, ...]
    parameters: tuple[Estimate, ...]
    shrink: dict

    def with_date(self, date: datetime | None) -> Session:
        """The same session at a date."""
        return replace(self, date=date)

    def names(self, effect: str) -> bool | None:
        """Whether its verdict names an effect; None where it leaves that open:
        an effect that could be the one that is named, a gap that none
        explains, or a faulty recording.
        """
        if any(e.name == effect for e in self.effects):
            return True
        if effect in self.ambiguous or self.outside or self.faulty:
            return None
        return False

    def estimates(self) -> tuple[Estimate, ...]:
        """Those of the subject, then those of the effects that are named."""
        own = (e.parameters for e in self.effects)
        return (*self.parameters, *(p for some in own for p in some))

    def wrong(self, effect: str) -> float:
        """Probability that what it says of an effect is wrong."""
        own = [e.probability for e in self.effects if e.name == effect]
        return 1.0 - (own[0] if own else self.probability)


def LoadSession(folder: Path) -> Session:
    """Reads the diagnosis.json of a folder.

    Raises:
        CampaignError: One line: file, key, value, what is allowed.
    """
    path = folder / DIAGNOSIS
    return session_of(LoadJson(path, CampaignError), folder, str(path))


def session_of(document: Any, folder: Path, source: str) -> Session:
    """A session from the content of a diagnosis.json.

    Args:
        document: Its content.
        folder: Where it is, or the campaign that it is of.
        source: Named in errors.

    Raises:
        CampaignError: One line: source, key, value, what is allowed.
    """
    head = _taken(document, form.HEAD, source, "")
    verdict = _taken(head["verdict"], form.VERDICT, source, "verdict.")
    own = head["subject"].get("parameters")
    parameters = _estimates(own, "subject", source, "subject.parameters")
    provenance = head["provenance"]
    shrink = head.get("shrink") or {}
    return Session(
        name=real_path(folder).name or "session",
        folder=folder,
        date=_date_of(document, source),
        device=head["device"],
        subject=head["subject_name"],
        scenario=_scenario_of(provenance),
        data_sha256=str(provenance.get("data_sha256") or ""),
        sentence=verdict["sentence"],
        probability=verdict["probability"],
        gap=verdict["gap"],
        outside=verdict["outside_library"],
        faulty=bool(verdict.get("recording")),
        effects=_effects(verdict["supported"], source),
        ambiguous=tuple(verdict["ambiguous_with"]),
        parameters=parameters,
        shrink=_taken(shrink, form.SHRINK, source, "shrink.") if shrink else {},
    )


def _taken(values, fields, source: str, at: str) -> dict[str, Any]:
    if not isinstance(values, dict):
        wanted = f"a map of keys, format {form.FORMAT}"
        raise CampaignError(
            f"{source}: {at or 'the whole text'} is"
            f" {quoted(values)}; allowed: {wanted}"
        )
    taken, faults = take(values, fields)
    if faults:
        name, wanted, value = faults[0]
        raise CampaignError(
            f"{source}: {at}{name} is {quoted(value)}; allowed: {wanted}"
        )
    return taken


def _effects(rows: Sequence[dict], source: str) -> tuple[NamedEffect, ...]:
    found, names = [], _names_of(rows)
    for i, row in enumerate(rows):
        at = f"verdict.supported[{i}]."
        taken = _taken(row, form.SUPPORTED, source, at)
        name = names[i]
        own = _estimates(taken["parameters"], name, source, f"{at}parameters")
        share, closes = taken["probability"], taken.get("closes")
        found.append(NamedEffect(name, taken["title"], share, closes, own))
    _check_once([e.name for e in found], source, "verdict.supported: effect")
    return tuple(found)


def _names_of(rows: Sequence[dict]) -> list[str]:
    """Of named effects; with its place where one is there at several."""
    names = [row.get("effect") for row in rows]
    places = [row.get("form") for row in rows]
    return [
        f"{name} ({at})" if at and names.count(name) > 1 else name
        for name, at in zip(names, places, strict=True)
    ]


def _estimates(rows, of: str, source: str, at: str) -> tuple[Estimate, ...]:
    if not form.MAPS.accepts(rows):
        raise CampaignError(
            f"{source}: {at} is {quoted(rows)}; allowed: {form.MAPS.wanted}"
        )
    found = []
    for i, row in enumerate(rows):
        taken = _taken(row, form.PARAMETER, source, f"{at}[{i}].")
        _check_interval(taken, source, f"{at}[{i}].")
        found.append(
            Estimate(
                taken["name"],
                taken["unit"],
                of,
                float(taken["value"]),
                taken.get("standard_error"),
                taken.get("lower95"),
                taken.get("upper95"),
                taken.get("nominal"),
                taken["at_limit"],
            )
        )
    _check_once([e.name for e in found], source, f"{at}: name")
    return tuple(found)


def _check_interval(taken: dict, source: str, at: str) -> None:
    low, high = taken.get("lower95"), taken.get("upper95")
    if low is not None and high is not None and low > high:
        raise CampaignError(
            f"{source}: {at}lower95 is {low:g}; allowed: a number up to"
            f" upper95, {high:g}"
        )


def _check_once(names: Sequence[str], source: str, what: str) -> None:
    twice = [name for i, name in enumerate(names) if name in names[:i]]
    if twice:
        raise CampaignError(
            f"{source}: {what} {quoted(twice[0])} is there twice; allowed: once"
        )


def _scenario_of(provenance: dict) -> str:
    """What tells its nominal twin from others, as far as it is written."""
    found = provenance.get("scenario_sha256", provenance.get("scenario"))
    if isinstance(found, dict):
        found = found.get("sha256")
    return str(found or "")


def _date_of(document: dict, source: str) -> datetime | None:
    found = document["provenance"].get("recorded")
    return None if found is None else parse_date(found, source)


def parse_date(text: object, source: str) -> datetime:
    """A date as in 2026-03-31 or 2026-03-31T14:30, in UTC where it has a zone.

    Raises:
        CampaignError: It is none.
    """
    try:
        found = datetime.fromisoformat(str(text).strip())
    except ValueError:
        found = None
    if found is None or found.year not in _YEARS:
        raise CampaignError(
            f"{source}: date is {quoted(text)}; allowed: {_DATE}"
        )
    if found.tzinfo is not None:
        found = found.astimezone(UTC).replace(tzinfo=None)
    return found
