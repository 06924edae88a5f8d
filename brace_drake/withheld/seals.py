"""Seals and commitments: given now, checked later, not read before.

A seal is the SHA-256 of a secret salt followed by the document as canonical
JSON; the salt keeps anyone from trying the few possible answers. Seals fix
the truth of cases before they are answered, a commitment the answers before
the truth is opened.
"""

from __future__ import annotations

import hashlib
import json
import re
import secrets
from datetime import UTC, datetime
from pathlib import Path

import yaml

from brace_drake.core.errors import BraceError
from brace_drake.core.output import WriteJson, WriteText
from brace_drake.core.reading import LoadJson, LoadYaml, ReadBytes, in_file

SEALS, ANSWERS, COMMITMENT = "SEALS.yaml", "answers.json", "COMMITMENT"
VAULT_FORMAT, ANSWERS_FORMAT = "brace-vault/1", "brace-answers/1"
# Names of cases, each of which is a folder.
_CASE = re.compile(r"[A-Za-z0-9][\w.+-]{0,99}", re.ASCII)


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
    for name in seals:
        # Answers are written to a folder of this name.
        if not _CASE.fullmatch(str(name)):
            raise AnswerError(
                f"{path}: seals: case {str(name)!r}; allowed: letters, digits,"
                " _, -, . and +, beginning with a letter or digit"
            )
    return {str(name): str(value) for name, value in seals.items()}


def read_cases(path: Path, wanted: str) -> dict:
    """What a vault or answers of a format hold of each case.

    Raises:
        AnswerError: The file is missing or of another format.
    """
    document = LoadJson(path, AnswerError)
    cases = document.get("cases") if isinstance(document, dict) else None
    if not isinstance(cases, dict) or document.get("format") != wanted:
        raise AnswerError(f"{path}: not a {wanted} document")
    return cases


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
        if not isinstance(earlier, list):
            raise AnswerError(f"{path}: earlier is {earlier!r}, not a list")
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
