"""A pseudo-terminal's master side: the device's end of a serial line."""

from __future__ import annotations

import contextlib
import os
import select
import time
from pathlib import Path

from brace_drake.core.errors import LinkError

_DIGITS = "0123456789"


class Terminal:
    """A pseudo-terminal that a host opens as if it were a serial port.

    Attributes:
        path: Of the slave, or of the link to it.
        overruns: Frames that the host's side had no room for.
    """

    def __init__(self, link: str | Path | None = None):
        self._link = None if link is None else Path(link)
        self.overruns = 0
        self._fds: tuple[int, int] | None = None
        self.connect()

    def connect(self) -> None:
        """Makes the terminal, and the link to it where one was asked for."""
        try:
            import tty
        except ImportError as error:
            raise LinkError(
                "no pseudo-terminals on this system: the emulator needs Linux"
                " or macOS"
            ) from error
        master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(master, False)
        # The slave stays open here too, so that a host may come and go.
        self._fds = master, slave
        self.path = self._slave = os.ttyname(slave)
        if self._link is not None:
            try:
                self._MakeLink()
            except LinkError:
                self.disconnect()
                raise

    def _MakeLink(self) -> None:
        if os.path.lexists(self._link) and not self._is_left_over():
            raise LinkError(
                f"{self._link}: exists, and no emulated device that is gone has"
                " left it; give another path, or remove it"
            )
        try:
            self._link.unlink(missing_ok=True)
            self._link.symlink_to(self.path)
        except OSError as error:
            raise LinkError(f"{self._link}: {error.strerror}") from error
        self.path = str(self._link)

    def _is_left_over(self) -> bool:
        """Whether the link is one of a device that was killed: to a terminal
        that is gone, or whose number is this one's now.
        """
        target = _target_of(self._link)
        if target.rstrip(_DIGITS) != self._slave.rstrip(_DIGITS):
            return False
        return target == self._slave or not os.path.exists(target)

    def disconnect(self) -> None:
        """Unplugs: the host's reads fail from now on."""
        fds, self._fds = self._fds, None
        for fd in fds or ():
            os.close(fd)
        if self._link is not None and _target_of(self._link) == self._slave:
            with contextlib.suppress(OSError):
                self._link.unlink(missing_ok=True)

    @property
    def is_connected(self) -> bool:
        """Whether there is a terminal."""
        return self._fds is not None

    def read(self, timeout: float) -> bytes:
        """Bytes of the host, waiting for at most so long, s."""
        if self._fds is None:
            time.sleep(max(0.0, timeout))
            return b""
        ready, _, _ = select.select([self._fds[0]], [], [], max(0.0, timeout))
        if not ready:
            return b""
        try:
            return os.read(self._fds[0], 65536)
        except OSError:
            return b""

    def write(self, data: bytes) -> None:
        """Sends what there is room for: nobody may be listening."""
        if self._fds is None or not data:
            return
        try:
            if os.write(self._fds[0], data) < len(data):
                self.overruns += 1
        except OSError:
            self.overruns += 1


def _target_of(link: Path) -> str:
    """Where a link leads; empty where there is none."""
    try:
        return os.readlink(link)
    except OSError:
        return ""
