"""Tones: they play in order with everything requested before."""

import wave
from pathlib import Path

import msgspec
import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.model.theme import TONES, Note, Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.sound.mixer import Sound
from sar_tui.outputs.sound.samples import tone
from tests.needs_speech import needs_speech
from tests.outputs.voice_fixtures import NOBODY, listening


def frames(path: Path) -> bytes:
    with wave.open(str(path)) as file:
        return file.readframes(file.getnframes())


def test_each_of_the_themes_tones_sounds(calm: Theme, tmp_path: Path) -> None:
    with listening(Sound(f"file:{tmp_path}"), calm, VirtualClock()) as listener:
        for name in TONES:
            listener.tones.tone(name, name)
    written = sorted(tmp_path.iterdir())
    assert [path.name for path in written] == [
        f"{n:03d}-{name}-tone.wav" for n, name in enumerate(TONES, 1)
    ]
    assert [frames(path) for path in written] == [
        tone(calm.notes(name)).tobytes() for name in TONES
    ]


@needs_speech
def test_tones_follow_each_other_and_speech(calm: Theme) -> None:
    with listening(Sound(backends=NOBODY), calm) as listener:
        listener.tones.tone("t1", "go")
        listener.speech.say("s1", "Good.")
        listener.tones.tone("t2", "success")
        listener.wait("t2", "done")
        assert [(report.action, report.state) for report in listener.reports] == [
            (action, state) for action in ("t1", "s1", "t2") for state in ("started", "done")
        ]
        times = [report.at for report in listener.reports]
        assert times == sorted(times)


def test_a_tone_lasts_as_long_as_its_notes(calm: Theme) -> None:
    clock = VirtualClock()
    theme = msgspec.structs.replace(
        calm, tones={"go": (Note(440, 500), Note(0, 250), Note(880, 250))}
    )
    with listening(Sound(), theme, clock) as listener:
        listener.tones.tone("t1", "go")
        clock.advance(SECOND)
        assert listener.wait("t1", "done").at == pytest.approx(SECOND, abs=MS)


def test_a_tone_that_the_theme_lacks_fails(calm: Theme) -> None:
    with listening(Sound(), calm, VirtualClock()) as listener:
        listener.tones.tone("t1", "trumpet")
        assert listener.wait("t1", "failed").detail == "The theme has no tone 'trumpet'."


def test_stop_of_one_tone_leaves_the_others(calm: Theme) -> None:
    clock = VirtualClock()
    with listening(Sound(), calm, clock) as listener:
        for action in ("t1", "t2", "t3"):
            listener.tones.tone(action, "go")
        listener.tones.stop("t2")
        clock.advance(SECOND)
        assert listener.states("t2") == ["aborted"]
        assert listener.states("t1") == listener.states("t3") == ["started", "done"]
