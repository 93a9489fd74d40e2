"""A phone on the hand: its gyroscope and accelerometer, through the app phyphox (phyphox.org)."""

import math
import socket
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, suppress
from importlib.resources import files

from sar_tui.inputs.delivery import Absent, Delivery, ReadSource, Unusable
from sar_tui.inputs.imu import NOTHING, Info, Sample, SourceError, Vector
from sar_tui.inputs.network_address import bracketed, split_address
from sar_tui.inputs.phyphox_remote import (
    TRANSPORT_ERRORS,
    Asked,
    Config,
    Connection,
    Device,
    Input,
    Query,
    Reply,
    State,
)
from sar_tui.loop.clock import host_now
from sar_tui.model.language import Sentence
from sar_tui.model.units import MS, SECOND
from sar_tui.model.visible_text import visible

PORTS = (8080, 80)
"""Default ports of the app on Android and on iOS, tried in turn."""
TITLE = "sar-tui"
"""Title of our own experiment."""

POLL_S = 0.02
"""Pause between two requests; the app asks for 10 ms at least."""
GIVE_UP = 3 * SECOND
"""A phone that has not answered for this long is lost. Until then it may catch up: it goes on
measuring while the network is down.
"""
SILENCE = 500 * MS
"""A phone that measures but has no new samples for this long is asked for its newest time."""
JUMP = 250 * MS
"""A larger step between the phone's clock and ours means that it was paused or cleared."""
HOLD_S = 0.1
"""Longest time that a sample of the gyroscope waits for the accelerometer, on the phone's clock."""

_MOST_HELD = 5000
_NO_ADDRESS = (
    'There is no sensor "phyphox:{address}". Use phyphox://HOST or phyphox://HOST:PORT with the '
    "address that the phone shows below the experiment, such as phyphox://192.168.1.20:8080."
)
_WAITING = (
    "Waiting for the phone at {}: open the experiment sar-tui in phyphox, choose Allow remote "
    "access in its menu, and keep its screen on."
)
_NO_SUCH_NAME = (
    "The network has no device of the name {}: use the address that the phone shows below the "
    "experiment, and see that the phone and this computer are in the same network."
)
_NO_GYROSCOPE = (
    'The experiment "{}" on the phone does not send the gyroscope with its time. Open the '
    "experiment sar-tui; `sar-tui sensors --phyphox FILE` writes it for the phone."
)
_SILENT = (
    "The phone measures, but its gyroscope sends nothing: see whether phyphox shows its values."
)
_TIMED = "The phone is set to a timed run: switch that off in the menu of phyphox."
_REFUSED = "The phone does not start to measure: see what phyphox shows on its screen."
_CLEARED = "The phone began anew: its data were cleared, or its measurement was paused."
_NOT_RISING = "The time stamps of the phone do not increase, so its sample rate is unknown."


def experiment_file() -> bytes:
    """Return our own experiment for the app, which measures with both sensors."""
    return (files(__package__) / "sar-tui.phyphox").read_bytes()


class PhyphoxSource(ReadSource):
    """A phone that runs an experiment of phyphox with remote access, as a source of samples.

    The phone's own time stamps are the device's clock. If the phone does not measure, it is
    started, and stopped at the end. Our own experiment is cleared before that, so that its times
    are small: the app sends eight digits. The acceleration is interpolated at the times of the
    gyroscope, as the two sensors have time stamps of their own.

    Args:
        address: ``//HOST[:PORT]``; both default ports are tried if it names none. Raises
            SourceError for anything else.
        now: returns the time of the host's clock, in ns.
    """

    def __init__(self, address: str, now: Callable[[], int] = host_now) -> None:
        try:
            self._host, port, query = split_address(address, "phyphox")
        except ValueError:
            self._host = query = ""
        if query or not self._host:
            raise SourceError(Sentence(_NO_ADDRESS, address=address))
        self._ports = deque((port,) if port else PORTS)
        self._now = now
        self._phone = Device()
        self._has_started_it = False
        super().__init__(Delivery(self._described, _NOT_RISING), "phyphox")

    def _described(self, rate_hz: float, has_acceleration: bool) -> Info:
        return Info(
            source=f"phyphox://{bracketed(self._host)}:{self._ports[0]}",
            model=self._phone.model,
            rate_hz=rate_hz,
            rate_range_rad_s=self._phone.rate_range,
            acceleration_range_m_s2=self._phone.acceleration_range,
            has_acceleration=has_acceleration,
        )

    def _read(self, stopped: threading.Event) -> None:
        with closing(Connection(self._host, self._ports[0], self._now)) as phone:
            try:
                config = phone.ask("/config", Config)
                self._phone = phone.device()
                reading = _Reading(config)
                self._begin(phone, config, reading)
            except TRANSPORT_ERRORS as error:
                self._ports.rotate()
                raise self._absent(error) from error
            try:
                while not stopped.wait(POLL_S):
                    samples = self._poll(phone, reading)
                    if stopped.is_set():
                        break
                    if reading.is_silent and self.info is None:
                        self.delivery.wait(_SILENT)
                    for sample in samples:
                        self.delivery.put(sample)
            finally:
                if stopped.is_set() and self._has_started_it:
                    self._has_started_it = False
                    with suppress(*TRANSPORT_ERRORS):
                        phone.control("stop")

    def _begin(self, phone: Connection, config: Config, reading: "_Reading") -> None:
        """Have the phone measure, and go to the newest sample: older ones are not of now."""
        state = reading.seek(phone.get(reading.last))
        if state.measuring:
            return
        if state.timed:
            raise Absent(_TIMED)
        if config.title == TITLE:
            phone.control("clear")
            reading.rewind()
        if not phone.control("start"):
            raise Unusable(_REFUSED)
        self._has_started_it = True

    def _poll(self, phone: Connection, reading: "_Reading") -> list[Sample]:
        """Return the samples that are new. A phone that does not answer may catch up for a while.

        Raises Absent.
        """
        try:
            asked = phone.get(reading.query(self._now()))
        except TRANSPORT_ERRORS as error:
            phone.close()
            if self._now() - reading.answered_ns > GIVE_UP:
                raise self._absent(error) from error
            return []
        return reading.take(asked)

    def _absent(self, error: Exception) -> Absent:
        """Say what is waited for: the same at each port, so that it is said once."""
        if isinstance(error, socket.gaierror):
            return Absent(_NO_SUCH_NAME.format(self._host))
        port = f":{self._ports[0]}" if len(self._ports) == 1 else ""
        return Absent(_WAITING.format(bracketed(self._host) + port))


_Row = tuple[float, Vector]
"""Time in s of the phone's clock, and a value about each axis."""


class _Reading:
    """Reads the phone's buffers, and watches that its clock runs on.

    Args:
        config: the experiment on the phone. Raises Unusable if it has no gyroscope.

    Attributes:
        answered_ns: when the last reply had come.
        is_silent: True if the last query was one of the newest times, as nothing came for long.
    """

    def __init__(self, config: Config) -> None:
        tracks = {each.source: _outputs(each) for each in config.inputs}
        if not (gyroscope := tracks.get("gyroscope")):
            raise Unusable(_NO_GYROSCOPE.format(visible(config.title)[:60]))
        self._gyroscope = _Track(gyroscope)
        accelerometer = tracks.get("accelerometer")
        self._accelerometer = _Track(accelerometer) if accelerometer else None
        self._aligned = Alignment(HOLD_S if accelerometer else 0.0)
        self._session: str | None = None
        self.answered_ns = self._begun_ns = self._new_ns = 0
        self.is_silent = False
        self._offset: tuple[float, float] | None = None

    @property
    def _tracks(self) -> "list[_Track]":
        return [self._gyroscope, *([self._accelerometer] if self._accelerometer else [])]

    @property
    def last(self) -> Query:
        """A query of the newest time of each sensor."""
        return [each for track in self._tracks for each in track.last]

    def seek(self, asked: Asked) -> State:
        """Go to the newest samples, which ``last`` asked for; return the state of the phone."""
        for track in self._tracks:
            track.read_s = track.newest(asked.reply)
        self._session = asked.reply.state.session
        self.answered_ns = self._begun_ns = self._new_ns = asked.came_ns
        return asked.reply.state

    def rewind(self) -> None:
        """Go to the beginning: the buffers are empty."""
        for track in self._tracks:
            track.read_s = None

    def query(self, now: int) -> Query:
        """Return a query of what is new, or of the newest times if there is nothing for long."""
        self.is_silent = now - self._new_ns > SILENCE
        if self.is_silent:
            self._new_ns = now
            return self.last
        return [each for track in self._tracks for each in track.query]

    def take(self, asked: Asked) -> list[Sample]:
        """Return what is new in a reply to ``query``.

        Raises Absent if the phone does not measure, or began anew.
        """
        reply = asked.reply
        self.answered_ns = asked.came_ns
        is_starting = asked.came_ns - self._begun_ns < SILENCE
        if reply.state.session != self._session or not (reply.state.measuring or is_starting):
            raise Absent(_CLEARED)
        if self.is_silent:
            if self._gyroscope.is_cleared(reply):
                raise Absent(_CLEARED)
            return []
        if self._accelerometer:
            self._aligned.hear(self._accelerometer.take(reply))
        rates = self._gyroscope.take(reply)
        if rates:
            self._new_ns = asked.came_ns
            self._check_clock(rates[-1][0], asked)
        return [
            Sample(asked.came_ns, time * 1000, acceleration, rate)
            for time, rate, acceleration in self._aligned.put(rates)
        ]

    def _check_clock(self, newest_s: float, asked: Asked) -> None:
        """Raise Absent if the phone's clock was stopped, or set back.

        Its newest sample was measured before the reply had come, and, if it measures, not long
        before the request was sent.
        """
        newest = newest_s * SECOND
        lowest, highest = asked.sent_ns - newest, asked.came_ns - newest
        before = self._offset
        if before and (lowest > before[1] + JUMP or highest < before[0] - JUMP):
            raise Absent(_CLEARED)
        if highest - lowest < JUMP:  # a slow reply says little
            self._offset = lowest, highest


def _outputs(sensor: Input) -> dict[str, str]:
    """Return the names of a sensor's buffers; none if one of time and axes has no buffer."""
    names = {component: name for each in sensor.outputs for component, name in each.items()}
    return names if {"x", "y", "z", "t"} <= set(names) else {}


class _Track:
    """The buffers of one sensor of the phone, and how far they have been read.

    Args:
        outputs: the names of its buffers, by ``x``, ``y``, ``z`` and ``t``.
    """

    def __init__(self, outputs: Mapping[str, str]) -> None:
        self.time = outputs["t"]
        self._axes = [outputs[axis] for axis in "xyz"]
        self.read_s: float | None = None

    @property
    def last(self) -> Query:
        """A query of the newest time."""
        return [(self.time, "")]

    @property
    def query(self) -> Query:
        """A query of all that is new. The app takes no threshold of zero or below as such."""
        if not self.is_partial:
            return [(name, "full") for name in (self.time, *self._axes)]
        new = repr(self.read_s)
        return [(self.time, new), *((axis, f"{new}|{self.time}") for axis in self._axes)]

    @property
    def is_partial(self) -> bool:
        """True if a query has a threshold."""
        return self.read_s is not None and self.read_s > 0

    def newest(self, reply: Reply) -> float | None:
        """Return the newest time in a reply; None if the buffer is empty."""
        times = reply.buffers[self.time].values if self.time in reply.buffers else []
        return max((time for time in times if time is not None), default=None)

    def is_cleared(self, reply: Reply) -> bool:
        """True if the newest time is earlier than what has been read, or there is none."""
        newest = self.newest(reply)
        return self.read_s is not None and (newest is None or newest < self.read_s)

    def take(self, reply: Reply) -> list[_Row]:
        """Return what is new in a reply. Raises Absent if the buffers have been cleared.

        After they were, the app ignores the threshold of the next query and sends them in full.
        """
        names = (self.time, *self._axes)
        buffers = [reply.buffers[name] for name in names if name in reply.buffers]
        if len(buffers) < len(names):
            return []
        if self.is_partial and buffers[0].mode == "full" and self.is_cleared(reply):
            raise Absent(_CLEARED)
        rows: list[_Row] = []
        for time, x, y, z in zip(*(buffer.values for buffer in buffers), strict=False):
            if time is not None and (self.read_s is None or time > self.read_s):
                self.read_s = time
                rows.append((time, (_number(x), _number(y), _number(z))))
        return rows


def _number(value: float | None) -> float:
    """Return a value of a buffer. JSON has no not-a-number: the app sends null."""
    return math.nan if value is None else value


class Alignment:
    """Interpolates the acceleration at the times of the gyroscope.

    Args:
        hold_s: longest time that a sample waits for a later acceleration; the last one is taken
            then, unless it is older than that.
    """

    def __init__(self, hold_s: float) -> None:
        self._hold_s = hold_s
        self._rates: deque[_Row] = deque()
        self._accelerations: deque[_Row] = deque(maxlen=_MOST_HELD)

    def hear(self, accelerations: list[_Row]) -> None:
        """Take new accelerations."""
        self._accelerations.extend(accelerations)

    def put(self, rates: list[_Row]) -> Iterator[tuple[float, Vector, Vector]]:
        """Take new rates; yield the time, rate and acceleration of those that are complete."""
        self._rates.extend(rates)
        while self._rates:
            time, rate = self._rates[0]
            while len(self._accelerations) > 1 and self._accelerations[1][0] <= time:
                self._accelerations.popleft()
            is_late = self._rates[-1][0] - time >= self._hold_s
            acceleration = self._at(time)
            if acceleration is None and not is_late:
                return
            self._rates.popleft()
            yield time, rate, acceleration or self._nearest(time)

    def _at(self, time: float) -> Vector | None:
        """Return the acceleration between two; None if the later one is not there yet."""
        if not self._accelerations or self._accelerations[-1][0] < time:
            return None
        before, first = self._accelerations[0]
        if before >= time:
            return self._nearest(time)
        after, second = self._accelerations[1]
        if after - before > 2 * self._hold_s:
            return self._nearest(time)
        share = (time - before) / (after - before)
        x, y, z = (a + share * (b - a) for a, b in zip(first, second, strict=True))
        return x, y, z

    def _nearest(self, time: float) -> Vector:
        near = [each for each in self._accelerations if abs(each[0] - time) <= self._hold_s]
        return min(near, key=lambda each: abs(each[0] - time))[1] if near else NOTHING
