"""A robot on a ROS system that speaks, moves and looks. It is reached through the rosbridge
protocol.
"""

import secrets
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any, Literal, cast

import msgspec

from sar_tui.drivers.rosbridge import Address, AddressError, Bridge, TopicName, parse
from sar_tui.loop.clock import Clock, Handle
from sar_tui.model.messages import ActionPart, PartState
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.model.visible_text import visible
from sar_tui.outputs.output import Output, OutputError, Report

STRING = "std_msgs/String"
_EXAMPLE = (
    "ros://HOST or ros://HOST:PORT; after a question mark, joined by &, there may be speech=, "
    "gesture=, gaze=, "
    "report= and stop=, each with a topic such as /robot/speech, and form=json or form=text"
)


class Topics(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Options after the question mark of an address.

    ``form``: each message is JSON, with an id that the robot repeats in its reports; or only the
    text (or name).
    """

    speech: TopicName = "/sar_tui/speech"
    gesture: TopicName = "/sar_tui/gesture"
    gaze: TopicName = "/sar_tui/gaze"
    report: TopicName = "/sar_tui/report"
    stop: TopicName = "/sar_tui/stop"
    form: Literal["json", "text"] = "json"

    def message(self, identity: str, fields: dict[str, Any], text: str) -> dict[str, str]:
        """Return a message: ``fields`` with the id of their action, or ``text`` if that is the
        form.
        """
        return {
            "data": text
            if self.form == "text"
            else msgspec.json.encode({"id": identity} | fields).decode()
        }


class RobotReport(msgspec.Struct, frozen=True, rename={"former_part": "deed"}):
    """A robot's report. In the form ``text``, without an id, it is about the oldest request that is
    under way.

    ``former_part``: ``part`` under its former name in the protocol, ``deed``; robots may use
    either.
    """

    state: Literal["started", "done", "failed", "aborted"]
    id: str = ""
    part: Literal["say", "gesture", "gaze", ""] = ""
    former_part: Literal["say", "gesture", "gaze", ""] = ""
    detail: str = ""


def parse_address(address: str) -> tuple[Address, Topics]:
    """Read the address of a robot. Raises OutputError, with an example."""
    try:
        found = parse(address, _EXAMPLE)
        topics = msgspec.convert(found.options, Topics)
    except AddressError as error:
        raise OutputError(str(error)) from error
    except msgspec.ValidationError as error:
        raise OutputError(
            f'The address "{address}" is not valid ({error}). Use {_EXAMPLE}.'
        ) from error
    if found.path.strip("/"):
        raise OutputError(
            f'"{found.path}" has no meaning in the address of a robot. Use {_EXAMPLE}.'
        )
    return found, topics


def read_report(message: Any) -> RobotReport | str:
    """Return a robot's report, or the reason why it cannot be read."""
    try:
        report = msgspec.json.decode(
            msgspec.convert(message, dict[str, str])["data"], type=RobotReport
        )
    except (msgspec.MsgspecError, KeyError, UnicodeError) as error:
        return plain(str(error))
    return msgspec.structs.replace(
        report, part=report.part or report.former_part, detail=plain(report.detail)
    )


def plain(text: str) -> str:
    """Return a robot's text, fit for one line of the log and the screen."""
    return visible(text)[:200]


PATIENCE = 3 * SECOND
"""Time after opening in which a request may wait for the first connection."""
SETTLE = 500 * MS
"""Pause after connecting before anything is sent: ROS needs a moment to discover a new
publisher.
"""
ANSWER = 2 * SECOND
"""Time in which a robot must report that it has started."""
CONFIRM = 1500 * MS
"""Time in which it must confirm a stop. Less than `node.STOP_TIMEOUT`, so that this failure is the
one reported.
"""
LONGEST = 15 * SECOND
"""Time that a request may take beyond its expected duration."""
A_CHARACTER = 100 * MS
"""Slowest speaking rate: time for one character."""


class _Request:
    """A request to the robot."""

    def __init__(
        self, action: str, part: ActionPart, topic: str, message: dict[str, str], lasts: int
    ) -> None:
        self.action, self.part, self.topic, self.message, self.lasts = (
            action,
            part,
            topic,
            message,
            lasts,
        )
        self.sent: int | None = None
        self.started: int | None = None
        self.is_stopping = False
        self.timer: Handle | None = None


class Ros(Output):
    """A robot on a ROS system. Everything except sending happens on the clock's thread.

    Args:
        address: ``ros://HOST[:PORT]``, and after a question mark the options of
            `ros_topics.Topics`. Raises OutputError if it is invalid.
    """

    name = "ros"
    can = frozenset[ActionPart]({"say", "gesture", "gaze"})

    def __init__(self, address: str) -> None:
        self._address, self._topics = parse_address(address)
        self._bridge: Bridge | None = None
        self._begin()

    def _begin(self) -> None:
        self._queues: dict[ActionPart, deque[_Request]] = {
            "say": deque(),
            "gesture": deque(),
            "gaze": deque(),
        }
        self._token = secrets.token_hex(3)
        self._ready_at: int | None = None
        self._stop_pending = self._was_lost = False
        self._unended: dict[ActionPart, _Request] = {}
        self._unread_report = ""

    def open(self, theme: Theme, clock: Clock, report: Callable[[Report], None]) -> None:
        """Connect in the background. Requests in the first moments wait for the connection."""
        self.close()
        super().open(theme, clock, report)
        self._begin()
        self._patience = clock.now() + PATIENCE
        topics = self._topics
        bridge = Bridge(
            self._address,
            dict.fromkeys((topics.speech, topics.gesture, topics.gaze, topics.stop), STRING),
            {topics.report: (STRING, lambda message: self._receive(bridge, message))},
            lambda: self._on_change(bridge),
        )
        self._bridge = bridge
        bridge.open()
        self._advance_at(bridge, self._patience)

    def say(self, action: str, text: str) -> None:
        """Have the robot speak."""
        text = text.encode("utf-8", "replace").decode()  # lone surrogates cannot be sent
        said = {"text": text, "language": self.theme.language}
        self._request(action, "say", self._topics.speech, said, text, A_CHARACTER * len(text))

    def gesture(self, action: str, name: str) -> None:
        """Have the robot move. The theme's keyframes are sent, too."""
        gesture = self.theme.gestures.get(name)
        if gesture is None:
            self.report(
                action,
                "gesture",
                "failed",
                f"The theme {self.theme.name} has no gesture {plain(name)}.",
            )
            return
        moves = {"gesture": name, "keyframes": gesture.keyframes}
        self._request(
            action, "gesture", self._topics.gesture, moves, name, gesture.duration_ms * MS
        )

    def gaze(self, action: str, where: str) -> None:
        """Have the robot look somewhere."""
        self._request(action, "gaze", self._topics.gaze, {"gaze": where}, where, 0)

    def stop(self, action: str = "") -> None:
        """Ask the robot to stop. Its request is aborted when it confirms, or after a while as not
        confirmed.

        The next request waits for that. A stop that cannot be sent now is sent before anything
        else. Raises OutputError if the robot may still be performing a request that was given up.
        """
        if self._bridge is None:
            return
        stopped = [
            request
            for queue in self._queues.values()
            for request in queue
            if action in ("", request.action)
        ]
        sent = [request for request in stopped if request.sent is not None]
        is_sent = False
        if sent or not action:
            is_sent = self._send_stop(action)
            self._stop_pending |= not is_sent
        now = self.clock.now()
        for request in stopped:
            if request.sent is None:
                self._end(request, "aborted", now)
            elif not is_sent:
                self._end(request, "failed", now, self._stop_failure)
            elif not request.is_stopping:
                request.is_stopping = True
                self._set_timer(
                    request, now + CONFIRM, partial(self._overdue, self._bridge, request)
                )
        if action:
            self._advance_all(self._bridge)
        elif self._was_lost and not is_sent:
            raise OutputError(self._stop_failure)
        elif not sent and any(self._may_go_on(request, now) for request in self._unended.values()):
            raise OutputError(self._unconfirmed)

    def close(self) -> None:
        """Have the robot stop, and close the connection."""
        if self._bridge is not None:
            with suppress(OutputError):  # nothing is reported any more
                self.stop()
            bridge, self._bridge = self._bridge, None
            bridge.close()

    # --- on the connection's thread: stamp and pass on

    def _on_change(self, bridge: Bridge) -> None:
        self.clock.call_soon(partial(self._connection_changed, bridge, bridge.is_connected))

    def _receive(self, bridge: Bridge, message: Any) -> None:
        at = self.clock.now()
        report = read_report(message)
        if isinstance(report, str):
            self._unread_report = f" One of its reports could not be understood: {report}."
        else:
            self.clock.call_soon(partial(self._reported, bridge, report, at))

    # --- on the clock's thread

    def _connection_changed(self, bridge: Bridge, connected: bool) -> None:
        if bridge is not self._bridge:
            return
        now = self.clock.now()
        if connected:
            self._was_lost = False
            if self._stop_pending:
                self._stop_pending = not self._send_stop("")
            self._ready_at = now + SETTLE
            self._advance_at(bridge, self._ready_at)
            return
        self._ready_at = None
        for request in self._under_way:
            self._was_lost = True
            self._stop_pending |= request.is_stopping
            self._unended[request.part] = request
            self._end(
                request, "failed", now, f"The connection to the robot at {self._address} was lost."
            )
        self._advance_all(bridge)

    def _reported(self, bridge: Bridge, report: RobotReport, at: int) -> None:
        if bridge is not self._bridge:
            return
        sent = [
            request
            for request in self._under_way
            if request.sent is not None and request.sent <= at
        ]
        about = [
            request for request in sent if self._is_about(report, request.action, request.part)
        ]
        self._forget_unended(report, {request.part for request in about})
        begun = [request for request in about if request.started is not None]
        waiting = [request for request in about if request.started is None]
        for request in (waiting if report.state == "started" else begun + waiting)[:1]:
            if request.started is None and report.state in ("started", "done"):
                request.started = at
                self._report(request, "started", at)
            if report.state != "started":
                why = report.detail or ("The robot failed." if report.state == "failed" else "")
                if request.is_stopping and not why:
                    self._unended.clear()
                self._end(
                    request, "aborted" if request.is_stopping and not why else report.state, at, why
                )
                self._advance(request.part)

    def _forget_unended(self, report: RobotReport, parts: set[ActionPart]) -> None:
        """Forget requests that were given up and are over now: the robot reports so late, or has
        begun the next one.
        """
        self._unended = {
            part: request
            for part, request in self._unended.items()
            if part not in parts
            and (report.state == "started" or not self._is_about(report, request.action, part))
        }

    def _request(
        self, action: str, part: ActionPart, topic: str, what: dict[str, Any], text: str, lasts: int
    ) -> None:
        if self._bridge is None:
            return
        message = self._topics.message(self._id(action), what, text)
        self._queues[part].append(_Request(action, part, topic, message, lasts))
        self._advance(part)

    def _advance_at(self, bridge: Bridge, when: int) -> None:
        self.clock.call_at(when, partial(self._advance_all, bridge, when))

    def _advance_all(self, bridge: Bridge, due: int = 0) -> None:
        if bridge is self._bridge:
            for part in self._queues:
                self._advance(part, due)

    def _advance(self, part: ActionPart, due: int = 0) -> None:
        """Send the next requests of a part that are due, or fail them. The time is at least
        ``due``.
        """
        queue, bridge = self._queues[part], cast(Bridge, self._bridge)
        while queue and queue[0].sent is None:
            request, now = queue[0], max(self.clock.now(), due)
            if not bridge.problem and self._is_to_wait(bridge, now):
                return
            if bridge.publish(request.topic, request.message):
                request.sent, self._unread_report = now, ""
                self._set_timer(request, now + ANSWER, partial(self._overdue, bridge, request))
            else:
                self._end(request, "failed", now, bridge.problem or self._not_connected)

    def _is_to_wait(self, bridge: Bridge, now: int) -> bool:
        if self._ready_at is None:
            return (
                bridge.is_connected or now < self._patience
            )  # `_connection_changed` has yet to be called
        return now < self._ready_at

    def _overdue(self, bridge: Bridge, request: _Request) -> None:
        queue, now = self._queues[request.part], self.clock.now()
        if bridge is not self._bridge or not queue or queue[0] is not request:
            return
        state: PartState = "failed"
        if request.is_stopping:
            state, why = "aborted", self._unconfirmed
        elif request.started is None:
            why = f"Sent to the robot at {self._address}, which did not acknowledge it."
        elif now < (until := request.started + request.lasts + LONGEST):
            self._set_timer(request, until, partial(self._overdue, bridge, request))
            return
        else:
            why = f"The robot at {self._address} started, but did not report that it was done."
        self._unended[request.part] = request
        self._end(request, state, now, why + self._unread_report)
        self._advance(request.part)

    def _set_timer(self, request: _Request, when: int, ring: Callable[[], None]) -> None:
        if request.timer:
            request.timer.cancel()
        request.timer = self.clock.call_at(when, ring)

    def _end(self, request: _Request, state: PartState, at: int, detail: str = "") -> None:
        self._queues[request.part].remove(request)
        if request.timer:
            request.timer.cancel()
        self._report(request, state, at, detail)

    def _report(self, request: _Request, state: PartState, at: int, detail: str = "") -> None:
        self._send_report(Report(request.action, request.part, state, at, detail))

    # --- stopping and helpers

    def _send_stop(self, action: str) -> bool:
        message = self._topics.message(action and self._id(action), {}, "stop")
        return cast(Bridge, self._bridge).publish(self._topics.stop, message)

    def _is_about(self, report: RobotReport, action: str, part: ActionPart) -> bool:
        unnamed = self._topics.form == "text" and not report.id
        return (unnamed or report.id == self._id(action)) and report.part in ("", part)

    def _id(self, action: str) -> str:
        """Return an action's id for the robot. It is unique to this session, so late reports of
        others are ignored.
        """
        return f"{action}-{self._token}"

    @property
    def _under_way(self) -> list[_Request]:
        """Requests that are sent and not over, oldest first."""
        sent = (queue[0] for queue in self._queues.values() if queue and queue[0].sent is not None)
        return sorted(sent, key=lambda request: request.sent or 0)

    def _may_go_on(self, request: _Request, now: int) -> bool:
        """Return True if the robot may perform a request that was given up: it started it, or still
        has time to.
        """
        return request.started is not None or now < (request.sent or 0) + request.lasts + LONGEST

    @property
    def _unconfirmed(self) -> str:
        return f"The robot at {self._address} did not confirm that it stopped."

    @property
    def _stop_failure(self) -> str:
        return f"The robot could not be asked to stop. {self._not_connected}"

    @property
    def _not_connected(self) -> str:
        return (
            f"The robot is not connected: there is no ROS bridge at {self._address}. Start "
            "rosbridge there."
        )
