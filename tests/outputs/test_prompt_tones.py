"""Tones of prompts in a process of their own: on a card that is not there, on one that nobody hears, and in files."""

import queue
import wave
from collections.abc import Iterator
from pathlib import Path

import pytest

from sar_tui.framework.clock import MS, host_now
from sar_tui.framework.tone import Tone
from sar_tui.outputs.sound.tone_process import Onset, ToneProcess
from tests.outputs.voice_fixtures import DEADLINE_S, NOBODY

BEEP = Tone(880, 50)


class Player:
    """A process, and the onsets that it has reported."""

    def __init__(self, where: str = "sound", backends: tuple[str, ...] = NOBODY) -> None:
        self._onsets: queue.SimpleQueue[Onset] = queue.SimpleQueue()
        self.process = ToneProcess(self._onsets.put, where, backends)

    def next(self) -> Onset:
        return self._onsets.get(timeout=DEADLINE_S)


@pytest.fixture
def player() -> Iterator[Player]:
    player = Player()
    yield player
    player.process.close()


def test_the_onset_of_a_tone_is_by_the_clock_of_the_card(player: Player) -> None:
    player.process.prepare([BEEP])
    player.process.play(1, BEEP, 0)
    first = player.next()
    assert (first.job, first.source) == (1, "device")
    planned = host_now() + 2000 * MS
    player.process.play(2, BEEP, planned)
    onset = player.next()
    assert (onset.job, onset.source) == (2, "device")
    assert abs(onset.at - planned) < MS, "it is planned to the sample"


def test_the_loss_of_the_process_is_reported(player: Player) -> None:
    player.process.play(1, BEEP, 0)
    player.next()
    player.process._child.kill()
    lost = player.next()
    assert (lost.job, lost.source) == (0, "failed")
    assert "has ended" in lost.detail
    assert player.process.has_ended


def test_a_tone_without_a_card_fails_with_a_sentence() -> None:
    player = Player(backends=("JACK",))
    try:
        player.process.play(1, BEEP, 0)
        onset = player.next()
    finally:
        player.process.close()
    assert (onset.job, onset.source) == (1, "failed")
    assert "There is no sound card that can be used" in onset.detail


def test_a_repeated_tone_is_written_into_a_file(tmp_path: Path) -> None:
    player = Player(f"file:{tmp_path / 'sounds'}", ())
    try:
        player.process.play(1, Tone(500, 100, times=3, every_ms=400), 0)
        assert player.next().source == "host"
    finally:
        player.process.close()
    (file,) = (tmp_path / "sounds").iterdir()
    with wave.open(str(file), "rb") as sound:
        assert sound.getnframes() / sound.getframerate() == pytest.approx(0.9, abs=0.001)
