"""The broker process: runs Zenoh for a session, so that peers cannot disturb the timing of the
participant's program.

It talks to the program through pipes (see ``protocol``), and exits when its input ends, even if the
program was killed.
"""

import contextlib
import itertools
import math
import os
import queue
import threading
import time
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sar_tui.link import protocol
from sar_tui.link.admission import Admission
from sar_tui.link.peer import MotionTrace
from sar_tui.link.protocol import (
    Admit,
    BrokerCommand,
    BrokerEvent,
    Deny,
    ProtocolError,
    Publish,
    SendTo,
    SensorSamples,
    SessionMessage,
    Setup,
)
from sar_tui.link.remote_clock import clock_id
from sar_tui.link.zenoh_settings import LinkKeys, config
from sar_tui.loop.clock import host_now
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.samples import Samples, join, unpack

if TYPE_CHECKING:
    import zenoh


_TICK_S = 0.05
_HEARTBEAT = 500 * MS
_MAX_QUEUED = 500
_CLOSE_TIMEOUT_S = 0.5
_DIAL_AGAIN_S = 2.0
_ALL = ""
"""In place of a key: to all peers."""


class _OutgoingMessage(NamedTuple):
    """Payload for a key, or for ``_ALL``; ``number`` if it is a batch."""

    key: str
    payload: bytes
    number: int = 0


class Broker:
    """Runs Zenoh for a session.

    One thread reads the program's commands, Zenoh's threads deliver what peers send, and one thread
    sends. Zenoh's threads never send: they put messages on the outbox, or drop them if it is full.
    """

    def __init__(self, setup: Setup, events: int) -> None:
        self._events = events
        self._events_lock = threading.Lock()
        self._keys = LinkKeys(setup.link)
        self._outbox: queue.Queue[_OutgoingMessage | None] = queue.Queue(_MAX_QUEUED)
        self._is_visit = setup.is_visit
        self._zenoh: zenoh.Session | None = None
        self._admission = Admission(
            setup.lost_after, self.notify, self._answer, clock_id(), is_visit=setup.is_visit
        )
        self._downsampler: Downsampler | None = None
        self._downsampler_lock = threading.Lock()
        self._sender = threading.Thread(target=self._send, name="link sender", daemon=True)

    def notify(self, event: BrokerEvent) -> None:
        """Send an event to the program. If it is gone, the end of its commands will show it."""
        data = protocol.pack_frame(event)
        with self._events_lock, contextlib.suppress(OSError):
            while data:
                data = data[os.write(self._events, data) :]

    def open(self, setup: Setup) -> None:
        """Listen, or begin to dial out. Raises LinkError, or ZError with Zenoh's own reason."""
        import zenoh

        if setup.is_visit:
            threading.Thread(
                target=self._dial, args=(setup,), name="link dial", daemon=True
            ).start()
        else:
            if setup.guests is not None:
                _start_log(setup.guests, self._admission)
            self._serve(zenoh.open(config(setup.settings)))
        self._sender.start()

    def _dial(self, setup: Setup) -> None:
        """Connect to a router, by its addresses in turn, until one answers; from then on Zenoh
        reconnects by itself.
        """
        import zenoh

        for settings in itertools.cycle(setup.dials):
            with contextlib.suppress(zenoh.ZError):
                self._serve(zenoh.open(config(settings)))
                return
            time.sleep(_DIAL_AGAIN_S)

    def _serve(self, session: "zenoh.Session") -> None:
        """Listen to peers, and let them see that there is a session."""
        import zenoh

        self._zenoh = session
        keys, subscribers = self._keys, []
        for key, receive in (
            (keys.act("*"), self._admission.receive_act),
            (keys.ping("*"), self._admission.receive_ping),
        ):
            handler = zenoh.handlers.Callback(self._receiver(receive), indirect=False)
            subscribers.append(session.declare_subscriber(key, handler))
        liveliness = session.liveliness()
        handler = zenoh.handlers.Callback(self._liveliness_changed, indirect=False)
        subscribers.append(liveliness.declare_subscriber(keys.ping("*"), handler))
        self._declared = (*subscribers, liveliness.declare_token(keys.broadcast))

    def _receiver(self, receive: Any) -> Any:
        """Return a callback for Zenoh's samples."""

        def take(sample: "zenoh.Sample") -> None:
            now = host_now()
            name = str(sample.key_expr).rpartition("/")[2]
            too_long = len(sample.payload) > protocol.MAX_ACT_BYTES
            payload = bytes(protocol.MAX_ACT_BYTES + 1) if too_long else sample.payload.to_bytes()
            receive(name, payload, now)

        return take

    def _liveliness_changed(self, sample: "zenoh.Sample") -> None:
        if "DELETE" in str(sample.kind):
            self._admission.disconnect(str(sample.key_expr).rpartition("/")[2], host_now())

    def execute(self, command: BrokerCommand) -> None:
        """Execute a command of the program."""
        match command:
            case Publish():
                self._outbox.put(_OutgoingMessage(_ALL, command.payload, command.number))
            case SendTo():
                self._outbox.put(_OutgoingMessage(self._keys.reply(command.name), command.payload))
            case Admit():
                self._admission.admit(command.name)
            case Deny():
                self._admission.deny(command.why)
            case SensorSamples():
                with self._downsampler_lock:
                    self._downsampler = self._downsampler or Downsampler()
                    with contextlib.suppress(ValueError):
                        self._downsampler.add(command.seat, command.samples)

    def close(self) -> None:
        """Send what is queued and close Zenoh, so that peers see at once that the session is
        over.
        """
        with contextlib.suppress(queue.Full):
            self._outbox.put(None, timeout=_CLOSE_TIMEOUT_S)
        self._sender.join(_CLOSE_TIMEOUT_S)
        if self._zenoh is None:
            return
        closing = threading.Thread(target=self._zenoh.close, daemon=True)
        closing.start()
        closing.join(_CLOSE_TIMEOUT_S)

    def _answer(self, name: str, message: SessionMessage) -> None:
        with contextlib.suppress(queue.Full):
            self._outbox.put_nowait(
                _OutgoingMessage(self._keys.reply(name), protocol.encode(message))
            )

    def _send(self) -> None:
        import zenoh

        tick = heartbeat = 0
        while True:
            with contextlib.suppress(queue.Empty):
                if (message := self._outbox.get(timeout=_TICK_S)) is None:
                    return
                self._put(zenoh, *message)
            now = host_now()
            if now - tick >= _TICK_S * 1e9:
                tick = now
                self._admission.tick(now)
                self._put_traces(zenoh, now)
            if now - heartbeat >= _HEARTBEAT:
                heartbeat = now
                self.notify(protocol.Heartbeat())

    def _put(self, zenoh: Any, key: str, payload: bytes, number: int = 0) -> None:
        """Send without waiting for slow peers: they notice a missing batch by its number and ask
        for a snapshot.
        """
        if number:
            self._admission.number = number
        if self._zenoh is None:
            return
        for each in (key,) if key else self._keys_of_all:
            with contextlib.suppress(zenoh.ZError):
                self._zenoh.put(
                    each, payload, congestion_control=zenoh.CongestionControl.DROP, express=True
                )

    @property
    def _keys_of_all(self) -> list[str]:
        """The keys by which all peers are reached: in a visit, those of the ones who were agreed
        to, as anybody at the clinic could listen to another.
        """
        if not self._is_visit:
            return [self._keys.broadcast]
        return [self._keys.reply(name) for name in self._admission.present]

    def _put_traces(self, zenoh: Any, now: int) -> None:
        if self._downsampler:
            with self._downsampler_lock:
                traces = self._downsampler.due(now)
            if traces:
                self._put(zenoh, _ALL, protocol.encode(protocol.MotionTraces(traces)))


def _read_log(log: int, guests: tuple[str, ...], admission: Admission) -> None:
    """Report what Zenoh refuses, which only its log contains; a flood of refusals stays in this
    process.
    """
    from sar_tui.link.refusals import RefusalLog

    refusals = RefusalLog(guests)
    with os.fdopen(log, encoding="utf-8", errors="replace") as lines:
        for line in lines:
            if refusal := refusals.parse(line.rstrip("\n")):
                why = f"{refusal.why[:1].upper()}{refusal.why[1:]}."
                admission.refuse(refusal.guest or "unknown", f"a {refusal.what}", why, host_now())


def _start_log(guests: tuple[str, ...], admission: Admission) -> None:
    """Redirect standard output, where Zenoh writes its log, to a pipe and read it."""
    import zenoh

    from sar_tui.link.refusals import HOST_LOG, log_environment

    log, end = os.pipe()
    os.dup2(end, 1)
    os.close(end)
    os.environ |= log_environment(HOST_LOG)
    threading.Thread(
        target=_read_log, args=(log, guests, admission), name="link log", daemon=True
    ).start()
    zenoh.init_log_from_env_or(HOST_LOG)


def main() -> None:
    """Run until the commands end."""
    os.umask(0o177)  # the socket's folder is private already, and so is the socket
    commands = os.fdopen(os.dup(0), "rb")
    events = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # libraries must not print into the pipe of events
    with contextlib.suppress(ProtocolError, OSError):
        setup = protocol.read_frame(commands, BrokerCommand)
        if isinstance(setup, Setup):
            broker = Broker(setup, events)
            try:
                broker.open(setup)
            except Exception as error:
                broker.notify(protocol.BrokerStarted(str(error) or type(error).__name__))
            else:
                broker.notify(protocol.BrokerStarted())
                while (command := protocol.read_frame(commands, BrokerCommand)) is not None:
                    broker.execute(command)
                broker.close()
    os._exit(0)  # even if a thread of Zenoh's hangs


# --- samples of sensors for operators


INTERVAL = SECOND // 12
"""Shortest time between two traces of a seat (ns)."""
MAX_POINTS = 50
_POINTS_HZ = 60.0
"""Finer than a panel's plot can show."""


class Downsampler:
    """Traces of one session's motion sensors, by seat."""

    def __init__(self) -> None:
        self._pending: dict[str, list[Samples]] = {}
        self._sent_at: dict[str, int] = {}

    def add(self, seat: str, data: bytes) -> None:
        """Add packed samples. Raises ValueError if they cannot be unpacked."""
        if len(samples := unpack(data)):
            self._pending.setdefault(seat, []).append(samples)

    def due(self, now: int) -> list[MotionTrace]:
        """Return the traces to send at ``now`` (ns)."""
        seats = [
            seat for seat in self._pending if now - self._sent_at.get(seat, -INTERVAL) >= INTERVAL
        ]
        self._sent_at |= dict.fromkeys(seats, now)
        return [_trace(seat, join(self._pending.pop(seat))) for seat in seats]


def _trace(seat: str, samples: Samples) -> MotionTrace:
    """Return the norm of the angular rate, averaged over as many samples as needed to keep to
    ``MAX_POINTS``.
    """
    speeds = np.linalg.norm(samples["rate"].astype(float), axis=1)
    seconds = float(samples["at"][-1] - samples["at"][0]) / SECOND
    rate_hz = (len(samples) - 1) / seconds if seconds > 0 else _POINTS_HZ
    stride = max(math.ceil(len(speeds) / MAX_POINTS), math.ceil(rate_hz / _POINTS_HZ))
    points = [
        float(np.mean(speeds[start : start + stride])) for start in range(0, len(speeds), stride)
    ]
    return MotionTrace(
        seat=seat,
        at=int(samples["at"][-1]),
        hz=round(rate_hz / stride, 3),
        rates=tuple(round(point, 4) for point in points),
    )


if __name__ == "__main__":
    main()
