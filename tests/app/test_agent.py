"""The agent in a session: it speaks and moves between trials, is still in them, and one key stops
it.
"""

import pytest
from textual.color import Color

from sar_tui.loop.phrase_keys import PERFORMANCE, PHRASE_KEYS
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from sar_tui.widgets.agent import Agent
from tests.app.app_driver import AppDriver, OpenApp, OpenSession
from tests.app.fake_voice import Voice
from tests.app.test_quiet_screen import count_frames
from tests.examples import first

SPOKEN = {"outputs": ["screen", "voice"]}
UNSEEN = {"outputs": ["voice"]}
_LONG = {
    "value": "12.35 seconds",
    "goal": "10 seconds",
    "difference": "12.35 seconds",
    "percent": "100 %",
    "correct": "200",
    "trials": "200",
    "reached": "200",
    "attempts": "200",
    "change": "with less fuss",
    "aim": "as smoothly as you can",
}


def robot(driver: AppDriver) -> str:
    """The drawing of the agent."""
    area = driver.app.screen.query_one("#agent > .robot").region
    return "\n".join(row[area.x : area.right] for row in driver.rows[area.y : area.bottom])


def mouth(theme: Theme, face: str) -> str:
    return theme.faces[face].splitlines()[theme.mouth_line]


# --- while it speaks


async def test_the_mouth_moves_only_while_a_voice_sounds(
    open_session: OpenSession, calm: Theme, voice: Voice
) -> None:
    async with open_session(**SPOKEN) as driver:
        await driver.wait(3000)
        assert voice.asked[0][1] == driver.said
        assert mouth(calm, "happy") in robot(driver)
        await voice.begin(driver)
        assert mouth(calm, "speaking") in robot(driver)
        await driver.wait(200)
        assert mouth(calm, "happy") in robot(driver)
        await driver.wait(200)
        assert mouth(calm, "speaking") in robot(driver)
        await voice.end(driver)
        assert voice.asked[1][1] == driver.session.task.instructions()


async def test_a_trial_continues_when_the_agent_has_spoken_and_its_text_stays_until_then(
    open_session: OpenSession, voice: Voice
) -> None:
    async with open_session(**SPOKEN) as driver:
        await voice.begin(driver)
        await driver.press("enter")
        await driver.wait(300)
        await driver.press("enter")
        assert driver.waiting.what == "agent"
        words = driver.said
        assert words == voice.asked[0][1]
        await driver.wait(5000)
        assert driver.waiting.what == "agent"
        assert driver.said == words
        assert driver.sees("One moment…")
        assert "Press" not in "\n".join(driver.rows[1:15])
        await voice.end(driver)
        assert driver.waiting.what in ("quiet", "foreperiod")
        assert driver.said == ""
        await driver.to_prompt()


async def test_a_voice_that_continues_into_a_response_window_draws_nothing(
    open_session: OpenSession, catalogue: Catalogue, voice: Voice, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_session(**SPOKEN) as driver:
        await voice.end(driver)
        prompt = await driver.to_first_prompt()
        agent = driver.app.screen.query_one(Agent)
        frames = count_frames(driver, monkeypatch)
        agent.speaking(True)
        agent.gaze("left")
        agent.gesture(catalogue.theme("calm").gestures["cheer"])
        for _ in range(5):
            await driver.wait(200)
        assert frames == []
        assert not agent.is_moving
        await driver.press(prompt.expected)
        assert agent.is_moving


async def test_the_goodbye_is_spoken_on_the_summary_and_the_voice_released_afterwards(
    open_session: OpenSession, voice: Voice
) -> None:
    async with open_session(attempts=1, prompts_per_attempt=1, **SPOKEN) as driver:
        await voice.end(driver)
        await driver.do_attempt(await driver.to_first_prompt())
        await voice.end(driver)
        await driver.see_the_summary()
        assert driver.sees("Press Enter to finish.")
        await driver.wait(3000)  # the gesture that went with the last answer ends
        assert voice.asked[-1][1] == driver.said
        await voice.begin(driver)
        assert driver.app.screen.query_one(Agent).is_moving
        assert not voice.is_closed
        await driver.press("enter")
        assert voice.is_closed
        assert not driver.app.is_running


# --- when it cannot be heard


async def test_a_failed_voice_is_reported_until_it_speaks_again(
    open_session: OpenSession, voice: Voice
) -> None:
    async with open_session(**SPOKEN) as driver:
        assert "no voice" not in driver.text
        words = driver.said
        await driver.wait(3000)
        await voice.fail(driver)
        assert driver.said == f"{words} The voice is silent; please read."
        assert "no voice" in driver.rows[0]
        assert "loudspeaker" not in driver.text  # what broke is for the log
        await driver.do_attempt(await driver.to_first_prompt())
        assert "no voice" in driver.rows[0]
        assert "please read" not in driver.said
        await voice.begin(driver)
        assert "no voice" not in driver.rows[0]


async def test_without_the_screen_output_the_agent_is_shown_only_while_its_text_must_be_read(
    open_session: OpenSession, voice: Voice
) -> None:
    async with open_session(**UNSEEN) as driver:
        agent = driver.app.screen.query_one(Agent)
        await voice.begin(driver)
        await voice.end(driver)
        assert not agent.display
        assert not driver.sees(voice.asked[0][1])
        await driver.press("enter")
        prompt = await driver.begin()
        assert not agent.display
        await driver.answer(prompt)
        await driver.answer(await driver.to_prompt())
        unheard = driver.messages("arbiter/action")[-1]["text"]
        await voice.fail(driver)
        assert agent.display
        assert driver.said == f"{unheard} The voice is silent; please read."
        await driver.answer(await driver.begin())
        await driver.answer(await driver.to_prompt())
        await voice.begin(driver)
        assert not agent.display


async def test_a_participant_who_holds_a_key_is_asked_to_release_it_even_without_an_agent(
    open_session: OpenSession, voice: Voice
) -> None:
    async with open_session(**UNSEEN) as driver:
        agent = driver.app.screen.query_one(Agent)
        await voice.end(driver)
        await driver.press("enter")
        await driver.wait(300)
        await driver.press("enter")
        for _ in range(40):  # held
            await driver.wait(100)
            await driver.press("x")
        assert driver.said == "Please let go of the keys for a moment."
        await driver.to_prompt()
        assert not agent.display


async def test_a_voice_that_fails_in_a_trial_is_reported_after_it(
    open_session: OpenSession, voice: Voice, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_session(**UNSEEN) as driver:
        await voice.end(driver)
        prompt = await driver.to_first_prompt()
        frames = count_frames(driver, monkeypatch)
        assert driver.app.live
        stage = driver.app.live.screen._stage
        stage.agent.voiceless(driver.app.live.screen._agent.action)
        await driver.wait(300)
        assert frames == []
        assert "no voice" not in driver.text
        await driver.press(prompt.expected)
        assert "no voice" in driver.rows[0]


# --- an answer that comes later, or is asked for


async def test_delayed_feedback_is_awaited_with_a_thinking_face(
    open_session: OpenSession, calm: Theme
) -> None:
    async with open_session(feedback_delay_ms=3000) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        assert driver.sees("One moment…")
        assert mouth(calm, "thinking") in robot(driver)
        assert "Enter" not in driver.text
        await driver.wait(2900)
        assert driver.said == ""
        await driver.wait(200)
        assert "0.40 seconds" in driver.said
        assert driver.sees("Press Enter for attempt 2 of 2.")
        assert mouth(calm, "thinking") not in robot(driver)


async def test_the_agent_listens_again_if_it_has_nothing_to_say(
    open_session: OpenSession, calm: Theme
) -> None:
    settings = {
        "feedback_delay_ms": 3000,
        "feedback_every": 2,
        "attempts": 3,
        "encouragement": False,
    }
    async with open_session(**settings) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.wait(3100)
        assert driver.sees("Press Enter for attempt 2 of 3.")
        assert mouth(calm, "thinking") not in robot(driver)
        assert driver.said == ""


async def test_tab_requests_feedback(open_session: OpenSession) -> None:
    async with open_session(feedback_schedule="request", encouragement=False) as driver:
        await driver.press("enter")
        assert "Tab" not in driver.text
        await driver.do_attempt(await driver.begin())
        assert driver.said == ""
        assert driver.sees("Press Enter for attempt 2 of 2. Press Tab to hear how it went.")
        await driver.press("tab")
        assert "0.40 seconds" in driver.said
        assert "Tab" not in driver.text
        await driver.do_attempt(await driver.begin())
        assert driver.sees("Press Enter to see how it went. Press Tab to hear how it went.")


# --- one stop


@pytest.mark.parametrize(
    "where", first(2, ["trial", "too small", "summary", "instructions", "help", "palette", "pause"])
)
async def test_f2_stops_the_agent_on_every_screen_of_a_session(
    open_session: OpenSession, where: str, voice: Voice
) -> None:
    async with open_session(attempts=1, prompts_per_attempt=1, **SPOKEN) as driver:
        if where == "help":
            await driver.press("f1")
        elif where == "palette":
            await driver.press("ctrl+p")
        elif where == "too small":
            await driver.resize(60, 20)
        elif where == "pause":
            await driver.press("escape")
        elif where in ("trial", "summary"):
            await voice.end(driver)
            prompt = await driver.to_first_prompt()
            if where == "summary":
                await driver.do_attempt(prompt)
                await voice.end(driver)
                await driver.see_the_summary()
        before, keys = voice.stops.count(""), driver.messages("input/key")
        await driver.press("f2")
        assert voice.stops.count("") == before + 1
        stop = driver.messages("operator/act")[-1]
        assert (stop["command"], stop["actor"], stop["at"]) == (
            "stop",
            "participant",
            driver.clock.now(),
        )
        assert driver.messages("input/key") == keys
        assert driver.stored("SELECT count(*) FROM trials") == [(int(where == "summary"),)]


async def test_a_stop_is_immediate_and_the_latency_of_each_output_is_logged(
    open_session: OpenSession, calm: Theme, voice: Voice
) -> None:
    async with open_session(**SPOKEN) as driver:
        await voice.begin(driver)
        await driver.wait(500)
        assert "●" in robot(driver).splitlines()[2][17:]  # it waves
        await driver.press("f2")
        assert mouth(calm, "happy") in robot(driver)
        assert "●" not in robot(driver).splitlines()[2][17:]
        assert not driver.app.screen.query_one(Agent).is_moving
        delays = {
            stopped["output"]: stopped["at"] - stopped["asked"]
            for stopped in driver.messages("output/stopped")
        }
        assert set(delays) == {"screen", "voice"}
        assert all(took < 100 * MS for took in delays.values())


async def test_the_stop_key_is_shown_only_with_a_voice(
    open_session: OpenSession, voice: Voice
) -> None:
    async with open_session(**SPOKEN) as driver:
        assert "F2 Stop robot" in driver.rows[-1], "the output of this test is a plug-in"
        await driver.press("f1")
        assert driver.sees("F2 Stop robot")
    async with open_session(participant="P02") as driver:
        assert "F2 Stop" not in driver.text
        await driver.wait(500)
        assert driver.app.screen.query_one(Agent).is_moving
        await driver.press("f2")
        assert not driver.app.screen.query_one(Agent).is_moving


@pytest.mark.slow
async def test_outside_a_session_f2_belongs_to_the_screen(opened: OpenApp) -> None:
    async with opened() as driver:
        await driver.press("enter")
        await driver.write(*"p01")
        await driver.press("enter", "f2")
        assert driver.screen_name == "SettingsScreen"
        assert "F2 Stop" not in driver.text


# --- words


async def test_encouragement_replaces_feedback_once_that_could_be_read(
    open_session: OpenSession,
) -> None:
    async with open_session(attempts=3) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.wait(4000)
        feedback, encouragement = (said["text"] for said in driver.messages("arbiter/action")[-2:])
        assert driver.said == feedback
        await driver.wait(20_000)
        assert driver.said == encouragement
        assert driver.sees("goal: less than 1 second ✓"), "its figure stays"
        await driver.do_attempt(await driver.begin())
        await driver.wait(4000)
        following = driver.messages("arbiter/action")[-1]
        assert following["kind"] == "encouragement"
        await driver.begin()
        reports = [
            report
            for report in driver.messages("output/report")
            if report["action"] == following["id"]
        ]
        shown = [report["state"] for report in reports if report["deed"] == "show"]
        assert shown == ["queued", "aborted"], "the next attempt began before"


async def test_encouragement_is_read_when_a_voice_says_it(
    open_session: OpenSession, voice: Voice
) -> None:
    async with open_session(**SPOKEN) as driver:
        for _ in range(2):  # the greeting, and the instructions
            await voice.end(driver)
        await driver.do_attempt(await driver.to_first_prompt())
        await voice.begin(driver)
        feedback = driver.said
        await voice.end(driver)
        await driver.wait(3000)
        assert voice.asked[-1][1] != feedback
        assert driver.said == feedback
        await voice.begin(driver)
        assert driver.said == voice.asked[-1][1]


def longest(theme: Theme, among: list[str]) -> str:
    """Return the longest wording of some phrase keys, with long values in its slots."""
    slots = {**_LONG, "reference": max(theme.vocabulary.values(), key=len)}
    return max(
        (wording.format(**slots) for name in among for wording in theme.phrases[name]), key=len
    )


@pytest.mark.parametrize("name", first(1, ["calm", "high-contrast", "playful"]))
async def test_text_has_the_colour_of_its_valence_and_joined_text_has_none(
    open_session: OpenSession, name: str, catalogue: Catalogue
) -> None:
    colors = catalogue.theme(name).colors
    async with open_session(theme=name) as driver:
        agent = driver.app.screen.query_one(Agent)
        for valence in ("positive", "neutral", "negative", None):
            agent.say("Well done.", "happy", valence)
            agent.say("Have a rest.", "sleeping", joins=True)
            await driver.settle()
            said, more = (
                agent.query_one(each).visual_style.foreground.rgb for each in (".said", ".more")
            )
            assert said == pytest.approx(
                Color.parse(getattr(colors, valence) if valence else colors.text).rgb, abs=1
            )
            assert more == pytest.approx(Color.parse(colors.text).rgb, abs=1)


@pytest.mark.parametrize("language", ["en", "es"])
@pytest.mark.parametrize("name", first(1, ["calm", "high-contrast", "playful"]))
async def test_the_longest_text_fits_beside_the_agent_and_the_key_hints(
    open_session: OpenSession, name: str, language: str, catalogue: Catalogue
) -> None:
    theme = catalogue.theme(name, language)
    answers = [
        each for each in PHRASE_KEYS if each.split("_")[0] in ("positive", "neutral", "negative")
    ]
    in_words = [each for each in answers if not PHRASE_KEYS[each]]
    in_figures = [each for each in answers if PHRASE_KEYS[each]]
    performance = [each for each in PERFORMANCE if each.endswith("figures")]
    words = " ".join(longest(theme, each) for each in (in_words, in_figures, performance))
    more = longest(theme, ["rest", "encouragement"])
    async with open_session(theme=name, language=language, attempts=200) as driver:
        await driver.press("enter")
        at_foot, press = driver.rows[-2:], driver.app.screen.query_one("#enter").render()  # type: ignore[attr-defined]
        agent = driver.app.screen.query_one(Agent)
        agent.say(words, "happy", "positive")
        agent.say(more, "encouraging", joins=True)
        agent.note(driver.app.screen.tr("The voice is silent; please read."))  # type: ignore[attr-defined]
        await driver.settle()
        assert driver.said.startswith(f"{words} {more} ")
        assert driver.sees(str(press))
        assert driver.rows[-2:] == at_foot
