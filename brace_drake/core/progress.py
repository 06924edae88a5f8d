"""Progress of long work: a bar on a terminal, else a line now and then."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

from tqdm import tqdm

_BAR = "{desc} {bar:30} {n:3.0f} % [{elapsed}<{remaining}]"
_LINE = "{desc} {n:3.0f} % [{elapsed}<{remaining}]"
# A log has a line at most every so often, s.
LINE_S = 30.0


class _Lines(tqdm):
    """Prints whole lines, and few of them: for pipes and logs."""

    def __init__(self, *args: Any, **options: Any):
        self._told, self._has_told = time.monotonic(), False
        super().__init__(*args, **options)

    def display(self, msg: str | None = None, pos: int | None = None) -> None:
        """A line, unless there was one just before; none to clear a bar."""
        now = time.monotonic()
        if msg == "" or now - self._told < LINE_S:
            return
        self._told, self._has_told = now, True
        self._write()

    def end(self) -> None:
        """A last line where there were others: all of it is done."""
        self.set_description(f"{'done':<28}", refresh=False)
        self.n = self.total
        if self._has_told:
            self._write()

    def _write(self) -> None:
        with contextlib.suppress(OSError, ValueError):
            self.fp.write(f"{str(self).strip()}\n")
            self.fp.flush()

    def close(self) -> None:
        """Ends; there is nothing to clear."""
        self.sp = None
        super().close()


def open_bar(line: str | None = None, **options: Any) -> tqdm:
    """A bar on standard error that leaves nothing behind on a terminal.

    Args:
        line: Form of the lines where standard error is no terminal; None: as
            the bar's.
        options: Of tqdm.
    """
    if sys.stderr is not None and sys.stderr.isatty():
        return tqdm(leave=False, **options)
    if line is not None:
        options["bar_format"] = line
    # Else each change would be formatted, and most of them dropped.
    return _Lines(leave=False, disable=sys.stderr is None, **options)


def part_of(
    say: Callable[[str, float], None], begin: float, end: float
) -> Callable[[str, float], None]:
    """Progress of a part, told as that of the whole."""
    return lambda what, share: say(what, begin + (end - begin) * share)


@contextlib.contextmanager
def share_bar() -> Iterator[Callable[[str, float], None]]:
    """A progress bar; yields a function of what is done and its share."""
    with open_bar(_LINE, total=100, unit="%", bar_format=_BAR) as bar:

        def progress(what: str, share: float) -> None:
            bar.set_description(f"{what:<28.28}", refresh=False)
            bar.n = round(100 * share)
            bar.refresh()

        yield progress
        if isinstance(bar, _Lines):
            bar.end()
