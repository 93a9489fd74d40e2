"""Speech by the real engine, and tones: played, written to files, timed on a virtual clock."""

import wave
from array import array
from pathlib import Path

import msgspec
import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.model.theme import TONES, Theme, Voice
from sar_tui.model.units import SECOND
from sar_tui.outputs.sound.mixer import Sound
from sar_tui.outputs.sound.samples import RATE, peak, tone
from sar_tui.outputs.speech import LONGEST
from tests.needs_speech import needs_speech
from tests.outputs.voice_fixtures import NOBODY, listening

pytestmark = needs_speech


WORDS = "You were forty milliseconds faster."


def spoken(path: Path) -> "array[int]":
    with wave.open(str(path)) as file:
        assert (file.getframerate(), file.getsampwidth(), file.getnchannels()) == (RATE, 2, 1)
        return array("h", file.readframes(file.getnframes()))


def rms(samples: "array[int]") -> float:
    return float((sum(each * each for each in samples) / len(samples)) ** 0.5)


def test_utterances_are_written_to_files_that_can_be_heard(calm: Theme, tmp_path: Path) -> None:
    with listening(Sound(f"file:{tmp_path}"), calm, VirtualClock()) as listener:
        listener.speech.say("a1", WORDS)
        listener.speech.say("a/2", "523")
    first, second = sorted(tmp_path.iterdir())
    assert (first.name, second.name) == ("001-a1-say.wav", "002-a-2-say.wav")
    for path, words in ((first, 5), (second, 4)):
        samples = spoken(path)
        assert rms(samples) > 500
        assert 0.2 < len(samples) / RATE / words < 0.9


def test_voice_rate_volume_and_language_of_the_theme_are_applied(
    calm: Theme, tmp_path: Path
) -> None:
    slow = Voice(rate=120)
    fast = Voice(rate=300, volume=0.3)
    american = Voice(rate=120, names={"en": "america"})
    with listening(Sound(f"file:{tmp_path}"), calm, VirtualClock()) as listener:
        for language, voice in (("en", slow), ("en", fast), ("en", american), ("es", slow)):
            theme = msgspec.structs.replace(calm, language=language, voice=voice)
            listener.speech.apply_theme(theme)
            listener.speech.say("a1", WORDS)
    first, faster, *others = (spoken(path) for path in sorted(tmp_path.iterdir()))
    assert len(faster) < 0.6 * len(first)
    assert peak(faster) < 0.5 * peak(first)
    assert first not in others


def test_on_a_virtual_clock_speech_takes_its_time_on_that_clock_only(
    calm: Theme, tmp_path: Path
) -> None:
    clock = VirtualClock()
    with listening(Sound(f"file:{tmp_path}"), calm, clock) as listener:
        listener.speech.say("a1", WORDS)
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
        listener.speech.say("a1", WORDS)
        clock.advance(20 * SECOND)
        assert listener.states("a1") == ["started", "done"]


def test_in_real_time_a_file_takes_as_long_as_it_would_sound(calm: Theme, tmp_path: Path) -> None:
    with listening(Sound(f"file:{tmp_path}"), calm) as listener:
        listener.speech.say("a1", "Good.")
        lasted = listener.wait("a1", "done").at - listener.wait("a1", "started").at
    (path,) = tmp_path.iterdir()
    assert lasted / SECOND >= len(spoken(path)) / RATE


def test_an_invalid_utterance_fails_in_its_turn(calm: Theme) -> None:
    invalid = {
        "": "the text is empty.",
        " \x00\n": "the text is empty.",
        "word " * LONGEST: f"{5 * LONGEST - 1} characters, of at most {LONGEST}.",
        "👍": "it has neither letters nor digits.",
    }
    with listening(Sound(backends=NOBODY), calm) as listener:
        listener.speech.say("valid", "Good.")
        for number, (text, says) in enumerate(invalid.items()):
            listener.speech.say(f"a{number}", text)
            assert listener.wait(f"a{number}", "failed").detail.endswith(says)
        assert [report.state for report in listener.reports] == ["started", "done", *["failed"] * 4]


def test_each_of_the_themes_tones_sounds(calm: Theme, tmp_path: Path) -> None:
    with listening(Sound(f"file:{tmp_path}"), calm, VirtualClock()) as listener:
        for name in TONES:
            listener.tones.tone(name, name)
    written = sorted(tmp_path.iterdir())
    assert [path.name for path in written] == [
        f"{n:03d}-{name}-tone.wav" for n, name in enumerate(TONES, 1)
    ]
    assert [spoken(path) for path in written] == [tone(calm.notes(name)) for name in TONES]
