"""Every sentence of a participant's screens is spoken: once, in order, until a key interrupts it."""

import re
import wave
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from sar_tui.app.read_aloud import in_words, same_words
from sar_tui.model.language import BUNDLED
from sar_tui.outputs import outputs
from sar_tui.outputs.output import Output
from sar_tui.outputs.speech import Speech
from sar_tui.store import passphrase
from sar_tui.store.passphrase import Passphrase
from sar_tui.tui.language import app_language
from tests.app.app_driver import AppDriver, OpenApp, OpenSession, given, known
from tests.needs_speech import needs_speech

_ALOUD: dict[str, Any] = {"outputs": ["screen", "speech"], "read_aloud": True}


class Transcript:
    """All that is heard, in order: who says it, and what. What is read is over at once, or with
    ``is_slow`` not before it is stopped or ``finish`` is called.
    """

    def __init__(self) -> None:
        self.heard: list[tuple[str, str]] = []
        self.is_slow = False
        self.reader: _Voice

    @property
    def read(self) -> list[str]:
        """The texts that were read."""
        return [text for who, text in self.heard if who == "reader"]


class _Voice(Output):
    name = "speech"
    can = frozenset({"say"})

    def __init__(self, who: str, transcript: Transcript) -> None:
        self._who, self._transcript = who, transcript
        self.under_way = ""
        self.is_closed = False

    def say(self, action: str, text: str) -> None:
        self._transcript.heard.append((self._who, text))
        self.report(action, "say", "started")
        self.under_way = action
        if not (self._transcript.is_slow and self._who == "reader"):
            self._end("done")

    def finish(self) -> None:
        """End the sentence under way."""
        self._end("done")

    def stop(self, action: str = "") -> None:
        if self.under_way:
            self._end("aborted")

    def _end(self, state: Any) -> None:
        action, self.under_way = self.under_way, ""
        self.report(action, "say", state)

    def close(self) -> None:
        self.is_closed = True


@pytest.fixture
def transcript(monkeypatch: pytest.MonkeyPatch) -> Transcript:
    """All that the agent says, and all that is read."""
    made = Transcript()

    def open_voice(_: str) -> Output:
        made.reader = _Voice("reader", made)
        return made.reader

    monkeypatch.setattr("sar_tui.app.read_aloud.open_voice", open_voice)
    monkeypatch.setitem(outputs._SHIPPED, "speech", lambda text, sound: _Voice("agent", made))
    return made


def told(driver: AppDriver) -> list[str]:
    """Return the sentences that the screen declares."""
    screen: Any = driver.app.screen
    return list(screen.sentences)


def words(text: str) -> set[str]:
    """Return the words of a text."""
    return set(re.findall(r"[^\W\d_]{2,}", text.casefold()))


_SEEN = (
    "#question", "#decline", "#given", "#headline", "#text", "#ask", "#praise", "#which", "#facts",
    "#earlier", "#next", "KeyLine", "#menu", "#agent .words", "#agent .below", "#hello", "#exercise", "#how",
)  # fmt: skip
"""The parts of the screens that say something. The others are the place, progress and keys."""


def words_seen(driver: AppDriver) -> set[str]:
    """Return the words that can be read in the middle of the screen."""
    found = set()
    rows = driver.rows
    for selector in _SEEN:
        for part in driver.app.screen.query(selector):
            region = part.region
            inside = (row[region.x : region.right] for row in rows[region.y : region.bottom])
            found |= words(" ".join(inside)) if part.display else set()
    return found


async def until_agent_is_still(driver: AppDriver) -> None:
    """Wait until the agent has said and done what is due."""
    while driver.app.open_session and driver.session.is_agent_acting:
        await driver.wait(200)


class Listener:
    """Presses keys, and finds that all that is new on the screen is heard, once and in order."""

    def __init__(self, driver: AppDriver, transcript: Transcript, language: str = "en") -> None:
        self._driver, self._transcript = driver, transcript
        self._tr = app_language(language)
        self.screens = self.count = 0

    async def press(self, *keys: str) -> None:
        before = told(self._driver)
        self._transcript.heard.clear()
        await self._driver.press(*keys)
        await self.hear(before)

    async def hear(self, before: list[str]) -> None:
        await until_agent_is_still(self._driver)
        heard = self._transcript.heard
        said = " ".join(text for _, text in heard)
        unheard = words_seen(self._driver) - words(said) - words(" ".join(before))
        assert not unheard, f"{unheard} is seen and not heard: {heard}\n{self._driver.text}"
        read = self._transcript.read
        spoken = [in_words(sentence, self._tr) for sentence in told(self._driver)]
        order = [sentence for sentence in read if sentence in spoken]
        assert order == [sentence for sentence in spoken if sentence in read], "in order"
        assert max(Counter(read).values(), default=1) == 1, f"twice: {read}"
        self.screens += 1
        self.count += len(read)


async def test_each_sentence_of_a_session_is_heard_once_and_in_order(
    open_session: OpenSession, transcript: Transcript
) -> None:
    async with open_session(ask_wellbeing=True, questions=["exertion"], **_ALOUD) as driver:
        listener = Listener(driver, transcript)
        await listener.hear([])
        for key in given("2", "3", "1"):
            await listener.press(key)
        await listener.press("enter")
        while driver.waiting.stage != "review":
            if driver.waiting.step:
                await listener.press("2")
                await listener.press("enter")
            else:
                await driver.wait(300)
                await driver.press("enter")
                if driver.waiting.stage == "trial":
                    await driver.do_attempt(await driver.to_prompt())
                await listener.press()
        await driver.wait(300)
        await listener.press("enter")
        await driver.wait(300)
        await listener.press("enter")
        for key in ("2", "enter", "3", "enter", "1"):
            await listener.press(key)
    assert listener.screens > 10
    assert listener.count > 30


async def test_words_that_are_typed_are_not_read(
    open_session: OpenSession, transcript: Transcript
) -> None:
    async with open_session(attempts=1, questions=["remark"], **_ALOUD) as driver:
        await driver.do_attempt(await driver.to_first_prompt())
        await driver.wait(5000)
        assert "Type your answer, then press Enter." in transcript.read
        transcript.heard.clear()
        await driver.press("c", "o", "l", "d")
        driver.see("cold▏")
        assert transcript.read == []


async def test_nothing_is_read_from_the_foreperiod_to_the_response(
    open_session: OpenSession, transcript: Transcript
) -> None:
    transcript.is_slow = True
    async with open_session(**_ALOUD) as driver:
        prompt = await driver.to_first_prompt()
        assert not transcript.reader.under_way, "it was stopped before the trial"
        transcript.heard.clear()
        await driver.answer(prompt)
        await driver.to_prompt()
        assert transcript.read == []


async def test_any_key_interrupts_the_voice_and_one_repeats_the_screen(
    open_session: OpenSession, transcript: Transcript
) -> None:
    transcript.is_slow = True
    async with open_session(ask_wellbeing=True, **_ALOUD) as driver:
        assert transcript.read == ["How much pain do you have now?"]
        driver.see("F9 Say again")
        await driver.press("3")
        assert transcript.read[1:] == ["Chosen: 3."], "the rest of the question is left out"
        transcript.heard.clear()
        await driver.press("f9")
        for _ in range(3):
            transcript.reader.finish()
            await driver.settle()
        assert transcript.read == told(driver)[:4]
        await driver.press("q")
        assert not transcript.reader.under_way, "a key that means nothing ends it, too"


@pytest.mark.parametrize("code", sorted(BUNDLED))
async def test_the_key_that_repeats_fits_in_80_columns(
    open_session: OpenSession, transcript: Transcript, code: str
) -> None:
    key = f"F9 {app_language(code)('Say again')} "
    async with open_session(ask_wellbeing=True, language=code, **_ALOUD) as driver:
        assert key in f"{driver.rows[-1]} "
        await driver.press(*given("0", "0"))
        assert driver.screen_name == "SessionScreen"
        assert key in f"{driver.rows[-1]} "
        assert f"F1 {app_language(code)('Help')}" in driver.rows[-1]


async def test_a_window_that_is_too_small_is_told(
    open_session: OpenSession, transcript: Transcript
) -> None:
    async with open_session(ask_wellbeing=True, **_ALOUD) as driver:
        transcript.heard.clear()
        await driver.resize(60, 20)
        assert transcript.read[:2] == ["This window is too small.", "Please make it larger."]


async def test_the_choice_in_the_pause_menu_is_spoken_as_it_changes(
    open_session: OpenSession, transcript: Transcript
) -> None:
    async with open_session(**_ALOUD) as driver:
        await driver.to_first_prompt()
        transcript.heard.clear()
        await driver.press("escape")
        assert transcript.read[:2] == ["Paused", "Take your time."]
        assert transcript.read[-1] == "Go on"
        await driver.press("down")
        assert transcript.read[-1] == "I am tired"
        await driver.press("up")
        assert transcript.read[-1] == "Go on"


async def test_the_agent_is_not_interrupted_and_its_words_are_not_said_again(
    open_session: OpenSession, transcript: Transcript
) -> None:
    async with open_session(**_ALOUD) as driver:
        (instructions,) = (text for who, text in transcript.heard if who == "agent")
        assert not transcript.read, "the agent acts"
        await until_agent_is_still(driver)
        assert "Press Enter to go on." in transcript.read
        assert not set(transcript.read) & set(instructions.split(". "))
        await driver.press("enter")


async def test_without_the_setting_or_speech_nothing_is_read(
    open_session: OpenSession, transcript: Transcript
) -> None:
    for settings in ({"outputs": ["screen", "speech"]}, {"read_aloud": True}):
        async with open_session(ask_wellbeing=True, **settings) as driver:
            driver.lacks("Say again")
            await driver.press("f9", *given("0", "0"))
            assert transcript.read == []


async def test_what_is_read_is_not_recorded(
    open_session: OpenSession, transcript: Transcript
) -> None:
    async with open_session(**_ALOUD) as driver:
        await driver.do_session()
        await until_agent_is_still(driver)
        said = [text for who, text in transcript.heard if who == "agent"]
        recorded = [
            message for message in driver.messages("arbiter/action") if message.get("spoken")
        ]
        assert len(recorded) == len(said)
        assert transcript.read
        (parameters,) = driver.stored("SELECT parameters FROM sessions")
        assert '"read_aloud":true' in parameters[0].replace(" ", "")


async def test_patient_mode_is_read_from_its_first_screen(
    opened: OpenApp, data: Path, transcript: Transcript, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(passphrase, "_COST", 16)
    Passphrase(data).set("quiet morning")
    known(data, **_ALOUD)
    known(data, task="gonogo", **_ALOUD)
    async with opened(patient="P01") as driver:
        assert transcript.read[0].startswith("Good ")
        assert "Exercise 1 of 2" in transcript.read
        assert "Press Enter to start." in transcript.read
        await driver.press("down")
        assert transcript.read[-1] == "Skip this exercise"
        await driver.press("enter")
        assert "Exercise 2 of 2" in transcript.read


@pytest.mark.parametrize(
    ("language", "text", "said"),
    [
        ("en", "You took 0.43 seconds.", "You took zero point four three seconds."),
        ("de", "Sie brauchten 0,43 Sekunden.", "Sie brauchten null Komma vier drei Sekunden."),
        ("es", "Tardó 12,5 segundos.", "Tardó 12 coma cinco segundos."),
        ("en", "P01 · 2/10", "P zero one, 2 of 10"),
        ("en", "F9 says 20 sentences again.", "F9 says 20 sentences again."),
    ],
)
def test_figures_that_a_voice_misreads_become_words(language: str, text: str, said: str) -> None:
    assert in_words(text, app_language(language)) == said


@pytest.mark.slow
@needs_speech
@pytest.mark.parametrize("language", ["en", "de", "es"])
async def test_a_session_is_spoken_to_files_with_every_sentence(
    open_session: OpenSession, tmp_path: Path, language: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []
    say = Speech.say

    def noted(voice: Speech, action: str, text: str) -> None:
        asked.append(text)
        say(voice, action, text)

    monkeypatch.setattr(Speech, "say", noted)
    folder, tr = tmp_path / "sounds", app_language(language)
    settings = {**_ALOUD, "speech": f"file:{folder}", "language": language, "attempts": 1}
    async with open_session(ask_wellbeing=True, **settings) as driver:
        seen: list[str] = []

        async def hear(*keys: str) -> None:
            await driver.press(*keys)
            for _ in range(30):
                await driver.wait(2000)  # the next sentence begins when the app has heard the end
            seen.extend(told(driver))

        await hear()
        for key in given("2", "3", "1"):
            await hear(key)
        await hear("enter")
        await driver.do_attempt(await driver.begin())
        await hear()
        await hear("enter")
    assert len(seen) > 20
    spoken = " ".join(asked)  # figures are words, except in the utterances of the agent
    for sentence in seen:
        assert same_words(in_words(sentence, tr), spoken) or same_words(sentence, spoken)
    files = sorted(folder.glob("*-say.wav"))
    assert len(files) == len(asked)
    for path in files:
        with wave.open(str(path)) as sound:
            assert sound.getnframes() > sound.getframerate() // 10
