"""A server from its first moment to its last: it listens, runs until a signal, and takes its programs along."""

import asyncio
import errno
import logging
import os
import signal
import socket
from collections.abc import Callable

from aiohttp import web

from sar_tui.serve.address import AddressError
from sar_tui.serve.server import Server

_ENDS_S = 2.0
"""How long an answer that is under way may take when the server ends."""
_quiet = logging.getLogger("sar_tui.serve")
"""aiohttp's own log: what it would say of a broken request helps nobody here."""
_quiet.addHandler(logging.NullHandler())
_quiet.propagate = False


class ListenError(Exception):
    """The host and port cannot be had; one clear sentence."""


def listen(host: str, port: int) -> socket.socket:
    """Take a port; 0 takes any that is free.

    Raises:
        AddressError: this machine has no such address.
        ListenError: the port is taken, or not for us.
    """
    try:
        family, _, _, _, place = socket.getaddrinfo(host or "?", port, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError):
        raise AddressError(f"There is no host {host} to serve at; leave --host out for this machine alone.") from None
    try:
        return socket.create_server(place[:2], family=family)
    except OSError as error:
        if error.errno == errno.EADDRNOTAVAIL:
            raise AddressError(f"This machine has no address {host} to serve at.") from error
        why = "is taken" if error.errno == errno.EADDRINUSE else f"cannot be had ({error.strerror})"
        raise ListenError(f"Port {port} {why}; name another with --port, or 0 for any that is free.") from error


def run(server: Server, taken: socket.socket, ready: Callable[[], None]) -> int:
    """Serve until a signal asks to end; returns its number.

    Args:
        server: what is served.
        taken: where (see ``listen``).
        ready: called once when browsers may come.
    """
    return asyncio.run(_run(server, taken, ready))


async def _run(server: Server, taken: socket.socket, ready: Callable[[], None]) -> int:
    ended: asyncio.Future[int] = asyncio.get_running_loop().create_future()
    _catch_signals(ended)
    runner = web.AppRunner(server.app(), access_log=None, logger=_quiet, shutdown_timeout=_ENDS_S)
    await runner.setup()
    try:
        await web.SockSite(runner, taken).start()
        ready()
        return await ended
    finally:
        await runner.cleanup()


def _catch_signals(ended: "asyncio.Future[int]") -> None:
    """Where signals cannot be caught so (Windows), a Ctrl-C cancels the future, and with it all else."""
    if os.name != "posix":
        return

    def end(number: int) -> None:
        if not ended.done():
            ended.set_result(number)

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        asyncio.get_running_loop().add_signal_handler(number, end, number)
