"""The agent in a session: it speaks and moves between trials, is still in them, and one key stops
it.
"""

from collections.abc import AsyncIterator

import pytest
from textual.color import Color

from sar_tui.loop.phrase_keys import PERFORMANCE, PHRASE_KEYS
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from sar_tui.tui.key_line import KeyLine
from sar_tui.widgets.agent import Agent
from tests.app.app_driver import AppDriver, OpenSession
from tests.app.fake_voice import Voice
from tests.app.test_quiet_screen import count_frames
from tests.examples import first

SPOKEN = {"outputs": ["screen", "voice"]}
_LONG = {
    "value": "12.35 seconds", "goal": "10 seconds", "difference": "12.35 seconds",
    "percent": "100 %", "correct": "200", "trials": "200", "reached": "200", "attempts": "200",
    "change": "with less fuss", "aim": "as smoothly as you can",
}  # fmt: skip


def robot(driver: AppDriver) -> str:
    """The drawing of the agent."""
    area = driver.app.screen.query_one("#agent > .robot").region
    return "\n".join(row[area.x : area.right] for row in driver.rows[area.y : area.bottom])


def mouth(theme: Theme, face: str) -> str:
    return theme.faces[face].splitlines()[theme.mouth_line]


@pytest.fixture
async def spoken(open_session: OpenSession, voice: Voice) -> AsyncIterator[AppDriver]:
    """A session with a voice."""
    async with open_session(**SPOKEN) as driver:
        yield driver


@pytest.fixture
async def unseen(open_session: OpenSession, voice: Voice) -> AsyncIterator[AppDriver]:
    """A session with a voice and nothing on the screen."""
    async with open_session(outputs=["voice"]) as driver:
        yield driver


# --- while it speaks


async def test_a_trial_waits_for_the_agents_voice(spoken: AppDriver, voice: Voice) -> None:
    await voice.begin(spoken)
    await spoken.press("enter")
    await spoken.wait(300)
    await spoken.press("enter")
    assert spoken.waiting.what == "agent"
    words = spoken.said
    assert words == voice.asked[0][1]
    await spoken.wait(5000)
    assert spoken.waiting.what == "agent"
    assert spoken.said == words
    spoken.see("One moment…")
    assert "Press" not in "\n".join(spoken.rows[1:15])
    await voice.end(spoken)
    assert spoken.waiting.what in ("quiet", "foreperiod")
    assert spoken.said == ""
    await spoken.to_prompt()


async def test_the_summary_speaks_the_goodbye(open_session: OpenSession, voice: Voice) -> None:
    async with open_session(attempts=1, prompts_per_attempt=1, **SPOKEN) as driver:
        await voice.end(driver)
        await driver.do_attempt(await driver.to_first_prompt())
        await voice.end(driver)
        await driver.see_the_summary()
        driver.see("Press Enter to finish.")
        await driver.wait(3000)  # the gesture that went with the last answer ends
        assert voice.asked[-1][1] == driver.said
        await voice.begin(driver)
        assert driver.app.screen.query_one(Agent).is_moving
        assert not voice.is_closed
        await driver.press("enter")
        assert voice.is_closed
        assert not driver.app.is_running


# --- when it cannot be heard


async def test_a_failed_voice_is_told_until_it_speaks(spoken: AppDriver, voice: Voice) -> None:
    assert "no voice" not in spoken.text
    words = spoken.said
    await spoken.wait(3000)
    await voice.fail(spoken)
    assert spoken.said == f"{words} The voice is silent; please read."
    assert "no voice" in spoken.rows[0]
    assert "loudspeaker" not in spoken.text  # what broke is for the log
    await spoken.do_attempt(await spoken.to_first_prompt())
    assert "no voice" in spoken.rows[0]
    assert "please read" not in spoken.said
    await voice.begin(spoken)
    assert "no voice" not in spoken.rows[0]


@pytest.mark.slow
async def test_an_unseen_agent_is_shown_to_be_read(unseen: AppDriver, voice: Voice) -> None:
    agent = unseen.app.screen.query_one(Agent)
    await voice.begin(unseen)
    await voice.end(unseen)
    assert not agent.display
    unseen.lacks(voice.asked[0][1])
    await unseen.press("enter")
    prompt = await unseen.begin()
    assert not agent.display
    await unseen.answer(prompt)
    await unseen.answer(await unseen.to_prompt())
    unheard = unseen.messages("arbiter/action")[-1]["text"]
    await voice.fail(unseen)
    assert agent.display
    words, note = unseen.said.split(" The voice ")
    assert note == "is silent; please read."
    assert unheard.startswith(f"{words} 0.40 seconds"), "which is shown"
    await unseen.answer(await unseen.begin())
    await unseen.answer(await unseen.to_prompt())
    await voice.begin(unseen)
    assert not agent.display


async def test_without_an_agent_a_held_key_is_told_at_once_and_a_failed_voice_after_the_trial(
    unseen: AppDriver, voice: Voice, monkeypatch: pytest.MonkeyPatch
) -> None:
    agent = unseen.app.screen.query_one(Agent)
    await voice.end(unseen)
    await unseen.press("enter")
    await unseen.wait(300)
    await unseen.press("enter")
    for _ in range(40):  # held
        await unseen.wait(100)
        await unseen.press("x")
    assert unseen.said == "Please let go of the keys for a moment."
    prompt = await unseen.to_prompt()
    assert not agent.display

    frames = count_frames(unseen, monkeypatch)
    assert unseen.app.live
    stage = unseen.app.live.screen._stage
    stage.agent.voiceless(unseen.app.live.screen._agent.action)
    await unseen.wait(300)
    assert frames == []
    assert "no voice" not in unseen.text
    await unseen.press(prompt.expected)
    assert "no voice" in unseen.rows[0]


# --- an answer that comes later, or is asked for


@pytest.mark.slow
async def test_delayed_feedback_has_a_thinking_face(open_session: OpenSession, calm: Theme) -> None:
    async with open_session(feedback_delay_ms=3000) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        driver.see("One moment…")
        assert mouth(calm, "thinking") in robot(driver)
        assert "Enter" not in driver.text
        await driver.wait(2900)
        assert driver.said == ""
        await driver.wait(200)
        assert driver.said
        driver.see("0.40 seconds")
        driver.see("Press Enter for attempt 2 of 2.")
        assert mouth(calm, "thinking") not in robot(driver)


@pytest.mark.slow
async def test_tab_requests_feedback(open_session: OpenSession) -> None:
    async with open_session(feedback_schedule="request", encouragement=False) as driver:
        await driver.press("enter")
        assert "Tab" not in driver.text
        await driver.do_attempt(await driver.begin())
        assert driver.said == ""
        driver.see("Press Enter for attempt 2 of 2.", "Press Tab to hear how it went.")
        await driver.press("tab")
        assert driver.said
        driver.see("0.40 seconds")
        assert "Tab" not in driver.text
        await driver.do_attempt(await driver.begin())
        driver.see("Press Enter to see how it went.", "Press Tab to hear how it went.")


# --- one stop


@pytest.mark.slow
async def test_f2_stops_it_everywhere(open_session: OpenSession, voice: Voice) -> None:
    async with open_session(attempts=1, prompts_per_attempt=1, **SPOKEN) as driver:

        async def stop() -> None:
            before, keys = voice.stops.count(""), driver.messages("input/key")
            await driver.press("f2")
            assert voice.stops.count("") == before + 1
            act = driver.messages("operator/act")[-1]
            found = (act["command"], act["actor"], act["at"])
            assert found == ("stop", "participant", driver.clock.now())
            assert driver.messages("input/key") == keys

        for key in ("f1", "ctrl+p"):
            await driver.press(key)
            await stop()
            await driver.press("escape")
        await driver.resize(60, 20)
        await stop()
        await driver.resize(80, 24)
        await voice.end(driver)
        prompt = await driver.to_first_prompt()
        await stop()
        assert driver.stored("SELECT count(*) FROM trials") == [(0,)]
        await driver.do_attempt(prompt)
        await voice.end(driver)
        await driver.see_the_summary()
        await stop()
        assert driver.stored("SELECT count(*) FROM trials") == [(1,)]


async def test_a_stop_is_immediate(spoken: AppDriver, calm: Theme, voice: Voice) -> None:
    assert "F2 Stop robot" in spoken.rows[-1], "the output of this test is a plug-in"
    await voice.begin(spoken)
    await spoken.wait(500)
    assert "●" in robot(spoken).splitlines()[2][17:]  # it waves
    await spoken.press("f2")
    assert mouth(calm, "happy") in robot(spoken)
    assert "●" not in robot(spoken).splitlines()[2][17:]
    assert not spoken.app.screen.query_one(Agent).is_moving
    delays = {
        stopped["output"]: stopped["at"] - stopped["asked"]
        for stopped in spoken.messages("output/stopped")
    }
    assert set(delays) == {"screen", "voice"}
    assert all(took < 100 * MS for took in delays.values())
    await spoken.press("f1")
    spoken.see("F2 Stop robot")


async def test_without_a_voice_the_stop_key_works_but_is_not_named(driver: AppDriver) -> None:
    assert "F2 Stop" not in driver.text
    await driver.wait(500)
    assert driver.app.screen.query_one(Agent).is_moving
    await driver.press("f2")
    assert not driver.app.screen.query_one(Agent).is_moving


# --- words


@pytest.mark.slow
async def test_encouragement_replaces_feedback_that_was_read(open_session: OpenSession) -> None:
    async with open_session(attempts=3) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.wait(4000)
        feedback, encouragement = (said["text"] for said in driver.messages("arbiter/action")[-2:])
        assert driver.said
        assert feedback.startswith(f"{driver.said} 0.40 seconds"), "its figure is shown"
        await driver.wait(20_000)
        assert driver.said == encouragement
        assert driver.sees("G O A L R E A C H E D"), "its figure stays"
        await driver.do_attempt(await driver.begin())
        await driver.wait(4000)
        following = driver.messages("arbiter/action")[-1]
        assert following["kind"] == "encouragement"
        await driver.begin()
        reports = driver.messages("output/report")
        of = {"action": following["id"], "deed": "show"}
        shown = [report["state"] for report in reports if of.items() <= report.items()]
        assert shown == ["queued", "aborted"], "the next attempt began before"


async def test_encouragement_is_shown_as_it_is_said(spoken: AppDriver, voice: Voice) -> None:
    for _ in range(2):  # the greeting, and the instructions
        await voice.end(spoken)
    await spoken.do_attempt(await spoken.to_first_prompt())
    await voice.begin(spoken)
    feedback = spoken.said
    await voice.end(spoken)
    await spoken.wait(3000)
    assert voice.asked[-1][1] != feedback
    assert spoken.said == feedback
    await voice.begin(spoken)
    assert spoken.said == voice.asked[-1][1]


def longest(theme: Theme, among: list[str]) -> str:
    """Return the longest wording of some phrase keys, with long values in its slots."""
    slots = {**_LONG, "reference": max(theme.vocabulary.values(), key=len)}
    return max(
        (wording.format(**slots) for name in among for wording in theme.phrases[name]), key=len
    )


async def test_text_has_the_colour_of_its_valence_but_never_that_of_a_warning(
    driver: AppDriver, calm: Theme
) -> None:
    agent = driver.app.screen.query_one(Agent)
    colours = calm.colors
    expected = {"positive": colours.positive, "neutral": colours.neutral}
    for valence in ("positive", "neutral", "negative", None):
        agent.say("Well done.", "happy", valence)
        agent.say("Have a rest.", "sleeping", joins=True)
        await driver.settle()
        said, more = (
            agent.query_one(each).visual_style.foreground.rgb for each in (".said", ".more")
        )
        own = expected.get(valence or "", colours.text)
        assert said == pytest.approx(Color.parse(own).rgb, abs=1)
        assert more == pytest.approx(Color.parse(colours.text).rgb, abs=1)


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
        at_foot, press = driver.rows[-2:], driver.app.screen.query_one(KeyLine).render()  # type: ignore[attr-defined]
        agent = driver.app.screen.query_one(Agent)
        agent.say(words, "happy", "positive")
        agent.say(more, "encouraging", joins=True)
        agent.note(driver.app.screen.tr("The voice is silent; please read."))  # type: ignore[attr-defined]
        await driver.settle()
        assert driver.said.startswith(f"{words} {more} ")
        driver.see(str(press))
        assert driver.rows[-2:] == at_foot
