"""Shared by sources whose device does not tell its rate: it is attached once the rate is known."""

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from itertools import pairwise
from statistics import fmean, median
from typing import Literal

from sar_tui.inputs.imu import Info, Sample, Status
from sar_tui.loop.clock import host_now
from sar_tui.model.units import SECOND

LOOKED_AT = 50
"""Samples from which the rate is estimated; or those of one second, at least five."""
_FEWEST = 5
_USUAL_STEP = 1.5
"""Steps of more than this many medians are left out of the estimate: samples are missing there."""
COMPLAIN_AGAIN = SECOND
"""Least time between two reports of an error."""
RETRY_S = 0.5
"""Time between two attempts to read a device."""
CLOSE_S = 2.0
"""Longest wait for the thread of a source that stops."""


class Delivery:
    """Delivers the samples of a device, and attaches it.

    It is attached when its rate is known: from the time stamps of its first samples, none of which
    is lost, or with the first one if the rate is given.

    Args:
        describe: returns the description of the device, given its samples a second and whether it
            measures acceleration.
        not_rising: sentence for a device whose time stamps do not increase.
        rate_hz: samples a second, if known.

    Attributes:
        info: description of the device; None until it is attached.
    """

    def __init__(
        self,
        describe: Callable[[float, bool], Info],
        not_rising: str,
        rate_hz: float | None = None,
    ) -> None:
        self.info: Info | None = None
        self._describe = describe
        self._not_rising = not_rising
        self._rate_hz = rate_hz
        self._first: list[Sample] = []
        self._said = ""
        self._complained_ns = -COMPLAIN_AGAIN

    def begin(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        """Deliver to a new consumer."""
        self._sink, self._on_status = sink, on_status
        self.forget()

    def forget(self) -> None:
        """Forget the device, and what was last said."""
        self.info = None
        self._first.clear()
        self._said = ""
        self._complained_ns = -COMPLAIN_AGAIN

    def put(self, sample: Sample, *, stamped: bool = True) -> None:
        """Deliver a sample. ``stamped``: its time is of the device's clock, not of the host's."""
        if self.info is not None:
            self._said = ""
            self._sink(sample)
            return
        self._first.append(sample)
        if rate_hz := self._rate_hz or self._rate_seen(stamped):
            self._attach(rate_hz)

    def wait(self, what: str) -> None:
        """Report that there is no device, and what is waited for; once in a row."""
        if self._said != what or self.info is not None:
            self.forget()
            self._said = what
            self._report("detached", what)

    def refuse(self, what: str) -> None:
        """Report that the device cannot be used, and why; once in a row."""
        if self._said != what or self.info is not None:
            if self.info is not None:
                self.wait(what)
            self._said = ""
            self.complain(what)

    def complain(self, what: str) -> None:
        """Report an error; once until samples are valid again, and never soon after another."""
        now = host_now()
        if what != self._said and now - self._complained_ns >= COMPLAIN_AGAIN:
            self._said, self._complained_ns = what, now
            self._report("error", what)

    def _rate_seen(self, stamped: bool) -> float | None:
        """Return samples per second among the first ones; None until there are enough."""
        first, count = self._first, len(self._first)
        if count < LOOKED_AT and (count < _FEWEST or first[-1].host_ns - first[0].host_ns < SECOND):
            return None
        steps = [after.device_ms - before.device_ms for before, after in pairwise(first)]
        longest = _USUAL_STEP * median(steps) if stamped else max(steps)
        step = fmean([step for step in steps if step <= longest])
        if step > 0:
            return 1000 / step
        self.complain(self._not_rising)
        first.clear()
        return None

    def _attach(self, rate_hz: float) -> None:
        measured = any(sample.acceleration[0] == sample.acceleration[0] for sample in self._first)
        self.info = self._describe(rate_hz, measured)
        self._report("attached")
        for sample in self._first:
            self._sink(sample)
        self._first.clear()

    def _report(self, state: Literal["attached", "detached", "error"], detail: str = "") -> None:
        self._on_status(Status(state=state, at=host_now(), detail=detail))


class Absent(Exception):
    """The device is not there now. The message says what is waited for."""


class Unusable(Exception):
    """The device is there, but cannot be used. The message says why, and what to do."""


class ReadSource(ABC):
    """Base of sources that read their device on a thread, and try again whenever that fails.

    Args:
        delivery: delivers the samples.
        name: name of the thread.
    """

    keeps_bias = True
    """The device cannot take its present rate as zero."""

    def __init__(self, delivery: Delivery, name: str) -> None:
        self.delivery = delivery
        self._thread_name = name
        self._stopped = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def info(self) -> Info | None:
        """Description of the device; None until it is attached."""
        return self.delivery.info

    def start(self, sink: Callable[[Sample], None], on_status: Callable[[Status], None]) -> None:
        """Look for the device in the background, and deliver its samples."""
        self.stop()
        self.delivery.begin(sink, on_status)
        self._stopped = threading.Event()
        self._thread = threading.Thread(
            target=self._run, args=(self._stopped,), name=self._thread_name, daemon=True
        )
        self._thread.start()

    def stop(self) -> None:
        """Stop delivering, and release the device. Takes at most two seconds if that hangs."""
        self._stopped.set()
        if self._thread and self._thread is not threading.current_thread():
            self._thread.join(CLOSE_S)
        self._thread = None
        self.delivery.forget()

    def zero(self) -> None:  # noqa: B027  most devices have nothing to do
        """Do nothing: the device keeps its bias."""

    @abstractmethod
    def _read(self, stopped: threading.Event) -> None:
        """Read the device until it fails, or ``stopped`` is set.

        Raises:
            Absent: it is not there.
            Unusable: it cannot be used.
        """

    def _run(self, stopped: threading.Event) -> None:
        while not stopped.is_set():
            try:
                self._read(stopped)
            except Exception as error:
                if stopped.is_set():
                    return
                if isinstance(error, Absent):
                    self.delivery.wait(str(error))
                elif isinstance(error, Unusable):
                    self.delivery.refuse(str(error))
                else:
                    self.delivery.refuse(f"The sensor cannot be read ({error!r}).")
                stopped.wait(RETRY_S)
