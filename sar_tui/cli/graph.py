"""``sar-tui graph``: draw the loop from the nodes' own declarations."""

import textwrap
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import typer

from sar_tui.cli.common import (
    AsJson,
    Home,
    TaskName,
    console,
    print_json,
    watch_plugins,
)

if TYPE_CHECKING:
    from sar_tui.loop.graph import Edge, Graph, Part

_INDENT = "  "


def graph(
    context: typer.Context,
    home: Home,
    task: TaskName,
    as_json: AsJson = False,
) -> None:
    """Draw the nodes and topics of a task's loop."""
    from sar_tui.app.loop_graph import loop_graph

    watch_plugins(context)
    catalogue = home.catalogue()
    kind = catalogue.task(task)
    whole = loop_graph(kind, catalogue.theme("calm"))
    if as_json:
        print_json({"task": task, "nodes": whole.nodes, "edges": whole.edges})
        return

    out = console()
    out.print(draw(whole, out.width), markup=False, end="")


def draw(whole: "Graph", width: int) -> str:
    """Return the drawing, in lines of at most ``width`` characters if the names allow it."""
    from sar_tui.loop.graph import longest_path

    path = longest_path(whole)
    parts = {part.name: part for part in whole.nodes}
    inner = max(len(name) for name in parts)
    lines: list[str] = []
    for name, below in zip(path, [*path[1:], None], strict=True):
        lines += _node(parts[name], below, whole, inner, width)
    rest = [part for part in whole.nodes if part.name not in path]
    for part in rest:
        lines += ["", *_node(part, None, whole, inner, width)]
    return "\n".join(
        [
            *lines,
            "",
            "│ ──▶ topic: published when it happens    ┄┄▶ service: called, answers at once",
            "",
        ]
    )


def _node(part: "Part", below: str | None, whole: "Graph", inner: int, width: int) -> Iterator[str]:
    """Yield the lines of a box, its branches, and the line down to the next box."""
    out = [edge for edge in whole.edges if edge.source == part.name]
    down = [edge.name for edge in out if edge.kind == "topic" and edge.target == below]
    branches = list(
        _branches([edge for edge in out if edge.name not in down or edge.target != below])
    )
    middle = (inner + 2) // 2
    stem = "┬" if down or branches else "─"
    yield f"{_INDENT}╭{'─' * (inner + 2)}╮"
    yield f"{_INDENT}│ {part.name.center(inner)} │{_note(part)}"
    yield f"{_INDENT}╰{'─' * middle}{stem}{'─' * (inner + 1 - middle)}╯"
    margin = _INDENT + " " * (middle + 1)
    longest = max((len(target) for target, _, _ in branches), default=0)
    for number, (target, arrow, names) in enumerate(branches, start=1):
        last = number == len(branches) and not down
        head = f"{margin}{'╰' if last else '├'}{arrow} {target.ljust(longest)}  "
        follow = f"{margin}{' ' if last else '│'}".ljust(len(head))
        yield from textwrap.wrap(
            ", ".join(names), width, initial_indent=head, subsequent_indent=follow,
            break_long_words=False, break_on_hyphens=False,
        )  # fmt: skip
    for name in down:
        yield f"{margin}│ {name}"
    if down:
        yield f"{margin}▼"


def _branches(edges: "Sequence[Edge]") -> Iterator[tuple[str, str, list[str]]]:
    """Yield each other target, its arrow, and the names of the topics or services."""
    for kind, arrow in (("topic", "──▶"), ("service", "┄┄▶")):
        for target in dict.fromkeys(edge.target for edge in edges if edge.kind == kind):
            yield (
                target,
                arrow,
                [edge.name for edge in edges if (edge.kind, edge.target) == (kind, target)],
            )


def _note(part: "Part") -> str:
    """Return a note beside a box."""
    notes = {
        "input": "  user interface: what the participant does",
        "output": "  user interface: what the participant gets",
        "tap": "  receives every message, and stores it",
        "outside": "  the program around the loop",
    }
    if part.answers:
        return f"  answers {', '.join(part.answers)}"
    return notes.get(part.kind, "")
