"""A session on its screen, from the instructions to the summary; rests, resuming, typed text and answers to trials."""

from pathlib import Path

import pytest
from textual.widget import Widget

from sar_tui.app import session_start
from sar_tui.model.messages import SessionCommand
from tests.app.app_driver import AppDriver, OpenApp, OpenSession, known
from tests.documented import write_documented
from tests.edit import edit
from tests.runs.test_resume import interrupted


async def test_a_session_from_start_to_summary(open_session: OpenSession) -> None:
    async with open_session(practice_attempts=1) as driver:
        await driver.press("enter")
        driver.see("Practice 1 of 1 · level 1", "in less than 1 second on average, with 2 of 2")
        await driver.do_attempt(await driver.begin())
        driver.see("Practice is over.", "Practice 1 of 1 · level 1", "□ □")
        await driver.do_attempt(await driver.begin())
        driver.lacks("Practice is over.")
        driver.see("■ □")
        driver.lacks("Keys 2 of 2")
        assert "0.40 seconds" not in driver.said, "it is shown already"
        driver.see("G O A L R E A C H E D")
        driver.see("you 0.40 seconds ━━━━━━━━", "shorter is faster", "goal 1.00 seconds ━━━━━━━━")
        driver.see("Attempt 1 of 2 · level 1")

        await driver.do_attempt(await driver.begin())
        assert driver.waiting.stage == "review"
        driver.see("Attempt 2 of 2 · level 2", "■ ■")
        said = driver.messages("arbiter/action")[-1]["text"]
        assert said == f"{driver.said} 0.40 seconds: that is inside the goal.", (
            "its result is shown"
        )
        assert not driver.session.ended

        await driver.see_the_summary()
        assert driver.session.ended
        driver.see("▀▀█ ▀▀█ █▀▀ of █▀▀ ▀▀▀ ▀▀▀ goals reached", "Your best: 0.40 seconds")
        driver.see("level ███ ███", "goal reached ● ●")
        await driver.press("enter")
        assert not driver.app.is_running
        assert driver.app.return_code == 0
    assert driver.stored("SELECT status FROM sessions") == [("completed",)]
    assert driver.stored("SELECT attempt, practice FROM attempts") == [(1, 1), (2, 0), (3, 0)]
    assert driver.stored(
        "SELECT count(*), sum(correct), min(reaction_time_ms), max(reaction_time_ms) FROM trials"
    ) == [(6, 6, 400.0, 400.0)]


async def test_a_bouncing_enter_neither_closes_the_summary_nor_begins_another_session(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P01", attempts=1, prompts_per_attempt=1)
    async with opened() as driver:
        await driver.press("enter", "enter")
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.wait(300)
        await driver.press("enter")
        for _ in range(30):
            await driver.wait(40)
            await driver.strike("enter")
        driver.see("Press Enter to finish.")
        await driver.press("enter")
        await driver.wait(450)
        for _ in range(60):
            await driver.strike("enter")
            await driver.wait(33)
        assert driver.screen_name == "HomeScreen"
        assert driver.stored("SELECT count(*) FROM sessions") == [(1,)]


async def test_an_enter_that_is_held_is_asked_to_be_let_go(driver: AppDriver) -> None:
    await driver.press("enter")
    for _ in range(2):
        await driver.wait(500)
        await driver.strike("enter")
    driver.lacks("let go")
    await driver.wait(500)
    await driver.strike("enter")
    driver.see("Press Enter to begin attempt 1 of 2. Please let go of the keys for a moment.")
    await driver.press("enter")
    assert driver.waiting.stage == "trial"
    driver.lacks("let go")


async def test_after_the_last_attempt_it_resumes(
    opened: OpenApp, open_session: OpenSession
) -> None:
    async with open_session() as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.do_attempt(await driver.begin())
        session = driver.session_id
        await driver.press("ctrl+q", "down", "enter")
    assert driver.stored("SELECT status FROM sessions") == [("interrupted",)]
    async with opened(session) as driver:
        driver.see("Press Enter to see how it went.")
        assert "level" not in driver.rows[0]
        driver.see("■ ■")
        await driver.press("enter")
        driver.see("of █▀▀ ▀▀▀ ▀▀▀ goals reached")
    assert driver.stored("SELECT status FROM sessions") == [("completed",)]


async def test_a_key_that_waited_while_the_program_was_suspended_is_asked_for_again(
    open_session: OpenSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_session() as driver:
        prompt = await driver.to_first_prompt()
        with monkeypatch.context() as suspended:
            suspended.setattr(
                "sar_tui.tui.gc_control.GcControl.is_stalled", lambda control, at: True
            )
            await driver.answer(prompt, after_ms=2800)
        again = await driver.to_prompt()
        found = (again.trial, again.stimulus, again.presentation)
        assert found == (prompt.trial, prompt.stimulus, 2)
        await driver.answer(again)
    assert driver.stored("SELECT trial, reaction_time_ms FROM trials") == [(1, 400.0)]


async def test_an_attempt_that_begins_again_counts_once_and_the_next_one_begins_by_itself(
    open_task: OpenSession, tmp_path: Path
) -> None:
    folder = write_documented(tmp_path / "mytasks", "twoback")
    async with open_task(folder, attempts=3, feedback_schedule="none") as driver:
        await driver.to_first_prompt()
        await driver.to_prompt()
        await driver.press("escape")
        assert driver.app.live
        driver.app.live.operate(SessionCommand(command="resume"))
        await driver.settle()
        driver.see("This attempt begins again.", "□ □ □")
        assert (await driver.begin()).attempt == 2
        driver.see("Attempt 1 of 3")
        for _ in range(19):
            await driver.to_prompt()
        await driver.wait(2100)
        assert driver.waiting.stage == "attempt"
        driver.see("The next one begins by itself.")
        driver.lacks("Press Enter")
        assert (await driver.to_prompt()).attempt == 3


async def test_the_rest_tells_the_time_that_is_left_and_the_therapist_ends_it(
    open_session: OpenSession,
) -> None:
    async with open_session(
        attempts=3, rest_after_attempts=1, rest_seconds=65, encouragement=False
    ) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        driver.see("A short rest We go on in 1 minute 5 seconds.")
        await driver.wait(4000)
        assert "Now a rest. Put your hands down for a while." in driver.said
        assert driver.app.screen.stage.agent.widget.face == "sleeping"  # type: ignore[attr-defined]
        await driver.press("enter")
        await driver.wait(56_400)
        driver.see("We go on in 5 seconds.")
        await driver.wait(5000)
        driver.see("Press Enter for attempt 2 of 3.")
        assert driver.said == "Start when you are ready."

        await driver.do_attempt(await driver.begin())
        await driver.press("escape", "up", "enter")
        driver.see("End the rest")
        await driver.press("enter")
        ended = [act for act in driver.messages("operator/act") if act["command"] == "skip"]
        assert [(act["actor"], act["reason"]) for act in ended] == [("therapist", "rest")]


@pytest.mark.parametrize("seconds", [0.0, 60.0])
async def test_the_progress_of_a_long_replay_is_painted(
    opened: OpenApp, seconds: float, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    painted: list[str] = []
    paint = session_start.paint_now

    def watched(widget: Widget, *, in_place: bool) -> None:
        painted.append(str(widget.render()))
        paint(widget, in_place=in_place)

    monkeypatch.setattr(session_start, "paint_now", watched)
    monkeypatch.setattr(session_start, "_SHOWN_AFTER_S", seconds)
    monkeypatch.setattr(session_start, "_PAINTED_EVERY_S", 0.0)
    async with opened(interrupted(data, "long", 400)) as driver:
        assert driver.screen_name == "SessionScreen"
    if seconds:
        assert painted == []
    else:
        assert painted[0].startswith("The session goes on where it stopped: ")
        shares = [int(text.split()[-2]) for text in painted]
        assert len(set(shares)) > 5
        assert shares == sorted(shares)


async def test_digits_are_echoed_as_they_are_typed(open_task: OpenSession, tmp_path: Path) -> None:
    folder = write_documented(tmp_path / "mytasks", "digitspan")
    async with open_task(folder, attempts=1) as driver:
        prompt = await driver.to_first_prompt()
        for _ in prompt.expected:
            await driver.wait(800)
        driver.see("Type the digits.")
        await driver.press("4", "a")
        driver.see("4_")
        await driver.press("7")
        driver.see("47_")
        await driver.press("backspace")
        driver.see("4_")
        driver.lacks("47_")
        assert driver.stored("SELECT count(*) FROM trials") == [(0,)]
        await driver.press("enter")
        await driver.wait(100)
        driver.lacks("4_")
        assert driver.stored("SELECT response, correct FROM trials") == [("4", 0)]


def glyphs(driver: AppDriver) -> list[str]:
    """The signs on the screen, each as often as it stands there."""
    return [character for character in driver.text if character in "✓✗"]


async def test_a_tick_and_a_cross_are_shown_and_stamped(open_session: OpenSession) -> None:
    async with open_session(trial_feedback_ms=700) as driver:
        prompt = await driver.to_first_prompt()
        assert glyphs(driver) == []
        await driver.answer(prompt)
        assert "✓" in glyphs(driver)
        driver.lacks(prompt.text)
        assert driver.waiting.what == "result"
        await driver.wait(800)
        assert glyphs(driver) == []
        await driver.wait(1500)
        await driver.press("#")
        assert "✗" in glyphs(driver)
        await driver.wait(800)
        assert glyphs(driver) == []
        shown = driver.messages("screen/trial_feedback")
        found = [(one["attempt"], one["trial"], one["source"]) for one in shown]
        assert found == [(1, 1, "refresh"), (1, 2, "refresh")]
        await driver.answer(await driver.begin())
        await driver.press("escape")
        assert driver.waiting.stage == "paused"
        assert glyphs(driver) == [], "the pause covers it"


async def test_a_prompt_that_follows_at_once_takes_its_place(
    open_task: OpenSession, tmp_path: Path
) -> None:
    file = write_documented(tmp_path / "mytasks", "harvest") / "task.py"
    head = "class Harvest(Task):"
    edit(file, head, f"{head}\n    has_foreperiod = False")
    async with open_task(file.parent) as driver:
        await driver.answer(await driver.to_first_prompt())
        driver.see("0")
        driver.lacks("Left or right?")
        assert (await driver.to_prompt()).trial == 2
        driver.see("Left or right?")
