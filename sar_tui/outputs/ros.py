"""A robot on a ROS system, reached through the rosbridge protocol: it speaks, moves and looks."""

import secrets
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any, cast

from sar_tui.drivers.rosbridge import Bridge
from sar_tui.framework.clock import MS, SECOND, Clock, Handle
from sar_tui.framework.messages import ActionPart, PartState
from sar_tui.framework.theme import Theme
from sar_tui.outputs.output import Output, OutputError, Report
from sar_tui.outputs.ros_topics import STRING, RobotReport, parse_address, plain, read_report

PATIENCE = 3 * SECOND
"""How long after the beginning a part may wait for the first connection."""
SETTLE = 500 * MS
"""How long after a connection nothing is sent: on a ROS system it takes a moment until a new publisher is heard."""
ANSWER = 2 * SECOND
"""How long a robot may take to tell that it has begun."""
CONFIRM = 1500 * MS
"""How long it may take to tell that it has stopped; less than `node.STILL`, so that this is what is told of it."""
LONGEST = 15 * SECOND
"""How much longer a part may take than it should."""
A_CHARACTER = 100 * MS
"""How long speaking one takes, at the slowest."""


class _Asked:
    """Something the robot is to do."""

    def __init__(self, action: str, part: ActionPart, topic: str, message: dict[str, str], lasts: int) -> None:
        self.action, self.part, self.topic, self.message, self.lasts = action, part, topic, message, lasts
        self.sent: int | None = None
        self.started: int | None = None
        self.is_stopping = False
        self.timer: Handle | None = None


class Ros(Output):
    """A robot on a ROS system. Everything but the sending happens on the thread that owns the clock.

    Args:
        address: ``ros://HOST[:PORT]``, and after a question mark `ros_topics.Topics`. Raises OutputError for anything
            else.
    """

    name = "ros"
    can = frozenset[ActionPart]({"say", "gesture", "gaze"})

    def __init__(self, address: str) -> None:
        self._address, self._topics = parse_address(address)
        self._bridge: Bridge | None = None
        self._begin()

    def _begin(self) -> None:
        self._lines: dict[ActionPart, deque[_Asked]] = {"say": deque(), "gesture": deque(), "gaze": deque()}
        self._token = secrets.token_hex(3)
        self._ready_at: int | None = None
        self._stop_owed = self._was_lost = False
        self._muddle = ""

    def open(self, theme: Theme, clock: Clock, report: Callable[[Report], None]) -> None:
        """Connect in the background. What is asked for in the first moments waits for the connection."""
        self.close()
        super().open(theme, clock, report)
        self._begin()
        self._patience = clock.now() + PATIENCE
        topics = self._topics
        bridge = Bridge(
            self._address,
            dict.fromkeys((topics.speech, topics.gesture, topics.gaze, topics.stop), STRING),
            {topics.report: (STRING, lambda message: self._hear(bridge, message))},
            lambda: self._change(bridge),
        )
        self._bridge = bridge
        bridge.open()
        self._look_again(bridge, self._patience)

    def say(self, action: str, text: str) -> None:
        """Have the robot speak."""
        text = text.encode("utf-8", "replace").decode()  # half a character cannot be sent
        said = {"text": text, "language": self.theme.language}
        self._ask(action, "say", self._topics.speech, said, text, A_CHARACTER * len(text))

    def gesture(self, action: str, name: str) -> None:
        """Have the robot move; it is told the theme's keyframes too."""
        gesture = self.theme.gestures.get(name)
        if gesture is None:
            self.report(action, "gesture", "failed", f"The theme {self.theme.name} has no gesture {plain(name)}.")
            return
        moves = {"gesture": name, "keyframes": gesture.keyframes}
        self._ask(action, "gesture", self._topics.gesture, moves, name, gesture.duration_ms * MS)

    def gaze(self, action: str, where: str) -> None:
        """Have the robot look somewhere."""
        self._ask(action, "gaze", self._topics.gaze, {"gaze": where}, where, 0)

    def stop(self, action: str = "") -> None:
        """Ask the robot to be still: what it does is aborted when it confirms that, or after a while as not confirmed.

        What comes next waits for that. A stop that cannot be sent now is sent before anything else; and raises
        OutputError if the robot was lost in the middle of something that it may still be doing.
        """
        if self._bridge is None:
            return
        stopped = [asked for line in self._lines.values() for asked in line if action in ("", asked.action)]
        sent = [asked for asked in stopped if asked.sent is not None]
        told = False
        if sent or not action:
            told = self._send_stop(action)
            self._stop_owed |= not told
        now = self.clock.now()
        for asked in stopped:
            if asked.sent is None:
                self._end(asked, "aborted", now)
            elif not told:
                self._end(asked, "failed", now, self._unasked)
            elif not asked.is_stopping:
                asked.is_stopping = True
                self._set_timer(asked, now + CONFIRM, partial(self._overdue, self._bridge, asked))
        if action:
            self._advance_all(self._bridge)
        elif self._was_lost and not told:
            raise OutputError(self._unasked)

    def close(self) -> None:
        """Have the robot be still, and let go of the connection."""
        if self._bridge is not None:
            with suppress(OutputError):  # nobody is told any more
                self.stop()
            bridge, self._bridge = self._bridge, None
            bridge.close()

    # --- on the connection's thread: stamp, and hand on ---------------------------------------------------

    def _change(self, bridge: Bridge) -> None:
        self.clock.call_soon(partial(self._changed, bridge, bridge.is_connected))

    def _hear(self, bridge: Bridge, message: Any) -> None:
        at = self.clock.now()
        report = read_report(message)
        if isinstance(report, str):
            self._muddle = f" A report of it could not be understood: {report}."
        else:
            self.clock.call_soon(partial(self._heard, bridge, report, at))

    # --- on the clock's thread ------------------------------------------------------------------------------

    def _changed(self, bridge: Bridge, connected: bool) -> None:
        if bridge is not self._bridge:
            return
        now = self.clock.now()
        if connected:
            self._was_lost = False
            if self._stop_owed:
                self._stop_owed = not self._send_stop("")
            self._ready_at = now + SETTLE
            self._look_again(bridge, self._ready_at)
            return
        self._ready_at = None
        for asked in self._under_way:
            self._was_lost = True
            self._stop_owed |= asked.is_stopping
            self._end(asked, "failed", now, f"The connection to the robot at {self._address} was lost meanwhile.")
        self._advance_all(bridge)

    def _heard(self, bridge: Bridge, report: RobotReport, at: int) -> None:
        if bridge is not self._bridge:
            return
        sent = [asked for asked in self._under_way if asked.sent is not None and asked.sent <= at]
        about = [asked for asked in sent if self._is_about(report, asked.action, asked.part)]
        begun = [asked for asked in about if asked.started is not None]
        waiting = [asked for asked in about if asked.started is None]
        for asked in (waiting if report.state == "started" else begun + waiting)[:1]:
            if asked.started is None and report.state in ("started", "done"):
                asked.started = at
                self._report(asked, "started", at)
            if report.state != "started":
                why = report.detail or ("The robot failed." if report.state == "failed" else "")
                self._end(asked, "aborted" if asked.is_stopping and not why else report.state, at, why)
                self._advance(asked.part)

    def _ask(self, action: str, part: ActionPart, topic: str, what: dict[str, Any], bare: str, lasts: int) -> None:
        if self._bridge is None:
            return
        message = self._topics.message(self._id(action), what, bare)
        self._lines[part].append(_Asked(action, part, topic, message, lasts))
        self._advance(part)

    def _look_again(self, bridge: Bridge, when: int) -> None:
        self.clock.call_at(when, partial(self._advance_all, bridge, when))

    def _advance_all(self, bridge: Bridge, due: int = 0) -> None:
        if bridge is self._bridge:
            for part in self._lines:
                self._advance(part, due)

    def _advance(self, part: ActionPart, due: int = 0) -> None:
        """Send what is next, if its turn has come; or tell that it cannot be. It is as late as ``due`` at least."""
        line, bridge = self._lines[part], cast(Bridge, self._bridge)
        while line and line[0].sent is None:
            asked, now = line[0], max(self.clock.now(), due)
            if not bridge.problem and self._is_to_wait(bridge, now):
                return
            if bridge.publish(asked.topic, asked.message):
                asked.sent, self._muddle = now, ""
                self._set_timer(asked, now + ANSWER, partial(self._overdue, bridge, asked))
            else:
                self._end(asked, "failed", now, bridge.problem or self._away)

    def _is_to_wait(self, bridge: Bridge, now: int) -> bool:
        if self._ready_at is None:
            return bridge.is_connected or now < self._patience  # that it is will be told in a moment
        return now < self._ready_at

    def _overdue(self, bridge: Bridge, asked: _Asked) -> None:
        line, now = self._lines[asked.part], self.clock.now()
        if bridge is not self._bridge or not line or line[0] is not asked:
            return
        state: PartState = "failed"
        if asked.is_stopping:
            state, why = "aborted", f"The robot at {self._address} did not confirm that it stopped."
        elif asked.started is None:
            why = f"Sent to the robot at {self._address}, which did not acknowledge it."
        elif now < (until := asked.started + asked.lasts + LONGEST):
            self._set_timer(asked, until, partial(self._overdue, bridge, asked))
            return
        else:
            why = f"The robot at {self._address} began, and did not tell that it was done."
        self._end(asked, state, now, why + self._muddle)
        self._advance(asked.part)

    def _set_timer(self, asked: _Asked, when: int, ring: Callable[[], None]) -> None:
        if asked.timer:
            asked.timer.cancel()
        asked.timer = self.clock.call_at(when, ring)

    def _end(self, asked: _Asked, state: PartState, at: int, detail: str = "") -> None:
        self._lines[asked.part].remove(asked)
        if asked.timer:
            asked.timer.cancel()
        self._report(asked, state, at, detail)

    def _report(self, asked: _Asked, state: PartState, at: int, detail: str = "") -> None:
        self._send_report(Report(asked.action, asked.part, state, at, detail))

    # --- stopping, and small things --------------------------------------------------------------------------

    def _send_stop(self, action: str) -> bool:
        message = self._topics.message(action and self._id(action), {}, "stop")
        return cast(Bridge, self._bridge).publish(self._topics.stop, message)

    def _is_about(self, report: RobotReport, action: str, part: ActionPart) -> bool:
        unnamed = self._topics.form == "text" and not report.id
        return (unnamed or report.id == self._id(action)) and report.part in ("", part)

    def _id(self, action: str) -> str:
        """What an action is called towards the robot: nothing late of an earlier session is taken for this one's."""
        return f"{action}-{self._token}"

    @property
    def _under_way(self) -> list[_Asked]:
        """What was sent and is not over, the oldest first."""
        sent = (line[0] for line in self._lines.values() if line and line[0].sent is not None)
        return sorted(sent, key=lambda asked: asked.sent or 0)

    @property
    def _unasked(self) -> str:
        return f"The robot could not be asked to stop. {self._away}"

    @property
    def _away(self) -> str:
        return f"The robot is not connected: there is no ROS bridge at {self._address}. Start rosbridge there."
