"""Playback to a card or a folder: it takes the samples' time, and can be halted."""

import stat
import sys
import threading
import wave
from array import array
from pathlib import Path
from typing import Any

import pytest

from sar_tui.model.theme import Note
from sar_tui.outputs.sound.player import Destination, Folder, NoSound, Playback, SoundCard
from sar_tui.outputs.sound.protocol import SoundError
from sar_tui.outputs.sound.samples import tone
from tests.outputs.voice_fixtures import DEADLINE_S, NOBODY

BEEP = tone((Note(880, 200),))


class Began:
    """Records the start of a sound, and may halt it then."""

    def __init__(self, halts: Playback | None = None) -> None:
        self.reports: list[tuple[int, float]] = []
        self._halts = halts

    def __call__(self, at: int, lasts: float) -> None:
        self.reports.append((at, lasts))
        if self._halts:
            self._halts.halt()


AS_A_FILE: Any = ("a1-say", BEEP, Playback(), Began())


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.mark.parametrize("destination", [SoundCard(NOBODY), NoSound()], ids=["card", "nowhere"])
def test_the_onset_and_duration_of_a_sound_are_reported_once(destination: Destination) -> None:
    began = Began()
    destination.play("a", BEEP, Playback(), began)
    ((at, lasts),) = began.reports
    assert at > 0
    assert lasts == pytest.approx(0.2, abs=0.001)


@pytest.mark.parametrize("in_real_time", [True, False])
def test_a_file_holds_the_samples_and_is_private(tmp_path: Path, in_real_time: bool) -> None:
    folder = tmp_path / "new" / "sounds"
    Folder(str(folder), in_real_time).play(*AS_A_FILE)
    (path,) = folder.iterdir()
    assert path.name == "001-a1-say.wav"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    with wave.open(str(path)) as file:
        assert array("h", file.readframes(file.getnframes())) == BEEP


def test_files_are_numbered_after_what_is_there_and_nothing_is_overwritten(tmp_path: Path) -> None:
    for name in ("007-a1-say.wav", "notes.txt", "x-y.wav"):
        (tmp_path / name).write_text("mine")
    mine, yours = Folder(str(tmp_path), False), Folder(str(tmp_path), False)
    for destination in (mine, yours, yours, mine, mine):
        destination.play(*AS_A_FILE)
    found = contents(tmp_path)
    assert [name for name in found if found[name] != b"mine"] == [
        f"{n:03d}-a1-say.wav" for n in (8, 9, 10, 11, 12)
    ]
    for name in ("notes.txt", "notes.txt/below"):
        with pytest.raises(SoundError, match=r"cannot take sound files \(.+\): choose another"):
            Folder(str(tmp_path / name), True).play(*AS_A_FILE)


@pytest.mark.parametrize("made", ["card", "folder"])
def test_a_halt_cuts_it_short(tmp_path: Path, made: str) -> None:
    destination: Destination = SoundCard(NOBODY) if made == "card" else Folder(str(tmp_path), True)
    playback = Playback()
    forever = tone((Note(880, 1000),)) * 60
    playing = threading.Thread(
        target=destination.play, args=("a", forever, playback, Began(halts=playback))
    )
    playing.start()
    playing.join(DEADLINE_S)
    assert not playing.is_alive()


def test_a_card_that_stops_taking_sound_is_reported_in_words_and_reopened(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    import miniaudio

    monkeypatch.setattr("sar_tui.outputs.sound.player._STALLED_S", 0.05)
    card = SoundCard(NOBODY)
    with monkeypatch.context() as unplugged:
        unplugged.setattr(miniaudio.PlaybackDevice, "start", lambda self, feed: None)
        with pytest.raises(SoundError, match="The sound card has stopped taking sound"):
            card.play(*AS_A_FILE)
    began = Began()
    card.play("a", BEEP, Playback(), began)
    assert len(began.reports) == 1


def test_a_missing_card_one_that_refuses_to_start_and_a_missing_package_are_reported_in_words(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    import miniaudio

    def refuse(device: object, feed: object) -> None:
        raise miniaudio.MiniaudioError("failed to start audio device", -1)

    missing = SoundCard(("WASAPI", "SNDIO"))
    for _ in range(2):
        with pytest.raises(SoundError, match="There is no sound card that can be used"):
            missing.play(*AS_A_FILE)
    monkeypatch.setattr(miniaudio.PlaybackDevice, "start", refuse)
    with pytest.raises(SoundError, match="failed to start audio device"):
        SoundCard(NOBODY).play(*AS_A_FILE)
    monkeypatch.setitem(sys.modules, "miniaudio", None)
    with pytest.raises(SoundError, match="pip install miniaudio"):
        SoundCard().open()
