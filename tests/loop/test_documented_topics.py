"""docs/write-a-node.md lists every topic with the fields of its messages."""

import os
import re
from pathlib import Path

import msgspec

from sar_tui.loop import topics
from sar_tui.loop.bus import FAULT, Topic

PAGE = Path(__file__).parents[2] / "docs" / "write-a-node.md"
_HEADING = "## All topics\n"
_ABOUT = """
Made from the program's list. Import name and message from `sar_tui.api.node`. Every message has a `seat` besides, whom
it concerns. *Input*: recorded, and published again in a replay; *derived*: computed anew from inputs; *later*: added to
the record after the session, and received by no node. A message that is *kept* is delivered to a node that subscribes
later; a *stream* is not among the events of the database.

"""


def lists() -> str:
    """The end of the page as it has to be."""
    names = {name: topic for name, topic in vars(topics).items() if isinstance(topic, Topic)} | {
        "FAULT": FAULT
    }
    said: dict[type, str] = {}
    rows = ["| name | topic | message and fields | |", "|---|---|---|---|"]
    for name, topic in names.items():
        fields = ", ".join(
            f"`{field.name}`"
            for field in msgspec.structs.fields(topic.type)
            if field.name != "seat"
        )
        summary = re.split(r"(?<=\.)\s|:\s", " ".join((topic.type.__doc__ or "").split()))[
            0
        ].rstrip(".")
        kind = ", ".join([topic.origin] + ["kept"] * topic.keep + ["stream"] * topic.stream)
        summary = summary.replace("``", "`")
        first = said.setdefault(topic.type, name)
        told = f"{summary}. {fields}" if first == name else f"as `{first}`"
        rows.append(f"| `{name}` | `{topic.name}` | `{topic.type.__name__}`: {told} | {kind} |")
    return _HEADING + _ABOUT + "\n".join(rows) + "\n"


def test_the_page_lists_every_topic() -> None:
    text = PAGE.read_text(encoding="utf-8")
    made = text.partition(_HEADING)[0] + lists()
    if os.environ.get("SAR_TUI_UPDATE_SNAPSHOTS"):
        PAGE.write_text(made, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == made, "write it anew with SAR_TUI_UPDATE_SNAPSHOTS=1"
