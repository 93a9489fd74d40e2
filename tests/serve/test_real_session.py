"""A session in its terminal is watched and operated from a browser."""

import asyncio
import json
import os
import signal
import sys
import tempfile
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import rows, run_command
from tests.needs_browser import needs_browser
from tests.serve.chromium import chromium
from tests.serve.serve_fixtures import SECONDS

pytestmark = [
    needs_browser,
    pytest.mark.skipif(os.name != "posix", reason="pseudo-terminals of POSIX systems"),
]


@pytest.fixture(autouse=True)
def short_runtime_folder(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Private runtime folder with a short path."""
    with tempfile.TemporaryDirectory(prefix="sar-") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        yield


@asynccontextmanager
async def serve(*arguments: str) -> AsyncIterator[str]:
    """Run ``sar-tui serve``; yields the printed address."""
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "sar_tui",
        "serve",
        *arguments,
        "--port",
        "0",
        stdout=asyncio.subprocess.PIPE,
    )
    try:
        assert process.stdout
        yield (await asyncio.wait_for(process.stdout.readline(), SECONDS)).decode().strip()
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            await asyncio.wait_for(process.wait(), SECONDS)
        except TimeoutError:
            process.kill()


@asynccontextmanager
async def keep_reading(terminal: Terminal) -> AsyncIterator[None]:
    """Keep reading a terminal's output, because a program whose output nobody reads blocks."""
    looks = True

    def look() -> None:
        while looks:
            terminal.settle(silence_ms=50, seconds=0.2)

    looking = asyncio.create_task(asyncio.to_thread(look))
    try:
        yield
    finally:
        looks = False
        await looking


async def logged_message(data: Path, topic: str, **with_values: str) -> dict[str, Any]:
    """Wait for the first logged message of a topic with these values."""
    async with asyncio.timeout(SECONDS):
        while True:
            for (text,) in rows(
                data, "SELECT message FROM events WHERE topic=? ORDER BY seq", topic
            ):
                message: dict[str, Any] = json.loads(text)
                if with_values.items() <= message.items():
                    return message
            await asyncio.sleep(0.05)


@pytest.mark.slow
async def test_proposal_is_approved_in_a_browser(data: Path) -> None:
    settings = {
        "operator_feedback": "approve",
        "operator_time_ms": 60_000,
        "operator_timeout": "drop",
    }
    session = [*run_command(data, prompts_per_attempt=2, attempts=1, **settings), "--operator"]
    with Terminal(session) as terminal:
        await asyncio.to_thread(terminal.wait_for, "Press Enter to go on.")
        async with serve("operator", "--data", str(data)) as address, chromium() as browser:
            async with (
                aiohttp.ClientSession() as http,
                http.get(address.partition("?")[0]) as refused,
            ):
                assert refused.status == 403
            async with keep_reading(terminal):
                await browser.open(address)
                await browser.see("P01")
            participant = ScriptedParticipant(terminal, random_answers(3, 120, 220))
            terminal.confirm()
            await asyncio.to_thread(participant.run, 2)
            async with keep_reading(terminal):
                text = (await logged_message(data, "arbiter/pending_approval"))["proposal"]["text"]
                await browser.see(text[:20])
                assert text[:20].encode() not in terminal.output
                # keys pressed too soon after a proposal are ignored
                await logged_message(data, "arbiter/filler_due")
                await browser.press("Enter")
            await asyncio.to_thread(terminal.wait_for, text[:20])
            await browser.call("Page.navigate", url="about:blank")
            async with keep_reading(terminal):
                left = await logged_message(data, "operator/presence", state="left")
    assert left["actor"].startswith("operator.")
    ((decision, actor, final, decided),) = rows(
        data, "SELECT decision, actor, final, decided_ns FROM actions WHERE kind='feedback'"
    )
    assert decision == "accepted"
    assert actor.startswith("operator.")
    assert json.loads(final)["text"] == text
    assert decided > 0
