"""Gestures by servo motors on a Phidget controller."""

import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from sar_tui.drivers.phidget import UDEV_RULE, new_channel, usb_denied, words
from sar_tui.framework.clock import MS, SECOND, Clock, VirtualClock
from sar_tui.framework.gesture import REST
from sar_tui.framework.messages import ActionPart, PartState
from sar_tui.framework.theme import Theme
from sar_tui.outputs.output import Output, Report
from sar_tui.outputs.servo.address import parse
from sar_tui.outputs.servo.channel import FEED_MS, ServoChannel
from sar_tui.outputs.servo.motion import STEP_MS, Motion
from sar_tui.outputs.servo.step_timer import StepTimer

ATTACH_NS = SECOND
"""How long after opening a gesture waits for a controller that may just be about to tell of itself."""
SETTLE_NS = 100 * MS
"""How long a motor is held after its last target, so that it gets there."""
_CLOSE_S = 2.0
_NO_PACKAGE = "The Python package Phidget22 is missing; install it with: pip install phidget22"
_NO_LIBRARY = "The servo's driver cannot be loaded ({}); install it with: pip install phidget22 libusb-package"
_NO_PERMISSION = (
    "A Phidget is plugged in, but this computer does not let you use it: "
    f"write the line {UDEV_RULE} into the file /etc/udev/rules.d/70-phidget.rules, unplug it, and plug it in again."
)


class _GestureRequest:
    """A gesture that has been asked for."""

    def __init__(self, action: str, name: str) -> None:
        self.action = action
        self.name = name
        self.stopped = False


class _ActiveGesture:
    """The gesture that is being made: since when, on which channels, and since when its last target is sent."""

    def __init__(self, part: _GestureRequest, motion: Motion, channels: list[ServoChannel], began: int) -> None:
        self.part = part
        self.motion = motion
        self.channels = channels
        self.began = began
        self.arrived: int | None = None


class Servo(Output):
    """A robot's joints, each an RC servo on a Phidget controller (1061, 1066, RCC1000 and their kin).

    A controller may be plugged in, pulled out and plugged in again at any time. A motor is engaged only while a gesture
    is under way; else it is limp, and a hand may move it. All calls go to the controller from one thread, since USB may
    keep a call waiting; so a stop is carried out as soon as the call that is under way returns, some milliseconds.

    Where the controller has a failsafe it lets go of the motors by itself, a second after this program last ran: when
    it was killed, or the computer froze. A controller without one (`sar-tui doctor` tells) holds them where they were
    last sent, until it is unplugged; no motor goes on moving.

    Args:
        address: which controller, and how it is wired, see `address.parse`. Raises OutputError.
        make: makes a channel; Phidget22's ``RCServo`` if None.
        denied: whether a Phidget is plugged in that one may not use; looked up if None.
    """

    name = "servo"
    can: frozenset[ActionPart] = frozenset({"gesture"})

    def __init__(
        self, address: str = "", *, make: Callable[[], Any] | None = None, denied: Callable[[], bool] | None = None
    ) -> None:
        self._address = parse(address)
        self._make = make or partial(new_channel, "RCServo")
        self._denied = denied or usb_denied
        self._lock = threading.Lock()
        self._pace: StepTimer | None = None

    def open(self, theme: Theme, clock: Clock, report: Callable[[Report], None]) -> None:
        """Wait in the background for the controller."""
        super().open(theme, clock, report)
        live = not isinstance(clock, VirtualClock)
        self._channels = [ServoChannel(wire, self._address, live, self._wake) for wire in self._address.wires]
        self._waiting: deque[_GestureRequest] = deque()
        self._underway: _ActiveGesture | None = None
        self._pose = REST
        self._opened: int | None = None
        self._missing = ""
        self._silent = False
        self._pace = StepTimer(clock, self._step, self._let_go)
        self._pace.start()

    def gesture(self, action: str, name: str) -> None:
        """Move through one of the theme's gestures."""
        with self._lock:
            self._waiting.append(_GestureRequest(action, name))
        self._wake()

    def stop(self, action: str = "") -> None:
        """Make the motors limp, at once."""
        with self._lock:
            underway = self._underway
            for part in (*self._waiting, *([underway.part] if underway else [])):
                part.stopped = part.stopped or action in ("", part.action)
        self._wake()

    def close(self) -> None:
        """Make the motors limp, and let go of the controller. Takes two seconds at most, should the driver hang."""
        if self._pace is not None:
            self.stop()
            self._pace.finish(_CLOSE_S)
            self._silent = True

    def _wake(self) -> None:
        if self._pace is not None:
            self._pace.wake()

    def _tell_of(self, part: _GestureRequest, state: PartState, detail: str = "") -> None:
        if not self._silent:
            self.report(part.action, "gesture", state, detail)

    # --- from here on, all is called by the pace alone ----------------------------------------------------

    def _step(self) -> int | None:
        """Do what is due. Returns when to be called again, in ns."""
        now = self.clock.now()
        if self._opened is None:
            self._opened = now
            self._open_channels()
        if self._underway:
            self._go_on(self._underway, now)
        self._drop_stopped()
        for channel in self._channels:
            channel.feed(now)
            if self._waiting and channel.reopen():
                self._opened = now
        while self._underway is None and self._waiting:
            if (patience := self._patience(now)) > 0:
                return patience
            # It is among those that wait until it is under way or over, so that no stop misses it.
            self._begin(self._waiting[0], now)
            with self._lock:
                self._waiting.popleft()
        if self._underway:
            return STEP_MS * MS
        return FEED_MS * MS if any(channel.has_failsafe for channel in self._channels) else None

    def _open_channels(self) -> None:
        try:
            for channel in self._channels:
                channel.open(self._make())
        except ImportError:
            self._missing = _NO_PACKAGE
        except OSError as error:
            self._missing = _NO_LIBRARY.format(error)
        except Exception as error:
            self._missing = f"The servo cannot be opened: {words(error)}"

    def _patience(self, now: int) -> int:
        """How much longer to wait for a controller that has not told of itself, in ns."""
        expected = not self._missing and any(not channel.attached and not channel.trouble for channel in self._channels)
        return (self._opened or 0) + ATTACH_NS - now if expected else 0

    def _drop_stopped(self) -> None:
        with self._lock:
            dropped = [part for part in self._waiting if part.stopped]
            self._waiting = deque(part for part in self._waiting if not part.stopped)
        for part in dropped:
            self._tell_of(part, "aborted")

    def _begin(self, part: _GestureRequest, now: int) -> None:
        """Begin with a gesture; or end it, if it cannot be made."""
        if (gesture := self.theme.gestures.get(part.name)) is None:
            known = ", ".join(self.theme.gestures) or "none"
            what = f'The theme {self.theme.name} has no gesture "{part.name}". There is: {known}.'
            self._tell_of(part, "failed", what)
            return
        motion = Motion(gesture, self._pose, self._address.speed_deg_s / self._address.range_deg)
        channels = [channel for channel in self._channels if channel.joint in motion.joints]
        if not channels:
            self._tell_of(part, "started")
            self._tell_of(part, "done", f"This robot has none of the joints that take part in {part.name}.")
        elif absence := self._absence(channels):
            self._tell_of(part, "failed", absence)
        else:
            self._engage(_ActiveGesture(part, motion, channels, now))

    def _absence(self, channels: list[ServoChannel]) -> str:
        """Why a gesture cannot be made; empty if it can."""
        if self._missing:
            return self._missing
        absent = [channel for channel in channels if not channel.attached]
        if not absent:
            return ""
        if self._denied():
            return _NO_PERMISSION
        if absent[0].trouble:
            return f"The servo for {absent[0].place} cannot be used. {absent[0].trouble}"
        return f"There is no servo for {absent[0].place}: plug in its controller, and close other programs that use it."

    def _engage(self, underway: _ActiveGesture) -> None:
        self._underway = underway
        try:
            for channel in underway.channels:
                channel.engage(getattr(self._pose, channel.joint))
        except Exception as error:
            self._fail(underway, words(error))
        else:
            self._tell_of(underway.part, "started")

    def _go_on(self, underway: _ActiveGesture, now: int) -> None:
        """Take the next step of the gesture that is under way, or end it."""
        if underway.part.stopped:
            self._end(underway, "aborted")
            return
        if not all(channel.attached for channel in underway.channels):
            self._fail(underway)
            return
        try:
            self._pose = underway.motion.step((now - underway.began) / MS)
            for channel in underway.channels:
                channel.move(getattr(self._pose, channel.joint))
        except Exception as error:
            self._fail(underway, words(error))
            return
        if underway.motion.over:
            if underway.arrived is None:
                underway.arrived = now
            if now >= underway.arrived + SETTLE_NS:
                troubles = (channel.trouble for channel in underway.channels)
                self._end(underway, "done", next(filter(None, troubles), ""))

    def _fail(self, underway: _ActiveGesture, error: str = "") -> None:
        """End a gesture in the middle: a motor was lost, or refuses with an error."""
        lost = [channel for channel in underway.channels if not channel.attached]
        if lost:
            self._pose = REST
            why = lost[0].trouble or "It was unplugged: plug it in again."
            what = f"The servo for {lost[0].place} was lost while it moved. {why}"
        else:
            what = f"The servo for {underway.channels[0].place} does not do what it is told: {error}."
        self._end(underway, "failed", what)

    def _end(self, underway: _ActiveGesture, state: PartState, detail: str = "") -> None:
        """Make the motors limp, all of them whatever becomes of one, and tell how the gesture ended."""
        held = list(filter(None, [channel.release() for channel in underway.channels]))
        self._underway = None
        self._tell_of(underway.part, "failed" if held else state, " ".join(filter(None, [detail, *held])))

    def _let_go(self) -> None:
        """The last step: whatever is under way ends, and the channels are closed."""
        if self._underway:
            self._end(self._underway, "aborted")
        self._drop_stopped()
        for channel in self._channels:
            with suppress(Exception):
                channel.close()
