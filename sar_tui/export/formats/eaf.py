"""Documents of ELAN (EAF 3.0, Max Planck Institute for Psycholinguistics): tiers of annotations on
a time line.
"""

import re
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree

import msgspec

POINT_MS = 100
"""Length of what has no duration: ELAN shows no annotation that is shorter than a millisecond."""
_TYPE = "interval"
_SCHEMA = "http://www.mpi.nl/tools/elan/EAFv3.0.xsd"
_INSTANCE = "http://www.w3.org/2001/XMLSchema-instance"
_NOT_IN_XML = re.compile("[^\t\n\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class Annotation(msgspec.Struct, frozen=True, order=True):
    """A value from a start to an end, in ms."""

    start: int
    end: int
    value: str

    @property
    def times(self) -> tuple[int, int]:
        """Start and end."""
        return self.start, self.end


class Tier(msgspec.Struct, frozen=True):
    """A line of annotations.

    Attributes:
        participant: the code of the person it is about; empty if none.
    """

    name: str
    annotations: Sequence[Annotation]
    participant: str = ""


def annotation(start: int, end: int | None, value: str) -> Annotation:
    """Return an annotation. Without an end after its start it is as long as `POINT_MS`."""
    return Annotation(start, end if end is not None and end > start else start + POINT_MS, value)


def document(tiers: Iterable[Tier], date: str) -> ElementTree.ElementTree:
    """Return the document of a session.

    Args:
        date: with time, ISO 8601.
    """
    attributes = {"AUTHOR": "sar-tui", "DATE": date, "FORMAT": "3.0", "VERSION": "3.0"}
    root = ElementTree.Element("ANNOTATION_DOCUMENT", attributes)
    root.set(f"{{{_INSTANCE}}}noNamespaceSchemaLocation", _SCHEMA)
    header = ElementTree.SubElement(root, "HEADER", MEDIA_FILE="", TIME_UNITS="milliseconds")
    times = ElementTree.SubElement(root, "TIME_ORDER")
    lines = [line for tier in tiers for line in _without_overlap(tier)]
    numbered = dict(enumerate((each for line in lines for each in line.annotations), 1))
    # Each end has a slot of its own: annotations that share one move together when it is dragged in
    # ELAN.
    ends = sorted(
        (time, number, end)
        for number, each in numbered.items()
        for end, time in enumerate(each.times)
    )
    slots = {(number, end): f"ts{slot}" for slot, (_, number, end) in enumerate(ends, 1)}
    for time, number, end in ends:
        ElementTree.SubElement(
            times, "TIME_SLOT", TIME_SLOT_ID=slots[number, end], TIME_VALUE=str(time)
        )
    numbers = iter(numbered)
    for line in lines:
        whose = {"PARTICIPANT": line.participant} if line.participant else {}
        tier = ElementTree.SubElement(
            root, "TIER", {"LINGUISTIC_TYPE_REF": _TYPE, "TIER_ID": line.name, **whose}
        )
        for each, number in zip(line.annotations, numbers, strict=False):
            found = ElementTree.SubElement(
                ElementTree.SubElement(tier, "ANNOTATION"),
                "ALIGNABLE_ANNOTATION",
                ANNOTATION_ID=f"a{number}",
                TIME_SLOT_REF1=slots[number, 0],
                TIME_SLOT_REF2=slots[number, 1],
            )
            ElementTree.SubElement(found, "ANNOTATION_VALUE").text = _text(each.value)
    last = ElementTree.SubElement(header, "PROPERTY", NAME="lastUsedAnnotationId")
    last.text = str(len(numbered))
    ElementTree.SubElement(
        root,
        "LINGUISTIC_TYPE",
        GRAPHIC_REFERENCES="false",
        LINGUISTIC_TYPE_ID=_TYPE,
        TIME_ALIGNABLE="true",
    )
    ElementTree.indent(root)
    return ElementTree.ElementTree(root)


def _without_overlap(tier: Tier) -> list[Tier]:
    """Return a tier, and others for what overlaps in it, which ELAN does not allow: "notes", "notes
    2", …
    """
    lines: list[list[Annotation]] = [[]]
    for each in sorted(tier.annotations):
        line = next((line for line in lines if not line or line[-1].end <= each.start), None)
        if line is None:
            lines.append(line := [])
        line.append(each)
    return [
        Tier(tier.name if number == 1 else f"{tier.name} {number}", line, tier.participant)
        for number, line in enumerate(lines, 1)
    ]


def _text(value: str) -> str:
    """Return a text that XML can hold: line ends as LF, and a mark for a control character."""
    return _NOT_IN_XML.sub("\ufffd", re.sub("\r\n?", "\n", value))
