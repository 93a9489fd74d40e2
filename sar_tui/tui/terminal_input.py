"""Input of a terminal: what cannot be read is dropped and reported, and the next key counts again.

A byte of another encoding, a damaged escape sequence or a paste without an end would otherwise end the app, or make it
deaf. Textual's drivers look up their parser and decoder in their modules, so they are exchanged there.
"""

import codecs
import importlib
import os
import time
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from types import ModuleType
from typing import Any

from textual import events
from textual._xterm_parser import BRACKETED_PASTE_END, BRACKETED_PASTE_START, XTermParser
from textual.geometry import Size
from textual.message import Message

LARGEST = Size(1000, 400)
"""Largest terminal that is drawn, in columns and rows. Drawing the sizes of faulty reports would take minutes."""
_PASTE_GAP_S = 0.5
"""A paste that stops for longer has lost its end."""
_QUOTED = 80
"""Characters of dropped input that are reported."""


class UnreadableInput(Message):
    """Input that cannot be read was dropped. ``what``: its end, with escapes."""

    def __init__(self, what: str) -> None:
        super().__init__()
        self.what = what


class TolerantParser:
    """Parser of a terminal's input, in place of Textual's, which ends at the first input that it cannot read.

    Args:
        debug: write a log, as Textual's parser does.
        now: the time in seconds.
    """

    def __init__(self, debug: bool = False, now: Callable[[], float] = time.monotonic) -> None:
        self._debug = debug
        self._now = now
        self._parser = XTermParser(debug)
        self._window: tuple[Any, ...] = (False, None, None)
        self._recent = self._last = ""
        self._dropped = ""
        self._pasted_at: float | None = None

    def feed(self, data: str) -> Iterator[Message]:
        """Parse text, in which surrogates stand for bytes that are not UTF-8. Empty text ends what was begun."""
        for character in data:
            if is_surrogate(character):
                self._dropped += character
                continue
            self._recent = (self._recent + character)[-_QUOTED:]
            self._notice_paste(character)
            yield from self._read(self._parser.feed(character))
        if not data:
            yield from self._read(self._parser.feed(data))
            self._begin()
        yield from self._report()

    def tick(self) -> Iterator[Message]:
        """Return messages that wait for no further input, such as a single Escape."""
        yield from self._read(self._parser.tick())
        if self._pasted_at is not None and self._now() - self._pasted_at > _PASTE_GAP_S:
            self._recent = BRACKETED_PASTE_START  # what was pasted is not recorded
            self._drop()
        yield from self._report()

    def _read(self, messages: Iterable[Message]) -> Iterator[Message]:
        try:
            for message in messages:
                if _is_valid(message):
                    self._recent = ""
                    yield message
                else:
                    self._drop()
        except Exception:
            self._drop()
        parser = self._parser
        self._window = (parser.mouse_pixels, parser.terminal_size, parser.terminal_pixel_size)

    def _notice_paste(self, character: str) -> None:
        """Remember when the last character of a paste was read that has not ended yet."""
        self._last = (self._last + character)[-len(BRACKETED_PASTE_START) :]
        if self._last == BRACKETED_PASTE_END:
            self._pasted_at = None
        elif self._pasted_at is not None or self._last == BRACKETED_PASTE_START:
            self._pasted_at = self._now()

    def _drop(self) -> None:
        """Drop what was read of a sequence or a paste."""
        self._dropped += self._recent
        self._begin()

    def _begin(self) -> None:
        """Expect the first character of a key or a sequence."""
        self._recent, self._last, self._pasted_at = "", "", None
        self._parser = XTermParser(self._debug)
        self._parser.mouse_pixels, self._parser.terminal_size, self._parser.terminal_pixel_size = self._window

    def _report(self) -> Iterator[Message]:
        if self._dropped:
            what, self._dropped = self._dropped[-_QUOTED:], ""
            yield UnreadableInput(ascii(what)[1:-1].replace(r"\udc", r"\x"))


def is_surrogate(character: str) -> bool:
    """Return True if a character is a surrogate, which is no character of its own."""
    return "\ud800" <= character <= "\udfff"


def _is_valid(message: Message) -> bool:
    """Return False for keys that no keyboard has, and for sizes that no terminal has."""
    if isinstance(message, events.Key):
        return not any(map(is_surrogate, f"{message.key}{message.character or ''}"))
    if isinstance(message, events.Resize):
        pixels = message.pixel_size or message.size
        return _fits(message.size) and pixels.width >= message.size.width and pixels.height >= message.size.height
    return True


def _fits(size: Size) -> bool:
    return 0 < size.width <= LARGEST.width and 0 < size.height <= LARGEST.height


def capped(size: Size) -> Size:
    """Return a terminal's size, at most `LARGEST`."""
    return Size(min(size.width, LARGEST.width), min(size.height, LARGEST.height))


def tolerate(driver: ModuleType) -> None:
    """Let a driver of Textual read with a `TolerantParser`, given its module."""
    for name, tolerant in (("XTermParser", TolerantParser), ("getincrementaldecoder", _decoder)):
        if hasattr(driver, name):
            setattr(driver, name, tolerant)


def tolerate_in_terminals() -> None:
    """Let the driver of this system's terminals read with a `TolerantParser`."""
    tolerate(importlib.import_module("textual.drivers." + ("linux_driver" if os.name == "posix" else "win32")))


def _decoder(encoding: str) -> Callable[[], codecs.IncrementalDecoder]:
    return partial(codecs.getincrementaldecoder(encoding), errors="surrogateescape")
