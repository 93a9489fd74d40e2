"""A person at a browser: Debian's Chromium without a window, driven over its DevTools protocol."""

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
from tests.serve.serve_fixtures import SECONDS, Eyes

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
    """A tab. What its page asks the network for, what comes for its terminal, and what it complains of is kept."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self.asked_for: list[str] = []
        self.complaints: list[str] = []
        self.eyes = Eyes()
        self._socket = socket
        self._numbers = itertools.count(1)
        self._answers: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._screen_bytes: list[bytes] = []

    async def listen(self) -> None:
        """Hear what the browser tells, until it ends."""
        async for message in self._socket:
            told = message.json()
            if waiter := self._answers.pop(told.get("id", 0), None):
                waiter.set_result(told)
                continue
            match told.get("method"), told.get("params"):
                case "Network.requestWillBeSent", params:
                    self.asked_for.append(params["request"]["url"])
                case "Network.webSocketCreated", params:
                    self.asked_for.append(params["url"])
                    self._open_eyes(params["url"])
                case "Network.webSocketFrameReceived", {"response": {"opcode": 2, "payloadData": data}}:
                    self._screen_bytes.append(base64.b64decode(data))
                case "Log.entryAdded", params:
                    self.complaints.append(params["entry"]["text"])
                case "Runtime.exceptionThrown", params:
                    self.complaints.append(str(params["exceptionDetails"]))

    def _open_eyes(self, url: str) -> None:
        """A terminal says how large it is in its address."""
        asked = parse_qs(urlsplit(url).query)
        if "width" in asked:
            self.eyes = Eyes(int(asked["width"][0]), int(asked["height"][0]))

    async def call(self, method: str, **params: Any) -> dict[str, Any]:
        """Ask the browser for something."""
        number = next(self._numbers)
        self._answers[number] = asyncio.get_running_loop().create_future()
        await self._socket.send_json({"id": number, "method": method, "params": params})
        answer = await asyncio.wait_for(self._answers[number], SECONDS)
        assert "error" not in answer, answer
        result: dict[str, Any] = answer["result"]
        return result

    async def open(self, url: str, first: str = "") -> None:
        """Go to an address; ``first`` is a script that runs before the page's own."""
        await self.call("Page.addScriptToEvaluateOnNewDocument", source=first)
        await self.call("Page.navigate", url=url)

    async def value(self, expression: str) -> Any:
        """What a JavaScript expression says in the page."""
        result = await self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        return result["result"].get("value")

    async def wait_until(self, expression: str) -> None:
        """Wait until an expression is true in the page."""
        async with asyncio.timeout(SECONDS):
            while not await self.value(expression):
                await asyncio.sleep(0.05)

    async def see(self, words: str) -> None:
        """Wait until words stand in the page's terminal."""
        try:
            async with asyncio.timeout(SECONDS):
                while words not in self.text:
                    await asyncio.sleep(0.02)
        except TimeoutError:
            raise AssertionError(f"{words!r} does not come; there stands:\n{self.text}") from None

    @property
    def text(self) -> str:
        """What stands in the page's terminal."""
        while self._screen_bytes:
            self.eyes.feed(self._screen_bytes.pop(0))
        return self.eyes.text

    async def press(self, key: str) -> None:
        """Press a key: a character, or a name of the DevTools protocol's."""
        name = {"key": key, "windowsVirtualKeyCode": _CODES.get(key, ord(key[0].upper()))}
        if key not in _CODES:
            name["text"] = key
        elif key == "Enter":
            name["text"] = "\r"
        await self.call("Input.dispatchKeyEvent", type="keyDown", **name)
        await self.call("Input.dispatchKeyEvent", type="keyUp", **name)

    async def picture(self, path: Path) -> None:
        """Save what is to be seen."""
        shot = await self.call("Page.captureScreenshot", format="png")
        path.write_bytes(base64.b64decode(shot["data"]))


@asynccontextmanager
async def chromium() -> AsyncIterator[Chromium]:
    """A browser with one tab, and nothing of anybody's in it. It ends with the context."""
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
            while Path(profile).exists():  # what it has started may still be writing there
                shutil.rmtree(profile, ignore_errors=True)
                await asyncio.sleep(0.02)


async def _port(file: Path) -> int:
    async with asyncio.timeout(SECONDS):
        while not file.exists() or "\n" not in file.read_text():
            await asyncio.sleep(0.05)
    return int(file.read_text().splitlines()[0])
