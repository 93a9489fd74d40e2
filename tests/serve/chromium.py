"""Headless Chromium, driven over its DevTools protocol."""

import asyncio
import base64
import contextlib
import itertools
import os
import shutil
import signal
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

import aiohttp

from tests.needs_browser import CHROMIUM
from tests.serve.serve_fixtures import SECONDS, TerminalScreen

_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--no-first-run",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--remote-debugging-port=0",
    "--window-size=1200,800",
)
_CODES = {"Enter": 13, "Escape": 27, "ArrowDown": 40, "ArrowUp": 38, "F2": 113}


class Chromium:
    """Tab that records its page's requests, errors and terminal."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self.requested: list[str] = []
        self.errors: list[str] = []
        self.screen = TerminalScreen()
        self._socket = socket
        self._numbers = itertools.count(1)
        self._answers: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._screen_bytes: list[bytes] = []

    async def listen(self) -> None:
        """Receive messages of the browser until it ends."""
        async for message in self._socket:
            received = message.json()
            if waiter := self._answers.pop(received.get("id", 0), None):
                waiter.set_result(received)
                continue
            match received.get("method"), received.get("params"):
                case "Network.requestWillBeSent", params:
                    self.requested.append(params["request"]["url"])
                case "Network.webSocketCreated", params:
                    self.requested.append(params["url"])
                    self._open_screen(params["url"])
                case "Network.webSocketFrameReceived", {
                    "response": {"opcode": 2, "payloadData": data}
                }:
                    self._screen_bytes.append(base64.b64decode(data))
                case "Log.entryAdded", params:
                    self.errors.append(params["entry"]["text"])
                case "Runtime.exceptionThrown", params:
                    self.errors.append(str(params["exceptionDetails"]))

    def _open_screen(self, url: str) -> None:
        """Create the screen with the size in the terminal's URL."""
        query = parse_qs(urlsplit(url).query)
        if "width" in query:
            self.screen = TerminalScreen(int(query["width"][0]), int(query["height"][0]))

    async def call(self, method: str, **params: Any) -> dict[str, Any]:
        """Call a method of the protocol."""
        number = next(self._numbers)
        self._answers[number] = asyncio.get_running_loop().create_future()
        await self._socket.send_json({"id": number, "method": method, "params": params})
        answer = await asyncio.wait_for(self._answers[number], SECONDS)
        assert "error" not in answer, answer
        result: dict[str, Any] = answer["result"]
        return result

    async def open(self, url: str, first: str = "") -> None:
        """Open a URL; the script ``first`` runs before the page's own."""
        await self.call("Page.addScriptToEvaluateOnNewDocument", source=first)
        await self.call("Page.navigate", url=url)

    async def value(self, expression: str) -> Any:
        """Evaluate a JavaScript expression in the page."""
        result = await self.call(
            "Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True
        )
        return result["result"].get("value")

    async def wait_until(self, expression: str) -> None:
        """Wait until an expression is true in the page."""
        async with asyncio.timeout(SECONDS):
            while not await self.value(expression):
                await asyncio.sleep(0.05)

    async def see(self, text: str) -> None:
        """Wait until the page's terminal shows a text."""
        try:
            async with asyncio.timeout(SECONDS):
                while text not in self.text:
                    await asyncio.sleep(0.02)
        except TimeoutError:
            raise AssertionError(f"{text!r} is not shown; the screen is:\n{self.text}") from None

    @property
    def text(self) -> str:
        """Text of the page's terminal."""
        while self._screen_bytes:
            self.screen.feed(self._screen_bytes.pop(0))
        return self.screen.text

    async def press(self, key: str) -> None:
        """Press a key: a character, or a name of the DevTools protocol."""
        name = {"key": key, "windowsVirtualKeyCode": _CODES.get(key, ord(key[0].upper()))}
        if key not in _CODES:
            name["text"] = key
        elif key == "Enter":
            name["text"] = "\r"
        await self.call("Input.dispatchKeyEvent", type="keyDown", **name)
        await self.call("Input.dispatchKeyEvent", type="keyUp", **name)


@asynccontextmanager
async def chromium() -> AsyncIterator[Chromium]:
    """Run a browser with one tab and a fresh profile."""
    profile = tempfile.mkdtemp(prefix="sar-tui-chromium-")
    process = await asyncio.create_subprocess_exec(
        CHROMIUM,
        *_FLAGS,
        f"--user-data-dir={profile}",
        "about:blank",
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        async with aiohttp.ClientSession() as http:
            port = await _port(Path(profile) / "DevToolsActivePort")
            async with http.get(f"http://127.0.0.1:{port}/json/list") as answer:
                (page,) = [each for each in await answer.json() if each["type"] == "page"]
            async with http.ws_connect(page["webSocketDebuggerUrl"], max_msg_size=0) as socket:
                tab = Chromium(socket)
                listening = asyncio.create_task(tab.listen())
                for domain in ("Page", "Network", "Runtime", "Log"):
                    await tab.call(f"{domain}.enable")
                yield tab
                await tab.call("Browser.close")
                listening.cancel()
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()
        async with asyncio.timeout(SECONDS):
            while Path(profile).exists():  # its child processes may still write there
                shutil.rmtree(profile, ignore_errors=True)
                await asyncio.sleep(0.02)


async def _port(file: Path) -> int:
    async with asyncio.timeout(SECONDS):
        while not file.exists() or "\n" not in file.read_text():
            await asyncio.sleep(0.05)
    return int(file.read_text().splitlines()[0])
