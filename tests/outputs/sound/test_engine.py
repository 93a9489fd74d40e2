"""The speech engine, real and fake: samples, or a clear error."""

import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

from sar_tui.outputs.sound.engine import Engine
from sar_tui.outputs.sound.protocol import SoundError, Voicing
from sar_tui.outputs.sound.samples import RATE, peak, seconds
from tests.needs_speech import needs_speech
from tests.outputs.voice_fixtures import ENGINE

pytestmark = needs_speech

ENGLISH = Voicing("en")
TEXTS = {
    "en": ("Well done.", "You were forty milliseconds faster than before.", "Press the key."),
    "de": ("Gut gemacht.", "Sie waren vierzig Millisekunden schneller.", "Drücken Sie die Taste."),
    "es": ("Muy bien hecho.", "Tu tiempo fue de quinientos milisegundos.", "Pulsa la tecla."),
}


@pytest.fixture(scope="module")
def engine() -> Engine:
    """The real engine: espeak-ng on Linux."""
    return Engine()


def stand_in(monkeypatch: pytest.MonkeyPatch, speak: str) -> None:
    """Replace pyttsx3 by another engine; ``speak`` is the body of its method that speaks a text."""
    fake = ModuleType("pyttsx3")
    exec(f"{ENGINE}\ndef speak(engine):\n    {speak}", fake.__dict__)
    monkeypatch.setitem(sys.modules, "pyttsx3", fake)


@pytest.mark.parametrize("language", TEXTS)
def test_speech_is_audible_and_lasts_as_long_as_speech_does(engine: Engine, language: str) -> None:
    assert engine.voice(Voicing(language)).speaks(language)
    for text in TEXTS[language]:
        samples = engine.speak(text, Voicing(language))
        assert peak(samples) > 0.1
        assert 0.2 < seconds(samples) / len(text.split()) < 0.9


def test_voice_and_rate_count_from_the_very_next_utterance(engine: Engine) -> None:
    """Without the engine's workaround, pyttsx3 sometimes loses a rate."""
    for language in ("en", "es", "de") * 2:
        slow, fast = (
            engine.speak(TEXTS[language][1], Voicing(language, rate=rate)) for rate in (100, 300)
        )
        assert seconds(fast) < 0.6 * seconds(slow)


def test_no_utterance_is_cut_short_or_runs_into_the_next(engine: Engine) -> None:
    long = "This is a much longer sentence. " * 10
    lengths = [
        (len(engine.speak(long, ENGLISH)), len(engine.speak("Well done.", ENGLISH)))
        for _ in range(4)
    ]
    for same in zip(*lengths, strict=True):
        assert max(same) - min(same) < 0.1 * RATE


def test_half_the_volume_is_half_as_loud_and_none_is_silence(engine: Engine) -> None:
    loud, soft, none = (
        peak(engine.speak("Well done.", Voicing("en", volume=volume))) for volume in (1.0, 0.5, 0.0)
    )
    assert soft == pytest.approx(loud / 2, rel=0.05), "espeak's loudness varies by about 1 %"
    assert none == 0


def test_a_language_without_a_voice_and_a_text_that_it_cannot_read_are_refused(
    engine: Engine,
) -> None:
    with pytest.raises(SoundError, match='no voice for the language "xx"'):
        engine.speak("Well done.", Voicing("xx"))
    with pytest.raises(SoundError, match="The voice cannot read this text") as caught:
        engine.speak("做得好", ENGLISH)
    assert caught.value.is_of_text


NO_SOUND = "gave no sound for this text"


@pytest.mark.parametrize(
    ("speak", "text", "says"),
    [
        ("beep(engine, level=10)", "Well done.", NO_SOUND),
        ("beep(engine, seconds=0.02)", "Well done.", NO_SOUND),
        ("beep(engine, seconds=0.2)", TEXTS["en"][1], NO_SOUND),
        (
            "engine.listeners['error'](name=None, exception=OSError('The disk is full'))",
            "Well done.",
            r"could not speak \(The disk is full\)",
        ),
        (
            "open(engine.path, 'wb').write(b'RIFF' + bytes([4, 0, 0, 0]) + b'what')",
            "Well done.",
            "gave no sound that can be read",
        ),
    ],
)
def test_speech_that_nobody_could_hear_that_is_cut_short_or_failed_is_refused(
    monkeypatch: pytest.MonkeyPatch, speak: str, text: str, says: str
) -> None:
    stand_in(monkeypatch, speak)
    with pytest.raises(SoundError, match=says) as caught:
        Engine().speak(text, ENGLISH)
    assert caught.value.is_of_text == (says == NO_SOUND)


def test_an_engine_that_writes_on_a_thread_of_its_own_is_waited_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stand_in(monkeypatch, "import threading; threading.Timer(0.1, beep, [engine]).start()")
    assert seconds(Engine().speak("Well done.", ENGLISH)) == pytest.approx(1.0)


def test_without_engine_or_package_it_says_what_to_install_and_works_once_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def init() -> object:
        raise RuntimeError("libespeak-ng.so.1: cannot open shared object file")

    engine = Engine()
    monkeypatch.setitem(sys.modules, "pyttsx3", SimpleNamespace(init=init))
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(SoundError, match=r"no speech engine: .*sudo apt install espeak-ng"):
        engine.voices()
    monkeypatch.setitem(sys.modules, "pyttsx3", None)
    with pytest.raises(SoundError, match="pip install pyttsx3"):
        engine.voices()
    stand_in(monkeypatch, "beep(engine)")
    assert [voice.id for voice in engine.voices()] == ["plain"]


def test_without_files_in_memory_a_private_folder_is_used_and_removed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    stand_in(
        monkeypatch,
        "beep(engine); seen.append((engine.path, "
        "oct(os.stat(os.path.dirname(engine.path)).st_mode)))",
    )
    seen = sys.modules["pyttsx3"].__dict__["seen"] = []
    assert seconds(Engine().speak("Well done.", ENGLISH)) == pytest.approx(1.0)
    ((path, mode),) = seen
    assert path.startswith(str(tmp_path))
    assert mode.endswith("700")
    assert list(tmp_path.iterdir()) == []
