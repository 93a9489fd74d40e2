"""The graph of nodes and topics, from the nodes' own declarations (the thesis' Figures 4.2 and 4.6)."""

from collections.abc import Sequence
from typing import Any, ClassVar, Literal, Protocol

import msgspec

from sar_tui.framework.bus import Topic
from sar_tui.framework.node import Node
from sar_tui.framework.topics import TIMER

OUTSIDE = "app"
"""Where topics come from that no node emits: the program around the loop."""


class Listener(Protocol):
    """A tap on the bus that speaks up, too: it is no node, for it hears everything."""

    name: ClassVar[str]
    emits: ClassVar[tuple[Topic[Any], ...]]


class Part(msgspec.Struct, frozen=True):
    """A node of the graph, with the names of its topics and services.

    ``kind``: ``input`` (hears nothing), ``output`` (only reports back), ``node`` (in between), ``tap`` (hears
    everything), ``outside`` (the program around them).
    """

    name: str
    kind: Literal["input", "node", "output", "tap", "outside"]
    emits: tuple[str, ...] = ()
    hears: tuple[str, ...] = ()
    asks: tuple[str, ...] = ()
    answers: tuple[str, ...] = ()


class Edge(msgspec.Struct, frozen=True):
    """What one node tells (``topic``) or asks (``service``) another; ``name`` is the topic's or the service's."""

    source: str = msgspec.field(name="from")
    target: str = msgspec.field(name="to")
    name: str
    kind: Literal["topic", "service"]


class Graph(msgspec.Struct, frozen=True):
    """Who there is, and who tells or asks whom what."""

    nodes: tuple[Part, ...]
    edges: tuple[Edge, ...]


def graph(nodes: Sequence[type[Node]], taps: Sequence[type[Listener]] = ()) -> Graph:
    """Make the graph of a loop. What a node tells itself, its timers above all, is left out.

    Args:
        nodes: in the order in which they hear a message.
        taps: those who hear everything; they have an edge from a topic that nobody else hears.
    """
    parts = [_part(node) for node in nodes]
    parts += [Part(tap.name, "tap", emits=_names(tap.emits)) for tap in taps]
    emitted = {name for part in parts for name in part.emits}
    orphans = dict.fromkeys(name for part in parts for name in part.hears if name not in emitted)
    if orphans:
        parts.append(Part(OUTSIDE, "outside", emits=tuple(orphans)))
    heard = {name for part in parts for name in part.hears}
    told = [
        Edge(source.name, target.name, name, "topic")
        for source in parts
        for name in source.emits
        for target in parts
        if target is not source and (name in target.hears or (target.kind == "tap" and name not in heard))
    ]
    asked = [
        Edge(source.name, target.name, name, "service")
        for source in parts
        for name in source.asks
        for target in parts
        if name in target.answers
    ]
    return Graph(tuple(parts), (*told, *asked))


def _part(node: type[Node]) -> Part:
    emits, hears = _names(node.emits), _names(node.hears())
    kind: Literal["input", "node", "output"] = "node"
    if all(topic.origin == "input" for topic in node.emits) and emits:
        kind = "output" if hears else "input"
    return Part(
        node.name,
        kind,
        emits=emits,
        hears=hears,
        asks=tuple(service.name for service in node.asks),
        answers=tuple(service.name for service in node.answers()),
    )


def _names(topics: Sequence[Topic[Any]]) -> tuple[str, ...]:
    return tuple(topic.name for topic in topics if topic is not TIMER)


def spine(whole: Graph) -> list[str]:
    """The longest way a message takes through the loop, from an input onwards: names, each once."""
    inner = {part.name for part in whole.nodes if part.kind in ("input", "node", "output")}
    told: dict[str, list[str]] = {}
    for edge in whole.edges:
        if edge.kind == "topic" and {edge.source, edge.target} <= inner:
            told.setdefault(edge.source, []).append(edge.target)

    def longest(path: list[str]) -> list[str]:
        ways = [longest([*path, name]) for name in dict.fromkeys(told.get(path[-1], ())) if name not in path]
        return max(ways, key=len, default=path)

    starts = [part.name for part in whole.nodes if part.kind == "input"] or [part.name for part in whole.nodes]
    return max((longest([name]) for name in starts), key=len, default=[])
