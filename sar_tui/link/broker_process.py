"""Runs the broker process of a session: starts it before the app, and restarts it if it dies."""

import contextlib
import queue
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import IO, NamedTuple, Protocol

from sar_tui.drivers import child_process
from sar_tui.link import protocol
from sar_tui.link.errors import LinkError
from sar_tui.link.peer import Welcome
from sar_tui.link.protocol import (
    Admit,
    BrokerCommand,
    BrokerEvent,
    BrokerStarted,
    Deny,
    Heartbeat,
    ProtocolError,
    Setup,
)
from sar_tui.loop.bus import Record
from sar_tui.model.messages import ActAnswered
from sar_tui.model.units import SECOND


class OutgoingBatch(NamedTuple):
    """Messages of the bus for all peers; batches are numbered from 1."""

    number: int
    records: Sequence[Record]

    def to_command(self) -> BrokerCommand:
        """Encode it as a command to the broker."""
        batch = protocol.Batch(self.number, protocol.encode_frames(self.records))
        return protocol.Publish(self.number, protocol.encode(batch))


class OutgoingSnapshot(NamedTuple):
    """State of the session after batch ``number``, for one peer."""

    name: str
    number: int
    welcome: Welcome
    records: Sequence[Record]

    def to_command(self) -> BrokerCommand:
        """Encode it as a command to the broker."""
        snapshot = protocol.Snapshot(
            self.number, self.welcome, protocol.encode_frames(self.records)
        )
        return protocol.SendTo(self.name, protocol.encode(snapshot))


class OutgoingAnswers(NamedTuple):
    """Answers to acts of one peer."""

    name: str
    answers: list[ActAnswered]

    def to_command(self) -> BrokerCommand:
        """Encode it as a command to the broker."""
        return protocol.SendTo(self.name, protocol.encode(protocol.Answers(self.answers)))


class OutgoingSamples(NamedTuple):
    """Samples of the sensor at a seat."""

    seat: str
    samples: bytes

    def to_command(self) -> BrokerCommand:
        """Encode it as a command to the broker."""
        return protocol.SensorSamples(self.seat, self.samples)


class BrokerEnded(NamedTuple):
    """The broker process ended. ``is_final``: it could not be restarted."""

    detail: str
    is_final: bool = False


Outgoing = OutgoingBatch | OutgoingSnapshot | OutgoingSamples | OutgoingAnswers | Admit | Deny
BrokerListener = Callable[[BrokerEvent | BrokerEnded], object]


class Channel(Protocol):
    """Connection of a node to the broker process.

    ``is_visit``: see `protocol.Setup`.
    """

    is_visit: bool

    def listen(self, listener: BrokerListener) -> None:
        """Call ``listener`` on any thread with each event, and first with those that came
        before.
        """

    def send(self, message: Outgoing) -> bool:
        """Queue a message without blocking; False, and it is dropped, if the queue is full."""

    def check(self) -> None:
        """Kill a broker process that no longer answers, so that it is restarted."""


PROGRAM = child_process.python("sar_tui.link.broker")
_MAX_QUEUED = 200
_START_TIMEOUT_S = 20.0
_SILENCE_TIMEOUT_S = 2.0
"""A broker that is silent for longer is killed; the timeout is longer where peers may be silent for
longer.
"""
_STABLE_S = 30.0
"""The count of restarts begins again after a broker has run for this long."""
_MAX_RESTARTS = 5
_RESTART_DELAY_S = 0.2
_CLOSE_TIMEOUT_S = 2.0

_SILENT = "The link's process did not answer within {:.0f} s."
_ENDED = "The link's process ended and is restarted."
_GIVEN_UP = "The link's process ended repeatedly. There is no link for the rest of this session."


class _Child:
    """One process, with a thread that writes to it and one that reads from it.

    ``on_event`` is called with each event, and with None when the process has ended.
    """

    def __init__(
        self,
        setup: Setup,
        on_event: "Callable[[_Child, BrokerEvent | None], object]",
        program: Sequence[str],
    ) -> None:
        self._process: subprocess.Popen[bytes] = child_process.start(program)
        assert self._process.stdin
        assert self._process.stdout
        self._commands: IO[bytes] = self._process.stdin
        self._events: IO[bytes] = self._process.stdout
        self._on_event = on_event
        self._outbox: queue.Queue[Outgoing | BrokerCommand | None] = queue.Queue(_MAX_QUEUED)
        self._outbox.put(setup)
        self.pid = self._process.pid
        self._threads = [
            threading.Thread(target=run, name=name, daemon=True)
            for run, name in ((self._write, "link commands"), (self._read, "link events"))
        ]
        for thread in self._threads:
            thread.start()

    def send(self, message: "Outgoing | BrokerCommand | None") -> bool:
        """Queue a message for the writing thread, or None to end it; False if the queue is full."""
        try:
            self._outbox.put_nowait(message)
        except queue.Full:
            return False
        return True

    def kill(self) -> None:
        """Kill the process, if it still runs."""
        child_process.kill(self._process)

    def wait(self, seconds: float) -> None:
        """Wait until the process ends, at most ``seconds``."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)

    def _write(self) -> None:
        with contextlib.suppress(OSError), self._commands:
            while (message := self._outbox.get()) is not None:
                command = message if isinstance(message, BrokerCommand) else message.to_command()
                data = memoryview(protocol.pack_frame(command))
                while data:
                    data = data[self._commands.write(data) :]

    def _read(self) -> None:
        with contextlib.suppress(OSError, ProtocolError), self._events:
            while (event := protocol.read_frame(self._events, BrokerEvent)) is not None:
                self._on_event(self, event)
        self.kill()
        self.send(None)
        self._on_event(self, None)


class BrokerProcess:
    """The broker process of a session; a ``Channel``.

    Args:
        setup: sent to the process each time it is started.
        program: its command line.
    """

    def __init__(self, setup: Setup, program: Sequence[str] = PROGRAM) -> None:
        self.link = setup.link
        self.is_visit = setup.is_visit
        self._setup, self._program = setup, program
        self._lock = threading.RLock()
        self._listener: BrokerListener | None = None
        self._early: deque[BrokerEvent | BrokerEnded] = deque(maxlen=1_000)
        self._opened = threading.Event()
        self._error: str | None = None
        self._child: _Child | None = None
        self._started_at = self._last_event_at = 0.0
        self._restarts = 0
        self._is_closed = False

    @property
    def pid(self) -> int | None:
        """Process id of the current broker."""
        return self._child.pid if self._child else None

    def open(self) -> None:
        """Start the process. Raises LinkError if it cannot listen as configured. One that dials out
        is not waited for: the router may be away.
        """
        try:
            self._start()
        except OSError as error:
            raise LinkError(
                f"The link's process cannot be started: {error.strerror or error}."
            ) from error
        if self.is_visit:
            return
        if not self._opened.wait(_START_TIMEOUT_S):
            self._error = _SILENT.format(_START_TIMEOUT_S)
        if self._error:
            self.close()
            raise LinkError(self._error)

    def listen(self, listener: BrokerListener) -> None:
        """See `Channel`."""
        with self._lock:
            self._listener = listener
            while self._early:
                listener(self._early.popleft())

    def send(self, message: Outgoing) -> bool:
        """See `Channel`."""
        child = self._child
        return child is not None and child.send(message)

    def check(self) -> None:
        """See `Channel`."""
        child = self._child
        timeout_s = max(_SILENCE_TIMEOUT_S, self._setup.lost_after / SECOND)
        if not self._opened.is_set():  # it is still loading
            timeout_s = _START_TIMEOUT_S
        if child and time.monotonic() - self._last_event_at > timeout_s:
            self._last_event_at = time.monotonic()
            threading.Thread(target=child.kill, daemon=True).start()

    def close(self) -> None:
        """Notify peers that the session is over, and end the process. May be called twice."""
        with self._lock:
            self._is_closed = True
            child, self._child = self._child, None
        if child:
            if child.send(
                protocol.Publish(0, protocol.encode(protocol.LinkClosed()))
            ) and child.send(None):
                child.wait(_CLOSE_TIMEOUT_S)
            child.kill()

    def _start(self) -> None:
        with self._lock:
            if not self._is_closed:
                self._started_at = self._last_event_at = time.monotonic()
                self._child = _Child(self._setup, self._received, self._program)

    def _received(self, child: _Child, event: BrokerEvent | None) -> None:
        """Handle an event on the child's reading thread."""
        self._last_event_at = time.monotonic()
        if event is None:
            self._ended()
        elif isinstance(event, BrokerStarted) and not self._opened.is_set():
            self._error = event.error
            self._opened.set()
        elif not isinstance(event, Heartbeat | BrokerStarted):
            self._notify(event)

    def _notify(self, event: BrokerEvent | BrokerEnded) -> None:
        with self._lock:
            if self._listener:
                self._listener(event)
            else:
                self._early.append(event)

    def _ended(self) -> None:
        """Restart the broker, up to ``_MAX_RESTARTS`` times; on the child's reading thread."""
        with self._lock:
            if self._is_closed:
                return
            self._child = None
        if not self._opened.is_set():
            self._error = self._error or "The link's process ended at once."
            self._opened.set()
            return
        self._restarts = (
            0 if time.monotonic() - self._started_at > _STABLE_S else self._restarts + 1
        )
        if self._restarts <= _MAX_RESTARTS:
            self._notify(BrokerEnded(_ENDED))
            time.sleep(_RESTART_DELAY_S * self._restarts)
            with contextlib.suppress(OSError):
                self._start()
                return
        self._notify(BrokerEnded(_GIVEN_UP, is_final=True))
