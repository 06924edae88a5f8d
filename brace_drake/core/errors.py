"""Exceptions of the package: every one is meant for the caller to read."""

import difflib
from collections.abc import Iterable


class BraceError(Exception):
    """Base of all errors that brace_drake raises on purpose."""


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


class ClusterError(BraceError, RuntimeError):
    """A cluster cannot be reached, or has lost its workers."""


def reason(error: Exception) -> str:
    """Why a file could not be read, on one line, without number and path."""
    if isinstance(error, UnicodeDecodeError):
        return "not UTF-8 text"
    return getattr(error, "strerror", None) or " ".join(str(error).split())


def suggest(word: object, words: Iterable[object]) -> str:
    """A hint at the word that was meant, or nothing."""
    close = difflib.get_close_matches(str(word), map(str, words), n=1)
    return f", did you mean {close[0]}?" if close else ""


def quoted(value: object, length: int = 60) -> str:
    """`value` as it would be typed, on one line and not too long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= length else text[: length - 3] + "..."
