"""The delays of tones, on a card that nobody hears."""

import json

import pytest

from sar_tui.outputs.sound.protocol import SoundError
from sar_tui.timing import tones
from sar_tui.timing.tones import ToneDelays, measure_tones
from sar_tui.timing.verdict import error_statistics
from tests.outputs.voice_fixtures import NOBODY
from tests.program import Call


def test_the_delays_of_tones_are_measured() -> None:
    found = measure_tones(2, NOBODY)
    assert (found.card, found.at_once.n, found.planned.n) == ("Null", 2, 2)
    assert found.buffer_ms > 0


def test_without_a_sound_card_it_says_so() -> None:
    with pytest.raises(SoundError, match="There is no sound card that can be used"):
        measure_tones(2, ("JACK",))


@pytest.fixture
def delays(monkeypatch: pytest.MonkeyPatch) -> None:
    found = ToneDelays(
        "ALSA", 30.0, error_statistics([31.0, 35.0, 33.0]), error_statistics([0.01, 0.02, 0.03])
    )
    monkeypatch.setattr(tones, "measure_tones", lambda count, on_tone: found)


@pytest.mark.usefixtures("delays")
def test_the_command_prints_the_delays(call: Call) -> None:
    called = call("timing", "--sound", "--trials", "10")
    assert called.code == 0
    assert "requested at once" in called.out
    assert "ALSA: a sample waits 30 ms in its buffer" in called.out
    assert (
        json.loads(call("timing", "--sound", "--json").out)["sound"]["at_once"]["median_ms"] == 33.0
    )


def test_the_command_fails_with_a_sentence(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(count: int, on_tone: object) -> None:
        raise SoundError("There is no sound card.")

    monkeypatch.setattr(tones, "measure_tones", fail)
    called = call("timing", "--sound")
    assert (called.code, called.out) == (1, "")
    assert (
        called.err.splitlines()[-1]
        == "The delays of tones could not be measured. There is no sound card."
    )
