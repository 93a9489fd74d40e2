"""The speech engine, pyttsx3, which turns text into samples. Only the voice process uses it, as it
may hang.

Only its ``save_to_file`` is used: its ``say`` cannot be interrupted and does not report a missing
sound card. Two faults of version 2.99 are worked around: with espeak, ``runAndWait`` may return
long before the file is written; and a rate set just before it is sometimes lost, as it cancels
whatever espeak is doing.
"""

import contextlib
import os
import sys
import threading
import time
from array import array
from collections.abc import Iterator
from tempfile import TemporaryDirectory
from typing import Any

from sar_tui.drivers.installation import pip_install
from sar_tui.outputs.sound.protocol import FoundVoice, SoundError, Unreadable, Voicing
from sar_tui.outputs.sound.readability import why_unreadable
from sar_tui.outputs.sound.samples import at_volume, is_whole, peak, read, seconds
from sar_tui.outputs.sound.voices import choose, found_voice

_SILENT = 0.005
"""Speech with no sample above this (of 1) is inaudible."""
_SHORTEST_S = 0.1
_SHORTEST_A_LETTER_S = 0.008
"""A third of the time for a letter at the fastest rate that a theme may set."""
_POLL_S = 0.002
_SET_S = 0.25
"""Time for the engine to apply a voice and a rate."""
_SETTLED_S = 0.02
_END_REPORT_S = 0.05
"""Time for the engine to report its end once the file is whole; on Windows it may never report."""

_NO_PACKAGE = f"Speech needs the Python package pyttsx3: {pip_install('pyttsx3')}."
_NO_ENGINE = {
    "linux": "There is no speech engine: install espeak-ng (on Debian and Ubuntu: sudo apt "
    "install espeak-ng).",
    "darwin": f"The speech engine of macOS cannot be used: {pip_install('pyobjc')}, or brew "
    "install espeak-ng.",
    "win32": "The speech engine of Windows cannot be used: "
    f"{pip_install('comtypes', 'pypiwin32')}.",
}
_MORE_VOICES = {
    "linux": "install espeak-ng, which has it",
    "darwin": "add one in System Settings, Accessibility, Spoken Content",
    "win32": "add one in Settings, Time & language, Speech",
}
_NO_SOUND = "The speech engine gave no sound for this text."


class Engine:
    """Turns text into samples. Must be used by the main thread: macOS and Windows require it."""

    def __init__(self) -> None:
        self._engine: Any = None
        self._voices: tuple[FoundVoice, ...] = ()
        self._default = ""
        self._set_to: tuple[str, int] | None = None
        self._finished = threading.Event()
        self._problem = ""

    def voices(self) -> tuple[FoundVoice, ...]:
        """Return all voices.

        Raises:
            SoundError: if there is no engine; it says how to install one.
        """
        if self._engine is None:
            self._engine = self._start()
        return self._voices

    def speak(self, text: str, voicing: Voicing) -> "array[int]":
        """Return the samples of a spoken text.

        Raises:
            SoundError: if there is no engine, no voice for the language, or no usable result.
            Unreadable: if a voice of this language cannot read the text.
        """
        voice = self.voice(voicing)
        if why := why_unreadable(text, voicing.language):
            raise Unreadable(why)
        self._set(voice.id, voicing.rate)
        samples = self._synthesise(text)
        letters = sum(character.isalnum() for character in text)
        if peak(samples) < _SILENT or seconds(samples) < max(
            _SHORTEST_S, _SHORTEST_A_LETTER_S * letters
        ):
            raise Unreadable(_NO_SOUND)
        return at_volume(samples, voicing.volume)

    def voice(self, voicing: Voicing) -> FoundVoice:
        """Return the voice to use.

        Raises:
            SoundError: if there is no engine, or no voice for the language.
        """
        voice = choose(self.voices(), voicing.language, voicing.name, self._default)
        if voice is None:
            more = _MORE_VOICES.get(sys.platform, _MORE_VOICES["linux"])
            raise SoundError(f'There is no voice for the language "{voicing.language}": {more}.')
        return voice

    def _set(self, voice: str, rate: int) -> None:
        """Set a voice and a rate, and wait until they are applied."""
        if self._set_to == (voice, rate):
            return
        self._engine.proxy.setBusy(False)  # applied at once, not in the loop
        self._engine.setProperty("voice", voice)
        self._engine.setProperty("rate", rate)
        until = time.monotonic() + _SET_S
        while self._engine.getProperty("rate") != rate and time.monotonic() < until:
            time.sleep(_POLL_S)
        time.sleep(_SETTLED_S)
        self._set_to = (voice, rate)

    def _synthesise(self, text: str) -> "array[int]":
        """Return the engine's samples of a text. May hang; the supervisor then kills this
        process.
        """
        self._finished.clear()
        self._problem = ""
        with _private_file() as path:
            # defers everything to the loop, which then always ends
            self._engine.proxy.setBusy(True)
            self._engine.save_to_file(text, path)
            self._engine.runAndWait()
            while not is_whole(path):
                if self._problem:
                    raise SoundError(f"The speech engine could not speak ({self._problem}).")
                time.sleep(_POLL_S)
            self._finished.wait(_END_REPORT_S)
            return read(path)

    def _failed(self, exception: object = "", **_: object) -> None:
        self._problem = str(exception) or type(exception).__name__

    def _start(self) -> object:
        try:
            import pyttsx3
        except ImportError as error:
            raise SoundError(_NO_PACKAGE) from error
        try:
            engine = pyttsx3.init()
            found = engine.getProperty("voices") or ()
            self._voices = tuple(found_voice(each.id, each.name, each.languages) for each in found)
            self._default = str(engine.getProperty("voice") or "")
            engine.connect("finished-utterance", lambda **_: self._finished.set())
            engine.connect("error", self._failed)
        except (
            Exception
        ) as error:  # each platform's driver raises its own, and espeak's a RuntimeError
            raise SoundError(_NO_ENGINE.get(sys.platform, _NO_ENGINE["linux"])) from error
        return engine


@contextlib.contextmanager
def _private_file() -> Iterator[str]:
    """Yield a file for the engine to write to, in memory where possible, so that nothing is left
    behind.
    """
    if sys.platform == "linux":
        handle = os.memfd_create("utterance")
        try:
            yield f"/proc/self/fd/{handle}"
        finally:
            os.close(handle)
    else:
        with TemporaryDirectory(prefix="sar-tui-") as folder:
            yield os.path.join(folder, "utterance.wav")
