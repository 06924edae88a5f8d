"""Watching a session to its end, from another thread than the one that reads.

So that a device gone silent, an operator's key and an error of ours all stop.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from brace_drake.link.operation.rows import Row
from brace_drake.link.operation.session import Session
from brace_drake.link.protocol.words import Cause


def WatchSession(
    session: Session,
    take: Callable[[list[Row]], None],
    asks_stop: Callable[[], bool] = lambda: False,
    pause: float = 0.02,
) -> None:
    """Returns when the session is over, however it ended.

    Args:
        session: Started.
        take: Called with the ticks since the last call, in order; at the end
            once more.
        asks_stop: Whether the operator wants it stopped.
        pause: Between two looks, s.
    """
    try:
        while not session.is_over:
            time.sleep(pause)
            session.CheckAlive()
            if asks_stop():
                session.Stop(Cause.STOP_KEY)
            take(_TakeRows(session))
    except BaseException:
        session.Stop(Cause.HOST_ERROR)
        raise
    finally:
        take(_TakeRows(session))


def _TakeRows(session: Session) -> list[Row]:
    rows = []
    while session.rows:
        rows.append(session.rows.popleft())
    return rows
