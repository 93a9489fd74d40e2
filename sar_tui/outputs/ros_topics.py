"""Topics and messages (``std_msgs/String``) to and from a robot on a ROS system."""

from typing import Any, Literal

import msgspec

from sar_tui.drivers.rosbridge import Address, AddressError, TopicName, parse
from sar_tui.model.visible_text import visible
from sar_tui.outputs.output import OutputError

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
