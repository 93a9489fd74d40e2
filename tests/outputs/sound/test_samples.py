"""Samples made from notes and sound files."""

import contextlib
import itertools
import math
import struct
import sys
import wave
from array import array
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model.theme import Note
from sar_tui.outputs.sound.protocol import SoundError
from sar_tui.outputs.sound.samples import (
    FULL,
    RATE,
    TONE_LEVEL,
    at_volume,
    is_whole,
    peak,
    read,
    seconds,
    tone,
)


def hum(rate: int, length: int, channels: int = 1) -> "array[int]":
    turn = 2 * math.pi * 200 / rate
    return array("h", [round(8000 * math.sin(turn * (n // channels))) for n in range(length)])


HUM = hum(RATE, RATE // 4)


def wav(path: Path, frames: bytes, width: int = 2, channels: int = 1, rate: int = RATE) -> str:
    with wave.open(str(path), "wb") as file:
        file.setsampwidth(width)
        file.setnchannels(channels)
        file.setframerate(rate)
        file.writeframes(frames)
    return str(path)


def aiff(path: Path, frames: bytes, encoding: bytes = b"", rate: int = RATE, bits: int = 16) -> str:
    exponent = rate.bit_length() - 1
    of_rate = (16_383 + exponent, rate << (63 - exponent))
    comm = struct.pack(">hLhHQ", 1, len(frames) // 2, bits, *of_rate) + encoding
    body = b"AIFC" if encoding else b"AIFF"
    for name, data in ((b"COMM", comm), (b"SSND", bytes(8) + frames)):
        body += name + struct.pack(">L", len(data)) + data + bytes(len(data) % 2)
    path.write_bytes(b"FORM" + struct.pack(">L", len(body)) + body)
    return str(path)


def in_order(samples: "array[int]", order: str) -> bytes:
    other = array("h", samples)
    if order != sys.byteorder:
        other.byteswap()
    return other.tobytes()


def rises_through_zero(samples: "array[int]") -> int:
    return sum(a < 0 <= b for a, b in itertools.pairwise(samples))


def test_a_tone_lasts_as_long_as_its_notes_which_have_their_frequency() -> None:
    assert seconds(tone((Note(660, 110), Note(880, 170)))) == pytest.approx(0.28, abs=0.001)
    assert peak(tone((Note(0, 100),))) == 0, "no frequency is silence"
    for hz in (100, 440, 880, 3000):
        assert rises_through_zero(tone((Note(hz, 1000),))) == pytest.approx(hz, abs=1)


_NOTES = st.builds(Note, hz=st.floats(50, 2000), ms=st.integers(10, 300))


@given(st.lists(_NOTES, min_size=1, max_size=4))
def test_no_tone_clicks(notes: list[Note]) -> None:
    """A click is a step between samples that the sine itself does not make."""
    samples = tone(tuple(notes))
    highest = max(note.hz for note in notes)
    steepest = FULL * TONE_LEVEL * 2 * math.pi * (highest / RATE + 1 / (2 * RATE * 0.005))
    assert (samples[0], samples[-1]) == (0, 0)
    assert max(abs(b - a) for a, b in itertools.pairwise(samples)) <= steepest + 1
    assert peak(samples) <= TONE_LEVEL + 1 / FULL


def test_half_the_volume_is_half_the_samples_and_the_peak_is_farthest_from_silence() -> None:
    assert at_volume(array("h", [1000, -1000, 3]), 0.5).tolist() == [500, -500, 1]
    assert at_volume(HUM, 1.0) == HUM
    assert peak(at_volume(HUM, 0.0)) == 0
    assert peak(array("h", [100, -FULL, 5])) == 1.0
    assert peak(array("h")) == 0.0


@pytest.mark.parametrize(("rate", "channels"), [(16_000, 1), (44_100, 2), (48_000, 1)])
def test_a_wav_file_of_another_rate_sounds_the_same_for_as_long(
    tmp_path: Path, rate: int, channels: int
) -> None:
    frames = in_order(hum(rate, rate * channels, channels), "little")
    samples = read(wav(tmp_path / "a.wav", frames, channels=channels, rate=rate))
    assert seconds(samples) == pytest.approx(1, abs=0.01)
    assert rises_through_zero(samples) == pytest.approx(200, abs=2)


def test_a_wav_file_of_8_bits_is_read(tmp_path: Path) -> None:
    frames = bytes(228 if n % 100 < 50 else 28 for n in range(RATE))
    samples = read(wav(tmp_path / "a.wav", frames, width=1))
    assert seconds(samples) == pytest.approx(1, abs=0.01)
    assert peak(samples) == pytest.approx(100 / 128, abs=0.05)


def test_wav_files_and_aiff_files_as_written_by_macos_come_out_as_they_went_in(
    tmp_path: Path,
) -> None:
    assert read(wav(tmp_path / "a.wav", in_order(HUM, "little"))) == HUM
    orders = {b"": "big", b"NONE": "big", b"twos": "big", b"sowt": "little"}
    for encoding, order in orders.items():
        assert read(aiff(tmp_path / "a.wav", in_order(HUM, order), encoding)) == HUM
    samples = read(aiff(tmp_path / "a.wav", in_order(HUM, "big"), rate=2 * RATE))
    assert len(samples) == pytest.approx(len(HUM) / 2, abs=10)


@pytest.mark.parametrize("content", [None, b"", b"RIFF", b"not a sound", b"FORM\0\0\0\0AIFF"])
def test_a_file_that_is_no_sound_is_refused_in_words(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "a.wav"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SoundError, match="The speech engine gave no sound that can be read"):
        read(str(path))
    with pytest.raises(SoundError, match="24 bit"):
        read(aiff(tmp_path / "other.wav", bytes(30), bits=24))


@pytest.mark.parametrize("make", [wav, aiff])
def test_a_file_is_whole_once_it_is_as_long_as_it_says(
    tmp_path: Path, make: Callable[[Path, bytes], str]
) -> None:
    path = tmp_path / "a.wav"
    assert not is_whole(str(path))
    whole = Path(make(path, HUM.tobytes())).read_bytes()
    assert is_whole(str(path))
    for length in (0, 3, 8, 50, len(whole) - 1):
        path.write_bytes(whole[:length])
        assert not is_whole(str(path))


@given(st.data())
def test_a_damaged_file_is_read_or_refused(tmp_path: Path, data: st.DataObject) -> None:
    path = tmp_path / "damaged.wav"
    whole = bytearray(
        Path(data.draw(st.sampled_from([wav, aiff]))(path, in_order(HUM[:40], "big"))).read_bytes()
    )
    for place in data.draw(st.lists(st.integers(0, 60), max_size=6)):
        whole[place] = data.draw(st.integers(0, 255))
    path.write_bytes(whole[: data.draw(st.integers(0, len(whole)))])
    with contextlib.suppress(SoundError):
        assert read(str(path)).typecode == "h"
