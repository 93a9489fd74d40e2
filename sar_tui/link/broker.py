"""The link's own process: holds Zenoh for a session, so that nothing of a peer's ever runs beside the participant's.

The program talks to it through pipes (see `wire`). It ends when its input ends, whatever became of the program.
"""

import contextlib
import os
import queue
import threading
from typing import TYPE_CHECKING, Any, NamedTuple

from sar_tui.framework.clock import MS, host_now
from sar_tui.link import protocol
from sar_tui.link.admission import Admission
from sar_tui.link.protocol import (
    BrokerCommand,
    BrokerEvent,
    ProtocolError,
    Publish,
    SendTo,
    SensorSamples,
    SessionMessage,
    Setup,
)
from sar_tui.link.remote_clock import clock_id
from sar_tui.link.settings import LinkKeys, config

if TYPE_CHECKING:
    import zenoh

    from sar_tui.link.downsample import Downsampler

_TICK_S = 0.05
_BEAT = 500 * MS
_MOST_WAITING = 500
_GOODBYE_S = 0.5


class _Parcel(NamedTuple):
    """To be sent: where to, what, and which batch it is."""

    key: str
    payload: bytes
    number: int = 0


class Broker:
    """Three threads: one reads the program's orders, Zenoh's hand over what peers send, and one sends.

    Zenoh's threads never send: what they would is put on the outbox, or where that is full left out.
    """

    def __init__(self, setup: Setup, up: int) -> None:
        self._up = up
        self._up_lock = threading.Lock()
        self._keys = LinkKeys(setup.link)
        self._outbox: queue.Queue[_Parcel | None] = queue.Queue(_MOST_WAITING)
        self._desk = Admission(setup.patience, self.tell, self._answer, clock_id())
        self._glimpse: Downsampler | None = None
        self._glimpse_lock = threading.Lock()
        self._sender = threading.Thread(target=self._send, name="link sender", daemon=True)

    def tell(self, news: BrokerEvent) -> None:
        """Tell the program; if it is no longer there, the end of the orders tells so."""
        data = protocol.pack_frame(news)
        with self._up_lock, contextlib.suppress(OSError):
            while data:
                data = data[os.write(self._up, data) :]

    def open(self, setup: Setup) -> None:
        """Listen. Raises LinkError where that cannot be; ZError where Zenoh says why in its own words."""
        import zenoh

        if setup.guests is not None:
            _begin_log(setup.guests, self._desk)
        self._zenoh = zenoh.open(config(setup.settings))
        keys, heard = self._keys, []
        for key, receive in ((keys.act("*"), self._desk.act), (keys.hello("*"), self._desk.hello)):
            handler = zenoh.handlers.Callback(self._receiver(receive), indirect=False)
            heard.append(self._zenoh.declare_subscriber(key, handler))
        liveliness = self._zenoh.liveliness()
        handler = zenoh.handlers.Callback(self._seen, indirect=False)
        heard.append(liveliness.declare_subscriber(keys.hello("*"), handler))
        self._held = (*heard, liveliness.declare_token(keys.out))
        self._sender.start()

    def _receiver(self, receive: Any) -> Any:
        """Takes a sample of Zenoh's; nothing that one holds may end the thread that brings the next."""

        def take(sample: "zenoh.Sample") -> None:
            now = host_now()
            name = str(sample.key_expr).rpartition("/")[2]
            length = len(sample.payload)
            payload = (
                sample.payload.to_bytes() if length <= protocol.MAX_ACT_BYTES else bytes(protocol.MAX_ACT_BYTES + 1)
            )
            receive(name, payload, now)

        return take

    def _seen(self, sample: "zenoh.Sample") -> None:
        if "DELETE" in str(sample.kind):
            self._desk.gone(str(sample.key_expr).rpartition("/")[2])

    def order(self, order: BrokerCommand) -> None:
        """Do what the program says."""
        match order:
            case Publish():
                self._outbox.put(_Parcel(self._keys.out, order.payload, order.number))
            case SendTo():
                self._outbox.put(_Parcel(self._keys.back(order.name), order.payload))
            case SensorSamples():
                from sar_tui.link.downsample import Downsampler

                with self._glimpse_lock:
                    self._glimpse = self._glimpse or Downsampler()
                    with contextlib.suppress(ValueError):
                        self._glimpse.hear(order.seat, order.samples)

    def close(self) -> None:
        """Send what waits, and let go: peers see at once that it is over."""
        with contextlib.suppress(queue.Full):
            self._outbox.put(None, timeout=_GOODBYE_S)
        self._sender.join(_GOODBYE_S)
        closing = threading.Thread(target=self._zenoh.close, daemon=True)
        closing.start()
        closing.join(_GOODBYE_S)

    def _answer(self, name: str, told: SessionMessage) -> None:
        with contextlib.suppress(queue.Full):
            self._outbox.put_nowait(_Parcel(self._keys.back(name), protocol.encode(told)))

    def _send(self) -> None:
        import zenoh

        tick = beat = 0
        while True:
            with contextlib.suppress(queue.Empty):
                if (parcel := self._outbox.get(timeout=_TICK_S)) is None:
                    return
                self._put(zenoh, *parcel)
            now = host_now()
            if now - tick >= _TICK_S * 1e9:
                tick = now
                self._desk.tick(now)
                self._put_traces(zenoh, now)
            if now - beat >= _BEAT:
                beat = now
                self.tell(protocol.Heartbeat())

    def _put(self, zenoh: Any, key: str, payload: bytes, number: int = 0) -> None:
        """Never wait for a peer that does not listen: it sees by the number that it missed something, and asks."""
        if number:
            self._desk.number = number
        with contextlib.suppress(zenoh.ZError):
            self._zenoh.put(key, payload, congestion_control=zenoh.CongestionControl.DROP, express=True)

    def _put_traces(self, zenoh: Any, now: int) -> None:
        if self._glimpse:
            with self._glimpse_lock:
                traces = self._glimpse.due(now)
            if traces:
                self._put(zenoh, self._keys.out, protocol.encode(protocol.MotionTraces(traces)))


def _read_log(log: int, guests: tuple[str, ...], desk: Admission) -> None:
    """Tell of what Zenoh refuses, which it writes to its log alone. A flood of that stays in this process."""
    from sar_tui.link.refusals import Refusals

    refusals = Refusals(guests)
    with os.fdopen(log, encoding="utf-8", errors="replace") as lines:
        for line in lines:
            if refusal := refusals.heard(line.rstrip("\n")):
                why = f"{refusal.why[:1].upper()}{refusal.why[1:]}."
                desk.refuse(refusal.guest or "unknown", f"a {refusal.what}", why, host_now())


def _begin_log(guests: tuple[str, ...], desk: Admission) -> None:
    """Have Zenoh write its log to a pipe in the place of standard output, and read it."""
    import zenoh

    from sar_tui.link.refusals import HOST_LOG, log_environment

    log, end = os.pipe()
    os.dup2(end, 1)
    os.close(end)
    os.environ |= log_environment(HOST_LOG)
    threading.Thread(target=_read_log, args=(log, guests, desk), name="link log", daemon=True).start()
    zenoh.init_log_from_env_or(HOST_LOG)


def main() -> None:
    """Run until the orders end."""
    orders = os.fdopen(os.dup(0), "rb")
    up = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what a library prints is not for the program
    with contextlib.suppress(ProtocolError, OSError):
        setup = protocol.read_frame(orders, BrokerCommand)
        if isinstance(setup, Setup):
            broker = Broker(setup, up)
            try:
                broker.open(setup)
            except Exception as error:
                broker.tell(protocol.BrokerStarted(str(error) or type(error).__name__))
            else:
                broker.tell(protocol.BrokerStarted())
                while (order := protocol.read_frame(orders, BrokerCommand)) is not None:
                    broker.order(order)
                broker.close()
    os._exit(0)  # a thread of Zenoh's that hangs must not keep it alive


if __name__ == "__main__":
    main()
