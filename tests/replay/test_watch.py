"""``sar-tui replay --watch``: a recorded session on the participant's screen, at its own pace."""

from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from textual.widgets import Static

from sar_tui.app import watch
from sar_tui.app.screens.summary import Summary
from sar_tui.loop.bus import Record, Topic
from sar_tui.loop.topics import ATTEMPT_STARTED, FRAME, KEY, PROMPT, SESSION, THEME, TRIAL_FEEDBACK
from sar_tui.model.messages import (
    AttemptStarted,
    KeyPressed,
    Prompt,
    SessionStarted,
    ThemeApplied,
)
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.replay.player import Player
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.widgets.big_prompt import BigPrompt
from tests.caches import compose_frames
from tests.documented import write_documented
from tests.program import Call
from tests.replay.test_replay import dump


def records(*times: int) -> list[Record]:
    """Return attempts that begin at these times, in seconds."""
    attempts = [
        AttemptStarted(attempt=number, practice=False, level=1, trials=2)
        for number, _ in enumerate(times, 1)
    ]
    return [
        Record(one.attempt, at * SECOND, ATTEMPT_STARTED, one)
        for one, at in zip(attempts, times, strict=True)
    ]


def test_a_player_keeps_the_recorded_times_at_any_speed() -> None:
    player = Player(records(10, 14, 20), speed=2)
    seen: list[tuple[int, int]] = []
    player.bus.subscribe(
        ATTEMPT_STARTED, lambda one: seen.append((one.attempt, player.clock.now() // SECOND))
    )
    player.advance(1 * SECOND)
    assert seen == [(1, 10)]
    player.advance(1 * SECOND)
    assert seen == [(1, 10), (2, 14)]
    player.paused = True
    player.advance(60 * SECOND)
    player.paused = False
    player.faster(-1)
    player.advance(5 * SECOND)
    assert (player.speed, player.is_over) == (1, False)
    player.advance(1 * SECOND)
    assert (seen[-1], player.is_over) == ((3, 20), True)


@pytest.mark.parametrize("resumed_at", [3, 90_000])
def test_a_player_goes_on_at_once_where_a_session_was_resumed(resumed_at: int, calm: Theme) -> None:
    themed = Record(2, resumed_at * SECOND - 1, THEME, ThemeApplied(theme=calm))
    started = SessionStarted(run=2, task="keyboard", theme="calm", seed=1, best={})
    player = Player([*records(500), themed, Record(3, resumed_at * SECOND, SESSION, started)])
    player.advance(2)
    player.advance(2)
    assert player.is_over


def test_nodes_that_show_a_record_can_publish_nothing() -> None:
    player = Player(records(1))
    seen: list[KeyPressed] = []
    player.bus.subscribe(KEY, seen.append)
    player.bus.publish(KEY, KeyPressed(key="a", at=1))
    player.bus.post(KEY, KeyPressed(key="a", at=1))
    player.advance(SECOND)
    assert seen == []


@pytest.mark.slow
async def test_a_session_is_shown_again_and_nothing_is_stored(
    call: Call, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    call("simulate", "keyboard", "--user", "average", "--seed", 1, "--attempts", 3, "-p", "P01")
    before = dump(data)
    shown = watched(data, monkeypatch)
    prompts: list[Prompt] = []
    async with shown.app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()

        def header() -> str:
            return str(shown.app.screen.query_one("#replay", Static).render())

        assert header() == "Replay · attempt 0 of 3 · 1× speed"
        await pilot.press("right", "right", "plus")
        assert header() == "Replay · attempt 2 of 3 · 2× speed"
        shown.watched.player.bus.subscribe(PROMPT, prompts.append)
        while not prompts:
            shown.watched.player.advance(SECOND // 10)
        await pilot.pause()
        assert shown.app.screen.query_one(BigPrompt).display
        await pilot.press("left", "space", "enter", "escape", "a")
        await pilot.pause()
        assert header() == "Replay · attempt 1 of 3 · paused"
        await pilot.press("space", "right", "right", "right")
        assert header() == "Replay · attempt 3 of 3 · over"
        assert shown.app.screen.query_one(Summary).display
        await pilot.press("q")
    assert shown.app.return_code == 0
    assert dump(data) == before


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--watch",), "This needs a real terminal"),
        (("--speed", "2"), "--speed is for --watch only"),
        (("--watch", "--json"), "give neither --what-if nor --json"),
    ],
)
def test_what_cannot_be_watched_is_refused(
    call: Call, simulated: str, words: tuple[str, ...], said: str
) -> None:
    called = call("replay", simulated, *words)
    assert (called.code, called.out) == (2, "")
    assert said in called.err


async def test_the_frames_of_a_prompt_are_shown_at_their_times(
    call: Call, data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tasks = write_documented(tmp_path / "mytasks", "stopping").parent
    call("simulate", "stopping", *BRIEF, "--tasks", str(tasks))
    shown = watched(data, monkeypatch, tasks)
    async with shown.app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        due = play_until(shown, FRAME)
        await pilot.pause()
        assert "Press: " in prompt_text(shown)
        shown.watched.player.advance(due.at - shown.watched.player.clock.now())
        assert "Do not press." in prompt_text(shown)


@pytest.mark.slow
async def test_the_answer_to_a_trial_is_shown_for_as_long_as_it_was(
    call: Call, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    call("simulate", "keyboard", *BRIEF, "--set", "trial_feedback_ms=700")
    shown = watched(data, monkeypatch)
    async with shown.app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        answer = play_until(shown, TRIAL_FEEDBACK)
        await pilot.pause()
        assert answer.text in prompt_text(shown)
        shown.watched.player.advance(SECOND)
        assert answer.text not in prompt_text(shown)


BRIEF = ("--user", "average", "-p", "P01", "--seed", 1, "--attempts", 1)


def watched(data: Path, monkeypatch: pytest.MonkeyPatch, *tasks: Path) -> watch.Watch:
    """Show the last session; only the test lets time pass."""
    monkeypatch.setattr(watch, "TICK_SECONDS", 10_000)
    compose_frames(monkeypatch)
    with closing(connect(data)) as database:
        row = sessions.find(database, data, "last")
        return watch.Watch(data, Catalogue(tasks=tasks), database, row, 1.0)


def play_until(shown: watch.Watch, topic: Topic[Any]) -> Any:
    """Let time pass until a message of a topic comes, and return it."""
    found: list[Any] = []
    shown.watched.player.bus.subscribe(topic, found.append)
    while not found:
        shown.watched.player.advance(SECOND // 1000)
    return found[0]


def prompt_text(shown: watch.Watch) -> str:
    return "\n".join(line for line, _ in shown.app.screen.query_one(BigPrompt)._lines)
