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
it concerns. A message that is *kept* is delivered to a node that subscribes later; a *stream* is not among the events
of the database.
"""
_ORIGINS = {
    "input": "Inputs: recorded, and published again in a replay",
    "derived": "Derived: computed anew from inputs",
    "later": "Later: added to the record after the session, and received by no node",
}


def lists() -> str:
    """The end of the page as it has to be."""
    names = {name: topic for name, topic in vars(topics).items() if isinstance(topic, Topic)} | {
        "FAULT": FAULT
    }
    first_with: dict[type, str] = {}
    rows: dict[str, list[str]] = {origin: [] for origin in _ORIGINS}
    for name, topic in names.items():
        first = first_with.setdefault(topic.type, name)
        told = _summary(topic.type) if first == name else f"as `{first}`"
        signs = "".join([" *Kept.*"] * topic.keep + [" *Stream.*"] * topic.stream)
        rows[topic.origin].append(
            f"| `{name}` | `{topic.name}` | `{topic.type.__name__}`: {told}{signs} |"
        )
    tables = (
        "\n".join(
            (
                f"\n**{title}**\n",
                "| name | topic | message and fields |",
                "|---|---|---|",
                *rows[of],
            )
        )
        for of, title in _ORIGINS.items()
    )
    return _HEADING + _ABOUT + "\n".join(tables) + "\n"


def _summary(message: type[msgspec.Struct]) -> str:
    """The first sentence on a message, and its fields."""
    fields = ", ".join(
        f"`{field.name}`" for field in msgspec.structs.fields(message) if field.name != "seat"
    )
    text = " ".join((message.__doc__ or "").split())
    sentence = re.split(r"(?<=\.)\s|:\s", text)[0].rstrip(".")
    return f"{sentence.replace('``', '`')}. {fields}"


def test_the_page_lists_every_topic() -> None:
    text = PAGE.read_text(encoding="utf-8")
    made = text.partition(_HEADING)[0] + lists()
    if os.environ.get("SAR_TUI_UPDATE_SNAPSHOTS"):
        PAGE.write_text(made, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == made, "write it anew with SAR_TUI_UPDATE_SNAPSHOTS=1"
