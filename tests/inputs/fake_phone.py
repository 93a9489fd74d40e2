"""A phone with phyphox: a real HTTP server on this computer that answers as the app does.

It follows the app's source for Android (phyphox/phyphox-android, RemoteServer.java, version 1.2.0):
thresholds are moved up by a part in 10⁷, numbers have eight digits, the query after a `clear` is
answered in full, unknown buffers are left out, and a failed command is a reply like any other.

The phone has a time of its own, which passes only as a test says and by the latency of requests, so
that an hour takes no longer than its requests.
"""

import json
import math
import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, NamedTuple
from urllib.parse import parse_qsl, urlsplit

from sar_tui.inputs.phyphox import TITLE
from sar_tui.model.units import SECOND
from sar_tui.motion.samples import Samples

Vector = tuple[float, float, float]
GYROSCOPE = ("gyrX", "gyrY", "gyrZ", "gyr_time")
ACCELEROMETER = ("accX", "accY", "accZ", "acc_time")
REST: Vector = (0.0, 0.0, 0.0)
LYING: Vector = (0.0, 0.0, 9.81)


class Experiment(NamedTuple):
    """An experiment of the app: its title, and the sensors with their buffers."""

    title: str = TITLE
    sensors: tuple[tuple[str, tuple[str, ...]], ...] = (
        ("gyroscope", GYROSCOPE),
        ("accelerometer", ACCELEROMETER),
    )
    size: int = 5000


STOCK = Experiment("Gyroscope (rotation rate)", (("gyroscope", GYROSCOPE),), 0)
"""The app's own experiment: one sensor, and buffers without a limit."""


class Phone:
    """A phone whose time a test advances.

    Attributes:
        began_ns: the host's time when the phone's clock was at zero.
        requests: paths that were asked for, in order.
        latency_ns: time that a request takes to arrive, and a reply to come back.
        fault: returns the body of a reply in place of the right one, given the path; None for the
            right one. It may raise ConnectionError to break off.
    """

    def __init__(self, experiment: Experiment = Experiment()) -> None:  # noqa: B008  immutable
        self.began_ns = 1000 * SECOND
        self.now_s = self.paused_s = 0.0
        self.requests: list[str] = []
        self.latency_ns: Callable[[], int] = lambda: 0
        self.fault: Callable[[str], str | None] = lambda path: None
        self.starts = True
        self.is_timed = False
        self._lock = threading.RLock()
        self._ahead: deque[tuple[float, Vector, Vector]] = deque()
        self._server: ThreadingHTTPServer | None = None
        self.port = 0
        self.open(experiment)

    # --- what happens to the phone

    def open(self, experiment: Experiment) -> None:
        """Open an experiment: a new session, without data."""
        with self._lock:
            self.experiment = experiment
            self.session = f"{id(experiment) & 0xFFFFFF:06x}{len(self.requests)}"
            self.measuring = self._must_be_full = False
            self._started_s: float | None = None
            self.buffers: dict[str, list[float]] = {
                name: [] for _, names in experiment.sensors for name in names
            }

    def pass_time(self, seconds: float) -> None:
        """Let time pass, and measure what is played."""
        with self._lock:
            until = self.now_s + seconds
            while self._ahead and self._ahead[0][0] <= until:
                at, rate, acceleration = self._ahead.popleft()
                self._go_to(at)
                self._append("gyroscope", self.t, rate)
                self._append("accelerometer", self.t, acceleration)
            self._go_to(until)

    def _go_to(self, now_s: float) -> None:
        if not self.measuring:
            self.paused_s += now_s - self.now_s
        self.now_s = now_s

    def measure(
        self,
        count: int = 1,
        step_s: float = 0.01,
        rate: Callable[[float], Vector] = lambda t: REST,
        acceleration: Callable[[float], Vector] | None = lambda t: LYING,
        offset_s: float = 0.0,
    ) -> None:
        """Measure samples with both sensors; ``offset_s``: the accelerometer is that much later."""
        with self._lock:
            for _ in range(count):
                self.pass_time(step_s)
                self._append("gyroscope", self.t, rate(self.now_s))
                if acceleration:
                    later = self.now_s + offset_s
                    self._append("accelerometer", self.t + offset_s, acceleration(later))

    def play(self, samples: Samples) -> None:
        """Measure the samples of a simulated hand as time passes, from now on."""
        columns = (samples[name].tolist() for name in ("device_ms", "rate", "acceleration"))
        with self._lock:
            self._ahead = deque(
                (self.now_s + ms / 1000, rate, acceleration)
                for ms, rate, acceleration in zip(*columns, strict=True)
            )

    @property
    def t(self) -> float:
        """Time of the experiment: from its first start, without pauses."""
        return self.now_s - self.paused_s - (self._started_s or 0.0)

    def _append(self, sensor: str, t: float, values: Vector) -> None:
        names = dict(self.experiment.sensors).get(sensor)
        if self.measuring and names:
            for name, value in zip(names, (*values, t), strict=True):
                self.buffers[name].append(value)
                if self.experiment.size:
                    del self.buffers[name][: -self.experiment.size]

    def clear(self) -> None:
        """Clear all data; the time begins anew, and the next query is answered in full."""
        with self._lock:
            for values in self.buffers.values():
                values.clear()
            self._must_be_full = True
            self._started_s = self.now_s - self.paused_s

    def lock(self) -> None:
        """Lock the screen: measurement and server stop."""
        self.leave()
        self.measuring = False

    # --- the server

    def now(self) -> int:
        """Return the host's time, in ns."""
        return self.began_ns + round(self.now_s * SECOND)

    def arrive(self) -> None:
        """Begin to answer, at the same port as before."""
        phone = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            disable_nagle_algorithm = True

            def do_GET(self) -> None:
                try:
                    body = phone.answer(self.path).encode()
                except ConnectionError:
                    self.close_connection = True
                    return
                self.send_response(200)
                self.send_header("Content-Type", "application/json")
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_: object) -> None:
                pass

            def handle(self) -> None:
                try:
                    super().handle()
                except OSError:  # the connection was shut down under it
                    self.close_connection = True

        class Server(ThreadingHTTPServer):
            daemon_threads = True

            def process_request(self, request: Any, client_address: Any) -> None:
                phone._connections.append(request)
                super().process_request(request, client_address)

        self._connections: list[Any] = []
        self._server = Server(("127.0.0.1", self.port), Handler)
        self.port = self._server.server_address[1]
        threading.Thread(
            target=self._server.serve_forever, args=(0.005,), name="phone", daemon=True
        ).start()

    def leave(self) -> None:
        """Stop answering, and break off all connections."""
        if self._server:
            self._server.shutdown()
            self._server.server_close()
            self._server = None
            for connection in self._connections:
                try:
                    connection.shutdown(2)
                except OSError:
                    continue

    def answer(self, path: str) -> str:
        """Return the body of a reply."""
        with self._lock:
            self.requests.append(path)
            self.pass_time(self.latency_ns() / SECOND)
            wrong = self.fault(path)
            if wrong is None:
                parts = urlsplit(path)
                query = dict(parse_qsl(parts.query, keep_blank_values=True))
                wrong = getattr(self, f"_{parts.path.strip('/')}")(query)
            self.pass_time(self.latency_ns() / SECOND)
            return wrong

    def _config(self, _: dict[str, str]) -> str:
        inputs = [
            {
                "source": sensor,
                "outputs": [{axis: name} for axis, name in zip("xyzt", names, strict=False)],
            }
            for sensor, names in self.experiment.sensors
        ]
        buffers = [{"name": name, "size": self.experiment.size} for name in self.buffers]
        facts = {"crc32": "44c5dc97", "title": self.experiment.title, "buffers": buffers}
        return json.dumps({**facts, "inputs": inputs, "export": []})

    def _meta(self, _: dict[str, str]) -> str:
        ranges = {"gyroscope": {"Range": "34.906586"}, "accelerometer": {"Range": "78.4532"}}
        return json.dumps({"deviceModel": "Test 5", "version": "1.2.0", "sensors": ranges})

    def _control(self, query: dict[str, str]) -> str:
        match query.get("cmd"):
            case "start" if self.starts:
                self.measuring = True
                self._started_s = self._started_s or self.now_s - self.paused_s
                return '{"result": true}'
            case "stop":
                self.measuring = False
                return '{"result": true}'
            case "clear":
                self.clear()
                return '{"result": true}'
        return '{"result": false}'

    def _get(self, query: dict[str, str]) -> str:
        full, self._must_be_full = self._must_be_full and bool(query), False
        parts = [self._buffer(n, v, full) for n, v in query.items() if n in self.buffers]
        status = {"session": self.session, "measuring": self.measuring, "timedRun": self.is_timed}
        state = json.dumps({**status, "countDown": 0})
        return f'{{"buffer":{{\n{",".join(parts)}\n}},\n"status":{state}\n}}\n'

    def _buffer(self, name: str, asked: str, full: bool) -> str:
        values = self.buffers[name]
        if not asked:
            mode, kept = "single", values[-1:] or [math.nan]
        elif asked == "full" or full:
            mode, kept = "full", values
        else:
            number, _, reference = asked.partition("|")
            threshold = float(number)
            if threshold:  # the app moves it up; of zero, the logarithm is minus infinity
                threshold += 10 ** math.floor(math.log10(abs(threshold) / 1e7))
            times = self.buffers[reference or name]
            mode = "partial"
            kept = [v for v, t in zip(values, times, strict=True) if t > threshold]
        numbers = ",".join(map(_number, kept))
        return f'"{name}":{{"size":{self.experiment.size},"updateMode":"{mode}", "buffer":[{numbers}]}}'


def _number(value: float) -> str:
    """Return a number as Java's DecimalFormat("0.#######E0") writes it."""
    if not math.isfinite(value):
        return "null"
    mantissa, _, exponent = f"{value:.7E}".partition("E")
    return f"{mantissa.rstrip('0').rstrip('.')}E{int(exponent)}"


@contextmanager
def phone(experiment: Experiment = Experiment()) -> Iterator[Phone]:  # noqa: B008  immutable
    """Provide a phone that answers."""
    made = Phone(experiment)
    made.arrive()
    try:
        yield made
    finally:
        made.leave()
