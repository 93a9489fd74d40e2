"""Web server: access, views, speech and shutdown; its page; and no session in a browser."""

import asyncio
import json
import os
import re
import signal
import sys
from pathlib import Path

import aiohttp
import pytest
import textual_serve

from sar_tui.serve import server
from sar_tui.serve.browser_view import DRIVER
from sar_tui.serve.server import MAX_VIEWS
from tests.app.app_driver import known, stored
from tests.program import Call, call
from tests.serve.serve_fixtures import (
    SECONDS,
    TOKEN,
    Served,
    TerminalScreen,
    close_code,
    logged,
    press,
    read_until,
    serving,
    told,
)

__all__ = ["call"]

PAGE = Path(server.__file__).parent / "page"
LIBRARY = Path(textual_serve.__file__).parent / "static"
PATHS = (
    "/",
    "/ready",
    "/page/page.js",
    "/library/js/textual.js",
    "/ws/one",
    "/voice/one",
    "/download/x",
    "/nowhere",
)
UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==",
}


async def status(served: Served, path: str, headers: dict[str, str]) -> tuple[int, str]:
    async with served.http.get(
        served.origin + path, headers=headers, allow_redirects=False
    ) as answer:
        return answer.status, await answer.text()


async def test_without_token_everything_is_refused(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary", "agent") as served:
        for path in PATHS:
            assert await status(served, path, {}) == (
                403,
                "Open the complete address that `sar-tui serve` printed, with its token.",
            )
        own = {"Origin": served.origin}
        for path in ("/ws/one", "/voice/one"):
            assert (await status(served, path, UPGRADE | own))[0] == 403
        assert served.log[0] == "127.0.0.1 refused: no token (/)"
        assert not served.diary.exists()


async def test_token_is_exchanged_for_a_cookie(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary") as served:
        async with served.http.get(
            f"{served.origin}/?token={TOKEN}", allow_redirects=False
        ) as answer:
            assert (answer.status, answer.headers["Location"]) == (303, "/")
            cookie = answer.headers["Set-Cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=Strict" in cookie
        assert TOKEN not in cookie
        assert (await status(served, "/", {"Cookie": cookie.partition(";")[0]}))[0] == 200


async def test_wrong_tokens_are_refused_then_delayed(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary") as served:
        for _ in range(7):
            refused, why = await status(served, f"/?token=not-{TOKEN}", {})
            assert (refused, "This token is wrong" in why) == (403, True)
        assert served.slept == [1, 2]
        assert (await status(served, f"/?token={TOKEN}", {}))[0] == 303
        assert not [line for line in served.log if TOKEN in line]


async def test_foreign_host_or_origin_is_refused_even_with_the_token(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary") as served:
        rebound = {"Host": f"evil.example:{served.port}"}
        assert "not a name" in (await status(served, f"/?token={TOKEN}", rebound))[1]
        why = "Other pages may not connect to this one."
        for origin in ({"Origin": "http://evil.example"}, {}):
            got = await status(served, "/ws/one", UPGRADE | served.cookie | origin)
            assert got == (403, why)
        assert not served.diary.exists()


async def test_security_headers_are_always_set(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary") as served:
        for path, headers in (("/", served.cookie), ("/nowhere", served.cookie), ("/", {})):
            async with served.http.get(served.origin + path, headers=headers) as answer:
                assert answer.headers["Referrer-Policy"] == "no-referrer"
                assert answer.headers["X-Content-Type-Options"] == "nosniff"
                assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]
                assert "default-src 'none'" in answer.headers["Content-Security-Policy"]
                assert answer.headers["Cache-Control"] == "no-store"


async def test_program_lives_as_long_as_its_browser(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary") as served:
        screen = TerminalScreen(60, 20)
        address = f"{served.origin}/ws/one?width=60&height=20"
        async with served.http.ws_connect(address, headers=served.allowed) as socket:
            await read_until(socket, screen, "Tiny is here")
            await press(socket, "aa")
            await read_until(socket, screen, "Pressed 2 times")
        assert await served.written("went") == "went left"
        await logged(served, "127.0.0.1 left the observer's view")
        assert "127.0.0.1 opened the observer's view (1 of 8)" in served.log


async def test_a_browser_whose_connection_breaks_has_not_left(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary") as served:
        socket = await served.http.ws_connect(f"{served.origin}/ws/one", headers=served.allowed)
        await read_until(socket, TerminalScreen(), "Tiny is here")
        transport = socket.get_extra_info("transport") or socket._writer.transport
        transport.abort()
        assert await served.written("went") == "went lost"


async def test_browser_is_disconnected_when_the_program_ends(tmp_path: Path) -> None:
    async with (
        serving(tmp_path / "diary") as served,
        served.http.ws_connect(f"{served.origin}/ws/one", headers=served.allowed) as socket,
    ):
        await read_until(socket, TerminalScreen(), "Tiny is here")
        await press(socket, "x")
        assert await told(socket, "ended") == {"failed": False, "why": ""}
        assert await close_code(socket) == aiohttp.WSCloseCode.OK
        assert await served.written("went")


async def test_page_is_not_told_so_by_an_app_that_hangs(tmp_path: Path) -> None:
    async with (
        serving(tmp_path / "diary") as served,
        served.http.ws_connect(f"{served.origin}/ws/one", headers=served.allowed) as socket,
    ):
        await told(socket, "alive")
        pid = int((await served.written("came")).split()[1])
        os.kill(pid, signal.SIGSTOP)
        await socket.send_str(json.dumps(["ping", "7"]))
        assert await told(socket, "pong") == "7", "the server itself goes on"
        os.kill(pid, signal.SIGCONT)
        await told(socket, "alive")


async def test_page_that_wants_to_come_back_asks_whether_there_is_a_session(tmp_path: Path) -> None:
    there = [False]
    async with serving(tmp_path / "diary", is_ready=lambda: there[0]) as served:
        assert (await status(served, "/ready", served.cookie))[0] == 503
        there[0] = True
        assert (await status(served, "/ready", served.cookie))[0] == 200
        assert not served.diary.exists(), "no program is started for it"


async def test_error_of_a_program_is_shown_in_the_browser(tmp_path: Path) -> None:
    failing = [sys.executable, "-c", "raise SystemExit('There is no such session.')"]
    async with (
        serving(tmp_path / "diary", program=failing) as served,
        served.http.ws_connect(f"{served.origin}/ws/one", headers=served.allowed) as socket,
    ):
        assert await told(socket, "ended") == {"failed": True, "why": "There is no such session."}
        assert await close_code(socket) == aiohttp.WSCloseCode.OK


@pytest.mark.parametrize(
    "sent", ["{", "[]", '["stdin", 3]', '["run", "rm"]', '["resize", {"width": "x"}]']
)
async def test_invalid_message_ends_the_view(tmp_path: Path, sent: str) -> None:
    idle = [sys.executable, "-c", "import sys; sys.stdin.read()"]
    async with (
        serving(tmp_path / "diary", program=idle) as served,
        served.http.ws_connect(f"{served.origin}/ws/one", headers=served.allowed) as socket,
    ):
        await socket.send_str(sent)
        assert (await socket.receive()).type is aiohttp.WSMsgType.CLOSE
        assert "refused: a browser sent an invalid message" in served.log


async def test_number_of_views_is_limited(tmp_path: Path) -> None:
    idle = [sys.executable, "-c", "import sys; sys.stdin.read()"]
    async with serving(tmp_path / "diary", program=idle) as served:
        sockets = [
            await served.http.ws_connect(f"{served.origin}/ws/{number}", headers=served.allowed)
            for number in range(MAX_VIEWS)
        ]
        got, why = await status(served, "/ws/another", UPGRADE | served.allowed)
        assert (got, why) == (503, "8 browsers are connected already; close one of them.")
        await sockets[0].close()
        await logged(served, "127.0.0.1 left the observer's view")
        another = await served.http.ws_connect(
            f"{served.origin}/ws/another", headers=served.allowed
        )
        assert not another.closed


async def test_programs_end_with_the_server(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary") as served:
        socket = await served.http.ws_connect(f"{served.origin}/ws/one", headers=served.allowed)
        await read_until(socket, TerminalScreen(), "Tiny is here")
        pid = int((await served.written("came")).split()[1])
    assert served.diary.read_text().splitlines()[-1].startswith("went")
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


async def test_a_program_that_does_not_end_is_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.serve.browser_view._QUIT_TIMEOUT_S", 0.1)
    diary = tmp_path / "diary"
    deaf = [
        sys.executable,
        "-c",
        f"import os, signal; open({str(diary)!r}, 'w').write(f'came {{os.getpid()}}\\n'); "
        "signal.pause()",
    ]
    async with serving(tmp_path / "diary", program=deaf) as served:
        # Keep the socket: a browser that disconnects ends the program, perhaps before it has
        # written.
        socket = await served.http.ws_connect(f"{served.origin}/ws/one", headers=served.allowed)
        pid = int((await served.written("came ")).split()[1])
        assert not socket.closed
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


async def test_browser_receives_the_agents_speech(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary", "agent") as served:
        assert (await status(served, "/voice/one", UPGRADE | served.allowed))[0] == 409
        screen = await served.http.ws_connect(f"{served.origin}/ws/one", headers=served.allowed)
        await read_until(screen, TerminalScreen(), "Tiny is here")
        voice = await served.http.ws_connect(f"{served.origin}/voice/one", headers=served.allowed)
        await press(screen, "ash")
        async with asyncio.timeout(SECONDS):
            received = [json.loads((await voice.receive()).data) for _ in range(2)]
        assert received == [{"say": "Muy bien.", "language": "es"}, {"hush": True}]


async def test_only_the_agent_view_has_a_voice(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary", "operator") as served:
        assert (await status(served, "/voice/one", UPGRADE | served.allowed))[0] == 404


@pytest.mark.slow
async def test_program_ends_when_its_server_is_killed(tmp_path: Path) -> None:
    """The program quits by itself when its input ends."""
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "tests.serve.counter_app",
        str(tmp_path / "diary"),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        env={**os.environ, "TEXTUAL_DRIVER": "sar_tui.tui.web_driver:ServedDriver"},
    )
    try:
        assert process.stdout
        assert process.stdin
        async with asyncio.timeout(SECONDS):
            await process.stdout.readline()
            process.stdin.close()
            await process.wait()
    finally:
        if process.returncode is None:
            process.send_signal(signal.SIGKILL)
    assert process.returncode == 0
    assert (tmp_path / "diary").read_text().splitlines()[-1] == "went lost"


# --- sessions stay in their terminal


@pytest.mark.parametrize("driver", [DRIVER, "textual.drivers.web_driver:WebDriver"])
def test_no_session_runs_in_a_browser(
    call: Call, monkeypatch: pytest.MonkeyPatch, driver: str
) -> None:
    monkeypatch.setenv("TEXTUAL_DRIVER", driver)
    why = "A session cannot run in a browser, where responses cannot be timed. Use a terminal.\n"
    assert call("run", "keyboard", "-p", "P01") == (2, "", why)


async def test_home_opens_in_a_browser_but_starts_no_session(tmp_path: Path) -> None:
    data = tmp_path / "data"
    known(data, "P01")
    program = [sys.executable, "-m", "sar_tui", "--data", str(data)]
    async with (
        serving(tmp_path / "diary", program=program) as served,
        served.http.ws_connect(
            f"{served.origin}/ws/one?width=100&height=30", headers=served.allowed
        ) as socket,
    ):
        screen = TerminalScreen(100, 30)
        await read_until(socket, screen, "P01")
        await press(socket, "\x1b[C\x1b[C\x1b[C\r")
        await read_until(socket, screen, "cannot run in a browser")
    assert stored(data, "SELECT id FROM sessions") == []


# --- all parts of the page come from this server


def test_page_refers_only_to_existing_files() -> None:
    page = (PAGE / "index.html").read_text("utf-8")
    named = re.findall(r'(?:src|href)="([^"]*)"', page)
    named += re.findall(r'url\("?([^")]*)"?\)', (PAGE / "page.css").read_text("utf-8"))
    named.remove("data:,")
    folders = {"page": PAGE, "library": LIBRARY}
    files = [folders[name.split("/")[1]] / name.split("/", 2)[2] for name in named]
    assert len(files) == 8
    assert [file for file in files if not file.is_file()] == []


def test_scripts_and_styles_contain_no_other_hosts() -> None:
    served = [
        *PAGE.iterdir(),
        *(path for path in LIBRARY.rglob("*") if path.suffix in (".js", ".css")),
    ]
    for path in served:
        text = re.sub(r"/\*.*?\*/", "", path.read_text("utf-8"), flags=re.DOTALL)
        assert re.findall(r"(?:https?|wss?)://[\w.-]+", text) == [], path.name


def test_page_has_no_inline_script_or_handler() -> None:
    page = (PAGE / "index.html").read_text("utf-8")
    assert re.findall(r"<script(?![^>]*src=)", page) == []
    assert re.findall(r"\son\w+=", page) == []
    assert "script-src 'self';" in server._HEADERS["Content-Security-Policy"]
