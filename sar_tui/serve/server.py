"""Web server: the page, its files, and a websocket per view, all behind the guard."""

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
from aiohttp import WSCloseCode, WSMsgType, web

from sar_tui.serve.address import Address
from sar_tui.serve.browser_view import BrowserView, SpeechRequest
from sar_tui.serve.guard import AccessRequest, Guard, Refusal, WrongTokenDelay

Kind = Literal["operator", "observer", "agent"]
TITLES: dict[Kind, str] = {"operator": "Operator", "observer": "Observer", "agent": "Agent"}
MAX_VIEWS = 8
_MAX_MESSAGE_BYTES = 64 * 1024
"""From a browser: enough for pasted text."""
_HEARTBEAT_S = 10.0
_GOODBYES = (WSCloseCode.OK, WSCloseCode.GOING_AWAY)
"""Sent by a browser whose tab is closed; one whose connection breaks sends nothing."""
_PAGE = Path(__file__).parent / "page"
_LIBRARY = Path(textual_serve.__file__).parent / "static"
_HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; font-src "
        "'self'; img-src 'self' "
        "data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""``unsafe-inline`` is for styles only: the terminal in the page sets its own."""

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class _Input(msgspec.Struct, array_like=True, tag="stdin"):
    text: str


class _Resize(msgspec.Struct, array_like=True, tag="resize"):
    size: dict[Literal["width", "height"], int]


class _Ping(msgspec.Struct, array_like=True, tag="ping"):
    at: str


class _Focus(msgspec.Struct, array_like=True, tag="focus"):
    pass


class _Blur(msgspec.Struct, array_like=True, tag="blur"):
    pass


_messages = msgspec.json.Decoder(_Input | _Resize | _Ping | _Focus | _Blur)
"""Messages of a browser's terminal."""


def log(text: str) -> None:
    """Print a line with the time on standard error; it never contains a token."""
    print(f"{time.strftime('%H:%M:%S')} {text}", file=sys.stderr, flush=True)


class Server:
    """Serves one kind of view, with a program of its own for each browser.

    Args:
        kind: the kind of view.
        program: the command that shows it, as a list.
        address: the address to serve at.
        token: the secret that opens it.
        log: called with a line for each event.
        sleep: delays answers to wrong tokens.
        is_ready: returns True if there is something to show; asked by pages that try to come back.
    """

    def __init__(
        self,
        kind: Kind,
        program: Sequence[str],
        address: Address,
        token: str,
        log: Callable[[str], None] = log,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        is_ready: Callable[[], bool] = lambda: True,
    ) -> None:
        self._kind = kind
        self._program = list(program)
        self._address = address
        self._guard = Guard(address, token)
        self._cookie = f"sar-tui-{address.port}"
        self._delay = WrongTokenDelay(time.monotonic)
        self._log = log
        self._sleep = sleep
        self._is_ready = is_ready
        self._views: dict[str, BrowserView] = {}
        self._voices: dict[str, web.WebSocketResponse] = {}
        self._opening = 0

    def app(self) -> web.Application:
        """Return the web application."""
        app = web.Application(middlewares=[self._check_access])
        app.add_routes(
            [
                web.get("/", self._index),
                web.get("/ready", self._ready),
                web.get("/ws/{view:[A-Za-z0-9_-]{1,40}}", self._terminal),
                web.static("/library", _LIBRARY),
                web.static("/page", _PAGE),
            ]
        )
        if self._kind == "agent":
            app.add_routes([web.get("/voice/{view:[A-Za-z0-9_-]{1,40}}", self._voice)])
        app.on_response_prepare.append(self._set_headers)
        app.on_shutdown.append(self._shut_down)
        return app

    # --- access

    @web.middleware
    async def _check_access(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Check every request, even for what does not exist."""
        access = AccessRequest(
            host=request.host,
            origin=request.headers.get("Origin"),
            token=request.query.get("token"),
            cookie=request.cookies.get(self._cookie, ""),
            is_websocket=request.headers.get("Upgrade", "").lower() == "websocket",
        )
        if refusal := self._guard.check(access):
            return await self._refuse(request, refusal)
        if access.token is not None and not access.is_websocket:
            return self._set_cookie()
        try:
            return await handler(request)
        except web.HTTPException as error:
            return web.Response(status=error.status, text=f"{error.reason}.")
        except ConnectionError:
            raise
        except Exception as error:
            self._log(f"{request.remote} error: {type(error).__name__}: {error}")
            return web.Response(
                status=500, text="Something went wrong; see the terminal where sar-tui serve runs."
            )

    async def _refuse(self, request: web.Request, refusal: Refusal) -> web.Response:
        self._log(
            f"{request.remote} refused: {refusal.log_text} ({request.rel_url.raw_path[:100]})"
        )
        if refusal.is_wrong_token and (seconds := self._delay.next_delay(request.remote or "")):
            await self._sleep(seconds)
        return web.Response(status=403, text=refusal.sentence)

    def _set_cookie(self) -> web.Response:
        """Replace the token in the address bar by a cookie."""
        redirect = web.Response(status=303, headers={"Location": "/"})
        redirect.set_cookie(
            self._cookie,
            self._guard.cookie,
            httponly=True,
            samesite="Strict",
            secure=self._address.is_encrypted,
            path="/",
        )
        return redirect

    async def _set_headers(self, _: web.Request, response: web.StreamResponse) -> None:
        response.headers.update(_HEADERS)
        response.headers.popall("Server", None)

    # --- pages

    async def _index(self, request: web.Request) -> web.Response:
        page = string.Template((_PAGE / "index.html").read_text("utf-8"))
        filled = page.substitute(
            title=html.escape(f"sar-tui: {TITLES[self._kind].lower()}"),
            kind=self._kind,
            view=secrets.token_urlsafe(12),
        )
        return web.Response(text=filled, content_type="text/html")

    async def _ready(self, _: web.Request) -> web.Response:
        is_full = len(self._views) + self._opening >= MAX_VIEWS
        return web.Response(status=200 if self._is_ready() and not is_full else 503)

    async def _terminal(self, request: web.Request) -> web.StreamResponse:
        """Run a view's program for as long as a browser is connected."""
        name = request.match_info["view"]
        if len(self._views) + self._opening >= MAX_VIEWS or name in self._views:
            self._log(f"{request.remote} refused: {MAX_VIEWS} browsers are connected already")
            return web.Response(
                status=503, text=f"{MAX_VIEWS} browsers are connected already; close one of them."
            )
        self._opening += 1
        try:
            socket = web.WebSocketResponse(heartbeat=_HEARTBEAT_S, max_msg_size=_MAX_MESSAGE_BYTES)
            await socket.prepare(request)
            view = BrowserView(self._program, socket, lambda spoken: self._speak(name, spoken))
            self._views[name] = view
        finally:
            self._opening -= 1
        self._log(
            f"{request.remote} opened the {self._kind}'s view ({len(self._views)} of {MAX_VIEWS})"
        )
        try:
            await view.start(_cells(request, "width", 80), _cells(request, "height", 24))
            await self._forward_input(socket, view)
        except OSError as error:
            self._log(f"{request.remote} the view cannot be started: {error.strerror}")
        finally:
            is_lost = socket.close_code not in _GOODBYES
            await asyncio.shield(self._leave(name, view, is_lost=is_lost))
            self._log(f"{request.remote} left the {self._kind}'s view")
        return socket

    async def _leave(self, name: str, view: BrowserView, *, is_lost: bool) -> None:
        await view.stop(is_lost=is_lost)
        self._views.pop(name, None)

    async def _forward_input(self, socket: web.WebSocketResponse, view: BrowserView) -> None:
        """Forward input to the program; an invalid message ends the view."""
        async for message in socket:
            if message.type is not WSMsgType.TEXT:
                continue
            try:
                received = _messages.decode(message.data)
            except msgspec.DecodeError:
                self._log("refused: a browser sent an invalid message")
                await socket.close()
                return
            match received:
                case _Input():
                    await view.send_bytes(received.text.encode(errors="replace"))
                case _Resize():
                    size = received.size
                    await view.set_terminal_size(
                        _clamp(size.get("width", 80)), _clamp(size.get("height", 24))
                    )
                case _Ping():
                    await socket.send_json(["pong", received.at])
                case _Focus():
                    await view.focus()
                case _Blur():
                    await view.blur()

    # --- speech

    async def _voice(self, request: web.Request) -> web.StreamResponse:
        """Let a browser speak for the agent that it shows; nothing is read from it."""
        name = request.match_info["view"]
        if name not in self._views or name in self._voices:
            return web.Response(status=409, text="There is no such view, or it already speaks.")
        socket = web.WebSocketResponse(heartbeat=_HEARTBEAT_S, max_msg_size=_MAX_MESSAGE_BYTES)
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

    # --- shutdown

    async def _shut_down(self, _: web.Application) -> None:
        """Stop the programs first, so that they can leave the session, then disconnect the
        browsers.
        """
        await asyncio.gather(*(view.stop() for view in list(self._views.values())))
        for voice in list(self._voices.values()):
            await voice.close()


def _cells(request: web.Request, name: str, default: int) -> int:
    try:
        return _clamp(int(request.query.get(name, default)))
    except ValueError:
        return default


def _clamp(cells: int) -> int:
    return max(10, min(500, cells))
