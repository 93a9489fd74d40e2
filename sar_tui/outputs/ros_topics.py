"""What goes to a robot on a ROS system, and what comes from it: topics, and messages of ``std_msgs/String``."""

from typing import Any, Literal

import msgspec

from sar_tui.drivers.rosbridge import Address, AddressError, TopicName, parse
from sar_tui.outputs.output import OutputError

STRING = "std_msgs/String"
_EXAMPLE = (
    "ros://HOST or ros://HOST:PORT; after a question mark, joined by &, there may be speech=, gesture=, gaze=, "
    "report= and stop=, each with a topic such as /robot/speech, and form=json or form=text"
)


class Topics(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What may follow the question mark of an address.

    ``form``: each message is JSON, with an id that the robot names in its reports; or the bare text (or name).
    """

    speech: TopicName = "/sar_tui/speech"
    gesture: TopicName = "/sar_tui/gesture"
    gaze: TopicName = "/sar_tui/gaze"
    report: TopicName = "/sar_tui/report"
    stop: TopicName = "/sar_tui/stop"
    form: Literal["json", "text"] = "json"

    def message(self, identity: str, what: dict[str, Any], bare: str) -> dict[str, str]:
        """A message: ``what`` with the id of what it belongs to, or ``bare``."""
        return {"data": bare if self.form == "text" else msgspec.json.encode({"id": identity} | what).decode()}


class Answer(msgspec.Struct, frozen=True):
    """What a robot reports. In bare text, without an id, it is about what has been under way for longest."""

    state: Literal["started", "done", "failed", "aborted"]
    id: str = ""
    deed: Literal["say", "gesture", "gaze", ""] = ""
    detail: str = ""


def parse_address(address: str) -> tuple[Address, Topics]:
    """Read the address of a robot. Raises OutputError, which tells what there may be."""
    try:
        found = parse(address, _EXAMPLE)
        topics = msgspec.convert(found.options, Topics)
    except AddressError as error:
        raise OutputError(str(error)) from error
    except msgspec.ValidationError as error:
        raise OutputError(f'The address "{address}" cannot be understood ({error}). Say {_EXAMPLE}.') from error
    if found.path.strip("/"):
        raise OutputError(f'"{found.path}" has no meaning in the address of a robot. Say {_EXAMPLE}.')
    return found, topics


def understand(message: Any) -> Answer | str:
    """What a robot reports, or why that cannot be understood."""
    try:
        answer = msgspec.json.decode(msgspec.convert(message, dict[str, str])["data"], type=Answer)
    except (msgspec.MsgspecError, KeyError, UnicodeError) as error:
        return plain(str(error))
    return msgspec.structs.replace(answer, detail=plain(answer.detail))


def plain(text: str) -> str:
    """A robot's words, fit for a line of the log and the screen."""
    return "".join(character if character.isprintable() else " " for character in text)[:200]
