"""A served view works in a real browser, and nothing leaves the machine."""

import os
import signal
import sys
from pathlib import Path

import pytest

from tests.needs_browser import needs_browser
from tests.serve.chromium import chromium
from tests.serve.serve_fixtures import TOKEN, logged, serving

pytestmark = needs_browser
COVER = (
    "(document.body.classList.contains('-covered') ? "
    "document.getElementById('why').textContent : '')"
)
"""Text that covers the view."""
COVERS_ALL = """
(() => {
  const {x, y, width, height} = document.getElementById("cover").getBoundingClientRect();
  return x === 0 && y === 0 && width === innerWidth && height === innerHeight;
})()
"""


@pytest.mark.slow
async def test_app_is_shown_and_receives_keys(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary") as served, chromium() as browser:
        await browser.open(f"{served.origin}/?token={TOKEN}")
        await browser.see("Tiny is here")
        await browser.wait_until("document.body.classList.contains('-first-byte')")
        assert await browser.value("window.location.href") == f"{served.origin}/"
        assert await browser.value("document.fonts.check('16px \"Roboto Mono\"')")
        await browser.press("a")
        await browser.see("Pressed 1 times")
        assert {
            url.partition("://")[2].partition("/")[0] for url in browser.requested if "://" in url
        } == {f"127.0.0.1:{served.port}"}
        assert browser.errors == []
        await browser.press("x")
        await browser.wait_until(f"{COVER} === 'You have left the session.'")


@pytest.mark.slow
async def test_view_that_is_out_of_date_is_covered_until_it_is_not(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary", "operator") as served, chromium() as browser:
        await browser.open(f"{served.origin}/?token={TOKEN}")
        await browser.see("Tiny is here")
        await browser.wait_until("document.body.classList.contains('-alive')")
        pid = int((await served.written("came")).split()[1])
        os.kill(pid, signal.SIGSTOP)
        await browser.wait_until(f"{COVER}.startsWith('The connection is lost.')")
        assert await browser.value(COVERS_ALL)
        await browser.press("a")
        os.kill(pid, signal.SIGCONT)
        await browser.wait_until(f"{COVER} === ''")
        await browser.press("a")
        await browser.see("Pressed 1 times")


@pytest.mark.slow
async def test_view_comes_back_by_itself_when_its_server_does(tmp_path: Path) -> None:
    async with chromium() as browser:
        async with serving(tmp_path / "diary", "operator") as served:
            await browser.open(f"{served.origin}/?token={TOKEN}")
            await browser.see("Tiny is here")
            await browser.press("a")
            await browser.see("Pressed 1 times")
        await browser.wait_until(f"{COVER}.startsWith('The connection is lost.')")
        async with serving(tmp_path / "diary", "operator", port=served.port):
            await browser.see("Tiny is here")
            await browser.wait_until(f"{COVER} === ''")
            await browser.press("a")
            await browser.see("Pressed 1 times")


@pytest.mark.slow
async def test_view_of_a_session_that_is_not_there_yet_opens_when_it_is(tmp_path: Path) -> None:
    there = tmp_path / "there"
    session = f"""
import sys
from pathlib import Path
if not Path({str(there)!r}).exists():
    sys.exit("There is no such session.")
sys.argv = ["tiny", {str(tmp_path / "diary")!r}]
from tests.serve.counter_app import Tiny
Tiny().run()
"""
    program = [sys.executable, "-c", session]
    async with (
        serving(tmp_path / "diary", "operator", program, is_ready=there.exists) as served,
        chromium() as browser,
    ):
        await browser.open(f"{served.origin}/?token={TOKEN}")
        await browser.wait_until(f"{COVER}.startsWith('There is no such session.')")
        there.touch()
        await browser.see("Tiny is here")
        await browser.wait_until(f"{COVER} === ''")


VOICES = """
window.said = [];
const voice = (lang, localService) => ({lang, localService});
const voices = [voice("es-ES", false), voice("en-US", true), voice("es-MX", true)];
window.SpeechSynthesisUtterance = class { constructor(text) { this.text = text; } };
Object.defineProperty(window, "speechSynthesis", {value: {
  getVoices: () => voices,
  speak: ({text, lang}) => window.said.push([text, lang ?? ""]),
  cancel: () => window.said.push(["hush"]),
}});
"""


@pytest.mark.slow
async def test_browser_speaks_after_the_button_and_with_local_voices_only(tmp_path: Path) -> None:
    async with serving(tmp_path / "diary", "agent") as served, chromium() as browser:
        await browser.open(f"{served.origin}/?token={TOKEN}", VOICES)
        await browser.see("Tiny is here")
        await browser.press("s")
        await browser.press("a")
        await browser.see("Pressed 1 times")
        assert await browser.value("window.said.length") == 0
        await browser.value("document.getElementById('speak').click()")
        await logged(served, "127.0.0.1 speaks for the agent")
        await browser.value("document.querySelector('textarea').focus()")
        await browser.press("s")
        await browser.press("h")
        await browser.wait_until("window.said.length >= 3")
        assert await browser.value("window.said") == [["", ""], ["Muy bien.", "es-MX"], ["hush"]]
        assert browser.errors == []
        await browser.press("f")
        await browser.wait_until(
            "document.getElementById('speak').textContent === 'This device has no voice for fr'"
        )
        assert await browser.value("window.said.length") == 3
