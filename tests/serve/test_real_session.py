"""A session in its terminal is operated over a served view."""

import asyncio
import json
import signal
import sys
import tempfile
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

import aiohttp
import pytest

if sys.platform == "win32":
    pytest.skip("pseudo-terminals of POSIX systems", allow_module_level=True)

from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import rows, run_command
from tests.serve.serve_fixtures import SECONDS, TerminalScreen, press, read_until


@pytest.fixture(autouse=True)
def short_runtime_folder(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Private runtime folder with a short path."""
    with tempfile.TemporaryDirectory(prefix="sar-") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        yield


@asynccontextmanager
async def serve(*arguments: str) -> AsyncIterator[str]:
    """Run ``sar-tui serve``; yields the printed address."""
    words = [sys.executable, "-m", "sar_tui", "serve", *arguments, "--port", "0"]
    process = await asyncio.create_subprocess_exec(*words, stdout=asyncio.subprocess.PIPE)
    try:
        assert process.stdout
        yield (await asyncio.wait_for(process.stdout.readline(), SECONDS)).decode().strip()
    finally:
        process.send_signal(signal.SIGTERM)
        await asyncio.wait_for(process.wait(), SECONDS)


async def logged(data: Path, terminal: Terminal, topic: str) -> str:
    """Wait for the first logged message of a topic, and read the terminal meanwhile: a program
    whose output nobody reads blocks.
    """
    async with asyncio.timeout(SECONDS):
        while True:
            await asyncio.to_thread(terminal.settle, silence_ms=50, seconds=0.2)
            query = "SELECT message FROM events WHERE topic=? ORDER BY seq"
            if found := rows(data, query, topic):
                return str(found[0][0])


@pytest.mark.slow
async def test_proposal_is_approved_in_a_served_view(data: Path) -> None:
    settings = {"operator_feedback": "approve", "operator_time_ms": 60_000}
    session = run_command(data, prompts_per_attempt=2, attempts=1, **settings)
    screen = TerminalScreen(100, 30)
    with Terminal([*session, "--operator"]) as terminal:
        await asyncio.to_thread(terminal.wait_for, "Press Enter to go on.")
        async with (
            serve("operator", "--data", str(data)) as address,
            aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as http,
        ):
            origin = address.partition("/?")[0]
            async with http.get(address) as opened:
                assert opened.status == 200
            async with http.ws_connect(
                f"{origin}/ws/one?width=100&height=30", headers={"Origin": origin}
            ) as view:
                await read_until(view, screen, "P01")
                await logged(data, terminal, "operator/presence")
                participant = ScriptedParticipant(terminal, random_answers(3, 120, 220))
                terminal.confirm()
                await asyncio.to_thread(participant.run, 2)
                pending = await logged(data, terminal, "arbiter/pending_approval")
                text = str(json.loads(pending)["proposal"]["text"])
                await read_until(view, screen, text[:20])
                assert text[:20].encode() not in terminal.output
                # keys pressed too soon after a proposal are ignored
                await logged(data, terminal, "arbiter/filler_due")
                await press(view, "\r")
                await asyncio.to_thread(terminal.wait_for, text[:20])
    ((decision, actor, final, decided),) = rows(
        data, "SELECT decision, actor, final, decided_ns FROM actions WHERE kind='feedback'"
    )
    assert (decision, actor.partition(".")[0]) == ("accepted", "operator")
    assert json.loads(final)["text"] == text
    assert decided > 0
