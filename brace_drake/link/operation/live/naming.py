"""Causes looked for in a process of its own, so that no tick waits for it."""

from __future__ import annotations

import contextlib
import os
import pickle
import sys
import threading

from brace_drake.core.child import EndChild, StartChild
from brace_drake.core.errors import BraceError
from brace_drake.monitoring.causes import NamedCause
from brace_drake.monitoring.prepare import Expected, Namer
from brace_drake.monitoring.watch import Since

# What drives the device comes first.
_NICE, _ENDS = 10, 5.0


class NamingProcess:
    """A `Namer` that may fail, hang or be killed: then nothing is named.

    Attributes:
        causes: The last answer, likeliest first.
        seen: Rows that it was made of; 0 before the first.
        is_busy: Whether a question is not answered yet.
    """

    def __init__(self, expected: Expected):
        self.causes: list[NamedCause] = []
        self.seen, self.is_busy = 0, True
        self._child = StartChild(__name__)
        self._question: Since | None = None
        self._asked, self._closed = threading.Event(), False
        threading.Thread(
            target=self._Talk, args=(expected,), daemon=True
        ).start()

    def Ask(self, since: Since) -> None:
        """Asks what has begun, unless it is busy; the answer comes later."""
        if not self.is_busy:
            self.is_busy, self._question = True, since
            self._asked.set()

    def Forget(self) -> None:
        """Drops the answer, as of what has gone."""
        self.causes, self.seen = [], 0

    def _Talk(self, expected: Expected) -> None:
        """Waits for the child, in a thread of its own."""
        given, told = self._child.stdin, self._child.stdout
        with contextlib.suppress(OSError, EOFError, pickle.PickleError):
            pickle.dump(expected, given)
            given.flush()
            pickle.load(told)
            while not self._closed:
                self.is_busy = False
                self._asked.wait()
                self._asked.clear()
                question = self._question
                if self._closed or question is None:
                    return
                pickle.dump(question, given)
                given.flush()
                causes = pickle.load(told)
                if causes:
                    self.causes, self.seen = causes, len(question.rows)

    def __enter__(self) -> NamingProcess:
        return self

    def __exit__(self, *_) -> None:
        """Ends it."""
        self._closed = True
        self._asked.set()
        EndChild(self._child, _ENDS)


def _Serve() -> None:
    """Answers until nothing more is asked."""
    os.nice(_NICE)
    given, told = sys.stdin.buffer, sys.stdout.buffer
    namer = Namer(pickle.load(given))
    namer.WarmUp()

    def answer(value) -> None:
        pickle.dump(value, told)
        told.flush()

    answer(None)
    while True:
        try:
            since = pickle.load(given)
        except EOFError:
            return
        try:
            answer(namer.Name(since))
        except (BraceError, ValueError, ArithmeticError):
            # Of so little no cause is told; of more perhaps.
            answer([])


if __name__ == "__main__":
    _Serve()
