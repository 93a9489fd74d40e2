"""Runs the web server until a signal ends it."""

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

_SHUTDOWN_TIMEOUT_S = 2.0
_logger = logging.getLogger("sar_tui.serve")
"""Discards aiohttp's own messages about broken requests."""
_logger.addHandler(logging.NullHandler())
_logger.propagate = False


class ListenError(Exception):
    """The port cannot be opened; the message is one clear sentence."""


def listen(host: str, port: int) -> socket.socket:
    """Open a port; 0 picks a free one.

    Raises:
        AddressError: this machine has no such address.
        ListenError: the port is in use or not permitted.
    """
    try:
        family, _, _, _, place = socket.getaddrinfo(host or "?", port, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError):
        raise AddressError(
            f"There is no host {host}. Leave out --host to serve this machine only."
        ) from None
    try:
        return socket.create_server(place[:2], family=family)
    except OSError as error:
        if error.errno == errno.EADDRNOTAVAIL:
            raise AddressError(f"This machine has no address {host} to serve at.") from error
        why = (
            "is in use"
            if error.errno == errno.EADDRINUSE
            else f"cannot be opened ({error.strerror})"
        )
        raise ListenError(
            f"Port {port} {why}; choose another with --port, or 0 for any free one."
        ) from error


def run(server: Server, listening: socket.socket, on_ready: Callable[[], None]) -> int:
    """Serve until a signal ends it; return the signal's number.

    Args:
        server: the server.
        listening: its socket (see ``listen``).
        on_ready: called once when browsers can connect.
    """
    return asyncio.run(_run(server, listening, on_ready))


async def _run(server: Server, listening: socket.socket, on_ready: Callable[[], None]) -> int:
    ended: asyncio.Future[int] = asyncio.get_running_loop().create_future()
    _catch_signals(ended)
    runner = web.AppRunner(
        server.app(), access_log=None, logger=_logger, shutdown_timeout=_SHUTDOWN_TIMEOUT_S
    )
    await runner.setup()
    try:
        await web.SockSite(runner, listening).start()
        on_ready()
        return await ended
    finally:
        await runner.cleanup()


def _catch_signals(ended: "asyncio.Future[int]") -> None:
    """Resolve ``ended`` on a signal. On Windows, Ctrl-C cancels it instead."""
    if os.name != "posix":
        return

    def end(number: int) -> None:
        if not ended.done():
            ended.set_result(number)

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        asyncio.get_running_loop().add_signal_handler(number, end, number)
