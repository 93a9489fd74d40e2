"""The speech engine, pyttsx3, which turns text into samples. Only the voice process uses it, as it
may hang.

Only its ``save_to_file`` is used: its ``say`` cannot be interrupted and does not report a missing
sound card. Two faults of version 2.99 are worked around: with espeak, ``runAndWait`` may return
long before the file is written; and a rate set just before it is sometimes lost, as it cancels
whatever espeak is doing.
"""

import contextlib
import os
import re
import sys
import threading
import time
import unicodedata
from array import array
from collections.abc import Iterable, Iterator, Sequence
from tempfile import TemporaryDirectory
from typing import Any

from sar_tui.drivers.installation import pip_install
from sar_tui.outputs.sound.protocol import FoundVoice, SoundError, Voicing
from sar_tui.outputs.sound.samples import at_volume, is_whole, peak, read, seconds

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
            SoundError: if there is no engine, no voice for the language, or no usable result; or,
                marked ``is_of_text``, if a voice of this language cannot read the text.
        """
        voice = self.voice(voicing)
        if why := why_unreadable(text, voicing.language):
            raise SoundError(why, is_of_text=True)
        self._set(voice.id, voicing.rate)
        samples = self._synthesise(text)
        letters = sum(character.isalnum() for character in text)
        if peak(samples) < _SILENT or seconds(samples) < max(
            _SHORTEST_S, _SHORTEST_A_LETTER_S * letters
        ):
            raise SoundError(_NO_SOUND, is_of_text=True)
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


_LATIN = (
    "ca cs da de en es et eu fi fr ga gl hr hu id is it lt lv ms nb nl nn no pl pt ro sk sl "
    "sv sw tr vi"
)
_SCRIPTS = {
    **dict.fromkeys(_LATIN.split(), ("LATIN",)),
    **dict.fromkeys("be bg mk ru uk".split(), ("CYRILLIC",)),
    **dict.fromkeys("ar fa ur".split(), ("ARABIC",)),
    **dict.fromkeys("hi mr ne".split(), ("DEVANAGARI",)),
    "el": ("GREEK",),
    "he": ("HEBREW",),
    "ja": ("HIRAGANA", "KATAKANA", "CJK"),
    "ko": ("HANGUL", "CJK"),
    "zh": ("CJK",),
}
"""Scripts of a language, by the first word of its letters' Unicode names. Other languages are not
checked.
"""


def why_unreadable(text: str, language: str) -> str:
    """Return why a voice of a language cannot read a text, as a sentence; empty if it can.

    It cannot if the text has neither letters nor digits, or if most letters are of a script of
    other languages.
    """
    if not any(character.isalnum() for character in text):
        return "The voice cannot read this text: it has neither letters nor digits."
    scripts = _SCRIPTS.get(language.partition("-")[0])
    letters = [character for character in text if character.isalpha()]
    if scripts and letters:
        foreign = sum(not unicodedata.name(letter, "").startswith(scripts) for letter in letters)
        if 2 * foreign > len(letters):
            return (
                "The voice cannot read this text: it is in a script that the language "
                f'"{language}" does not use.'
            )
    return ""


_TAG = re.compile(r"[a-z]{2,3}(-[a-z0-9]{1,8})*")
_REGIONS = {"en": ("us", "gb")}
"""Preferred regions of languages that have voices of many."""


def found_voice(identifier: object, name: object, languages: object) -> FoundVoice:
    """Clean up pyttsx3's description: languages may be missing, None, bytes with a leading count,
    or ``en_US``.
    """
    given = languages if isinstance(languages, list | tuple) else (languages,)
    tags = [tag for each in given if (tag := _tag(each))]
    if not tags and (tag := _tag(_text(identifier).rpartition("/")[2])):
        tags = [tag]
    return FoundVoice(_text(identifier), _text(name).strip(), tuple(tags))


def choose(
    voices: Sequence[FoundVoice], language: str, name: str, default: str
) -> FoundVoice | None:
    """Choose a voice; None if no voice speaks the language.

    A voice named by its id or a part of its name comes first. Otherwise, of those that speak the
    language: the engine's ``default``, by id; then one without a region; then one of the most
    expected region.
    """
    if name:
        wanted = name.casefold()
        exact = [voice for voice in voices if voice.id.casefold() == wanted]
        partly = [voice for voice in voices if wanted in voice.name.casefold()]
        if named := exact or partly:
            return named[0]
    fit = [voice for voice in voices if voice.speaks(language)]
    if not fit and "-" in language:
        return choose(voices, language.rpartition("-")[0], "", default)
    return min(
        fit, key=lambda voice: (voice.id != default, _rank(voice.languages, language)), default=None
    )


def _rank(languages: Iterable[str], language: str) -> int:
    regions = _REGIONS.get(language, (language,))
    order = [language, *(f"{language}-{region}" for region in regions)]
    return min((order.index(each) for each in languages if each in order), default=len(order))


def _text(value: object) -> str:
    return (
        value.decode(errors="ignore")
        if isinstance(value, bytes)
        else ""
        if value is None
        else str(value)
    )


def _tag(value: object) -> str:
    """Return a language in lower case with hyphens; empty if it is none."""
    tag = (
        "".join(each for each in _text(value) if each.isprintable())
        .strip()
        .lower()
        .replace("_", "-")
    )
    return tag if _TAG.fullmatch(tag) else ""
