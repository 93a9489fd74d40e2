"""Graph of nodes and topics, from the declarations of the nodes (thesis, Figures 4.2 and 4.6)."""

from collections.abc import Sequence
from typing import Any, ClassVar, Literal, Protocol

import msgspec

from sar_tui.loop.bus import Topic
from sar_tui.loop.node import Node
from sar_tui.loop.topics import TIMER

OUTSIDE = "app"
"""Name of the source of topics that no node emits: the program around the loop."""


class Listener(Protocol):
    """A tap on the bus that also emits. It is not a node, because it receives every topic."""

    name: ClassVar[str]
    emits: ClassVar[tuple[Topic[Any], ...]]


class Part(msgspec.Struct, frozen=True, rename={"receives": "hears"}):
    """A node of the graph, with the names of its topics and services.

    ``kind``: ``input`` (receives nothing), ``output`` (emits only reports, or nothing), ``node``
    (in between), ``tap`` (receives everything), ``outside`` (the program around them).
    """

    name: str
    kind: Literal["input", "node", "output", "tap", "outside"]
    emits: tuple[str, ...] = ()
    receives: tuple[str, ...] = ()
    asks: tuple[str, ...] = ()
    answers: tuple[str, ...] = ()


class Edge(msgspec.Struct, frozen=True):
    """A ``topic`` from the node that emits it to one that receives it, or a ``service`` from caller
    to server.
    """

    source: str = msgspec.field(name="from")
    target: str = msgspec.field(name="to")
    name: str
    kind: Literal["topic", "service"]


class Graph(msgspec.Struct, frozen=True):
    """Nodes and edges."""

    nodes: tuple[Part, ...]
    edges: tuple[Edge, ...]


def graph(nodes: Sequence[type[Node]], taps: Sequence[type[Listener]] = ()) -> Graph:
    """Return the graph of a loop, without the messages of nodes to themselves, such as timers.

    Args:
        nodes: in the order in which they receive a message.
        taps: receive everything; edges are drawn for topics that no node receives.
    """
    parts = [_part(node) for node in nodes]
    parts += [Part(tap.name, "tap", emits=_names(tap.emits)) for tap in taps]
    emitted = {name for part in parts for name in part.emits}
    orphans = dict.fromkeys(name for part in parts for name in part.receives if name not in emitted)
    if orphans:
        parts.append(Part(OUTSIDE, "outside", emits=tuple(orphans)))
    received = {name for part in parts for name in part.receives}
    topic_edges = [
        Edge(source.name, target.name, name, "topic")
        for source in parts
        for name in source.emits
        for target in parts
        if target is not source
        and (name in target.receives or (target.kind == "tap" and name not in received))
    ]
    service_edges = [
        Edge(source.name, target.name, name, "service")
        for source in parts
        for name in source.asks
        for target in parts
        if name in target.answers
    ]
    return Graph(tuple(parts), (*topic_edges, *service_edges))


def _part(node: type[Node]) -> Part:
    emits, receives, answers = _names(node.emits), _names(node.receives()), node.answers()
    kind: Literal["input", "node", "output"] = "node"
    if all(topic.origin == "input" for topic in node.emits) and not answers:
        kind = "output" if receives else "input"
    return Part(
        node.name,
        kind,
        emits=emits,
        receives=receives,
        asks=tuple(service.name for service in node.asks),
        answers=tuple(service.name for service in answers),
    )


def _names(topics: Sequence[Topic[Any]]) -> tuple[str, ...]:
    return tuple(topic.name for topic in topics if topic is not TIMER)


def longest_path(whole: Graph) -> list[str]:
    """Return the names on the longest path from an input through the loop, without repetition."""
    inner = {part.name for part in whole.nodes if part.kind in ("input", "node", "output")}
    targets: dict[str, list[str]] = {}
    for edge in whole.edges:
        if edge.kind == "topic" and {edge.source, edge.target} <= inner:
            targets.setdefault(edge.source, []).append(edge.target)

    def longest(path: list[str]) -> list[str]:
        ways = [
            longest([*path, name])
            for name in dict.fromkeys(targets.get(path[-1], ()))
            if name not in path
        ]
        return max(ways, key=len, default=path)

    starts = [part.name for part in whole.nodes if part.kind == "input"] or [
        part.name for part in whole.nodes
    ]
    return max((longest([name]) for name in starts), key=len, default=[])
