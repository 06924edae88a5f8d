"""How a Dask scheduler is reached: one line, and soon, where there is none."""

from __future__ import annotations

import asyncio
import socket
import time
from concurrent.futures import ThreadPoolExecutor

from distributed import Client, Security
from distributed.comm import connect
from distributed.comm.addressing import parse_address, parse_host_port

from brace_drake.core.errors import ClusterError, quoted, reason
from brace_drake.core.versions import installed_versions

# Results depend on these to the last bit (and on sources and processor, which
# are not compared).
PACKAGES = ("brace_drake", "drake", "numba", "numpy", "scipy")
# Ways to a scheduler that have a host and a port.
_SCHEMES = ("tcp", "tls", "ws", "wss")
_CONNECT_S = 30.0
# A scheduler that is about to begin refuses connections for so long at most.
_REFUSED_S = 5.0
_WORKERS_S = 60.0
_MOST_PORT = 65535


def _await_port(place: str) -> None:
    """Waits a little for a port that refuses connections.

    A client would ask for all of its time, as it does of a machine that is
    silent.

    Raises:
        OSError: It refuses them still, or no machine has that name.
        ValueError: It is no address.
    """
    target = parse_host_port(place)
    if not 0 < target[1] <= _MOST_PORT:
        raise ValueError(f"port {target[1]}")
    end = time.monotonic() + _REFUSED_S
    while True:
        try:
            socket.create_connection(target, _CONNECT_S).close()
            return
        except (ConnectionRefusedError, socket.gaierror):
            if time.monotonic() > end:
                raise
            time.sleep(0.2)


def _Greet(address: str) -> None:
    """Talks to a scheduler once.

    A client whose greeting fails is left behind, and keeps the process for
    minutes.

    Raises:
        Exception: Nobody answers, or in another language.
    """
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        asyncio.run(_greet(address))
        return
    # As in a notebook, whose loop cannot wait for itself.
    with ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, _greet(address)).result()


async def _greet(address: str) -> None:
    options = Security().get_connection_args("client")
    # Not every way heeds the limit that it is given.
    async with asyncio.timeout(_CONNECT_S):
        greeted = await connect(address, timeout=_CONNECT_S, **options)
    await greeted.close()


def connect_client(address: str) -> Client:
    """A client of a scheduler whose workers run what this process runs.

    Raises:
        ClusterError: Nobody answers there, there are no workers, or one runs
            other versions than this process.
    """
    place = f"--cluster {address}"
    try:
        scheme, target = parse_address(address)
        if scheme not in _SCHEMES:
            raise ClusterError(
                f"{place}: {quoted(scheme)} is no way to a scheduler; allowed:"
                f" {', '.join(_SCHEMES)}, as in tcp://host:8786"
            )
        _await_port(target)
        _Greet(address)
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except ClusterError:
        raise
    # What talks another language may raise any exception.
    except Exception as error:
        raise ClusterError(
            f"{place}: no Dask scheduler answers there"
        ) from error
    try:
        client.wait_for_workers(1, timeout=_WORKERS_S)
        there = client.run(installed_versions, PACKAGES)
        here = installed_versions(PACKAGES)
        for worker, found in there.items():
            for name, value in here.items():
                if found[name] != value:
                    raise ClusterError(
                        f"{place}: {worker} has {name} {found[name]}, here is"
                        f" {value}: results would differ"
                    )
    except Exception as error:
        client.close()
        if isinstance(error, ClusterError):
            raise
        if isinstance(error, OSError | TimeoutError):
            raise ClusterError(f"{place}: there are no workers") from error
        raise ClusterError(
            f"{place}: a worker cannot run brace_drake: {reason(error)}"
        ) from error
    return client
