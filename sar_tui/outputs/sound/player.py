"""Destinations of samples: the sound card, files in a folder, or none. Only the voice process uses
them.
"""

import os
import threading
import wave
from array import array
from collections.abc import Callable, Generator
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

from sar_tui.drivers.files import make_private
from sar_tui.drivers.installation import pip_install
from sar_tui.loop.clock import host_now
from sar_tui.outputs.sound.protocol import SoundError
from sar_tui.outputs.sound.samples import RATE, seconds

_PERIOD_MS = 10
_PERIODS = 4
BUFFER_S = _PERIODS * _PERIOD_MS / 1000
"""Time that a sample spends in the sound card's buffer."""
_STALLED_S = 2.0
"""A sound card that has taken no samples for this long has failed."""

_NO_PACKAGE = f"Sound needs the Python package miniaudio: {pip_install('miniaudio')}."
_NO_CARD = (
    "There is no sound card that can be used ({}): connect loudspeakers, and choose them "
    "in the system's settings."
)
_STALLED = (
    "The sound card has stopped taking sound: connect the loudspeakers again, or choose others."
)

Began = Callable[[int, float], object]
"""Called when the first samples are fed, with the time (ns, `host_now`) and the duration (s)."""


class Playback:
    """A job under way that another thread may halt."""

    def __init__(self) -> None:
        self.is_halted = False
        self.wake = threading.Event()

    def halt(self) -> None:
        self.is_halted = True
        self.wake.set()


class Destination(Protocol):
    """A destination of samples."""

    def play(self, name: str, samples: "array[int]", playback: Playback, began: Began) -> None:
        """Play samples. Returns when the last has been played, or as soon as the playback is
        halted.

        Raises:
            SoundError: if they cannot be played.
        """
        ...


class SoundCard:
    """The system's default sound card. Opened once, and again after a failure; it runs only while
    it plays.
    """

    def __init__(self, backends: tuple[str, ...] = ()) -> None:
        self._backends = backends
        self._device: Any = None

    def open(self) -> str:
        """Open it if necessary, and return the name of its sound system.

        Raises:
            SoundError: if there is none; it says what to do.
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
                    miniaudio.SampleFormat.SIGNED16,
                    1,
                    RATE,
                    _PERIOD_MS,
                    callback_periods=_PERIODS,
                    backends=backends,
                )
            except miniaudio.MiniaudioError as error:
                raise SoundError(_NO_CARD.format(error.args[0])) from error
        return self.name

    @property
    def name(self) -> str:
        """Name of the sound system; empty before it is open."""
        return str(self._device.backend) if self._device else ""

    def start(self, stream: Generator["array[int]", int, None]) -> None:
        """Play a stream that gives as many samples as it is sent a number for, until `close`.

        Raises:
            SoundError: if there is no sound card; it says what to do.
        """
        import miniaudio

        self.open()
        try:
            self._device.start(stream)
        except miniaudio.MiniaudioError as error:
            self.close()
            raise SoundError(_NO_CARD.format(error.args[0])) from error

    def play(self, name: str, samples: "array[int]", playback: Playback, began: Began) -> None:
        try:
            self.open()
            self._play(samples, playback, began)
        except SoundError:
            self.close()
            raise

    def _play(self, samples: "array[int]", playback: Playback, began: Began) -> None:
        import miniaudio

        feed = _Feed(samples, playback)
        try:
            self._device.start(feed.samples)
            self._watch(feed, playback, began)
            self._device.stop()
        except miniaudio.MiniaudioError as error:
            raise SoundError(_NO_CARD.format(error.args[0])) from error

    def _watch(self, feed: "_Feed", playback: Playback, began: Began) -> None:
        """Wait until everything is played, or the playback is halted."""
        if not feed.begun.wait(_STALLED_S):
            raise SoundError(_STALLED)
        began(feed.at, seconds(feed.all))
        reached = -1
        while not (feed.is_over or playback.is_halted):
            if not playback.wake.wait(_STALLED_S) and feed.reached == reached:
                raise SoundError(_STALLED)
            reached = feed.reached
        if not playback.is_halted:
            playback.wake.clear()
            if not playback.is_halted:
                playback.wake.wait(BUFFER_S)

    def close(self) -> None:
        """Stop the card, and give it back."""
        device, self._device = self._device, None
        if device is not None:
            device.close()


class _Feed:
    """Feeds samples to the sound card, on the card's own thread, until the playback is halted."""

    def __init__(self, samples: "array[int]", playback: Playback) -> None:
        self.all = samples
        self.playback = playback
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
        while self.reached < len(self.all) and not self.playback.is_halted:
            chunk = self.all[self.reached : self.reached + frames]
            self.reached += frames
            frames = yield chunk
        self.is_over = True
        self.playback.wake.set()
        while True:
            yield nothing


class Folder:
    """WAV files in a folder, numbered in order. Existing files are never overwritten.

    In real time, a file takes as long as its sound.
    """

    def __init__(self, folder: str, in_real_time: bool) -> None:
        self._folder = Path(folder)
        self._in_real_time = in_real_time
        self._number: int | None = None

    def play(self, name: str, samples: "array[int]", playback: Playback, began: Began) -> None:
        try:
            self._write(name, samples)
        except OSError as error:
            raise SoundError(
                f"{self._folder} cannot take sound files ({error.strerror or error}): choose "
                "another folder."
            ) from error
        began(host_now(), seconds(samples))
        if self._in_real_time:
            playback.wake.wait(seconds(samples))

    def _write(self, name: str, samples: "array[int]") -> None:
        make_private(self._folder)
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
        """Make the next file. Numbers that another session has used in the folder are skipped."""
        if self._number is None:
            starts = (each.name.partition("-")[0] for each in self._folder.iterdir())
            self._number = max((int(start) for start in starts if start.isdecimal()), default=0)
        while True:
            self._number += 1
            path = self._folder / f"{self._number:03d}-{name}.wav"
            with suppress(FileExistsError):
                return path, os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)


class NoSound:
    """No sound, only its duration. For sessions on a virtual clock."""

    def play(self, name: str, samples: "array[int]", playback: Playback, began: Began) -> None:
        began(host_now(), seconds(samples))
