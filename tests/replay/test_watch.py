"""``sar-tui replay --watch``: a recorded session on the participant's screen, at its own pace."""

from contextlib import closing
from pathlib import Path

import pytest
from textual.widgets import Static

from sar_tui.app import watch
from sar_tui.app.screens.summary import Summary
from sar_tui.loop.bus import Record
from sar_tui.loop.topics import ATTEMPT_STARTED, FRAME, KEY, PROMPT, SESSION, THEME, TRIAL_FEEDBACK
from sar_tui.model.messages import (
    AttemptStarted,
    FrameDue,
    KeyPressed,
    Prompt,
    SessionStarted,
    ThemeApplied,
    TrialFeedback,
)
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.plugins import Catalogue
from sar_tui.replay.player import Player
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.widgets.big_prompt import BigPrompt
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
    call: Call, data: Path, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(watch, "TICK_SECONDS", 10_000)  # only this test lets time pass
    call("simulate", "keyboard", "--user", "average", "--seed", 1, "--attempts", 3, "-p", "P01")
    before = dump(data)
    with closing(connect(data)) as database:
        shown = watch.Watch(data, catalogue, database, sessions.find(database, data, "last"), 1.0)
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
    monkeypatch.setattr(watch, "TICK_SECONDS", 10_000)
    tasks = write_documented(tmp_path / "mytasks", "stopping").parent
    brief = ("--user", "average", "--seed", 1, "--attempts", 1)
    call("simulate", "stopping", *brief, "--tasks", str(tasks))
    with closing(connect(data)) as database:
        catalogue = Catalogue(tasks=(tasks,))
        shown = watch.Watch(data, catalogue, database, sessions.find(database, data, "last"), 1.0)
    due: list[FrameDue] = []
    async with shown.app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        player = shown.watched.player
        player.bus.subscribe(FRAME, due.append)
        while not due:
            player.advance(SECOND // 1000)
        await pilot.pause()
        assert "Press: " in prompt_text(shown)
        player.advance(due[0].at - player.clock.now())
        assert "Do not press." in prompt_text(shown)


@pytest.mark.slow
async def test_the_answer_to_a_trial_is_shown_for_as_long_as_it_was(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(watch, "TICK_SECONDS", 10_000)
    brief = ("--user", "average", "-p", "P01", "--seed", 1, "--attempts", 1)
    shown_for = ("--set", "trial_feedback_ms=700", "--json")
    session = call("simulate", "keyboard", *brief, *shown_for).json["session"]
    data = tmp_path / "data"
    with closing(connect(data)) as database:
        row = sessions.find(database, data, session)
        shown = watch.Watch(data, Catalogue(), database, row, 1.0)
    due: list[TrialFeedback] = []
    async with shown.app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        player = shown.watched.player
        player.bus.subscribe(TRIAL_FEEDBACK, due.append)
        while not due:
            player.advance(SECOND // 1000)
        await pilot.pause()
        assert due[0].text in prompt_text(shown)
        player.advance(SECOND)
        assert due[0].text not in prompt_text(shown)


def prompt_text(shown: watch.Watch) -> str:
    return "\n".join(line for line, _ in shown.app.screen.query_one(BigPrompt)._lines)
