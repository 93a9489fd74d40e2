"""When did the prompt reach the terminal, and when did the key come? Stamped where it happens.

Textual writes each frame to its driver's file from a thread of its own. The file is wrapped: a frame that holds
the awaited text is noticed as it is written, and stamped when the flush that follows has returned. Keys are stamped
in the input thread as their bytes have been read, before they are parsed.
"""

import threading
from collections.abc import Callable, Iterable
from typing import IO, Any

from textual.driver import Driver
from textual.message import Message

from sar_tui.framework.clock import host_now

Stamped = Callable[[int], None]


class OnsetWatch:
    """Waits for a text to be flushed to the terminal. One text at a time; armed on the app's thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._text = ""
        self._stamped: Stamped | None = None
        self._written = False

    def arm(self, text: str, stamped: Stamped) -> None:
        """Call ``stamped`` with the time (ns) at which ``text`` was flushed, once, from the writing thread."""
        with self._lock:
            self._text, self._stamped, self._written = text, stamped, False

    def disarm(self) -> None:
        """Wait no longer."""
        with self._lock:
            self._stamped = None

    def wrote(self, frame: str) -> None:
        """A frame is about to be flushed."""
        if self._stamped is not None and self._text in frame:
            self._written = True

    def flushed(self) -> None:
        """What was written is with the terminal."""
        if self._written:
            now = host_now()
            with self._lock:
                stamped, self._stamped, self._written = self._stamped, None, False
            if stamped:
                stamped(now)


class WatchedFile:
    """The driver's terminal file, watched; and quiet about a terminal that has gone away."""

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
        try:
            self._file.flush()
        except (OSError, ValueError):
            self._lost()
        else:
            self._watch.flushed()

    def _lost(self) -> None:
        gone, self._gone = self._gone, None
        if gone:
            gone()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def stamp_keys_as_read() -> None:
    """Have the POSIX driver's parser stamp its events with the time at which their bytes came.

    Textual stamps an event when it is made, in the same thread but after parsing, by when another thread may have
    taken the interpreter. A Textual without the parser we know keeps its own stamps.
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
    """A driver class whose frames are watched. One without the file we know (Windows, a test) stays as it is.

    Args:
        driver: the class Textual chose.
        watch: is told of writes and flushes.
        gone: called once, from the writing thread, when the terminal cannot be written to any more.
    """

    class Watched(driver):  # type: ignore[valid-type, misc]
        def __init__(self, *args: Any, **kwargs: Any) -> None:
            super().__init__(*args, **kwargs)
            file = getattr(self, "_file", None)
            self.can_stamp_onset = file is not None
            if file is not None:
                self._file = WatchedFile(file, watch, gone)

    return Watched
