"""Seals: what is promised now can be checked later, and not read before.

A seal is the SHA-256 of a secret salt followed by the document as canonical
JSON. The salt keeps anyone from trying the few possible answers.
"""

from __future__ import annotations

import hashlib
import json
import secrets

from brace_drake.core.errors import BraceError

SEALS = "SEALS.yaml"
VAULT_FORMAT = "brace-vault/1"


class SealError(BraceError, ValueError):
    """A sealed document is not what was promised."""


def canonical(document: object) -> str:
    """The one JSON text of a document: sorted keys, no spare blanks."""
    return json.dumps(
        document, sort_keys=True, separators=(",", ":"), allow_nan=False
    )


def new_salt() -> str:
    """32 random bytes of the operating system, in hexadecimal."""
    return secrets.token_hex(32)


def seal(document: object, salt: str) -> str:
    """The seal of a document."""
    text = salt + canonical(document)
    return hashlib.sha256(text.encode()).hexdigest()


def check_seal(name: str, document: object, salt: str, promised: str) -> None:
    """Compares a document with its seal.

    Raises:
        SealError: It is another one.
    """
    if seal(document, salt) != promised:
        raise SealError(f"{name}: not the document that was sealed")
