"""One view in one browser: a program of ours, its screen sent there, and what is typed there sent to it."""

import asyncio
import contextlib
import json
import shlex
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

from aiohttp.web import WebSocketResponse
from textual_serve.app_service import AppService
from textual_serve.download_manager import DownloadManager

DRIVER = "sar_tui.tui.web_driver:ServedDriver"
_PRELUDE = b"__GANGLION__\n"
"""What Textual's web driver says first; see there for the packets that follow."""
_ENDS_S = 5.0
"""How long a program may take to end before it is killed."""
_KILLED_S = 1.0
_TOLD = 2000
"""Characters of what a program says of its failure."""

SpeechRequest = dict[str, str | bool]
"""What crosses to a browser that speaks: ``say`` and ``language``, or ``hush``."""


class BrowserView(AppService):
    """A running program.

    Args:
        program: the command, as a list: no shell reads it.
        socket: the browser's terminal.
        speak: is given what the program wants to be said, or ``{"hush": True}``.
    """

    def __init__(
        self, program: Sequence[str], socket: WebSocketResponse, speak: Callable[[SpeechRequest], Awaitable[None]]
    ) -> None:
        super().__init__(
            shlex.join(program),
            write_bytes=socket.send_bytes,
            write_str=socket.send_str,
            close=self._close_socket,
            download_manager=DownloadManager(),
        )
        self._program = program
        self._socket = socket
        self._speak = speak
        self._has_ended = asyncio.Event()

    async def _close_socket(self) -> None:
        with contextlib.suppress(ConnectionError, RuntimeError):
            await self._socket.close()

    def _build_environment(self, width: int = 80, height: int = 24) -> dict[str, str]:
        return super()._build_environment(width, height) | {"TEXTUAL_DRIVER": DRIVER}

    async def _open_app_process(self, width: int = 80, height: int = 24) -> Process:
        """In a session of its own, so that a Ctrl-C for the server is not one for the program."""
        self._process = process = await asyncio.create_subprocess_exec(
            *self._program,
            stdin=PIPE,
            stdout=PIPE,
            stderr=PIPE,
            env=self._build_environment(width, height),
            start_new_session=sys.platform != "win32",
        )
        self._stdin = process.stdin
        return process

    async def run(self) -> None:
        """Pass on what the program writes until it ends; if it failed, why is put on the browser's screen."""
        process = self._process
        assert process
        assert process.stdout
        failure = asyncio.create_task(self._failure(process))
        try:
            if await self._begins(process.stdout):
                await self._pass_on(process.stdout)
        except (asyncio.IncompleteReadError, ValueError):
            pass
        finally:
            with contextlib.suppress(ProcessLookupError):
                if process.stdout.at_eof() is False:
                    process.kill()
            code = await process.wait()
            told = await failure
            self._has_ended.set()
        if code and told:
            lines = told.replace("\n", "\r\n")
            await self.on_data(f"\x1b[?1049l\x1b[2J\x1b[H\r\n{lines}".encode())
        await self._close_socket()

    async def _begins(self, output: asyncio.StreamReader) -> bool:
        """Whether the program is an app: it says so in its first lines."""
        for _ in range(10):
            line = await output.readline()
            if not line or line == _PRELUDE:
                return bool(line)
        return False

    async def _pass_on(self, output: asyncio.StreamReader) -> None:
        while True:
            kind = await output.readexactly(1)
            size = int.from_bytes(await output.readexactly(4), "big")
            payload = await output.readexactly(size)
            if kind == b"D":
                await self.on_data(payload)
            elif kind == b"M":
                await self.on_meta(payload)

    async def _failure(self, process: Process) -> str:
        """The last of what the program says on its standard error."""
        assert process.stderr
        told = b""
        while more := await process.stderr.read(4096):
            told = (told + more)[-_TOLD:]
        return "".join(
            character for character in told.decode(errors="replace") if character.isprintable() or character == "\n"
        ).strip()

    async def on_data(self, payload: bytes) -> None:
        """A browser that has gone is told nothing, but the program is read on: it has to be able to end."""
        with contextlib.suppress(ConnectionError, RuntimeError):
            await self.remote_write_bytes(payload)

    async def on_meta(self, data: bytes) -> None:
        """Of what Textual's apps can ask a browser for, ours only ask to be heard."""
        asked: dict[str, Any] = json.loads(data)
        if asked["type"] == "say":
            await self._speak({"say": str(asked["text"]), "language": str(asked["language"])})
        elif asked["type"] == "hush":
            await self._speak({"hush": True})

    async def stop(self) -> None:
        """End the program: in order if it can, else it is killed. Harmless when called again."""
        if self._process is None or self._task is None:
            return
        await self.send_meta({"type": "quit"})
        self.stdin.close()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._has_ended.wait(), _ENDS_S)
        if self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()
        _, slow = await asyncio.wait({self._task}, timeout=_KILLED_S)
        for task in slow:  # a browser that does not read keeps it
            task.cancel()
