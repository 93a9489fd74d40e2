"""Gestures by servo motors on a Phidget controller."""

import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from sar_tui.drivers.installation import pip_install
from sar_tui.drivers.phidget import UDEV_RULE, describe, new_channel, usb_denied
from sar_tui.loop.clock import Clock, Handle, VirtualClock
from sar_tui.model.gesture import JOINTS, REST, Gesture, Pose
from sar_tui.model.messages import ActionPart, PartState
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.outputs.output import Output, Report
from sar_tui.outputs.servo.channel import FEED_MS, ServoChannel, parse

STEP_MS = 20
"""Interval between two targets that are sent to a servo."""
_LONGEST_STEP_MS = 2 * STEP_MS


class Motion:
    """The path through a gesture, step by step, with a speed limit.

    Where a gesture is faster than the limit, its joints move at the limit, and it ends later by the
    time they need to reach their last position.

    Args:
        gesture: the keyframes.
        start: where the joints are.
        speed: the share of its range (0 to 1) that a joint may move in a second.
    """

    def __init__(self, gesture: Gesture, start: Pose, speed: float) -> None:
        self.pose = start
        self._gesture = gesture
        self._start = start
        self._speed = speed
        self._ms = 0.0

    @property
    def joints(self) -> frozenset[str]:
        """The joints that the gesture moves or must bring back to rest."""
        poses = (self._start, *self._gesture.keyframes)
        return frozenset(joint for joint in JOINTS if any(getattr(pose, joint) for pose in poses))

    @property
    def over(self) -> bool:
        """True if the last keyframe is reached."""
        return (
            self._ms >= self._gesture.duration_ms and self.pose == self._gesture.keyframes[-1].pose
        )

    def step(self, ms: float) -> Pose:
        """Return the target of the joints ``ms`` after the start.

        If the computer paused, they move no further than in two ordinary steps, instead of jumping.
        """
        most = self._speed * min(ms - self._ms, _LONGEST_STEP_MS) / 1000
        self._ms = ms
        goal = self._gesture.pose_at(ms, self._start)
        self.pose = Pose(
            *(_nearer(getattr(self.pose, joint), getattr(goal, joint), most) for joint in JOINTS)
        )
        return self.pose


def _nearer(now: float, goal: float, most: float) -> float:
    """Return ``goal``, or the nearest value that ``most`` allows."""
    return goal if abs(goal - now) <= most else now + most if goal > now else now - most


ATTACH_NS = SECOND
"""Time after opening in which a gesture waits for a controller that may still attach."""
SETTLE_NS = 100 * MS
"""Time for which a motor is held after its last target, so that it gets there."""
_CLOSE_S = 2.0
_NO_PACKAGE = "The Python package Phidget22 is missing; install it with: " + pip_install(
    "phidget22"
)
_NO_LIBRARY = (
    "The servo's driver cannot be loaded ({}); install it with: "
    f"{pip_install('phidget22', 'libusb-package')}"
)
_NO_PERMISSION = (
    "A Phidget is plugged in, but this computer does not let you use it: "
    f"write the line {UDEV_RULE} into the file /etc/udev/rules.d/70-phidget.rules, unplug it, and "
    "plug it in again."
)


class _GestureRequest:
    """A requested gesture."""

    def __init__(self, action: str, name: str) -> None:
        self.action = action
        self.name = name
        self.stopped = False


class _ActiveGesture:
    """The gesture under way: its start, its channels, and when its last target was sent."""

    def __init__(
        self, request: _GestureRequest, motion: Motion, channels: list[ServoChannel], began: int
    ) -> None:
        self.request = request
        self.motion = motion
        self.channels = channels
        self.began = began
        self.arrived: int | None = None


class Servo(Output):
    """A robot's joints, each an RC servo on a Phidget controller (1061, 1066, RCC1000 and similar).

    A controller may be plugged in and out at any time. A motor is engaged only during a gesture;
    otherwise it is limp, and a hand may move it. All calls to the controller come from one thread,
    since USB may block; a stop takes effect when the current call returns, after some milliseconds.

    A controller with a failsafe releases the motors a second after this program last ran: when it
    was killed, or the computer froze. A controller without one (see `sar-tui doctor`) holds them at
    their last target until it is unplugged; no motor goes on moving.

    Args:
        address: the controller and its wiring, see `address.parse`. Raises OutputError.
        make: makes a channel; Phidget22's ``RCServo`` if None.
        denied: returns True if a Phidget is plugged in that this user may not open; looked up if
            None.
    """

    name = "servo"
    can: frozenset[ActionPart] = frozenset({"gesture"})

    def __init__(
        self,
        address: str = "",
        *,
        make: Callable[[], Any] | None = None,
        denied: Callable[[], bool] | None = None,
    ) -> None:
        self._address = parse(address)
        self._make = make or partial(new_channel, "RCServo")
        self._denied = denied or usb_denied
        self._lock = threading.Lock()
        self._timer: StepTimer | None = None

    def open(self, theme: Theme, clock: Clock, report: Callable[[Report], None]) -> None:
        """Wait in the background for the controller."""
        super().open(theme, clock, report)
        live = not isinstance(clock, VirtualClock)
        self._channels = [
            ServoChannel(each, self._address, live, self._wake)
            for each in self._address.joint_channels
        ]
        self._waiting: deque[_GestureRequest] = deque()
        self._active: _ActiveGesture | None = None
        self._pose = REST
        self._opened: int | None = None
        self._missing = ""
        self._closed = False
        self._timer = StepTimer(clock, self._step, self._shut_down)
        self._timer.start()

    def gesture(self, action: str, name: str) -> None:
        """Perform one of the theme's gestures."""
        with self._lock:
            self._waiting.append(_GestureRequest(action, name))
        self._wake()

    def stop(self, action: str = "") -> None:
        """Make the motors limp, at once."""
        with self._lock:
            active = self._active
            for request in (*self._waiting, *([active.request] if active else [])):
                request.stopped = request.stopped or action in ("", request.action)
        self._wake()

    def close(self) -> None:
        """Make the motors limp, and close the controller. Takes at most two seconds if the driver
        hangs.
        """
        if self._timer is not None:
            self.stop()
            self._timer.finish(_CLOSE_S)
            self._closed = True

    def _wake(self) -> None:
        if self._timer is not None:
            self._timer.wake()

    def _report_gesture(self, request: _GestureRequest, state: PartState, detail: str = "") -> None:
        if not self._closed:
            self.report(request.action, "gesture", state, detail)

    # --- from here on, everything is called by the step timer

    def _step(self) -> int | None:
        """Do what is due. Returns the time until the next call, in ns."""
        now = self.clock.now()
        if self._opened is None:
            self._opened = now
            self._open_channels()
        if self._active:
            self._continue(self._active, now)
        self._drop_stopped()
        for channel in self._channels:
            channel.feed(now)
            if self._waiting and channel.reopen():
                self._opened = now
        while self._active is None and self._waiting:
            if (patience := self._patience(now)) > 0:
                return patience
            # It stays in the queue until it is under way or over, so that no stop misses it.
            self._begin(self._waiting[0], now)
            with self._lock:
                self._waiting.popleft()
        if self._active:
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
            self._missing = f"The servo cannot be opened: {describe(error)}"

    def _patience(self, now: int) -> int:
        """Return how much longer to wait for a controller that has not attached, in ns."""
        expected = not self._missing and any(
            not channel.attached and not channel.trouble for channel in self._channels
        )
        return (self._opened or 0) + ATTACH_NS - now if expected else 0

    def _drop_stopped(self) -> None:
        with self._lock:
            dropped = [request for request in self._waiting if request.stopped]
            self._waiting = deque(request for request in self._waiting if not request.stopped)
        for request in dropped:
            self._report_gesture(request, "aborted")

    def _begin(self, request: _GestureRequest, now: int) -> None:
        """Start a gesture; or end it if it cannot be performed."""
        if (gesture := self.theme.gestures.get(request.name)) is None:
            known = ", ".join(self.theme.gestures) or "none"
            what = (
                f'The theme {self.theme.name} has no gesture "{request.name}". Choose one of: '
                f"{known}."
            )
            self._report_gesture(request, "failed", what)
            return
        motion = Motion(gesture, self._pose, self._address.speed_deg_s / self._address.range_deg)
        channels = [channel for channel in self._channels if channel.joint in motion.joints]
        if not channels:
            self._report_gesture(request, "started")
            self._report_gesture(
                request, "done", f"This robot has none of the joints that {request.name} moves."
            )
        elif absence := self._unavailable(channels):
            self._report_gesture(request, "failed", absence)
        else:
            self._engage(_ActiveGesture(request, motion, channels, now))

    def _unavailable(self, channels: list[ServoChannel]) -> str:
        """Return why a gesture cannot be performed; empty if it can."""
        if self._missing:
            return self._missing
        absent = [channel for channel in channels if not channel.attached]
        if not absent:
            return ""
        if self._denied():
            return _NO_PERMISSION
        if absent[0].trouble:
            return f"The servo for {absent[0].place} cannot be used. {absent[0].trouble}"
        return (
            f"There is no servo for {absent[0].place}: plug in its controller, and close other "
            "programs that use it."
        )

    def _engage(self, active: _ActiveGesture) -> None:
        self._active = active
        try:
            for channel in active.channels:
                channel.engage(getattr(self._pose, channel.joint))
        except Exception as error:
            self._fail(active, describe(error))
        else:
            self._report_gesture(active.request, "started")

    def _continue(self, active: _ActiveGesture, now: int) -> None:
        """Take the next step of the gesture under way, or end it."""
        if active.request.stopped:
            self._end(active, "aborted")
            return
        if not all(channel.attached for channel in active.channels):
            self._fail(active)
            return
        try:
            self._pose = active.motion.step((now - active.began) / MS)
            for channel in active.channels:
                channel.move(getattr(self._pose, channel.joint))
        except Exception as error:
            self._fail(active, describe(error))
            return
        if active.motion.over:
            if active.arrived is None:
                active.arrived = now
            if now >= active.arrived + SETTLE_NS:
                troubles = (channel.trouble for channel in active.channels)
                self._end(active, "done", next(filter(None, troubles), ""))

    def _fail(self, active: _ActiveGesture, error: str = "") -> None:
        """End a gesture early: a motor was lost, or refuses a command."""
        lost = [channel for channel in active.channels if not channel.attached]
        if lost:
            self._pose = REST
            why = lost[0].trouble or "It was unplugged: plug it in again."
            what = f"The servo for {lost[0].place} was lost while it moved. {why}"
        else:
            what = f"The servo for {active.channels[0].place} refused a command: {error}."
        self._end(active, "failed", what)

    def _end(self, active: _ActiveGesture, state: PartState, detail: str = "") -> None:
        """Make all motors limp, even if one fails, and report how the gesture ended."""
        refusals = list(filter(None, [channel.release() for channel in active.channels]))
        self._active = None
        self._report_gesture(
            active.request,
            "failed" if refusals else state,
            " ".join(filter(None, [detail, *refusals])),
        )

    def _shut_down(self) -> None:
        """End whatever is under way, and close the channels."""
        if self._active:
            self._end(self._active, "aborted")
        self._drop_stopped()
        for channel in self._channels:
            with suppress(Exception):
                channel.close()


class StepTimer:
    """Calls steps at their times, and the next one at once when woken.

    Args:
        clock: a virtual clock calls the steps itself; otherwise a thread does, since a device may
            block.
        step: does what is due, and returns the ns until its next call; None: not until woken.
        last: called after the last step, in the same way.
    """

    def __init__(
        self, clock: Clock, step: Callable[[], int | None], last: Callable[[], None]
    ) -> None:
        self._clock = clock
        self._step = step
        self._last = last
        self._woken = threading.Event()
        self._finished = False
        self._due: Handle | None = None
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Take the first step."""
        if not isinstance(self._clock, VirtualClock):
            self._thread = threading.Thread(target=self._run, name="servo", daemon=True)
            self._thread.start()
        else:
            self.wake()

    def wake(self) -> None:
        """Take a step as soon as possible. May be called from any thread."""
        if self._thread:
            self._woken.set()
        else:
            self._tick_in(0)

    def finish(self, seconds: float) -> None:
        """Take only the last step. Waits for it, at most ``seconds`` if a device hangs."""
        if self._finished:
            return
        self._finished = True
        if self._thread:
            self._woken.set()
            self._thread.join(seconds)
        else:
            self._tick_in(None)
            self._last()

    def _run(self) -> None:
        while not self._finished:
            self._woken.clear()
            pause = self._step()
            self._woken.wait(None if pause is None else pause / SECOND)
        self._last()

    def _tick_in(self, pause: int | None) -> None:
        if self._due:
            self._due.cancel()
        self._due = (
            None if pause is None else self._clock.call_at(self._clock.now() + pause, self._tick)
        )

    def _tick(self) -> None:
        if not self._finished:
            self._tick_in(self._step())
