"""Figure 4.15 of the thesis: the parts of the loop that the reaching task adds to those of the keyboard task."""

from collections.abc import Mapping, Sequence

from sar_tui.app.loop_graph import loop_graph
from sar_tui.framework.graph import Graph
from sar_tui.validation import charts
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row

TASKS = ("keyboard", "reaching")
FOR_A_SENSOR = {"imu", "reach_perception", "view"}
"""Parts that a task with a motion sensor needs: the sensor, what finds reaches in its samples, and the view of them."""


def run(conditions: Conditions) -> Report:
    """Return one row per part of the two loops: in which of them it is, and whether it is the same there."""
    theme = conditions.catalogue.theme("calm")
    return report({task: loop_graph(conditions.catalogue.task(task), theme) for task in TASKS})


def report(graphs: Mapping[str, Graph]) -> Report:
    """Compare the loops of the two tasks."""
    rows = _rows(graphs)
    removed = [row["part"] for row in rows if not row["reaching"]]
    claims = [
        Claim("The reaching task has all parts of the keyboard task's loop.", ", ".join(removed)),
        Claim("It adds only parts for its sensor.", ", ".join(_needless(rows))),
    ]
    return Report(rows, [_COLUMNS], claims, chart=charts.parts(rows))


def _rows(graphs: Mapping[str, Graph]) -> list[Row]:
    one, other = ({part.name for part in graphs[task].nodes if part.kind not in ("tap", "outside")} for task in TASKS)
    names = [part.name for part in graphs["reaching"].nodes if part.name in other]
    names += sorted(one - other)
    return [
        {
            "part": name,
            "keyboard": name in one,
            "reaching": name in other,
            "state": "the same" if name in one and name in other else "added" if name in other else "removed",
        }
        for name in names
    ]


def _needless(rows: Sequence[Row]) -> list[str]:
    return [row["part"] for row in rows if row["state"] == "added" and row["part"] not in FOR_A_SENSOR]


def _mark(task: str) -> Column:
    return Column(task, lambda row: "●" if row[task] else "", is_number=False)


_COLUMNS = (
    Column("part", lambda row: str(row["part"]), is_number=False),
    *map(_mark, TASKS),
    Column("in the reaching task", lambda row: str(row["state"]), is_number=False),
)
