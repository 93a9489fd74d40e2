"""``sar-tui graph``: the thesis' Figure 4.2, made from the code."""

from typing import Any, ClassVar

from sar_tui.loop.graph import graph, longest_path
from sar_tui.loop.node import Node, TimedNode, on
from sar_tui.loop.topics import ACTION, KEY, PERCEIVED, TIMER
from tests.program import Call


def test_the_loop_is_the_thesis_figure_and_each_node_what_it_declares(call: Call) -> None:
    printed = call("graph keyboard --json").json
    assert set(printed) == {"task", "nodes", "edges"}
    edges = {
        tuple(edge[name] for name in ("from", "to", "name", "kind")) for edge in printed["edges"]
    }
    assert edges >= {
        ("keyboard", "perception", "input/key", "topic"),
        ("perception", "event_handler", "perception/key", "topic"),
        ("event_handler", "action_center", "event_handler/feedback", "topic"),
        ("event_handler", "memory", "event_handler/attempt_ended", "topic"),
        ("action_center", "memory", "memory/recall", "service"),
        ("action_center", "arbiter", "action_center/proposed", "topic"),
        ("arbiter", "screen", "arbiter/action", "topic"),
        ("event_handler", "screen", "event_handler/prompt", "topic"),
        ("screen", "event_handler", "screen/shown", "topic"),
        ("recorder", "event_handler", "store/stored", "topic"),
    }
    assert not [edge for edge in edges if edge[0] == edge[1]], "no node talks to itself"
    assert not [edge for edge in edges if edge[2] == TIMER.name]
    nodes = {node["name"]: node for node in printed["nodes"]}
    kinds = {"keyboard": "input", "memory": "node", "screen": "output", "recorder": "tap"}
    assert {name: nodes[name]["kind"] for name in kinds} == kinds
    assert nodes["memory"]["answers"] == ["memory/recall"]
    assert "view" not in nodes
    nodes = {node["name"]: node for node in call("graph pairs --json").json["nodes"]}
    assert (nodes["view"]["kind"], nodes["screen"]["kind"]) == ("output", "output")
    assert "event_handler/prompt" in nodes["view"]["hears"]


def test_the_drawing_goes_down_the_loop(call: Call) -> None:
    called = call("graph keyboard")
    called.shows("┄┄▶ memory")
    lines = called.out.splitlines()
    boxes = [line.split("│")[1].strip() for line in lines if line.startswith("  │ ")]
    way = ["keyboard", "perception", "event_handler", "action_center", "arbiter", "screen"]
    assert boxes[:6] == way
    assert {"memory", "recorder"} <= set(boxes)
    assert max(map(len, lines)) <= 160


class Eye(Node):
    name = "eye"
    emits = (KEY,)


class Brain(TimedNode):
    name = "brain"
    emits: ClassVar[tuple[Any, ...]] = (TIMER, PERCEIVED)

    @on(KEY)
    def seen(self, _: object) -> None: ...


class Mouth(Node):
    name = "mouth"

    @on(PERCEIVED)
    def understood(self, _: object) -> None: ...

    @on(ACTION)
    def acted(self, _: object) -> None: ...


def test_a_graph_is_made_from_declarations_alone() -> None:
    made = graph([Eye, Brain, Mouth])
    assert [(edge.source, edge.target, edge.name) for edge in made.edges] == [
        ("eye", "brain", "input/key"),
        ("brain", "mouth", "perception/key"),
        ("app", "mouth", "arbiter/action"),
    ]
    assert longest_path(made) == ["eye", "brain", "mouth"]


def test_a_topic_without_other_receivers_goes_to_the_recorder() -> None:
    class Ear:
        name: ClassVar[str] = "ear"
        emits: ClassVar[tuple[Any, ...]] = ()

    assert [(edge.source, edge.target) for edge in graph([Eye], [Ear]).edges] == [("eye", "ear")]
