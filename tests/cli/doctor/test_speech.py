"""The doctor reports whether a computer has speech and sound, and how to get them."""

import sys
from functools import partial

from sar_tui.cli.doctor.finding import Finding
from sar_tui.cli.doctor.speech import examine_voice, sound_card, speech_engine
from tests.needs_speech import needs_speech
from tests.outputs.voice_fixtures import ENGINE, NOBODY, program_with


@needs_speech
def test_an_engine_with_voices_for_each_language_is_ok() -> None:
    found = speech_engine(examine_voice)
    assert (found.name, found.state, found.advice) == ("Speech", "ok", "")
    assert found.found.endswith("voices, including English and Spanish")


def test_a_missing_spanish_voice_is_a_warning() -> None:
    found = speech_engine(partial(examine_voice, program_with(ENGINE)))
    assert (found.state, found.found) == ("care", "1 voice, but none for Spanish")
    assert "espeak-ng" in found.advice


def test_a_missing_engine_is_a_warning_with_what_to_install() -> None:
    found = speech_engine(partial(examine_voice, program_with("def init(): raise RuntimeError")))
    assert found.state == "care"
    assert "speech engine" in found.found
    assert found.advice.endswith("Without it, the agent's words are on the screen only.")


def test_a_sound_card_is_named_by_its_system() -> None:
    assert sound_card(partial(examine_voice, backends=NOBODY)) == Finding(
        "Sound card", "ok", "there is one, by Null"
    )


def test_a_missing_sound_card_is_a_warning_with_what_to_do() -> None:
    found = sound_card(partial(examine_voice, backends=("WASAPI",)))
    assert (found.name, found.state) == ("Sound card", "care")
    assert found.advice.startswith("Connect loudspeakers")


def test_a_voice_that_does_not_answer_is_a_warning() -> None:
    for look, name in ((speech_engine, "Speech"), (sound_card, "Sound card")):
        found = look(partial(examine_voice, [sys.executable, "-c", ""]))
        assert (found.name, found.state) == (name, "care")
        assert "stopped working" in found.found
