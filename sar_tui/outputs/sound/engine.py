"""The speech engine: pyttsx3, which makes a text into samples. Used by the child process alone, for it may hang.

Only its ``save_to_file`` is used. What its ``say`` plays cannot be interrupted, and it does not tell when there is no
sound card. Two of its habits are allowed for (2.99): with espeak, ``runAndWait`` may return long before the file is
written; and a rate that is set just before it is lost now and then, as it cancels whatever espeak is busy with.
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

from sar_tui.outputs.sound.protocol import FoundVoice, SoundError, Unreadable, Voicing
from sar_tui.outputs.sound.readability import why_unreadable
from sar_tui.outputs.sound.samples import at_volume, is_whole, peak, read, seconds
from sar_tui.outputs.sound.voices import choose, found_voice

_SILENT = 0.005
"""Speech whose loudest sample is below this (of 1) cannot be heard."""
_SHORTEST_S = 0.1
_SHORTEST_A_LETTER_S = 0.008
"""A third of what a letter takes at the fastest rate a theme may set."""
_LOOK_S = 0.002
_SET_S = 0.25
"""How long to wait for the engine to have taken on a voice and a rate."""
_SETTLED_S = 0.02
_TOLD_S = 0.05
"""How long to wait for the engine to tell that it has finished, once its file is whole; Windows' may tell never."""

_NO_PACKAGE = "Speech needs the Python package pyttsx3: pip install pyttsx3."
_NO_ENGINE = {
    "linux": "There is no speech engine: install espeak-ng (on Debian and Ubuntu: sudo apt install espeak-ng).",
    "darwin": "The speech engine of macOS cannot be used: pip install pyobjc, or brew install espeak-ng.",
    "win32": "The speech engine of Windows cannot be used: pip install comtypes pypiwin32.",
}
_MORE_VOICES = {
    "linux": "install espeak-ng, which has it",
    "darwin": "add one in System Settings, Accessibility, Spoken Content",
    "win32": "add one in Settings, Time & language, Speech",
}
_NO_SOUND = "The speech engine gave no sound for this text."


class Engine:
    """Speaks into samples. Must be used by the main thread: macOS and Windows ask for it."""

    def __init__(self) -> None:
        self._engine: Any = None
        self._voices: tuple[FoundVoice, ...] = ()
        self._default = ""
        self._set_to: tuple[str, int] | None = None
        self._finished = threading.Event()
        self._problem = ""

    def voices(self) -> tuple[FoundVoice, ...]:
        """All voices.

        Raises:
            SoundError: there is no engine; it says how to get one.
        """
        if self._engine is None:
            self._engine = self._start()
        return self._voices

    def speak(self, text: str, voicing: Voicing) -> "array[int]":
        """The samples of a text that is spoken.

        Raises:
            SoundError: there is no engine, or none of its voices speaks the language, or it gave nothing usable.
            Unreadable: the text is none that a voice of this language can read.
        """
        voice = self.voice(voicing)
        if why := why_unreadable(text, voicing.language):
            raise Unreadable(why)
        self._set(voice.id, voicing.rate)
        samples = self._synthesise(text)
        letters = sum(character.isalnum() for character in text)
        if peak(samples) < _SILENT or seconds(samples) < max(_SHORTEST_S, _SHORTEST_A_LETTER_S * letters):
            raise Unreadable(_NO_SOUND)
        return at_volume(samples, voicing.volume)

    def voice(self, voicing: Voicing) -> FoundVoice:
        """The voice that speaks so.

        Raises:
            SoundError: there is no engine, or none of its voices speaks the language.
        """
        voice = choose(self.voices(), voicing.language, voicing.name, self._default)
        if voice is None:
            more = _MORE_VOICES.get(sys.platform, _MORE_VOICES["linux"])
            raise SoundError(f'There is no voice for the language "{voicing.language}": {more}.')
        return voice

    def _set(self, voice: str, rate: int) -> None:
        """Take on a voice and a rate, and wait until that is so."""
        if self._set_to == (voice, rate):
            return
        self._engine.proxy.setBusy(False)  # so that they are set at once, and not in the loop
        self._engine.setProperty("voice", voice)
        self._engine.setProperty("rate", rate)
        until = time.monotonic() + _SET_S
        while self._engine.getProperty("rate") != rate and time.monotonic() < until:
            time.sleep(_LOOK_S)
        time.sleep(_SETTLED_S)
        self._set_to = (voice, rate)

    def _synthesise(self, text: str) -> "array[int]":
        """What the engine makes of a text. It may take for ever: who waits for it ends this process."""
        self._finished.clear()
        self._problem = ""
        with _private_file() as path:
            self._engine.proxy.setBusy(True)  # so that all is done in the loop, which then surely ends
            self._engine.save_to_file(text, path)
            self._engine.runAndWait()
            while not is_whole(path):
                if self._problem:
                    raise SoundError(f"The speech engine could not speak ({self._problem}).")
                time.sleep(_LOOK_S)
            self._finished.wait(_TOLD_S)
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
            told = engine.getProperty("voices") or ()
            self._voices = tuple(found_voice(each.id, each.name, each.languages) for each in told)
            self._default = str(engine.getProperty("voice") or "")
            engine.connect("finished-utterance", lambda **_: self._finished.set())
            engine.connect("error", self._failed)
        except Exception as error:  # each platform's driver raises its own, and espeak's a RuntimeError
            raise SoundError(_NO_ENGINE.get(sys.platform, _NO_ENGINE["linux"])) from error
        return engine


@contextlib.contextmanager
def _private_file() -> Iterator[str]:
    """A file for the engine to write to: in memory where there is such a thing, so that nothing is ever left behind."""
    if sys.platform == "linux":
        handle = os.memfd_create("utterance")
        try:
            yield f"/proc/self/fd/{handle}"
        finally:
            os.close(handle)
    else:
        with TemporaryDirectory(prefix="sar-tui-") as folder:
            yield os.path.join(folder, "utterance.wav")
