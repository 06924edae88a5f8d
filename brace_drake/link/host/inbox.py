"""Messages that came in, between the reading thread and those that wait."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from brace_drake.link.protocol.codec import Packet

_MOST_FAULTS = 100


class Inbox:
    """The newest message of each name, until it is forgotten.

    Attributes:
        error: What ended the reading, None while it goes on.
    """

    def __init__(self):
        self.error: Exception | None = None
        self._news = threading.Condition()
        self._newest: dict[str, Packet] = {}
        self._faults: list[Packet] = []

    def __getitem__(self, name: str) -> Packet:
        """The newest message of a name."""
        return self._newest[name]

    @property
    def fault(self) -> Packet | None:
        """The last fault, None before the first; never forgotten."""
        return self._faults[-1] if self._faults else None

    def Put(self, packet: Packet) -> None:
        """Takes a message; wakes who waits."""
        with self._news:
            if packet.name == "FAULT":
                self._faults = [*self._faults[1 - _MOST_FAULTS :], packet]
            self._newest[packet.name] = packet
            self._news.notify_all()

    def End(self, error: Exception) -> None:
        """Nothing more will come; wakes who waits."""
        with self._news:
            self.error = error
            self._news.notify_all()

    def Forget(self, *names: str) -> None:
        """Makes room for new messages of these names."""
        with self._news:
            for name in names:
                self._newest.pop(name, None)

    def WaitFor(
        self, names: Sequence[str], timeout: float, asked: Sequence[int] = ()
    ) -> bool:
        """Whether messages of all names come in time.

        Args:
            names: Of the messages.
            timeout: s.
            asked: Sequences of the requests of which the first must answer
                one, where it says what it answers; none: any.
        """

        def here() -> bool:
            if self.error is not None:
                return True
            if any(name not in self._newest for name in names):
                return False
            values = self._newest[names[0]].values
            told = getattr(values, "sequence_answered", None)
            return told is None or not asked or told in asked

        with self._news:
            return self._news.wait_for(here, timeout) and self.error is None
