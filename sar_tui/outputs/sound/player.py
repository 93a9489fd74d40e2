"""Where samples go: the sound card, files in a folder, or nowhere. Used by the child process alone."""

import os
import threading
import wave
from array import array
from collections.abc import Callable, Generator
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

from sar_tui.framework.clock import host_now
from sar_tui.outputs.sound.protocol import SoundError
from sar_tui.outputs.sound.samples import RATE, seconds

_PERIOD_MS = 10
_PERIODS = 4
BUFFER_S = _PERIODS * _PERIOD_MS / 1000
"""How long a sample waits in the sound card's buffer before it is heard."""
_STALLED_S = 2.0
"""A sound card that has taken nothing for this long no longer works."""

_NO_PACKAGE = "Sound needs the Python package miniaudio: pip install miniaudio."
_NO_CARD = (
    "There is no sound card that can be used ({}): connect loudspeakers, and choose them in the system's settings."
)
_STALLED = "The sound card has stopped taking sound: connect the loudspeakers again, or choose others."

Began = Callable[[int, float], object]
"""Called as the first samples are fed, with the time (ns, `host_now`) and how long they will last (s)."""


class Turn:
    """A job under way, which another thread may halt."""

    def __init__(self) -> None:
        self.is_halted = False
        self.wake = threading.Event()

    def halt(self) -> None:
        self.is_halted = True
        self.wake.set()


class Place(Protocol):
    """Where samples go."""

    def play(self, name: str, samples: "array[int]", turn: Turn, began: Began) -> None:
        """Sound them, and return when the last has been heard, or as soon as the turn is halted.

        Raises:
            SoundError: they cannot be sounded.
        """
        ...


class Card:
    """The system's default sound card. It is opened once, and again after it failed, but runs only while it sounds."""

    def __init__(self, backends: tuple[str, ...] = ()) -> None:
        self._backends = backends
        self._device: Any = None

    def open(self) -> str:
        """Open it, if it is not yet, and tell the name of its sound system.

        Raises:
            SoundError: there is none; it says what to do.
        """
        if self._device is None:
            try:
                import miniaudio
            except ImportError as error:
                raise SoundError(_NO_PACKAGE) from error
            real = [each for each in miniaudio.Backend if each.name not in ("NULL", "CUSTOM")]
            backends = [miniaudio.Backend[each] for each in self._backends] or real
            try:
                self._device = miniaudio.PlaybackDevice(
                    miniaudio.SampleFormat.SIGNED16, 1, RATE, _PERIOD_MS, callback_periods=_PERIODS, backends=backends
                )
            except miniaudio.MiniaudioError as error:
                raise SoundError(_NO_CARD.format(error.args[0])) from error
        return str(self._device.backend)

    def play(self, name: str, samples: "array[int]", turn: Turn, began: Began) -> None:
        try:
            self.open()
            self._play(samples, turn, began)
        except SoundError:
            self._close()
            raise

    def _play(self, samples: "array[int]", turn: Turn, began: Began) -> None:
        import miniaudio

        feed = _Feed(samples, turn)
        try:
            self._device.start(feed.samples)
            self._watch(feed, turn, began)
            self._device.stop()
        except miniaudio.MiniaudioError as error:
            raise SoundError(_NO_CARD.format(error.args[0])) from error

    def _watch(self, feed: "_Feed", turn: Turn, began: Began) -> None:
        """Wait until all is heard, or the turn is halted."""
        if not feed.begun.wait(_STALLED_S):
            raise SoundError(_STALLED)
        began(feed.at, seconds(feed.all))
        reached = -1
        while not (feed.is_over or turn.is_halted):
            if not turn.wake.wait(_STALLED_S) and feed.reached == reached:
                raise SoundError(_STALLED)
            reached = feed.reached
        if not turn.is_halted:
            turn.wake.clear()
            if not turn.is_halted:
                turn.wake.wait(BUFFER_S)

    def _close(self) -> None:
        device, self._device = self._device, None
        if device is not None:
            device.close()


class _Feed:
    """Hands samples to the sound card, on the card's own thread; none any more once the turn is halted."""

    def __init__(self, samples: "array[int]", turn: Turn) -> None:
        self.all = samples
        self.turn = turn
        self.at = 0
        self.reached = 0
        self.is_over = False
        self.begun = threading.Event()
        self.samples = self._feed()
        next(self.samples)

    def _feed(self) -> Generator["array[int]", int, None]:
        nothing = array("h")
        frames = yield nothing
        self.at = host_now()
        self.begun.set()
        while self.reached < len(self.all) and not self.turn.is_halted:
            chunk = self.all[self.reached : self.reached + frames]
            self.reached += frames
            frames = yield chunk
        self.is_over = True
        self.turn.wake.set()
        while True:
            yield nothing


class Folder:
    """WAV files in a folder, numbered in their order; nothing that is there is overwritten.

    In real time, a file takes as long as its sound would.
    """

    def __init__(self, folder: str, in_real_time: bool) -> None:
        self._folder = Path(folder)
        self._in_real_time = in_real_time
        self._number: int | None = None

    def play(self, name: str, samples: "array[int]", turn: Turn, began: Began) -> None:
        try:
            self._write(name, samples)
        except OSError as error:
            raise SoundError(
                f"{self._folder} cannot take sound files ({error.strerror or error}): choose another folder."
            ) from error
        began(host_now(), seconds(samples))
        if self._in_real_time:
            turn.wake.wait(seconds(samples))

    def _write(self, name: str, samples: "array[int]") -> None:
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        path, handle = self._next(name)
        try:
            with os.fdopen(handle, "wb") as file, wave.open(file, "wb") as sound:
                sound.setnchannels(1)
                sound.setsampwidth(2)
                sound.setframerate(RATE)
                sound.writeframes(samples.tobytes())
        except OSError:
            path.unlink(missing_ok=True)
            raise

    def _next(self, name: str) -> tuple[Path, int]:
        """Make the next file. Another session may write to the same folder: what it has taken is passed over."""
        if self._number is None:
            starts = (each.name.partition("-")[0] for each in self._folder.iterdir())
            self._number = max((int(start) for start in starts if start.isdecimal()), default=0)
        while True:
            self._number += 1
            path = self._folder / f"{self._number:03d}-{name}.wav"
            with suppress(FileExistsError):
                return path, os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)


class Nowhere:
    """No sound at all: only how long it would last. For sessions whose clock jumps."""

    def play(self, name: str, samples: "array[int]", turn: Turn, began: Began) -> None:
        began(host_now(), seconds(samples))
