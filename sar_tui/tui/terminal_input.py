"""Input of a terminal: what cannot be read is dropped and reported, and the next key counts again.

A byte of another encoding, a damaged escape sequence or a paste without an end would otherwise end
the app, or make it deaf. Textual's drivers look up their parser and decoder in their modules, so
they are exchanged there.
"""

import codecs
import importlib
import os
import re
import time
from collections.abc import Callable, Generator, Iterable, Iterator
from functools import partial
from types import ModuleType
from typing import Any, Literal

from textual import events
from textual._xterm_parser import BRACKETED_PASTE_END, BRACKETED_PASTE_START, XTermParser
from textual.geometry import Size
from textual.message import Message

LARGEST = Size(1000, 400)
"""Largest terminal that is drawn, in columns and rows. Drawing the sizes of faulty reports would
take minutes.
"""
LONGEST_PASTE = 64 * 1024
"""Characters of the longest paste that is passed on. A longer one is dropped, and its length
reported.
"""
TYPED_AT_MOST, _TYPED_WITHIN_S = 128, 0.25
"""Nobody types, and no keyboard repeats, more characters within this time; so they are pasted."""
_PASTE_GAP_S = 0.5
"""A paste that stops for longer has lost its end."""
_FLOOD_GAP_S = 0.1
"""A paste that is not marked ends with a gap of this length."""
_SIGNALS = {
    "f1": ("\x1bOP", "\x1b[P", "\x1b[11~", "\x1b[[A"),
    "f2": ("\x1bOQ", "\x1b[Q", "\x1b[12~", "\x1b[[B"),
}
"""Keys that act in the middle of a paste that is not marked: help and stop, by what terminals send
for them.
"""
_SIGNAL_GAP_S = 0.1
_LONGEST_SIGN = len(BRACKETED_PASTE_END) - 1
_NO_TEXT = re.compile(
    r"\x1b(?:\[[0-?]*[ -/]*[@-~]?|O[ -~]?)?|[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]"
)
"""Control sequences, cut off ones too, control characters other than tab and ends of lines, and
unreadable bytes.
"""
_MOUSE_BEGINS = "\x1b[<"
_MOUSE = re.compile(r"\x1b\[<[\d;]*[Mm]")
_QUOTED = 80
"""Characters of dropped input that are reported."""


class UnreadableInput(Message):
    """Input that cannot be read was dropped. ``what``: its end, with escapes."""

    def __init__(self, what: str) -> None:
        super().__init__()
        self.what = what


class PasteDropped(Message):
    """A paste was dropped: it is longer than `LONGEST_PASTE`, or holds no text. ``length``: its
    characters.
    """

    def __init__(self, length: int) -> None:
        super().__init__()
        self.length = length


class TolerantParser:
    """Parser of a terminal's input, in place of Textual's, which ends at the first input that it
    cannot read.

    Its time is linear in the length of the input, and short for what nobody types: Textual's parser
    takes 30 µs for each character, and the app many times that for each key. What comes in faster
    than `TYPED_AT_MOST` is therefore taken as a paste, although not all terminals mark it as one.
    F1 and F2 in it act at once, as help and stop must.

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
        self._paste = _Paste()
        self._typed, self._typed_since = 0, -_TYPED_WITHIN_S
        self._signalled: dict[str, float] = {}

    def feed(self, data: str) -> Iterator[Message]:
        """Parse text, in which surrogates stand for bytes that are not UTF-8. Empty text ends what
        was begun.
        """
        if not data:
            yield from self._read(self._parser.feed(data))
            self._begin()
        while data:
            if self._paste.kind == "marked":
                data = yield from self._take_paste(data)
            elif self._paste.kind == "flood":
                yield from self._take_flood(data)
                data = ""
            else:
                data = yield from self._take_typed(data)
        yield from self._report()

    def tick(self) -> Iterator[Message]:
        """Return messages that wait for no further input, such as a single Escape, or the end of a
        flood.
        """
        yield from self._read(self._parser.tick())
        silent_s = self._now() - self._paste.at
        if self._paste.kind == "flood" and silent_s > _FLOOD_GAP_S:
            yield from self._end_paste()
        elif self._paste.kind == "marked" and silent_s > _PASTE_GAP_S:
            self._recent = BRACKETED_PASTE_START  # what was pasted is not recorded
            self._drop()
        yield from self._report()

    # --- what is typed

    def _take_typed(self, data: str) -> Generator[Message, None, str]:
        """Parse keys and sequences; returns what follows the start of a paste, or comes in too fast
        to be typed.
        """
        left = self._typing_left(data)
        for at, character in enumerate(data):
            if at >= left and not self._recent:
                self._paste.begin("flood", self._now())
                return data[at:]
            if is_surrogate(character):
                self._dropped += character
                continue
            self._recent = (self._recent + character)[-_QUOTED:]
            self._last = (self._last + character)[-len(BRACKETED_PASTE_START) :]
            if self._last == BRACKETED_PASTE_START:
                self._begin()
                self._paste.begin("marked", self._now())
                return data[at + 1 :]
            yield from self._read(self._parser.feed(character))
        return ""

    def _typing_left(self, data: str) -> int:
        """Return the number of these characters up to which they may have been typed.

        The mouse does not count, which may report hundreds of positions in a second, nor does a
        paste that is marked.
        """
        now = self._now()
        if now - self._typed_since >= _TYPED_WITHIN_S:
            self._typed, self._typed_since = 0, now
        before, begins, _ = data.partition(BRACKETED_PASTE_START)
        count = len(_MOUSE.sub("", before)) if _MOUSE_BEGINS in before else len(before)
        self._typed += count
        if self._typed <= TYPED_AT_MOST or (begins and count <= TYPED_AT_MOST):
            return len(data)
        return max(0, TYPED_AT_MOST - (self._typed - count))

    # --- what is pasted

    def _take_paste(self, data: str) -> Generator[Message, None, str]:
        """Take a paste that is marked up to its end; returns what follows it."""
        follows = self._paste.take(data, self._now(), BRACKETED_PASTE_END)
        if follows is None:
            return ""
        yield from self._end_paste()
        return follows

    def _take_flood(self, data: str) -> Iterator[Message]:
        """Take what nobody types, but for the keys that must act at any time."""
        now = self._now()
        searched = self._paste.tail + data
        for key, sequences in _SIGNALS.items():
            is_there = any(sequence in searched for sequence in sequences)
            if is_there and now - self._signalled.get(key, -_SIGNAL_GAP_S) >= _SIGNAL_GAP_S:
                self._signalled[key] = now
                yield events.Key(key, None)
        self._paste.take(data, now)

    def _end_paste(self) -> Iterator[Message]:
        text, length = self._paste.end()
        self._begin()
        if length > LONGEST_PASTE or (length and not text):
            yield PasteDropped(length)
        elif length:
            yield events.Paste(text)

    # --- what cannot be read

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

    def _drop(self) -> None:
        """Drop what was read of a sequence or a paste."""
        self._dropped += self._recent
        self._begin()

    def _begin(self) -> None:
        """Expect the first character of a key or a sequence."""
        self._recent = self._last = ""
        self._paste.end()
        self._parser = XTermParser(self._debug)
        self._parser.mouse_pixels, self._parser.terminal_size, self._parser.terminal_pixel_size = (
            self._window
        )

    def _report(self) -> Iterator[Message]:
        if self._dropped:
            what, self._dropped = self._dropped[-_QUOTED:], ""
            yield UnreadableInput(ascii(what)[1:-1].replace(r"\udc", r"\x"))


class _Paste:
    """A paste while it is read. What is beyond `LONGEST_PASTE` is counted only.

    Attributes:
        kind: between the marks of a terminal, or a flood of characters without; empty if there is
            none.
        at: when its last part was read (s).
        tail: its last characters, as a sequence may be read in two parts.
    """

    def __init__(self) -> None:
        self.begin("", 0.0)

    def begin(self, kind: Literal["", "marked", "flood"], at: float) -> None:
        self.kind, self.at, self.tail = kind, at, ""
        self._parts: list[str] = []
        self._length = 0

    def take(self, data: str, at: float, end: str = "") -> str | None:
        """Add characters up to an end; returns those behind it, None if it has not come."""
        self.at = at
        searched = self.tail + data
        found = searched.find(end) if end else -1
        part = data if found < 0 else data[: max(0, found - len(self.tail))]
        self._length += len(part) - (max(0, len(self.tail) - found) if found >= 0 else 0)
        if self._length <= LONGEST_PASTE + _LONGEST_SIGN:
            self._parts.append(part)
        else:
            self._parts.clear()
        self.tail = searched[-_LONGEST_SIGN:]
        return None if found < 0 else searched[found + len(end) :]

    def end(self) -> tuple[str, int]:
        """Return the text without control sequences, and the length of what was pasted; forget
        them.
        """
        text, length = "".join(self._parts)[: self._length], self._length
        self.begin("", 0.0)
        return _NO_TEXT.sub("", text), length


def is_surrogate(character: str) -> bool:
    """Return True if a character is a surrogate, which is no character of its own."""
    return "\ud800" <= character <= "\udfff"


def _is_valid(message: Message) -> bool:
    """Return False for keys that no keyboard has, and for sizes that no terminal has."""
    if isinstance(message, events.Key):
        return not any(map(is_surrogate, f"{message.key}{message.character or ''}"))
    if isinstance(message, events.Resize):
        pixels = message.pixel_size or message.size
        return (
            _fits(message.size)
            and pixels.width >= message.size.width
            and pixels.height >= message.size.height
        )
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
    tolerate(
        importlib.import_module(
            "textual.drivers." + ("linux_driver" if os.name == "posix" else "win32")
        )
    )


def _decoder(encoding: str) -> Callable[[], codecs.IncrementalDecoder]:
    return partial(codecs.getincrementaldecoder(encoding), errors="surrogateescape")
