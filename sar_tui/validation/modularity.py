"""The share of common code in a task's session (the fourth requirement of the thesis: 70 to 80 %).

It compares the lines of code in the modules that a session of the task loads: those of the
framework, inputs, outputs and movement science with those in the task's own folder. The app, the
database and the simulated participant are left out: all tasks share them, and they would only raise
the figure.
"""

import ast
import io
import subprocess
import tokenize
from pathlib import Path
from typing import NamedTuple

import msgspec

from sar_tui.drivers import child_process
from sar_tui.plugins import Catalogue
from sar_tui.validation.report import Claim, Column, Conditions, Report, Row

SHARED_PACKAGES = tuple(
    f"sar_tui.{room}" for room in ("loop", "rules", "model", "inputs", "outputs", "motion")
)
LEAST = 0.75


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
