"""Modular flexibility, the fourth requirement of the thesis: the share of common code in a task's
session (70 to 80 %), and Figure 4.15, the parts of the loop that the reaching task adds to those of
the keyboard task.

The share compares the lines of code in the modules that a session of the task loads: those of the
framework, inputs, outputs and movement science with those in the task's own folder. The app, the
database and the simulated participant are left out: all tasks share them, and they would only raise
the figure.
"""

import ast
import io
import subprocess
import tokenize
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import msgspec

from sar_tui.app.loop_graph import loop_graph
from sar_tui.drivers import child_process
from sar_tui.loop.graph import Graph
from sar_tui.loop.session import OWN_PARTS, Parts, core_nodes
from sar_tui.loop.task import Task
from sar_tui.model.theme import Theme
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import set_up
from sar_tui.validation import charts
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row

SHARED_PACKAGES = tuple(
    f"sar_tui.{room}" for room in ("loop", "rules", "model", "inputs", "outputs", "motion")
)
LEAST = 0.75
TASKS = ("keyboard", "reaching")
FOR_A_SENSOR = {"imu", "trunk_imu", "reach_perception", "view"}
"""Parts that a task with a motion sensor needs: the sensor, what finds reaches in its samples, and
the view of them.
"""


class Loaded(msgspec.Struct, frozen=True):
    """The modules that the session of a task loads, with their files; the task's own package and
    folder.
    """

    modules: dict[str, str]
    package: str
    folder: str


class Code(NamedTuple):
    """Lines of code of a task's session, by module: shared ones, and the task's own."""

    shared: dict[str, int]
    own: dict[str, int]


class NotLoaded(Exception):
    """The session of a task cannot be run. The message says why."""


def run(conditions: Conditions) -> Report:
    """Return one row per installed task."""
    names = conditions.catalogue.task_names()
    codes: dict[str, Code] = {}
    broken = []
    for number, name in enumerate(names):
        conditions.progress(f"modularity: {name}", number, len(names))
        try:
            codes[name] = code(load(name, conditions.catalogue))
        except NotLoaded as error:
            broken.append(f"{name} cannot be counted: {error}")
    rows = [_row(name, codes) for name in codes]
    short = [f"{row['task']} {row['shared']:.0%}" for row in rows if row["shared"] < LEAST]
    claim = Claim(
        f"At least {LEAST:.0%} of the code that each task runs is shared.",
        ", ".join(short + broken),
    )
    return Report(rows, [_COLUMNS], [claim])


def load(name: str, catalogue: Catalogue) -> Loaded:
    """Run a session of a task in another process, and list what it loads. Raises NotLoaded."""
    command = child_process.python(
        "sar_tui.validation.loaded_modules", name, *map(str, catalogue.extra_tasks)
    )
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        last = done.stderr.strip().splitlines()[-1:]
        raise NotLoaded(last[0] if last else f"its session ended with {done.returncode}")
    return msgspec.json.decode(done.stdout.splitlines()[-1], type=Loaded)


def code(loaded: Loaded) -> Code:
    """Count the lines of what was loaded. Everything in a task's folder is its own, loaded or
    not.
    """
    own = {
        name: Path(file)
        for name, file in loaded.modules.items()
        if name == loaded.package or name.startswith(f"{loaded.package}.")
    }
    folder = Path(loaded.folder)
    if (folder / "task.py").is_file():
        own = {path.relative_to(folder).as_posix(): path for path in sorted(folder.rglob("*.py"))}
    shared = {
        name: Path(file)
        for name, file in loaded.modules.items()
        if name.startswith(SHARED_PACKAGES)
    }
    return Code(
        {name: source_lines(path) for name, path in shared.items()},
        {name: source_lines(path) for name, path in own.items()},
    )


def _row(name: str, codes: dict[str, Code]) -> Row:
    shared, own = codes[name]
    elsewhere = {module for other, code in codes.items() if other != name for module in code.shared}
    alone = sum(lines for module, lines in shared.items() if module not in elsewhere)
    framework_lines, own_lines = sum(shared.values()), sum(own.values())
    whole = framework_lines + own_lines
    return {
        "task": name,
        "framework_lines": framework_lines,
        "own_lines": own_lines,
        "shared": framework_lines / whole,
        "used_by_this_task_alone_lines": alone,
        "strict_shared": (framework_lines - alone) / whole,
    }


_COLUMNS = (
    Column("task", lambda row: str(row["task"]), is_number=False),
    Column("framework's lines", lambda row: str(row["framework_lines"])),
    Column("its own", lambda row: str(row["own_lines"])),
    Column("shared", lambda row: f"{row['shared']:.1%}"),
    Column("framework's, only this task", lambda row: str(row["used_by_this_task_alone_lines"])),
    Column("shared, strictly", lambda row: f"{row['strict_shared']:.1%}"),
)


_NO_CODE = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT,
    tokenize.ENCODING, tokenize.ENDMARKER,
}  # fmt: skip


def source_lines(path: Path) -> int:
    """Return the number of lines of code in a file."""
    with tokenize.open(path) as file:
        return count(file.read())


def count(source: str) -> int:
    """Return the number of lines of code. String expressions count as documentation."""
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in _NO_CODE:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Expr(value=ast.Constant(value=str())):
                lines.difference_update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return len(lines)


# --- the parts of the loop


def added_parts(conditions: Conditions) -> Report:
    """Return Figure 4.15: one row per part of the two loops: in which of them it is, and whether it is the same
    there.
    """
    theme = conditions.catalogue.theme("calm")
    kinds = {task: conditions.catalogue.task(task) for task in TASKS}
    return compared_loops(
        {task: loop_graph(kind, theme) for task, kind in kinds.items()},
        {task: node_classes(kind, theme) for task, kind in kinds.items()},
    )


def node_classes(kind: type[Task], theme: Theme, parts: Parts = OWN_PARTS) -> dict[str, str]:
    """Return the module and class of each node of a task's loop, by the node's name."""
    nodes = core_nodes(set_up(kind, build(kind.Parameters, {})), theme, 0, parts)
    return {node.name: f"{type(node).__module__}.{type(node).__name__}" for node in nodes}


def compared_loops(graphs: Mapping[str, Graph], nodes: Mapping[str, Mapping[str, str]]) -> Report:
    """Compare the loops of the two tasks, and the classes of their nodes."""
    rows = _part_rows(graphs, nodes)
    changed = [row["part"] for row in rows if row["state"] == "changed"]
    removed = [row["part"] for row in rows if not row["reaching"]]
    claims = [
        Claim("The reaching task has all parts of the keyboard task's loop.", ", ".join(removed)),
        Claim("Each of these parts is the same code in both.", ", ".join(changed)),
        Claim("It adds only parts for its sensors.", ", ".join(_needless(rows))),
    ]
    return Report(rows, [_PART_COLUMNS], claims, chart=charts.parts(rows))


def _part_rows(graphs: Mapping[str, Graph], nodes: Mapping[str, Mapping[str, str]]) -> list[Row]:
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


_PART_COLUMNS = (
    Column("part", lambda row: str(row["part"]), is_number=False),
    *map(_mark, TASKS),
    Column("in the reaching task", lambda row: str(row["state"]), is_number=False),
)
