"""The server: pages, their files, and a websocket for each view, all of it behind the guard."""

import asyncio
import contextlib
import html
import secrets
import string
import sys
import time
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path
from typing import Literal

import msgspec
import textual_serve
from aiohttp import WSMsgType, web

from sar_tui.serve.address import Address
from sar_tui.serve.browser_view import BrowserView, SpeechRequest
from sar_tui.serve.guard import AccessRequest, Guard, Refusal, WrongTokenDelay

Kind = Literal["operator", "observer", "agent"]
TITLES: dict[Kind, str] = {"operator": "Operator", "observer": "Observer", "agent": "Agent"}
MAX_VIEWS = 8
"""Browsers that may look at once."""
_LARGEST = 64 * 1024
"""Bytes of a message from a browser: what somebody pastes."""
_HEARTBEAT_S = 10.0
_PAGE = Path(__file__).parent / "page"
_LIBRARY = Path(textual_serve.__file__).parent / "static"
_HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; font-src 'self'; img-src 'self' "
        "data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""``unsafe-inline``, of style alone: the terminal in the page sets its own."""

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class _Key(msgspec.Struct, array_like=True, tag="stdin"):
    text: str


class _Resize(msgspec.Struct, array_like=True, tag="resize"):
    size: dict[Literal["width", "height"], int]


class _Ping(msgspec.Struct, array_like=True, tag="ping"):
    at: str


class _Focus(msgspec.Struct, array_like=True, tag="focus"):
    pass


class _Blur(msgspec.Struct, array_like=True, tag="blur"):
    pass


_typed = msgspec.json.Decoder(_Key | _Resize | _Ping | _Focus | _Blur)
"""What a browser's terminal sends."""


def log(told: str) -> None:
    """One line for whoever serves. It never holds a token."""
    print(f"{time.strftime('%H:%M:%S')} {told}", file=sys.stderr, flush=True)


class Server:
    """Serves one kind of view, a program of its own to each browser.

    Args:
        kind: which view.
        program: the command that shows it, as a list.
        address: where, and under which names.
        token: what opens it.
        log: is told what happens, a line each.
        sleep: how the answer to wrong tokens is put off.
    """

    def __init__(
        self,
        kind: Kind,
        program: Sequence[str],
        address: Address,
        token: str,
        log: Callable[[str], None] = log,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._kind = kind
        self._program = list(program)
        self._address = address
        self._guard = Guard(address, token)
        self._cookie = f"sar-tui-{address.port}"
        self._patience = WrongTokenDelay(time.monotonic)
        self._log = log
        self._sleep = sleep
        self._views: dict[str, BrowserView] = {}
        self._voices: dict[str, web.WebSocketResponse] = {}
        self._opening = 0

    def app(self) -> web.Application:
        """The web application."""
        app = web.Application(middlewares=[self._watch])
        app.add_routes(
            [
                web.get("/", self._index),
                web.get("/ws/{view:[A-Za-z0-9_-]{1,40}}", self._terminal),
                web.static("/library", _LIBRARY),
                web.static("/page", _PAGE),
            ]
        )
        if self._kind == "agent":
            app.add_routes([web.get("/voice/{view:[A-Za-z0-9_-]{1,40}}", self._voice)])
        app.on_response_prepare.append(self._dress)
        app.on_shutdown.append(self._shut_down)
        return app

    # --- the door ---------------------------------------------------------------------------------------------

    @web.middleware
    async def _watch(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Nothing is answered but through here: not even that something is not there."""
        asked = AccessRequest(
            host=request.host,
            origin=request.headers.get("Origin"),
            token=request.query.get("token"),
            cookie=request.cookies.get(self._cookie, ""),
            is_websocket=request.headers.get("Upgrade", "").lower() == "websocket",
        )
        if refusal := self._guard.check(asked):
            return await self._refuse(request, refusal)
        if asked.token is not None and not asked.is_websocket:
            return self._enter()
        try:
            return await handler(request)
        except web.HTTPException as error:
            return web.Response(status=error.status, text=f"{error.reason}.")
        except ConnectionError:
            raise
        except Exception as error:
            self._log(f"{request.remote} a fault: {type(error).__name__}: {error}")
            return web.Response(status=500, text="Something went wrong; see where sar-tui serve runs.")

    async def _refuse(self, request: web.Request, refusal: Refusal) -> web.Response:
        self._log(f"{request.remote} refused: {refusal.told} ({request.rel_url.raw_path[:100]})")
        if refusal.is_wrong_token and (seconds := self._patience.wrong(request.remote or "")):
            await self._sleep(seconds)
        return web.Response(status=403, text=refusal.sentence)

    def _enter(self) -> web.Response:
        """The token was shown: it need not stand in the address bar from here on."""
        there = web.Response(status=303, headers={"Location": "/"})
        there.set_cookie(
            self._cookie,
            self._guard.cookie,
            httponly=True,
            samesite="Strict",
            secure=self._address.is_encrypted,
            path="/",
        )
        return there

    async def _dress(self, _: web.Request, response: web.StreamResponse) -> None:
        response.headers.update(_HEADERS)
        response.headers.popall("Server", None)

    # --- pages --------------------------------------------------------------------------------------------------

    async def _index(self, request: web.Request) -> web.Response:
        page = string.Template((_PAGE / "index.html").read_text("utf-8"))
        filled = page.substitute(
            title=html.escape(f"sar-tui: {TITLES[self._kind].lower()}"),
            kind=self._kind,
            view=secrets.token_urlsafe(12),
        )
        return web.Response(text=filled, content_type="text/html")

    async def _terminal(self, request: web.Request) -> web.StreamResponse:
        """A browser opens a view: its program runs for as long as the browser looks."""
        name = request.match_info["view"]
        if len(self._views) + self._opening >= MAX_VIEWS or name in self._views:
            self._log(f"{request.remote} refused: {MAX_VIEWS} look already")
            return web.Response(status=503, text=f"{MAX_VIEWS} browsers look already; close one of them.")
        self._opening += 1
        try:
            socket = web.WebSocketResponse(heartbeat=_HEARTBEAT_S, max_msg_size=_LARGEST)
            await socket.prepare(request)
            view = BrowserView(self._program, socket, lambda spoken: self._speak(name, spoken))
            self._views[name] = view
        finally:
            self._opening -= 1
        self._log(f"{request.remote} opened the {self._kind}'s view ({len(self._views)} of {MAX_VIEWS})")
        try:
            await view.start(_cells(request, "width", 80), _cells(request, "height", 24))
            await self._listen(socket, view)
        except OSError as error:
            self._log(f"{request.remote} the view cannot be started: {error.strerror}")
        finally:
            await asyncio.shield(self._leave(name, view))
            self._log(f"{request.remote} left the {self._kind}'s view")
        return socket

    async def _leave(self, name: str, view: BrowserView) -> None:
        await view.stop()
        self._views.pop(name, None)

    async def _listen(self, socket: web.WebSocketResponse, view: BrowserView) -> None:
        """Pass on what is typed; what cannot be understood ends the view."""
        async for message in socket:
            if message.type is not WSMsgType.TEXT:
                continue
            try:
                typed = _typed.decode(message.data)
            except msgspec.DecodeError:
                self._log("refused: what a browser sent cannot be understood")
                await socket.close()
                return
            match typed:
                case _Key():
                    await view.send_bytes(typed.text.encode(errors="replace"))
                case _Resize():
                    size = typed.size
                    await view.set_terminal_size(_within(size.get("width", 80)), _within(size.get("height", 24)))
                case _Ping():
                    await socket.send_json(["pong", typed.at])
                case _Focus():
                    await view.focus()
                case _Blur():
                    await view.blur()

    # --- the voice ----------------------------------------------------------------------------------------------

    async def _voice(self, request: web.Request) -> web.StreamResponse:
        """A browser speaks for the agent that it shows. It is told words, and asked nothing."""
        name = request.match_info["view"]
        if name not in self._views or name in self._voices:
            return web.Response(status=409, text="There is no such view, or it speaks already.")
        socket = web.WebSocketResponse(heartbeat=_HEARTBEAT_S, max_msg_size=_LARGEST)
        self._voices[name] = socket
        try:
            await socket.prepare(request)
            self._log(f"{request.remote} speaks for the agent")
            async for _ in socket:
                pass
        finally:
            del self._voices[name]
        return socket

    async def _speak(self, name: str, spoken: SpeechRequest) -> None:
        if voice := self._voices.get(name):
            with contextlib.suppress(ConnectionError, RuntimeError):
                await voice.send_json(spoken)

    # --- the end ------------------------------------------------------------------------------------------------

    async def _shut_down(self, _: web.Application) -> None:
        """The programs end first, so that they can say goodbye; then the browsers are let go of."""
        await asyncio.gather(*(view.stop() for view in list(self._views.values())))
        for voice in list(self._voices.values()):
            await voice.close()


def _cells(request: web.Request, name: str, usual: int) -> int:
    try:
        return _within(int(request.query.get(name, usual)))
    except ValueError:
        return usual


def _within(cells: int) -> int:
    return max(10, min(500, cells))
