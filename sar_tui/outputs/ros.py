"""A robot on a ROS system that speaks, moves and looks. It is reached through the rosbridge
protocol.
"""

from typing import Any, Literal

import msgspec

from sar_tui.drivers.address import Address
from sar_tui.drivers.rosbridge import PORT, Bridge, TopicName
from sar_tui.model.units import MS
from sar_tui.outputs.robot import Answer, Changed, Heard, Link, Request, Robot, plain, read_address

STRING = "std_msgs/String"
SETTLE = 500 * MS
"""Pause after connecting before anything is sent: ROS needs a moment to discover a new
publisher.
"""
CONFIRM = 1500 * MS
"""Time in which it must confirm a stop. Less than `node.STOP_TIMEOUT`, so that this failure is the
one reported.
"""
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


class RosTopics:
    """The connection: a topic for each part, one to stop, and one for the robot's reports."""

    def __init__(self, address: Address, topics: Topics, changed: Changed, heard: Heard) -> None:
        self._topics = topics
        self._heard = heard
        self._by_part = {"say": topics.speech, "gesture": topics.gesture, "gaze": topics.gaze}
        self._bridge = Bridge(
            address,
            dict.fromkeys((*self._by_part.values(), topics.stop), STRING),
            {topics.report: (STRING, self._receive)},
            changed,
        )

    @property
    def problem(self) -> str:
        return self._bridge.problem

    @property
    def is_connected(self) -> bool:
        return self._bridge.is_connected

    def open(self) -> None:
        self._bridge.open()

    def send(self, request: Request) -> bool:
        match request.part:
            case "say":
                what: dict[str, Any] = {"text": request.what, "language": request.theme.language}
            case "gesture":
                what = {"gesture": request.what, "keyframes": request.gesture.keyframes}
            case _:
                what = {"gaze": request.what}
        message = self._topics.message(request.id, what, request.what)
        return self._bridge.publish(self._by_part[request.part], message)

    def stop(self, id: str) -> bool:
        return self._bridge.publish(self._topics.stop, self._topics.message(id, {}, "stop"))

    def close(self) -> None:
        self._bridge.close()

    def _receive(self, message: Any) -> None:
        report = read_report(message)
        if isinstance(report, str):
            self._heard(report)
        elif report.id or self._topics.form == "text":
            self._heard(Answer(report.state, report.id, report.part, report.detail))


class Ros(Robot):
    """A robot on a ROS system that listens to a topic for each part.

    Args:
        address: ``ros://HOST[:PORT]``, and after a question mark `Topics`. Raises OutputError if it
            is invalid.
    """

    name = "ros"
    settle = SETTLE
    confirm = CONFIRM

    def __init__(self, address: str) -> None:
        self._address, self._topics = read_address(address, "ros", PORT, Topics, _EXAMPLE)
        self.place = str(self._address)
        self.missing = f"there is no ROS bridge at {self.place}. Start rosbridge there."

    def connect(self, changed: Changed, heard: Heard) -> Link:
        return RosTopics(self._address, self._topics, changed, heard)
