"""Speech by the real engine: played, written to files, and timed on a virtual clock."""

import wave
from array import array
from pathlib import Path

import msgspec
import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.model.theme import Theme, Voice
from sar_tui.model.units import SECOND
from sar_tui.outputs.sound.mixer import Sound
from sar_tui.outputs.sound.samples import RATE, peak
from sar_tui.outputs.speech import LONGEST
from tests.needs_speech import needs_speech
from tests.outputs.voice_fixtures import LONG, NOBODY, listening

pytestmark = needs_speech

WORDS = {
    "en": "You were forty milliseconds faster.",
    "es": "Fuiste cuarenta milisegundos más rápido.",
}


def spoken(path: Path) -> "array[int]":
    with wave.open(str(path)) as file:
        assert (file.getframerate(), file.getsampwidth(), file.getnchannels()) == (RATE, 2, 1)
        return array("h", file.readframes(file.getnframes()))


def rms(samples: "array[int]") -> float:
    return float((sum(each * each for each in samples) / len(samples)) ** 0.5)


def in_language(theme: Theme, language: str, voice: Voice | None = None) -> Theme:
    return msgspec.structs.replace(theme, language=language, voice=voice or theme.voice)


@pytest.mark.parametrize("language", WORDS)
def test_utterances_are_written_to_files_that_can_be_heard(
    calm: Theme, tmp_path: Path, language: str
) -> None:
    clock = VirtualClock()
    with listening(Sound(f"file:{tmp_path}"), in_language(calm, language), clock) as listener:
        listener.speech.say("a1", WORDS[language])
        listener.speech.say("a/2", "523")
    first, second = sorted(tmp_path.iterdir())
    assert (first.name, second.name) == ("001-a1-say.wav", "002-a-2-say.wav")
    for path, words in ((first, 5), (second, 4)):
        samples = spoken(path)
        assert rms(samples) > 500
        assert 0.2 < len(samples) / RATE / words < 0.9


def test_voice_rate_and_volume_of_the_theme_are_applied(calm: Theme, tmp_path: Path) -> None:
    clock = VirtualClock()
    with listening(
        Sound(f"file:{tmp_path}"), in_language(calm, "en", Voice(rate=120)), clock
    ) as listener:
        listener.speech.say("a1", WORDS["en"])
        for voice in (Voice(rate=300, volume=0.3), Voice(rate=120, names={"en": "america"})):
            listener.speech.apply_theme(in_language(calm, "en", voice))
            listener.speech.say("a2", WORDS["en"])
    slow, fast, american = (spoken(path) for path in sorted(tmp_path.iterdir()))
    assert len(fast) < 0.6 * len(slow)
    assert peak(fast) < 0.5 * peak(slow)
    assert american != slow


def test_on_a_virtual_clock_speech_takes_its_time_on_that_clock_only(
    calm: Theme, tmp_path: Path
) -> None:
    clock = VirtualClock()
    with listening(Sound(f"file:{tmp_path}"), calm, clock) as listener:
        listener.speech.say("a1", WORDS["en"])
        listener.tones.tone("a1-tone", "go")
        assert listener.states("a1") == ["started"]
        clock.advance(20 * SECOND)
        (words, _) = (len(spoken(path)) / RATE for path in sorted(tmp_path.iterdir()))
        reported = {
            (report.action, report.state): report.at / SECOND for report in listener.reports
        }
    assert reported == {
        ("a1", "started"): 0,
        ("a1", "done"): pytest.approx(words),
        ("a1-tone", "started"): pytest.approx(words),
        ("a1-tone", "done"): pytest.approx(words + 0.12),
    }


def test_on_a_virtual_clock_there_is_no_sound_and_no_sound_card(calm: Theme) -> None:
    clock = VirtualClock()
    with listening(Sound(backends=("WASAPI",)), calm, clock) as listener:
        listener.speech.say("a1", WORDS["en"])
        clock.advance(20 * SECOND)
        assert listener.states("a1") == ["started", "done"]


def test_on_a_virtual_clock_a_stop_aborts_and_the_rest_goes_on(calm: Theme) -> None:
    clock = VirtualClock()
    with listening(Sound(), calm, clock) as listener:
        for action in ("a1", "a2", "a3"):
            listener.speech.say(action, LONG)
        listener.tones.tone("b1", "go")
        clock.advance(SECOND)
        listener.speech.stop("a2")
        listener.speech.stop("a1")
        assert listener.states("a1") == ["started", "aborted"]
        assert (listener.states("a2"), listener.states("a3")) == (["aborted"], ["started"])
        listener.speech.stop()
        clock.advance(SECOND)
        assert listener.states("a3") == ["started", "aborted"]
        assert listener.states("b1") == ["started", "done"]
        assert listener.wait("a3").at == SECOND


def test_in_real_time_a_file_takes_as_long_as_it_would_sound(calm: Theme, tmp_path: Path) -> None:
    with listening(Sound(f"file:{tmp_path}"), calm) as listener:
        listener.speech.say("a1", "Good.")
        lasted = listener.wait("a1", "done").at - listener.wait("a1", "started").at
    (path,) = tmp_path.iterdir()
    assert lasted / SECOND >= len(spoken(path)) / RATE


def test_in_real_time_a_stop_cuts_a_file_short(calm: Theme, tmp_path: Path) -> None:
    with listening(Sound(f"file:{tmp_path}"), calm) as listener:
        listener.speech.say("a1", LONG * 20)
        listener.wait("a1", "started")
        listener.speech.stop()
        assert listener.wait("a1").state == "aborted"


def test_a_folder_that_cannot_take_files_fails_each_utterance_with_the_reason(
    calm: Theme, tmp_path: Path
) -> None:
    (tmp_path / "taken").write_text("a file")
    with listening(Sound(f"file:{tmp_path / 'taken'}"), calm, VirtualClock()) as listener:
        listener.speech.say("a1", WORDS["en"])
        assert "cannot take sound files" in listener.wait("a1", "failed").detail


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "the text is empty."),
        (" \x00\n", "the text is empty."),
        ("word " * LONGEST, f"{5 * LONGEST - 1} characters, of at most {LONGEST}."),
        ("👍", "it has neither letters nor digits."),
    ],
)
def test_an_invalid_utterance_fails_in_its_turn(calm: Theme, text: str, says: str) -> None:
    with listening(Sound(backends=NOBODY), calm) as listener:
        listener.speech.say("a1", "Good.")
        listener.speech.say("a2", text)
        assert listener.wait("a2", "failed").detail.endswith(says)
        assert [report.state for report in listener.reports] == ["started", "done", "failed"]


def test_a_language_without_a_voice_fails_with_what_to_do(calm: Theme) -> None:
    with listening(Sound(), in_language(calm, "xx"), VirtualClock()) as listener:
        listener.speech.say("a1", "Good.")
        assert listener.wait("a1", "failed").detail.startswith(
            'There is no voice for the language "xx": '
        )
