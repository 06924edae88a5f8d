"""Exceptions of the package: every one is meant for the caller to read."""

import difflib
import re
from collections.abc import Iterable

# Characters that a terminal obeys, and those that cannot be written at all.
_HIDDEN = re.compile(
    "[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]"
)
_LONGEST = 4000
# Words beyond these are no misspelt names.
_MOST_WORDS, _LONGEST_WORD = 1000, 100


class BraceError(Exception):
    """Base of all errors that brace_drake raises on purpose."""

    def __str__(self) -> str:
        return one_line(super().__str__())


class ReadError(BraceError, ValueError):
    """A file cannot be read; the message is the reason, without the file."""


class ScenarioError(BraceError, ValueError):
    """A scenario file or value is missing, malformed or out of range."""


class KinematicsError(BraceError, ValueError):
    """Legs and rings do not fit: bad geometry, or a pose out of reach."""


class CampaignError(BraceError, ValueError):
    """A recorded campaign cannot be used; the message names the place."""


class EffectError(BraceError, ValueError):
    """An effect is unknown, registered twice, or given bad parameters."""


class FitError(BraceError, RuntimeError):
    """A fit could not be set up or its solver failed."""


class OutputError(BraceError, RuntimeError):
    """A result could not be written."""


class TorsoError(BraceError, ValueError):
    """A scan or its measures cannot be made into a torso."""


class LimitsError(BraceError, ValueError):
    """Limits are malformed, or wider than a device allows."""


class LinkError(BraceError, RuntimeError):
    """A device cannot be reached, is not ours, or has gone."""


class StoppedError(BraceError, RuntimeError):
    """A motion was stopped; the message names the cause."""


class PolicyError(BraceError, ValueError):
    """A policy, or what is needed to train or to use one, is not there."""


class ExtraError(BraceError, ImportError):
    """An optional package is needed that is not installed."""


class ClusterError(BraceError, RuntimeError):
    """A cluster cannot be reached, or has lost its workers."""


def reason(error: Exception) -> str:
    """Why a file could not be read, on one line, without number and path."""
    if isinstance(error, UnicodeDecodeError):
        return "not UTF-8 text"
    if isinstance(error, UnicodeEncodeError):
        return "no file can have that name"
    words = getattr(error, "strerror", None) or " ".join(str(error).split())
    return words or type(error).__name__


def closest(
    word: object, words: Iterable[object], likeness: float = 0.6
) -> str | None:
    """The word that was meant, None where none is as much alike, 0 to 1."""
    if len(str(word)) > _LONGEST_WORD:
        return None
    known = [w for w in map(str, words) if len(w) <= _LONGEST_WORD]
    close = difflib.get_close_matches(
        str(word), known[:_MOST_WORDS], n=1, cutoff=likeness
    )
    return close[0] if close else None


def suggest(word: object, words: Iterable[object]) -> str:
    """A hint at the word that was meant, or nothing."""
    close = closest(word, words)
    return f", did you mean {close}?" if close else ""


def quoted(value: object, length: int = 60) -> str:
    """`value` as it would be typed, on one line and not too long."""
    if type(value).__module__ == "numpy" and not getattr(value, "ndim", 1):
        value = value.item()  # type: ignore[attr-defined]
    text = " ".join(repr(value).split())
    return text if len(text) <= length else text[: length - 3] + "..."


def is_plain(text: str) -> bool:
    """Whether text has no line break and nothing that a terminal obeys."""
    return _HIDDEN.search(text) is None


def one_line(text: str) -> str:
    """Text for a terminal: one line, what it would obey as escapes."""
    if len(text) > _LONGEST:
        text = text[:_LONGEST] + "..."
    return _HIDDEN.sub(_escape, text)


def _escape(match: re.Match) -> str:
    character = match.group()
    return " " if character in "\t\n\r" else ascii(character)[1:-1]
