"""Figure 4.15 of the thesis: the parts of the loop that the reaching task adds to those of the
keyboard task.
"""

from collections.abc import Mapping, Sequence

from sar_tui.app.loop_graph import loop_graph
from sar_tui.loop.graph import Graph
from sar_tui.loop.session import OWN_PARTS, Parts, core_nodes
from sar_tui.loop.task import Task
from sar_tui.model.theme import Theme
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import set_up
from sar_tui.validation import charts
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row

TASKS = ("keyboard", "reaching")
FOR_A_SENSOR = {"imu", "trunk_imu", "reach_perception", "view"}
"""Parts that a task with a motion sensor needs: the sensor, what finds reaches in its samples, and
the view of them.
"""


def run(conditions: Conditions) -> Report:
    """Return one row per part of the two loops: in which of them it is, and whether it is the same
    there.
    """
    theme = conditions.catalogue.theme("calm")
    kinds = {task: conditions.catalogue.task(task) for task in TASKS}
    return report(
        {task: loop_graph(kind, theme) for task, kind in kinds.items()},
        {task: node_classes(kind, theme) for task, kind in kinds.items()},
    )


def node_classes(kind: type[Task], theme: Theme, parts: Parts = OWN_PARTS) -> dict[str, str]:
    """Return the module and class of each node of a task's loop, by the node's name."""
    nodes = core_nodes(set_up(kind, build(kind.Parameters, {})), theme, 0, parts)
    return {node.name: f"{type(node).__module__}.{type(node).__name__}" for node in nodes}


def report(graphs: Mapping[str, Graph], nodes: Mapping[str, Mapping[str, str]]) -> Report:
    """Compare the loops of the two tasks, and the classes of their nodes."""
    rows = _rows(graphs, nodes)
    changed = [row["part"] for row in rows if row["state"] == "changed"]
    removed = [row["part"] for row in rows if not row["reaching"]]
    claims = [
        Claim("The reaching task has all parts of the keyboard task's loop.", ", ".join(removed)),
        Claim("Each of these parts is the same code in both.", ", ".join(changed)),
        Claim("It adds only parts for its sensors.", ", ".join(_needless(rows))),
    ]
    return Report(rows, [_COLUMNS], claims, chart=charts.parts(rows))


def _rows(graphs: Mapping[str, Graph], nodes: Mapping[str, Mapping[str, str]]) -> list[Row]:
    one, other = (
        {part.name for part in graphs[task].nodes if part.kind not in ("tap", "outside")}
        for task in TASKS
    )
    names = [part.name for part in graphs["reaching"].nodes if part.name in other]
    names += sorted(one - other)
    return [
        {
            "part": name,
            "keyboard": name in one,
            "reaching": name in other,
            "state": _state(name, one, other, nodes),
        }
        for name in names
    ]


def _state(
    name: str, one: set[str], other: set[str], nodes: Mapping[str, Mapping[str, str]]
) -> str:
    if name not in other:
        return "removed"
    if name not in one:
        return "added"
    return "the same" if nodes["keyboard"].get(name) == nodes["reaching"].get(name) else "changed"


def _needless(rows: Sequence[Row]) -> list[str]:
    return [
        row["part"] for row in rows if row["state"] == "added" and row["part"] not in FOR_A_SENSOR
    ]


def _mark(task: str) -> Column:
    return Column(task, lambda row: "●" if row[task] else "", is_number=False)


_COLUMNS = (
    Column("part", lambda row: str(row["part"]), is_number=False),
    *map(_mark, TASKS),
    Column("in the reaching task", lambda row: str(row["state"]), is_number=False),
)
