"""Sound as samples: makes tones, reads sound files, sets volume. Always 16 bit, one channel, one
sample rate.
"""

import math
import struct
import sys
import wave
from array import array
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from sar_tui.model.theme import Note
from sar_tui.outputs.sound.protocol import SoundError

RATE = 22_050
"""Samples per second: espeak's rate, and more than twice the highest tone."""
FULL = 32_767
"""Largest sample value."""
TONE_LEVEL = 0.25
"""Volume of a tone: about as loud as speech, so that it startles nobody."""
RAMP_S = 0.008
"""Time in which a note swells and fades, to avoid clicks."""
_MOST_CHUNKS, _MOST_CHANNELS, _FASTEST = 64, 8, 192_000
"""Limits above those of any speech engine's file."""
_UNKNOWN = "The speech engine gave sound in an unknown format ({})."


@lru_cache(maxsize=64)
def tone(notes: tuple[Note, ...]) -> "array[int]":
    """Return the notes of a tone in sequence, as sines that swell and fade as a raised cosine."""
    samples = array("h")
    for note in notes:
        count = round(RATE * note.ms / 1000)
        ramp = min(round(RATE * RAMP_S), count // 2)
        step = 2 * math.pi * note.hz / RATE
        for index in range(count):
            near = min(index, count - 1 - index)
            swell = 0.5 - 0.5 * math.cos(math.pi * near / ramp) if near < ramp else 1.0
            samples.append(round(FULL * TONE_LEVEL * swell * math.sin(step * index)))
    return samples


def seconds(samples: Sequence[int]) -> float:
    """Return the duration of samples."""
    return len(samples) / RATE


def peak(samples: Sequence[int]) -> float:
    """Return the largest absolute value, from 0 to 1."""
    highest, lowest = max(samples, default=0), min(samples, default=0)
    return max(highest, -lowest) / FULL


def at_volume(samples: "array[int]", volume: float) -> "array[int]":
    """Return samples at a volume from 0 to 1."""
    return samples if volume >= 1 else array("h", [int(sample * volume) for sample in samples])


class _Raw(NamedTuple):
    """Contents of a sound file, in this machine's byte order."""

    frames: bytes
    width: int
    channels: int
    rate: int


def is_whole(path: str) -> bool:
    """Return True if a sound file has the length in its header: it is shorter while it is being
    written.
    """
    try:
        with open(path, "rb") as file:
            kind, size = file.read(4), file.read(4)
            length = file.seek(0, 2)
    except OSError:
        return False
    stated = int.from_bytes(size, "big" if kind == b"FORM" else "little")
    return 0 < stated <= length - 8


def read(path: str) -> "array[int]":
    """Return the samples of a WAV file, or of an AIFF file, the format of macOS.

    Raises:
        SoundError: if it is neither, or its samples are of an unknown kind.
    """
    try:
        with open(path, "rb") as file:
            is_aiff = file.read(4) == b"FORM"
        raw = _read_aiff(path) if is_aiff else _read_wav(path)
    except (OSError, EOFError, OverflowError, RuntimeError, wave.Error, struct.error) as error:
        why = str(error) or "the file is empty"
        raise SoundError(f"The speech engine gave no sound that can be read ({why}).") from error
    if (raw.width, raw.channels, raw.rate) == (2, 1, RATE):
        return _words(raw.frames)
    return _converted(raw)


def _read_wav(path: str) -> _Raw:
    with wave.open(path, "rb") as file:
        width, frames = file.getsampwidth(), file.readframes(file.getnframes())
        if width == 2 and sys.byteorder == "big":
            frames = _swapped(frames)
        return _Raw(frames, width, file.getnchannels(), file.getframerate())


def _read_aiff(path: str) -> _Raw:
    """Read an AIFF or AIFF-C file of plain 16 bit samples (Apple's Audio Interchange File Format,
    1.3 and C draft).
    """
    with open(path, "rb") as file:
        data = file.read()
    chunks: dict[bytes, bytes] = {}
    place = 12
    while place + 8 <= len(data) and len(chunks) < _MOST_CHUNKS:
        name, size = struct.unpack_from(">4sL", data, place)
        chunks[name] = data[place + 8 : place + 8 + size]
        place += 8 + size + size % 2
    channels, _, bits, exponent, mantissa = struct.unpack_from(">hLhHQ", chunks.get(b"COMM", b""))
    encoding = chunks[b"COMM"][18:22] or b"NONE"
    if bits != 16 or encoding not in (b"NONE", b"twos", b"sowt"):
        raise SoundError(_UNKNOWN.format(f"{bits} bit, {encoding!r}"))
    (offset,) = struct.unpack_from(">L", chunks.get(b"SSND", b""))
    frames = chunks[b"SSND"][8 + offset :]
    if (encoding == b"sowt") != (sys.byteorder == "little"):
        frames = _swapped(frames)
    return _Raw(frames, 2, channels, round(math.ldexp(mantissa, exponent - 16_383 - 63)))


def _words(frames: bytes) -> "array[int]":
    """Return frames as samples; an incomplete sample at the end is dropped."""
    return array("h", frames[: len(frames) - len(frames) % 2])


def _swapped(frames: bytes) -> bytes:
    samples = _words(frames)
    samples.byteswap()
    return samples.tobytes()


def _converted(raw: _Raw) -> "array[int]":
    """Convert samples of another rate, width or number of channels."""
    import miniaudio

    kinds = {
        1: miniaudio.SampleFormat.UNSIGNED8,
        2: miniaudio.SampleFormat.SIGNED16,
        3: miniaudio.SampleFormat.SIGNED24,
        4: miniaudio.SampleFormat.SIGNED32,
    }
    if (
        raw.width not in kinds
        or not 1 <= raw.channels <= _MOST_CHANNELS
        or not 1 <= raw.rate <= _FASTEST
    ):
        raise SoundError(
            _UNKNOWN.format(f"{8 * raw.width} bit, {raw.channels} channels, {raw.rate} Hz")
        )
    whole = len(raw.frames) - len(raw.frames) % (raw.width * raw.channels)
    ours = miniaudio.SampleFormat.SIGNED16
    frames = miniaudio.convert_frames(
        kinds[raw.width], raw.channels, raw.rate, raw.frames[:whole], ours, 1, RATE
    )
    return array("h", bytes(frames))
