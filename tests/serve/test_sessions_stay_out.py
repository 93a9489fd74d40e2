"""Sessions cannot be run in a browser."""

import sys
from pathlib import Path

import pytest

from sar_tui.serve.browser_view import DRIVER
from tests.app.app_driver import known, stored
from tests.program import Call, call
from tests.serve.serve_fixtures import TerminalScreen, press, read_until, serving

__all__ = ["call"]

REFUSED = "A session cannot run in a browser, where responses cannot be timed. Use a terminal.\n"


@pytest.mark.parametrize("driver", [DRIVER, "textual.drivers.web_driver:WebDriver"])
def test_session_is_refused(call: Call, monkeypatch: pytest.MonkeyPatch, driver: str) -> None:
    monkeypatch.setenv("TEXTUAL_DRIVER", driver)
    assert call("run", "keyboard", "-p", "P01") == (2, "", REFUSED)


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
