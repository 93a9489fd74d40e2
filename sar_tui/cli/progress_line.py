"""Progress of a command that takes long: a line on the terminal, or a line now and then on stderr
where it is piped.
"""

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Lock, Thread

from sar_tui.model.visible_text import visible

Show = Callable[[str, float, float], None]
"""Called with what is done, how much of it is done, and of how much (0: nobody knows)."""

_FROM_S = 1.0
"""Time from which a command is said to take long."""
_ON_TERMINAL_S = 0.2
"""Time between two drawings of the line."""
_PIPED_S = 10.0
"""Time between two lines where nobody may be looking."""


@contextmanager
def progress_line(
    what: str,
    *,
    piped: bool = False,
    still: bool = False,
    now: Callable[[], float] = time.monotonic,
) -> Iterator[Show]:
    """Show on stderr what a block is doing and how long it will go on, once it takes longer than a
    second.

    The line is gone when the block is over.

    Args:
        what: the first thing that is done.
        piped: also if stderr is no terminal, as a line of its own every ten seconds.
        still: only when the block calls, so that no thread disturbs what it measures.
        now: the clock, in s.
    """
    # it gets a carriage return, which others may not
    stream = getattr(sys.stderr, "rich_proxied_file", sys.stderr)
    if stream is None or not (stream.isatty() or piped):
        yield lambda what, done, of: None
        return

    def write(text: str) -> None:
        stream.write(text)
        stream.flush()

    line = _Line(what, now, write, on_terminal=stream.isatty())
    over = Event()
    ticking = None if still else Thread(target=line.keep_drawn, args=(over,), daemon=True)
    if ticking:
        try:
            ticking.start()
        except RuntimeError:  # this login may start no more: the line is drawn when the block calls
            ticking = None
    try:
        yield line.show
    finally:
        over.set()
        if ticking:
            ticking.join()
        line.erase()


class _Line:
    """The line, drawn by the block and by the thread that shows that time goes on."""

    def __init__(
        self,
        what: str,
        now: Callable[[], float],
        write: Callable[[str], None],
        *,
        on_terminal: bool,
    ) -> None:
        self._now, self._write, self._on_terminal = now, write, on_terminal
        self._what, self._done, self._of = what, 0.0, 0.0
        self._began_s, self._began_at = now(), 0.0
        self._next_s = now() + (_FROM_S if on_terminal else _PIPED_S)
        self._width = 0
        self._lock = Lock()

    def show(self, what: str, done: float, of: float) -> None:
        with self._lock:
            if of != self._of or done < self._done:  # another step begins
                self._began_s, self._began_at = self._now(), done
            self._what, self._done, self._of = what, done, of
            self._draw()

    def keep_drawn(self, over: Event) -> None:
        """Draw the line anew until the block is over."""
        is_over = False
        while not is_over:
            with self._lock:
                self._draw()
            is_over = over.wait(_ON_TERMINAL_S)

    def _draw(self) -> None:
        if self._now() < self._next_s:
            return
        self._next_s = self._now() + (_ON_TERMINAL_S if self._on_terminal else _PIPED_S)
        text = visible(f"{self._what} … {self._how_far()}")
        if self._on_terminal:
            text = text[: _columns() - 1]
            self._write(f"\r{text.ljust(self._width)}")
            self._width = len(text)
        else:
            self._write(f"{text}\n")

    def _how_far(self) -> str:
        """Return the share that is done, and the time left at the speed until now; or the time that
        has passed.
        """
        passed_s, made = self._now() - self._began_s, self._done - self._began_at
        if self._of <= 0:
            return f"{passed_s:.0f} s"
        share = f"{min(100, int(100 * self._done / self._of))} %"
        if made <= 0:
            return share
        return f"{share}, {in_words(passed_s * max(0.0, self._of - self._done) / made)} left"

    def erase(self) -> None:
        if self._width:
            self._write(f"\r{' ' * self._width}\r")


def in_words(seconds: float) -> str:
    """Return a time as people say it: ``about 40 s``, ``about 3 min``."""
    if seconds < 59.5:
        return f"about {max(1, round(seconds))} s"
    minutes = round(seconds / 60)
    return f"about {minutes} min" if minutes < 90 else f"about {seconds / 3600:.1f} h"


def _columns() -> int:
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except (OSError, ValueError, AttributeError):
        return 80
