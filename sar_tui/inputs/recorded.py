"""A recording as a sensor: plays its samples in real time or as fast as possible."""

import threading
from collections.abc import Callable, Iterator
from typing import Any, Literal

import numpy as np

from sar_tui.inputs.imu import Info, Sample, SourceError, Status
from sar_tui.loop.clock import Clock, Handle, host_now
from sar_tui.model.units import SECOND
from sar_tui.motion.samples import Samples

BLOCK = 1000
"""Number of samples sent at a time when playing fast."""

_vector: Callable[[Any], Any] = tuple


def as_sent(samples: Samples) -> Iterator[Sample]:
    """Yield samples one by one, as a sensor's driver delivers them."""
    columns = (
        samples[name].tolist() for name in ("host", "device_ms", "acceleration", "rate", "field")
    )
    for host_ns, device_ms, acceleration, rate, field in zip(*columns, strict=True):
        yield Sample(host_ns, device_ms, _vector(acceleration), _vector(rate), _vector(field))


class RecordedSource:
    """Plays samples, then reports that it has ended.

    Samples are stamped as in real time, also when they are played fast.

    Args:
        samples: the samples, dtype SAMPLE, at least two; their ``at`` sets the times.
        speed: as recorded, or as fast as possible.
        loop: True to repeat without end. In real time only: raises SourceError.
        clock: the clock to play on; the host's, with its own thread, if None.
        name: the name of the recording.
    """

    def __init__(
        self,
        samples: Samples,
        speed: Literal["real time", "fast"] = "real time",
        loop: bool = False,
        *,
        clock: Clock | None = None,
        name: str = "recorded",
    ) -> None:
        if len(samples) < 2:
            raise SourceError(
                f"A recording needs at least two samples to be played; this one has {len(samples)}."
            )
        if loop and speed == "fast":
            raise SourceError(
                "A recording cannot be both played fast and repeated without end. Choose one."
            )
        self.info: Info | None = None
        self._speed = speed
        self._loop = loop
        self._samples = list(as_sent(samples))
        self._elapsed: list[int] = (samples["at"] - samples["at"][0]).tolist()
        self._step_ns = int(np.median(np.diff(samples["at"])))
        self._pace = Pace(self._play, clock)
        self._info = Info(
            source=name,
            model="Recording",
            rate_hz=1e9 / self._step_ns,
            has_acceleration=not np.isnan(samples["acceleration"]).all(),
            has_field=not np.isnan(samples["field"]).all(),
        )

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        """Play from the beginning."""
        self._pace.stop()
        self._sink, self._on_status = sink, on_status
        self.info = None
        self._next = 0
        self._round_ns = 0
        self._pace.start()

    def stop(self) -> None:
        """Stop playing."""
        self._pace.stop()

    def zero(self) -> None:
        """Do nothing: recorded samples do not change."""

    def _play(self, now: int) -> int | None:
        if self.info is None:
            self.info = self._info
            self._begun_ns = now
            self._on_status(Status(state="attached", at=now))
        if self._speed == "fast":
            for _ in self._samples[self._next : self._next + BLOCK]:
                self._send(self._due_ns)
        else:
            while self._next < len(self._samples) and self._due_ns <= now:
                self._send(now)
        if self._next < len(self._samples):
            return now if self._speed == "fast" else self._due_ns
        if self._loop:
            self._round_ns += self._elapsed[-1] + self._step_ns
            self._next = 0
            return self._due_ns
        self._on_status(
            Status(
                state="ended",
                at=self._begun_ns + self._elapsed[-1],
                detail="The recording is at its end.",
            )
        )
        return None

    @property
    def _due_ns(self) -> int:
        return self._begun_ns + self._round_ns + self._elapsed[self._next]

    def _send(self, host_ns: int) -> None:
        sample = self._samples[self._next]
        device_ms = sample.device_ms + self._round_ns / 1e6
        self._sink(sample._replace(host_ns=host_ns, device_ms=device_ms))
        self._next += 1


class Pace:
    """Calls a step at its times: by a clock's callbacks, or on a thread.

    Args:
        step: does what is due at the given time (ns), and returns the time of its next call; None
            for never.
        clock: the clock whose callbacks to use; if None, a thread on the host's clock.
    """

    def __init__(self, step: Callable[[int], int | None], clock: Clock | None = None) -> None:
        self._step = step
        self._clock = clock
        self._stopped = threading.Event()
        self._due: Handle | None = None
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Take the first step as soon as possible."""
        self.stop()
        self._stopped = threading.Event()
        if self._clock:
            self._tick_at(self._clock, self._clock.now())
        else:
            self._thread = threading.Thread(
                target=self._run, args=(self._stopped,), name="sensor", daemon=True
            )
            self._thread.start()

    def stop(self) -> None:
        """Take no more steps. Waits for one under way, unless called by it."""
        self._stopped.set()
        if self._due:
            self._due.cancel()
            self._due = None
        if self._thread and self._thread is not threading.current_thread():
            self._thread.join()
        self._thread = None

    def _tick_at(self, clock: Clock, when: int) -> None:
        def tick() -> None:
            due = self._step(clock.now())
            if due is not None and not stopped.is_set():
                self._tick_at(clock, due)

        stopped = self._stopped
        self._due = clock.call_at(when, tick)

    def _run(self, stopped: threading.Event) -> None:
        due: int | None = host_now()
        while due is not None and not stopped.wait(max(0, due - host_now()) / SECOND):
            due = self._step(host_now())
