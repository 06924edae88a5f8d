"""Which sessions belong to one trend, and in which order they come."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from brace_drake.core.errors import CampaignError, quoted
from brace_drake.core.places import real_path
from brace_drake.recording.columns import BENCH, BRACE
from brace_drake.trend.sessions import DIAGNOSIS, Session, parse_date

# Their nominal numbers come from a scenario; others' from each recording.
_OF_SCENARIO = (BENCH, BRACE)


@dataclass(frozen=True)
class Timeline:
    """Sessions in order, and where they lie in time.

    Attributes:
        sessions: The earliest first.
        times: Days since the first; numbers from 0 where no dates are known.
        unit: "d" or "session".
        source: Where the times come from, in words.
    """

    sessions: tuple[Session, ...]
    times: tuple[float, ...]
    unit: str
    source: str


def parse_dates(text: str, count: int) -> list[datetime]:
    """The dates of the option --dates, one for each of `count` folders.

    Raises:
        CampaignError: Not as many dates, or one that is none.
    """
    words = [word.strip() for word in text.split(",")]
    if len(words) != count:
        raise CampaignError(
            f"--dates has {len(words)} dates for {count} folders; allowed: one"
            " for each folder, in its order"
        )
    return [parse_date(word, "--dates") for word in words]


def make_timeline(
    sessions: Sequence[Session], source: str | None = None
) -> Timeline:
    """Sessions of one trend in their order.

    Args:
        sessions: In the order in which they were given.
        source: Where their dates come from; None: from the recordings.

    Raises:
        CampaignError: Fewer than two, one that is there twice, a parameter in
            several units, or dates of some of them only.
    """
    if len(sessions) < 2:
        raise CampaignError(
            f"{_place(sessions)}one session; a trend needs two or more"
        )
    _check_different(sessions)
    _check_units(sessions)
    source = f"dates of {source or 'the recordings'}"
    undated = [s for s in sessions if s.date is None]
    if undated and len(undated) < len(sessions):
        raise CampaignError(
            f"{undated[0].folder}: no date, and others have one; allowed:"
            " `recorded` in each campaign.yaml, or --dates for all"
        )
    if undated:
        times = tuple(float(i) for i in range(len(sessions)))
        source = "no dates are known: sessions are in the order given"
        return Timeline(tuple(sessions), times, "session", source)
    ordered = sorted(sessions, key=lambda s: s.date or datetime.min)
    stamps = [s.date for s in ordered if s.date is not None]
    times = tuple((d - stamps[0]).total_seconds() / 86400.0 for d in stamps)
    return Timeline(tuple(ordered), times, "d", source)


def _place(sessions: Sequence[Session]) -> str:
    return f"{sessions[0].folder}: " if sessions else ""


def _check_different(sessions: Sequence[Session]) -> None:
    """Refuses the same recordings twice: they would count as agreement."""
    first: dict[str, Session] = {}
    for session in sessions:
        key = session.data_sha256 or str(real_path(session.folder))
        if key in first:
            raise CampaignError(
                f"{session.folder}: the same recordings as"
                f" {first[key].folder}; allowed: each once"
            )
        first[key] = session


def _check_units(sessions: Sequence[Session]) -> None:
    """Refuses a parameter that comes in several units."""
    first: dict[tuple[str, str], tuple[str, Session]] = {}
    for session in sessions:
        for own in session.estimates():
            unit, other = first.setdefault(
                (own.of, own.name), (own.unit, session)
            )
            if unit != own.unit:
                raise CampaignError(
                    f"{session.folder / DIAGNOSIS}: unit of {own.name} is"
                    f" {quoted(own.unit)}, that of {other.folder}"
                    f" {quoted(unit)}; allowed: one unit in a trend"
                )


def split_sessions(sessions: Sequence[Session]) -> dict[str, list[Session]]:
    """Sessions by what they are of: device, subject and scenario.

    Returns:
        Groups by a name that tells them apart, in the order of first sight.
    """
    groups: dict[tuple, list[Session]] = {}
    for session, key in zip(sessions, _identities(sessions), strict=True):
        groups.setdefault(key, []).append(session)
    keys = list(groups)
    varying = [i for i in range(3) if len({k[i] for k in keys}) > 1]
    names: dict[str, list[Session]] = {}
    for n, (key, group) in enumerate(groups.items(), start=1):
        words = [_word(key[i], i, n) for i in varying] or ["all"]
        name = "_".join(words)
        names[name if name not in names else f"{name}_{n}"] = group
    return names


def _word(value: object, what: int, number: int) -> str:
    """A part of a folder's name."""
    if what == 2:
        return f"scenario{number}"
    text = str(value) or ("device", "subject")[what]
    kept = [c if c.isalnum() or c in "-." else "_" for c in text]
    return "".join(kept).strip(".")[:60] or "other"


def check_alike(sessions: Sequence[Session]) -> None:
    """Checks that sessions are of one device, subject and scenario.

    Raises:
        CampaignError: They are not; the message says what differs.
    """
    first = sessions[0]
    own, *others = _identities(sessions)
    for session, other in zip(sessions[1:], others, strict=True):
        told = ", or --split for a trend of each"
        for i, what in enumerate(("device", "subject")):
            if own[i] != other[i]:
                raise CampaignError(
                    f"{session.folder}: {what} is {quoted(other[i])}, that of"
                    f" {first.folder} {quoted(own[i])}; allowed: one {what} in"
                    f" a trend{told}"
                )
        if own[2] != other[2]:
            raise CampaignError(
                f"{session.folder}: diagnosed with another scenario than"
                f" {first.folder}; allowed: one scenario in a trend{told}"
            )


def _identities(sessions: Sequence[Session]) -> list[tuple[str, str, tuple]]:
    """Device, subject, and what tells the scenario of each.

    Hashes of scenarios count where all diagnoses have one.
    """
    has_hashes = all(s.scenario for s in sessions)
    found = []
    for s in sessions:
        scenario: tuple = ()
        if s.device in _OF_SCENARIO:
            nominal = tuple((p.name, p.nominal) for p in s.parameters)
            scenario = (s.scenario if has_hashes else "", nominal)
        found.append((s.device, s.subject, scenario))
    return found
