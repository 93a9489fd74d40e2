"""Program shown in a browser: forwards its screen to the browser, and input to the program."""

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

from sar_tui.model.visible_text import visible

DRIVER = "sar_tui.tui.web_driver:ServedDriver"
_HANDSHAKE = b"__GANGLION__\n"
"""First line of Textual's web driver; see there for the packets that follow."""
_QUIT_TIMEOUT_S = 5.0
"""A program that takes longer to quit is killed."""
_KILL_TIMEOUT_S = 1.0
_MAX_ERROR_BYTES = 2000

SpeechRequest = dict[str, str | bool]
"""Sent to a browser that speaks: ``say`` and ``language``, or ``hush``."""


class BrowserView(AppService):
    """Running program, connected to a browser's terminal.

    Args:
        program: the command, as a list; no shell is involved.
        socket: the websocket of the browser's terminal.
        speak: called with each request for speech.
    """

    def __init__(
        self,
        program: Sequence[str],
        socket: WebSocketResponse,
        speak: Callable[[SpeechRequest], Awaitable[None]],
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
        self._is_stopping = False

    async def _close_socket(self) -> None:
        with contextlib.suppress(ConnectionError, RuntimeError):
            await self._socket.close()

    def _build_environment(self, width: int = 80, height: int = 24) -> dict[str, str]:
        return super()._build_environment(width, height) | {"TEXTUAL_DRIVER": DRIVER}

    async def _open_app_process(self, width: int = 80, height: int = 24) -> Process:
        """Start the program in a session of its own, so that Ctrl-C for the server does not reach
        it.
        """
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
        """Forward the program's output until it ends, and tell the page how it ended."""
        process = self._process
        assert process
        assert process.stdout
        error = asyncio.create_task(self._read_error(process))
        try:
            if await self._handshake(process.stdout):
                await self._forward(process.stdout)
        except (asyncio.IncompleteReadError, ValueError):
            pass
        finally:
            with contextlib.suppress(ProcessLookupError):
                if process.stdout.at_eof() is False:
                    process.kill()
            code = await process.wait()
            message = await error
            self._has_ended.set()
        if not self._is_stopping:  # else the server ends, and the page tries to come back
            await self._send_event("ended", {"failed": bool(code), "why": message if code else ""})
        await self._close_socket()

    async def _send_event(self, kind: str, content: object) -> None:
        """Send a message to the page itself."""
        with contextlib.suppress(ConnectionError, RuntimeError):
            await self._socket.send_json([kind, content])

    async def _handshake(self, output: asyncio.StreamReader) -> bool:
        """Return True if the program's first lines show that it is a Textual app."""
        for _ in range(10):
            line = await output.readline()
            if not line or line == _HANDSHAKE:
                return bool(line)
        return False

    async def _forward(self, output: asyncio.StreamReader) -> None:
        while True:
            kind = await output.readexactly(1)
            size = int.from_bytes(await output.readexactly(4), "big")
            payload = await output.readexactly(size)
            if kind == b"D":
                await self.on_data(payload)
            elif kind == b"M":
                await self.on_meta(payload)

    async def _read_error(self, process: Process) -> str:
        """Return the end of the program's standard error."""
        assert process.stderr
        message = b""
        while more := await process.stderr.read(4096):
            message = (message + more)[-_MAX_ERROR_BYTES:]
        return visible(message.decode(errors="replace"), "\n").strip()

    async def on_data(self, payload: bytes) -> None:
        """Send to the browser. If it is gone, the output is still read, so that the program can
        end.
        """
        with contextlib.suppress(ConnectionError, RuntimeError):
            await self.remote_write_bytes(payload)

    async def on_meta(self, data: bytes) -> None:
        """Handle signs of life and requests for speech, the only ones our apps make."""
        request: dict[str, Any] = json.loads(data)
        if request["type"] == "alive":
            await self._send_event("alive", None)
        if request["type"] == "say":
            await self._speak({"say": str(request["text"]), "language": str(request["language"])})
        elif request["type"] == "hush":
            await self._speak({"hush": True})

    async def stop(self, *, is_lost: bool = False) -> None:
        """Ask the program to quit, and kill it if it does not. May be called twice.

        Args:
            is_lost: the browser did not say goodbye.
        """
        self._is_stopping = True
        if self._process is None or self._task is None:
            return
        await self.send_meta({"type": "quit", "lost": is_lost})
        self.stdin.close()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._has_ended.wait(), _QUIT_TIMEOUT_S)
        if self._process.returncode is None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()
        _, slow = await asyncio.wait({self._task}, timeout=_KILL_TIMEOUT_S)
        for task in slow:  # blocked by a browser that does not read
            task.cancel()
