"""Seals and commitments: given now, checked later, not read before.

A seal is the SHA-256 of a secret salt followed by the document as canonical
JSON; the salt keeps anyone from trying the few possible answers. Seals fix
the truth of cases before they are answered, a commitment the answers before
the truth is opened.
"""

from __future__ import annotations

import hashlib
import json
import secrets
from datetime import UTC, datetime
from pathlib import Path

import yaml

from brace_drake.core.errors import BraceError
from brace_drake.core.output import WriteJson, WriteText
from brace_drake.core.reading import LoadJson, LoadYaml, ReadBytes, in_file

SEALS, ANSWERS, COMMITMENT = "SEALS.yaml", "answers.json", "COMMITMENT"
VAULT_FORMAT, ANSWERS_FORMAT = "brace-vault/1", "brace-answers/1"
_CASE_KEYS = {
    VAULT_FORMAT: {"truth", "salt"},
    ANSWERS_FORMAT: {"verdict", "closed"},
}


class SealError(BraceError, ValueError):
    """A sealed document is not the one that was sealed."""


class AnswerError(BraceError, ValueError):
    """Cases or answers are missing or unreadable."""


def new_salt() -> str:
    """32 random bytes of the operating system, in hexadecimal."""
    return secrets.token_hex(32)


def seal(document: object, salt: str) -> str:
    """The seal of a document."""
    text = json.dumps(
        document, sort_keys=True, separators=(",", ":"), allow_nan=False
    )
    return hashlib.sha256((salt + text).encode()).hexdigest()


def check_seal(name: str, document: object, salt: str, sealed: str) -> None:
    """Compares a document with its seal.

    Raises:
        SealError: It is another one.
    """
    if seal(document, salt) != sealed:
        raise SealError(f"{name}: not the document that was sealed")


def read_seals(folder: Path) -> dict[str, str]:
    """Seal of each case.

    Raises:
        AnswerError: The folder holds no readable SEALS.yaml.
    """
    path = Path(folder) / SEALS
    seals = LoadYaml(path, AnswerError).get("seals")
    if not isinstance(seals, dict):
        raise AnswerError(f"{path}: holds no seals")
    return {str(name): str(value) for name, value in seals.items()}


def read_cases(path: Path, wanted: str) -> dict:
    """What a vault or answers of a format hold of each case.

    Raises:
        AnswerError: The file is missing or of another format.
    """
    document = LoadJson(path, AnswerError)
    if not isinstance(document, dict) or not _are_cases(document, wanted):
        raise AnswerError(f"{path}: not a {wanted} document")
    return document["cases"]


def _are_cases(document: dict, wanted: str) -> bool:
    cases, keys = document.get("cases"), _CASE_KEYS[wanted]
    return (
        document.get("format") == wanted
        and isinstance(cases, dict)
        and all(isinstance(c, dict) and keys <= {*c} for c in cases.values())
    )


def digest_of(path: Path) -> str:
    """SHA-256 of a file's bytes.

    Raises:
        AnswerError: It cannot be read.
    """
    with in_file(path, AnswerError):
        return hashlib.sha256(ReadBytes(path)).hexdigest()


def commit(folder: Path, answers: Path, cases: dict) -> None:
    """Writes the answers and a hash that binds them to the seals.

    Hashes of answers that these replace, as a case that had failed was tried
    again, stay in the file.

    Args:
        folder: Of the cases and their seals.
        answers: Folder to write to.
        cases: Answer by case.
    """
    path = answers / COMMITMENT
    before = LoadYaml(path, AnswerError) if path.exists() else None
    WriteJson(answers / ANSWERS, {"format": ANSWERS_FORMAT, "cases": cases})
    lines: dict[str, object] = {
        "answers_sha256": digest_of(answers / ANSWERS),
        "seals_sha256": digest_of(folder / SEALS),
        "committed_at": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    if before is not None:
        if before.get("answers_sha256") == lines["answers_sha256"]:
            return
        earlier = before.pop("earlier", [])
        lines["earlier"] = [*earlier, before]
    WriteText(path, yaml.safe_dump(lines, sort_keys=False))


def check_commitment(folder: Path, answers: Path) -> None:
    """Compares answers and seals with what was committed to.

    Raises:
        SealError: One was changed since.
        AnswerError: There is no commitment.
    """
    path = answers / COMMITMENT
    committed = LoadYaml(path, AnswerError)
    expected = committed.get("answers_sha256"), committed.get("seals_sha256")
    if None in expected:
        raise AnswerError(f"{path}: no commitment")
    kept = answers / ANSWERS, folder / SEALS
    for file, digest in zip(kept, expected, strict=True):
        if digest_of(file) != digest:
            raise SealError(f"{file}: changed since the commitment")
