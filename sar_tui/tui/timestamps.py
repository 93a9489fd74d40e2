"""Time stamps of prompts and keys, taken where they happen.

Textual writes frames to its driver's file from a thread of its own. That file is wrapped: a frame
with the awaited text is recognized when it is written, and the time is taken when the flush after
it has returned. Keys are stamped in the input thread, after their bytes were read and before they
are parsed.
"""

import re
import threading
import time
from collections.abc import Callable, Iterable
from typing import IO, Any

from textual.driver import Driver
from textual.message import Message
from textual.widget import Widget

from sar_tui.loop.clock import host_now
from sar_tui.model.units import MS, SECOND

Stamped = Callable[[int], None]
_PATIENCE = 20 * MS
_CONTROL = re.compile(r"\x1b\[[0-?]*[ -/]*[@-~]")
"""A control sequence, whose numbers are no text."""


class OnsetWatch:
    """Waits for a text to be flushed to the terminal; for an empty one, until anything is.

    One text at a time; armed on the app's thread.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._text = ""
        self._stamped: Stamped | None = None
        self._written = False
        self._due = 0

    def arm(self, text: str, stamped: Stamped, due: int = 0) -> None:
        """Call ``stamped`` once, from the writing thread, with the time (ns) at which ``text`` was
        flushed.

        ``due``: it is not flushed before this time (ns), for which the writing thread waits, at
        most `_PATIENCE`.
        """
        with self._lock:
            self._text, self._stamped, self._written, self._due = text, stamped, False, due

    def wrote(self, frame: str) -> None:
        """Notice a frame that is about to be flushed."""
        if self._stamped is not None and self._text in frame:
            printed = _CONTROL.sub("", frame)
            self._written = self._written or (bool(printed) and self._text in printed)

    def await_time(self) -> None:
        """Wait until the awaited text may be flushed, if it is about to be."""
        if self._written and (left := self._due - host_now()) > 0:
            time.sleep(min(left, _PATIENCE) / SECOND)

    def missed(self) -> None:
        """Notice that the frame was dropped: the terminal is stalled. The next one holds the text
        again.
        """
        self._written = False

    def flushed(self) -> None:
        """Stamp the awaited text if it was in the flushed frame."""
        if self._written:
            now = host_now()
            with self._lock:
                stamped, self._stamped, self._written = self._stamped, None, False
            if stamped:
                stamped(now)


class WatchedFile:
    """The driver's terminal file, which reports writes and flushes, and survives the loss of the
    terminal.
    """

    def __init__(self, file: IO[str], watch: OnsetWatch, gone: Callable[[], None]) -> None:
        self._file = file
        self._watch = watch
        self._gone: Callable[[], None] | None = gone

    def write(self, text: str) -> int:
        self._watch.wrote(text)
        try:
            return self._file.write(text)
        except (OSError, ValueError):
            self._lost()
            return len(text)

    def flush(self) -> None:
        self._watch.await_time()
        try:
            self._file.flush()
        except (OSError, ValueError):
            self._lost()
        else:
            if getattr(self._file, "is_stalled", False):
                self._watch.missed()
            else:
                self._watch.flushed()

    def _lost(self) -> None:
        gone, self._gone = self._gone, None
        if gone:
            gone()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def stamp_keys_as_read() -> None:
    """Let the POSIX driver's parser stamp events with the time at which their bytes were read.

    Textual stamps an event after parsing, when another thread may have taken the interpreter. A
    version of Textual without this parser keeps its own stamps.
    """
    try:
        from textual import _time
        from textual.drivers import linux_driver
    except ImportError:  # Windows
        return

    class StampedParser(linux_driver.XTermParser):  # type: ignore[name-defined, misc]
        def feed(self, data: str) -> Iterable[Message]:
            read_at = _time.get_time()
            for message in super().feed(data):
                message.time = read_at
                yield message

    linux_driver.XTermParser = StampedParser  # type: ignore[attr-defined]


def watched(driver: type[Driver], watch: OnsetWatch, gone: Callable[[], None]) -> type[Driver]:
    """Return a driver class whose frames are watched; a driver without the known file (Windows,
    tests) is unchanged.

    Args:
        driver: the class Textual chose.
        watch: receives writes and flushes.
        gone: called once, from the writing thread, when the terminal can no longer be written to.
    """

    class Watched(driver):  # type: ignore[valid-type, misc]
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            file = getattr(self, "_file", None)
            self.can_stamp_onset = file is not None
            if file is not None:
                self._file = WatchedFile(file, watch, gone)

    return Watched


# --- painting at once


def paint_now(widget: Widget, *, in_place: bool = False) -> None:
    """Write what has changed in a widget to the terminal, without waiting for Textual's next paint.

    If another screen covers it, Textual paints as usual; also if the screen must be laid out first,
    unless the widget is to be painted ``in_place``, where it was laid out before.
    """
    screen = widget.screen
    if screen.is_current and (in_place or not (screen._layout_required or screen._scroll_required)):
        screen._compositor.update_widgets({widget})
        screen._compositor_refresh()
