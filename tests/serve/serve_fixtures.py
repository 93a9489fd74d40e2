"""Server of tiny apps on a free port, and a browser's terminal without a browser."""

import asyncio
import json
import sys
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import NamedTuple

import aiohttp
import pyte
from aiohttp import web

from sar_tui.serve.address import Address
from sar_tui.serve.guard import Guard
from sar_tui.serve.runner import listen
from sar_tui.serve.server import Kind, Server

TOKEN = "a-token-that-is-long-enough-for-a-test"
SECONDS = 60.0


class Served(NamedTuple):
    """Running server."""

    port: int
    log: list[str]
    slept: list[float]
    diary: Path
    http: aiohttp.ClientSession

    @property
    def origin(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def cookie(self) -> dict[str, str]:
        """Header of a browser that has shown the token."""
        address = Address("127.0.0.1", self.port)
        return {"Cookie": f"sar-tui-{self.port}={Guard(address, TOKEN).cookie}"}

    @property
    def allowed(self) -> dict[str, str]:
        """Headers of a page of this server."""
        return {**self.cookie, "Origin": self.origin}

    async def written(self, line: str) -> str:
        """Wait until an app has written a line with this beginning; return the last such line."""
        async with asyncio.timeout(SECONDS):
            while True:
                lines = self.diary.read_text().splitlines() if self.diary.exists() else []
                if found := [each for each in lines if each.startswith(line)]:
                    return found[-1]
                await asyncio.sleep(0.02)


@asynccontextmanager
async def serving(
    diary: Path,
    kind: Kind = "observer",
    program: Sequence[str] = (),
    port: int = 0,
    is_ready: Callable[[], bool] = lambda: True,
) -> AsyncIterator[Served]:
    """Serve tiny apps or another program."""
    listening = listen("127.0.0.1", port)
    port = listening.getsockname()[1]
    log: list[str] = []
    slept: list[float] = []

    async def sleep(seconds: float) -> None:
        slept.append(seconds)

    tiny = [sys.executable, "-m", "tests.serve.counter_app", str(diary)]
    server = Server(
        kind, program or tiny, Address("127.0.0.1", port), TOKEN, log.append, sleep, is_ready
    )
    runner = web.AppRunner(server.app(), access_log=None, shutdown_timeout=1)
    await runner.setup()
    try:
        await web.SockSite(runner, listening).start()
        async with aiohttp.ClientSession(cookie_jar=aiohttp.DummyCookieJar()) as http:
            yield Served(port, log, slept, diary, http)
    finally:
        await runner.cleanup()


class TerminalScreen:
    """Screen of a browser's terminal, from the bytes sent to it."""

    def __init__(self, columns: int = 80, rows: int = 24) -> None:
        self._screen = pyte.Screen(columns, rows)
        self._stream = pyte.ByteStream(self._screen)

    def feed(self, data: bytes) -> None:
        self._stream.feed(data)

    @property
    def text(self) -> str:
        return "\n".join(line.rstrip() for line in self._screen.display)


async def read_until(
    socket: aiohttp.ClientWebSocketResponse, screen: TerminalScreen, text: str
) -> None:
    """Read a view until it shows a text."""
    async with asyncio.timeout(SECONDS):
        while text not in screen.text:
            message = await socket.receive()
            if message.type is aiohttp.WSMsgType.TEXT:  # for the page itself
                continue
            assert message.type is aiohttp.WSMsgType.BINARY, (
                f"{message} came while the screen was: {screen.text}"
            )
            screen.feed(message.data)


async def told(socket: aiohttp.ClientWebSocketResponse, kind: str) -> object:
    """Read a view until the page is told something of a kind; return its content."""
    async with asyncio.timeout(SECONDS):
        while True:
            message = await socket.receive()
            assert message.type in (aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY), message
            if (
                message.type is aiohttp.WSMsgType.TEXT
                and (received := json.loads(message.data))[0] == kind
            ):
                content: object = received[1]
                return content


async def close_code(socket: aiohttp.ClientWebSocketResponse) -> int | None:
    """Read a view until it is closed; return the code."""
    async with asyncio.timeout(SECONDS):
        while not socket.closed:
            await socket.receive()
    return socket.close_code


async def press(socket: aiohttp.ClientWebSocketResponse, keys: str) -> None:
    await socket.send_str(json.dumps(["stdin", keys]))


async def logged(served: Served, line: str) -> None:
    """Wait until the server has logged a line."""
    async with asyncio.timeout(SECONDS):
        while line not in served.log:
            await asyncio.sleep(0.02)
