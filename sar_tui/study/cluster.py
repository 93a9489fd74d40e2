"""Chunks of a simulation on a running Dask cluster, by its futures
(https://distributed.dask.org/en/stable/client.html).

A chunk has its own random stream, so that a worker that is lost costs nothing but time: the
scheduler gives its chunks to another one.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import msgspec
import numpy as np

import sar_tui
from sar_tui.drivers.installation import pip_install_extra
from sar_tui.runs.plan import Failed
from sar_tui.study.power import Chunk, Compute, found_in

_RETRIES = 5
_CONNECT_S = 10


class ClusterRefused(Exception):
    """The cluster cannot be used as it was asked for. The message is one clear sentence."""


@contextmanager
def on_cluster(address: str) -> Iterator[Compute]:
    """Give what runs chunks on a cluster.

    Args:
        address: of its scheduler, ``tcp://HOST:PORT``.

    Raises:
        ClusterRefused: the extra ``cluster`` is not installed, or the address is none.
        Failed: the scheduler cannot be reached, it has no worker, or other versions.
    """
    host, _, port = address.removeprefix("tcp://").rpartition(":")
    if not (address.startswith("tcp://") and host and port.isdecimal()):
        raise ClusterRefused(f"--on takes tcp://HOST:PORT, not {address!r}.")
    try:
        from distributed import Client
    except ImportError:
        how = pip_install_extra("cluster")
        raise ClusterRefused(
            f"A cluster needs the Python package distributed. Install it with: {how}"
        ) from None
    try:
        connected: Any = Client
        client = connected(address, timeout=_CONNECT_S, set_as_default=False)
    except OSError:
        raise Failed(f"No Dask scheduler answers at {address}.") from None
    with client:
        _check(client, address)
        yield lambda chunks: _gathered(client, chunks)


def _check(client: Any, address: str) -> None:
    """Raise Failed unless there is a worker, and all have the versions of this computer: others may
    draw other numbers.
    """
    if not client.nthreads():
        raise Failed(f"The scheduler at {address} has no worker. Start one: dask worker {address}")

    def versions() -> str:  # sent as it stands: sar-tui may be missing there
        try:
            import numpy

            import sar_tui
        except ImportError:
            return "no sar-tui"
        return f"sar-tui {sar_tui.__version__} and numpy {numpy.__version__}"

    found = {"scheduler": client.run_on_scheduler(versions), **client.run(versions)}
    for where, there in found.items():
        if there != (here := _versions()):
            raise Failed(
                f"The cluster ({where}) has {there}, and this computer {here}: install the same "
                "there."
            )


def _gathered(client: Any, chunks: Sequence[Chunk]) -> list[int]:
    """Return the results of chunks. Raises Failed."""
    from distributed.scheduler import KilledWorker

    encoded = [msgspec.json.encode(chunk) for chunk in chunks]
    futures = client.map(_found, encoded, pure=False, retries=_RETRIES)
    try:
        found: list[int] = client.gather(futures)
    except KilledWorker as error:
        raise Failed(f"Too many workers of the cluster were lost: {error}") from None
    return found


def _found(encoded: bytes) -> int:
    """Run a chunk on a worker."""
    return found_in(msgspec.json.decode(encoded, type=Chunk))


def _versions() -> str:
    return f"sar-tui {sar_tui.__version__} and numpy {np.__version__}"
