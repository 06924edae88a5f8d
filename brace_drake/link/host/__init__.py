"""The host's end of the line: a port, and the conversation on it."""

from brace_drake.link.host.link import Link
from brace_drake.link.host.ports import OpenPort

__all__ = ["Link", "OpenPort"]
