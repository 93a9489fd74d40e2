"""Keeps the link's process for as long as a session may need it: started before the app, started anew if it dies."""

import contextlib
import queue
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import IO

from sar_tui.drivers import child_process
from sar_tui.framework.clock import SECOND
from sar_tui.link import protocol
from sar_tui.link.channel import BrokerEnded, BrokerListener, Outgoing
from sar_tui.link.errors import LinkError
from sar_tui.link.protocol import BrokerCommand, BrokerEvent, BrokerStarted, Heartbeat, ProtocolError, Setup

PROGRAM = child_process.python("sar_tui.link.broker")
_MOST_WAITING = 200
_OPENS_S = 20.0
_SILENT_S = 2.0
"""A broker that has not told anything for so long hangs: or for longer, where a peer may be silent for longer."""
_STEADY_S = 30.0
"""One that lived for so long is worth another try, however often others died before."""
_MOST_RESTARTS = 5
_PAUSE_S = 0.2
_CLOSES_S = 2.0

_SILENT = "The link's process did not answer within {:.0f} s."
_ENDED = "The link's process ended; another takes its place."
_GIVEN_UP = "The link's process ended time and again: there is no link for the rest of this session."


class _Child:
    """One process, with a thread that writes to it and one that hears it. ``heard`` gets None when it has ended."""

    def __init__(
        self, setup: Setup, heard: "Callable[[_Child, BrokerEvent | None], object]", program: Sequence[str]
    ) -> None:
        self._process: subprocess.Popen[bytes] = child_process.start(program)
        assert self._process.stdin
        assert self._process.stdout
        self._orders: IO[bytes] = self._process.stdin
        self._news: IO[bytes] = self._process.stdout
        self._heard = heard
        self._outbox: queue.Queue[Outgoing | BrokerCommand | None] = queue.Queue(_MOST_WAITING)
        self._outbox.put(setup)
        self.pid = self._process.pid
        self._threads = [
            threading.Thread(target=run, name=name, daemon=True)
            for run, name in ((self._write, "link orders"), (self._listen, "link news"))
        ]
        for thread in self._threads:
            thread.start()

    def send(self, what: "Outgoing | BrokerCommand | None") -> bool:
        """Queue it for the writing thread; None for the end. False where there is no room."""
        try:
            self._outbox.put_nowait(what)
        except queue.Full:
            return False
        return True

    def kill(self) -> None:
        """End it at once, or see that it has ended."""
        child_process.kill(self._process)

    def ends_within(self, seconds: float) -> None:
        """Wait for it to end by itself."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)

    def _write(self) -> None:
        with contextlib.suppress(OSError), self._orders:
            while (what := self._outbox.get()) is not None:
                data = memoryview(protocol.pack_frame(what if isinstance(what, BrokerCommand) else what.order()))
                while data:
                    data = data[self._orders.write(data) :]

    def _listen(self) -> None:
        with contextlib.suppress(OSError, ProtocolError), self._news:
            while (news := protocol.read_frame(self._news, BrokerEvent)) is not None:
                self._heard(self, news)
        self.kill()
        self.send(None)
        self._heard(self, None)


class BrokerProcess:
    """The link of a session, from when it is opened until it is closed.

    Args:
        setup: what the process is told, each time it is started.
        program: its command line.
    """

    def __init__(self, setup: Setup, program: Sequence[str] = PROGRAM) -> None:
        self.link = setup.link
        self._setup, self._program = setup, program
        self._lock = threading.RLock()
        self._hear: BrokerListener | None = None
        self._early: deque[BrokerEvent | BrokerEnded] = deque(maxlen=1_000)
        self._opened = threading.Event()
        self._why: str | None = None
        self._child: _Child | None = None
        self._started = self._heard_at = 0.0
        self._restarts = 0
        self._is_closed = False

    @property
    def pid(self) -> int | None:
        """The process that holds the link now."""
        return self._child.pid if self._child else None

    def open(self) -> None:
        """Start the process. Raises LinkError where it cannot listen as it was told."""
        try:
            self._start()
        except OSError as error:
            raise LinkError(f"The link's process cannot be started: {error.strerror or error}.") from error
        if not self._opened.wait(_OPENS_S):
            self._why = _SILENT.format(_OPENS_S)
        if self._why:
            self.close()
            raise LinkError(self._why)

    def listen(self, hear: BrokerListener) -> None:
        """See `Channel`."""
        with self._lock:
            self._hear = hear
            while self._early:
                hear(self._early.popleft())

    def send(self, what: Outgoing) -> bool:
        """See `Channel`."""
        child = self._child
        return child is not None and child.send(what)

    def check(self) -> None:
        """See `Channel`."""
        child = self._child
        patience_s = max(_SILENT_S, self._setup.patience / SECOND)
        if child and time.monotonic() - self._heard_at > patience_s:
            self._heard_at = time.monotonic()
            threading.Thread(target=child.kill, daemon=True).start()

    def close(self) -> None:
        """Tell peers that the session is over, and end the process. Harmless twice."""
        with self._lock:
            self._is_closed = True
            child, self._child = self._child, None
        if child:
            if child.send(protocol.Publish(0, protocol.encode(protocol.LinkClosed()))) and child.send(None):
                child.ends_within(_CLOSES_S)
            child.kill()

    def _start(self) -> None:
        with self._lock:
            if not self._is_closed:
                self._started = self._heard_at = time.monotonic()
                self._child = _Child(self._setup, self._heard, self._program)

    def _heard(self, child: _Child, news: BrokerEvent | None) -> None:
        """On the child's listening thread."""
        self._heard_at = time.monotonic()
        if news is None:
            self._ended()
        elif isinstance(news, BrokerStarted) and not self._opened.is_set():
            self._why = news.why
            self._opened.set()
        elif not isinstance(news, Heartbeat | BrokerStarted):
            self._tell(news)

    def _tell(self, news: BrokerEvent | BrokerEnded) -> None:
        with self._lock:
            if self._hear:
                self._hear(news)
            else:
                self._early.append(news)

    def _ended(self) -> None:
        """Start another, unless that was tried too often; on the thread that heard of the end."""
        with self._lock:
            if self._is_closed:
                return
            self._child = None
        if not self._opened.is_set():
            self._why = self._why or "The link's process ended at once."
            self._opened.set()
            return
        self._restarts = 0 if time.monotonic() - self._started > _STEADY_S else self._restarts + 1
        if self._restarts <= _MOST_RESTARTS:
            self._tell(BrokerEnded(_ENDED))
            time.sleep(_PAUSE_S * self._restarts)
            with contextlib.suppress(OSError):
                self._start()
                return
        self._tell(BrokerEnded(_GIVEN_UP, is_final=True))
