"""Where the large shared recordings lie, for tests that use them."""

import unittest
from pathlib import Path

SHARED = Path(__file__).resolve().parents[2] / "shared"
EXAMPLE = Path(__file__).resolve().parent / "data" / "example"


def needs_shared(name: str):
    """Skips a test, with the reason, where `../shared/{name}` is absent."""
    return unittest.skipUnless(
        (SHARED / name).exists(), f"../shared/{name} is not on this machine"
    )
