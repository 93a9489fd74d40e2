"""Exchanges letters between a clinic and its homes while a program is open, in a thread of its own."""

import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from sar_tui.letterbox import FILE
from sar_tui.store.database import StoreError

if TYPE_CHECKING:  # loaded if there is a letterbox
    from sar_tui.letterbox.exchange import Exchanged
    from sar_tui.letterbox.identity import Identity

LAST_SECONDS = 2.0
"""Longest wait for the exchange when a program ends. What is not sent then is sent the next time."""
AWAITED_SECONDS = 2.0
"""Longest wait for an exchange that is under way when a session begins."""


class Letters:
    """Takes and sends the letters of a data folder, if it has a letterbox.

    One exchange is made at a time, by a database connection of its own. A program that ends during
    one loses nothing.

    Args:
        folder: the data folder.
        done: called with what an exchange did, or why it could not be made; in the thread that made
            it.

    Attributes:
        role: of the data folder; empty if it has no letterbox, or if its file cannot be read.
        clinic: name of the clinic; empty without a role.
    """

    def __init__(self, folder: Path, done: "Callable[[Exchanged | StoreError], object]") -> None:
        self._folder = folder
        self._done = done
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._is_due = False
        self._has_letterbox = (folder / FILE).exists()
        found = self._identity() if self._has_letterbox else None
        self.role: Literal["", "clinic", "home"] = found.role if found else ""
        self.clinic = found.clinic if found else ""

    def _identity(self) -> "Identity | None":
        from sar_tui.letterbox.identity import read

        try:
            return read(self._folder)
        except StoreError:  # the first exchange says why
            return None

    def check_programme(self) -> None:
        """Raise StoreError at home: what a person trains there is changed at the clinic."""
        if self.role == "home":
            from sar_tui.letterbox.identity import check_programme

            check_programme(self._folder)

    def begin(self) -> None:
        """Begin an exchange; if one is under way, another one follows it."""
        if not self._has_letterbox:
            return
        with self._lock:
            self._is_due = True
            if self._thread is None:
                # a daemon: the program ends without waiting for a folder that does not answer
                self._thread = threading.Thread(target=self._run, name="letters", daemon=True)
                self._thread.start()

    def wait(self, seconds: float) -> bool:
        """Wait for exchanges that are under way; return True if none is any more."""
        thread = self._thread
        if thread is None:
            return True
        thread.join(seconds)
        return not thread.is_alive()

    def finish(self) -> None:
        """Make a last exchange, and wait for it, but not long."""
        self.begin()
        self.wait(LAST_SECONDS)

    def _run(self) -> None:
        while self._goes_on():
            if (result := self._exchange()) is not None:
                self._done(result)

    def _goes_on(self) -> bool:
        with self._lock:
            goes_on, self._is_due = self._is_due, False
            if not goes_on:
                self._thread = None
            return goes_on

    def _exchange(self) -> "Exchanged | StoreError | None":
        """Return what an exchange did; None if another program makes one now."""
        from sar_tui.letterbox.contents import Busy
        from sar_tui.letterbox.exchange import exchange

        try:
            return exchange(self._folder)
        except Busy:
            return None
        except StoreError as error:
            return error
        except Exception as error:  # it must not end on the screen
            return StoreError(f"Letters cannot be exchanged ({type(error).__name__}: {error}).")
