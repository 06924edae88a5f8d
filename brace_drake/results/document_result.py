"""A result that is one document, and one file."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

from brace_drake.core.output import MakeFolder, WriteJson


class DocumentResult:
    """A document of plain types and its file.

    Attributes:
        FILE: Name of the file.
        document: Its content.
    """

    FILE: ClassVar[str]

    def __init__(self, document: dict[str, Any]):
        self.document = document

    def save(self, folder: str | Path) -> Path:
        """Writes the file into a folder, which is made; returns the file.

        Raises:
            OutputError: It cannot be written.
        """
        file = MakeFolder(Path(folder)) / self.FILE
        WriteJson(file, self.document)
        return file
