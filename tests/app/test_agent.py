"""The agent in a session: it speaks and moves between trials, is still in them, and one key stops it."""

from pathlib import Path

import pytest
from textual.color import Color

from sar_tui.framework.clock import MS
from sar_tui.framework.situations import PERFORMANCE, SITUATIONS
from sar_tui.framework.task import Task
from sar_tui.framework.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.widgets.agent import Agent
from tests.app.chair import Chair, plan, sit_down
from tests.app.test_quiet_screen import count_frames
from tests.app.voice import Voice

SPOKEN = {"outputs": ["screen", "voice"]}
UNSEEN = {"outputs": ["voice"]}
_LONG = {
    "value": "12345.6 ms",
    "goal": "10000.0 ms",
    "difference": "12345.6 ms",
    "percent": "100 %",
    "correct": "200",
    "trials": "200",
    "reached": "200",
    "attempts": "200",
    "change": "with less fuss",
    "aim": "as smoothly as you can",
}


def robot(chair: Chair) -> str:
    """The drawing of the agent."""
    area = chair.app.screen.query_one("#agent > .robot").region
    return "\n".join(row[area.x : area.right] for row in chair.rows[area.y : area.bottom])


def mouth(theme: Theme, face: str) -> str:
    return theme.faces[face].splitlines()[theme.mouth_line]


# --- while it speaks ---------------------------------------------------------------------------------------


async def test_the_mouth_moves_while_a_voice_sounds_and_only_then(
    data: Path, catalogue: Catalogue, keyboard: type[Task], calm: Theme, voice: Voice
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, **SPOKEN)) as chair:
        await chair.wait(3000)
        assert voice.asked[0][1] == chair.said
        assert mouth(calm, "happy") in robot(chair)
        await voice.begin(chair)
        assert mouth(calm, "speaking") in robot(chair)
        await chair.wait(200)
        assert mouth(calm, "happy") in robot(chair)
        await chair.wait(200)
        assert mouth(calm, "speaking") in robot(chair)
        await voice.end(chair)
        assert voice.asked[1][1] == chair.session.task.instructions()


async def test_a_trial_goes_on_when_the_agent_has_spoken_and_its_words_stand_till_then(
    data: Path, catalogue: Catalogue, keyboard: type[Task], voice: Voice
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, **SPOKEN)) as chair:
        await voice.begin(chair)
        await chair.press("enter")
        await chair.wait(300)
        await chair.press("enter")
        assert chair.waiting.what == "agent"
        words = chair.said
        assert words == voice.asked[0][1]
        await chair.wait(5000)
        assert chair.waiting.what == "agent"
        assert chair.said == words
        assert chair.sees("One moment…")
        assert "Press" not in "\n".join(chair.rows[1:15])
        await voice.end(chair)
        assert chair.waiting.what in ("quiet", "foreperiod")
        assert chair.said == ""
        await chair.to_prompt()


async def test_a_voice_that_sounds_on_into_a_response_window_draws_nothing(
    data: Path, catalogue: Catalogue, keyboard: type[Task], voice: Voice, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, **SPOKEN)) as chair:
        await voice.end(chair)
        prompt = await chair.to_first_prompt()
        agent = chair.app.screen.query_one(Agent)
        frames = count_frames(chair, monkeypatch)
        agent.speaking(True)
        agent.gaze("left")
        agent.gesture(catalogue.theme("calm").gestures["cheer"])
        for _ in range(5):
            await chair.wait(200)
        assert frames == []
        assert not agent.is_moving
        await chair.press(prompt.expected)
        assert agent.is_moving


async def test_the_goodbye_is_spoken_while_the_summary_stands_and_the_voice_is_let_go_of_after(
    data: Path, catalogue: Catalogue, keyboard: type[Task], voice: Voice
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, attempts=1, prompts_per_attempt=1, **SPOKEN)) as chair:
        await voice.end(chair)
        await chair.do_attempt(await chair.to_first_prompt())
        await voice.end(chair)
        await chair.see_the_summary()
        assert chair.sees("Press Enter to finish.")
        await chair.wait(3000)  # the gesture that went with the last answer ends
        assert voice.asked[-1][1] == chair.said
        await voice.begin(chair)
        assert chair.app.screen.query_one(Agent).is_moving
        assert not voice.is_closed
        await chair.press("enter")
        assert voice.is_closed
        assert not chair.app.is_running


# --- when it cannot be heard --------------------------------------------------------------------------------


async def test_a_voice_that_fails_is_told_beside_its_words_and_at_the_top_until_it_speaks_again(
    data: Path, catalogue: Catalogue, keyboard: type[Task], voice: Voice
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, **SPOKEN)) as chair:
        assert "no voice" not in chair.text
        words = chair.said
        await chair.wait(3000)
        await voice.fail(chair)
        assert chair.said == f"{words} The voice is silent; please read."
        assert "no voice" in chair.rows[0]
        assert "loudspeaker" not in chair.text  # what broke is for the log
        await chair.do_attempt(await chair.to_first_prompt())
        assert "no voice" in chair.rows[0]
        assert "please read" not in chair.said
        await voice.begin(chair)
        assert "no voice" not in chair.rows[0]


async def test_without_the_screen_the_agent_is_only_there_while_its_words_have_to_be_read(
    data: Path, catalogue: Catalogue, keyboard: type[Task], voice: Voice
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, **UNSEEN)) as chair:
        agent = chair.app.screen.query_one(Agent)
        await voice.begin(chair)
        await voice.end(chair)
        assert not agent.display
        assert not chair.sees(voice.asked[0][1])
        await chair.press("enter")
        prompt = await chair.begin()
        assert not agent.display
        await chair.answer(prompt)
        await chair.answer(await chair.to_prompt())
        unheard = chair.messages("arbiter/action")[-1]["text"]
        await voice.fail(chair)
        assert agent.display
        assert chair.said == f"{unheard} The voice is silent; please read."
        await chair.answer(await chair.begin())
        await chair.answer(await chair.to_prompt())
        await voice.begin(chair)
        assert not agent.display


async def test_who_holds_a_key_is_asked_to_let_go_of_it_also_where_the_agent_is_not_seen(
    data: Path, catalogue: Catalogue, keyboard: type[Task], voice: Voice
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, **UNSEEN)) as chair:
        agent = chair.app.screen.query_one(Agent)
        await voice.end(chair)
        await chair.press("enter")
        await chair.wait(300)
        await chair.press("enter")
        for _ in range(40):  # held
            await chair.wait(100)
            await chair.press("x")
        assert chair.said == "Please let go of the keys for a moment."
        await chair.to_prompt()
        assert not agent.display


async def test_a_voice_that_fails_in_a_trial_is_told_when_the_trial_is_over(
    data: Path, catalogue: Catalogue, keyboard: type[Task], voice: Voice, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, **UNSEEN)) as chair:
        await voice.end(chair)
        prompt = await chair.to_first_prompt()
        frames = count_frames(chair, monkeypatch)
        assert chair.app.live
        stage = chair.app.live.screen._stage
        stage.voiceless(chair.app.live.screen._agent.action, "It has gone.")
        await chair.wait(300)
        assert frames == []
        assert "no voice" not in chair.text
        await chair.press(prompt.expected)
        assert "no voice" in chair.rows[0]


# --- an answer that comes later, or is asked for --------------------------------------------------------------


async def test_an_answer_that_comes_later_is_waited_for_with_a_thinking_face(
    data: Path, catalogue: Catalogue, keyboard: type[Task], calm: Theme
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, feedback_delay_ms=3000)) as chair:
        await chair.do_attempt(await chair.to_first_prompt())
        assert chair.sees("One moment…")
        assert mouth(calm, "thinking") in robot(chair)
        assert "Enter" not in chair.text
        await chair.wait(2900)
        assert chair.said == ""
        await chair.wait(200)
        assert "400 ms" in chair.said
        assert chair.sees("Press Enter to begin attempt 2 of 2.")
        assert mouth(calm, "thinking") not in robot(chair)


async def test_who_thinks_and_has_nothing_to_say_listens_again(
    data: Path, catalogue: Catalogue, keyboard: type[Task], calm: Theme
) -> None:
    settings = {"feedback_delay_ms": 3000, "feedback_every": 2, "attempts": 3, "encouragement": False}
    async with sit_down(data, catalogue, plan(keyboard, **settings)) as chair:
        await chair.do_attempt(await chair.to_first_prompt())
        await chair.wait(3100)
        assert chair.sees("Press Enter to begin attempt 2 of 3.")
        assert mouth(calm, "thinking") not in robot(chair)
        assert chair.said == ""


async def test_who_wants_to_know_how_it_went_asks_with_tab(
    data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, feedback_schedule="request", encouragement=False)) as chair:
        await chair.press("enter")
        assert "Tab" not in chair.text
        await chair.do_attempt(await chair.begin())
        assert chair.said == ""
        assert chair.sees("Press Enter to begin attempt 2 of 2. Press Tab to hear how it went.")
        await chair.press("tab")
        assert "400 ms" in chair.said
        assert "Tab" not in chair.text
        await chair.do_attempt(await chair.begin())
        assert chair.sees("Press Enter to see how it went. Press Tab to hear how it went.")


# --- one stop ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("where", ["instructions", "help", "palette", "pause", "trial", "too small", "summary"])
async def test_f2_stops_the_agent_on_every_screen_of_a_session(
    where: str, data: Path, catalogue: Catalogue, keyboard: type[Task], voice: Voice
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, attempts=1, prompts_per_attempt=1, **SPOKEN)) as chair:
        if where == "help":
            await chair.press("f1")
        elif where == "palette":
            await chair.press("ctrl+p")
        elif where == "too small":
            await chair.resize(60, 20)
        elif where == "pause":
            await chair.press("escape")
        elif where in ("trial", "summary"):
            await voice.end(chair)
            prompt = await chair.to_first_prompt()
            if where == "summary":
                await chair.do_attempt(prompt)
                await voice.end(chair)
                await chair.see_the_summary()
        before, keys = voice.stops.count(""), chair.messages("input/key")
        await chair.press("f2")
        assert voice.stops.count("") == before + 1
        stop = chair.messages("operator/act")[-1]
        assert (stop["command"], stop["actor"], stop["at"]) == ("stop", "participant", chair.clock.now())
        assert chair.messages("input/key") == keys
        assert chair.stored("SELECT count(*) FROM trials") == [(int(where == "summary"),)]


async def test_what_was_stopped_is_still_at_once_and_the_log_has_how_long_each_output_took(
    data: Path, catalogue: Catalogue, keyboard: type[Task], calm: Theme, voice: Voice
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, **SPOKEN)) as chair:
        await voice.begin(chair)
        await chair.wait(500)
        assert "●" in robot(chair).splitlines()[2][17:]  # it waves
        await chair.press("f2")
        assert mouth(calm, "happy") in robot(chair)
        assert "●" not in robot(chair).splitlines()[2][17:]
        assert not chair.app.screen.query_one(Agent).is_moving
        told = {stopped["output"]: stopped["at"] - stopped["asked"] for stopped in chair.messages("output/stopped")}
        assert set(told) == {"screen", "voice"}
        assert all(took < 100 * MS for took in told.values())


async def test_the_stop_key_is_offered_where_there_is_a_voice_to_stop(
    data: Path, catalogue: Catalogue, keyboard: type[Task], voice: Voice
) -> None:
    async with sit_down(data, catalogue, plan(keyboard, **SPOKEN)) as chair:
        assert "F2 Stop robot" in chair.rows[-1], "the output of this test is a plug-in"
        await chair.press("f1")
        assert chair.sees("F2 Stop robot")
    async with sit_down(data, catalogue, plan(keyboard, "P02")) as chair:
        assert "F2 Stop" not in chair.text
        await chair.wait(500)
        assert chair.app.screen.query_one(Agent).is_moving
        await chair.press("f2")
        assert not chair.app.screen.query_one(Agent).is_moving


async def test_without_a_session_f2_is_the_screens_own(data: Path, catalogue: Catalogue) -> None:
    async with sit_down(data, catalogue) as chair:
        await chair.press("enter")
        await chair.write(*"p01")
        await chair.press("enter", "f2")
        assert chair.screen_name == "SettingsScreen"
        assert "F2 Stop" not in chair.text


# --- words --------------------------------------------------------------------------------------------------------


def longest(theme: Theme, among: list[str]) -> str:
    """The longest wording of some situations, its slots filled with long figures."""
    slots = {**_LONG, "reference": max(theme.vocabulary.values(), key=len)}
    return max((wording.format(**slots) for name in among for wording in theme.phrases[name]), key=len)


@pytest.mark.parametrize("valence", ["positive", "neutral", "negative", None])
@pytest.mark.parametrize("name", ["calm", "high-contrast", "playful"])
async def test_words_have_the_colour_of_their_valence_and_what_joins_them_has_none(
    name: str, valence: str | None, data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    colors = catalogue.theme(name).colors
    async with sit_down(data, catalogue, plan(keyboard, theme=name)) as chair:
        agent = chair.app.screen.query_one(Agent)
        agent.say("Well done.", "happy", valence)
        agent.say("Have a rest.", "sleeping", joins=True)
        await chair.settle()
        said, more = (agent.query_one(each).visual_style.foreground.rgb for each in (".said", ".more"))
        assert said == pytest.approx(Color.parse(getattr(colors, valence) if valence else colors.text).rgb, abs=1)
        assert more == pytest.approx(Color.parse(colors.text).rgb, abs=1)


@pytest.mark.parametrize("language", ["en", "es"])
@pytest.mark.parametrize("name", ["calm", "high-contrast", "playful"])
async def test_the_longest_words_fit_beside_the_agent_and_leave_room_for_what_to_press(
    name: str, language: str, data: Path, catalogue: Catalogue, keyboard: type[Task]
) -> None:
    theme = catalogue.theme(name, language)
    answers = [each for each in SITUATIONS if each.split("_")[0] in ("positive", "neutral", "negative")]
    in_words = [each for each in answers if not SITUATIONS[each]]
    in_figures = [each for each in answers if SITUATIONS[each]]
    performance = [each for each in PERFORMANCE if each.endswith("figures")]
    words = " ".join(longest(theme, each) for each in (in_words, in_figures, performance))
    more = longest(theme, ["rest", "encouragement"])
    async with sit_down(data, catalogue, plan(keyboard, theme=name, language=language, attempts=200)) as chair:
        await chair.press("enter")
        at_foot, press = chair.rows[-2:], chair.app.screen.query_one("#enter").render()  # type: ignore[attr-defined]
        agent = chair.app.screen.query_one(Agent)
        agent.say(words, "happy", "positive")
        agent.say(more, "encouraging", joins=True)
        agent.note(chair.app.screen.tr("The voice is silent; please read."))  # type: ignore[attr-defined]
        await chair.settle()
        assert chair.said.startswith(f"{words} {more} ")
        assert chair.sees(str(press))
        assert chair.rows[-2:] == at_foot
