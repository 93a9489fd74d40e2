"""The tables of docs/data-dictionary.md, made from what the program declares."""

from collections.abc import Iterator
from pathlib import Path

from sar_tui.export.json_columns import declared_keys
from sar_tui.plugins import Catalogue
from sar_tui.store.tables import TABLES, Column, Table

PAGE = Path(__file__).parents[1] / "docs" / "data-dictionary.md"
MEASURES = PAGE.with_name("movement-measures.md")
BEGIN = "<!-- made by tests/test_data_dictionary.py from sar_tui/store/tables.py: begin -->\n"
END = "<!-- end -->\n"
_TASKS = ("keyboard", "pairs", "reaching")
"""Tasks whose details are not told by their names alone."""


def tables(catalogue: Catalogue) -> str:
    """Return the part of the page about the tables."""
    common = _common()
    lines = ["In several tables:\n", *(_line(column) for column in common), ""]
    for table in TABLES.values():
        lines += [f"### {table.name}\n", *_about(table, common), ""]
        if table.name == "trials":
            lines += _details(catalogue)
    return "\n".join(lines)


def with_tables(page: str, made: str) -> str:
    """Return the page with this part about the tables."""
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    return f"{before}{BEGIN}\n{made}{END}{after}"


def _common() -> list[Column]:
    """Return the columns that two tables or more have, with the same meaning."""
    known: dict[tuple[str, str, str], list[Column]] = {}
    for table in TABLES.values():
        for column in table.columns:
            known.setdefault((column.name, column.meaning, column.more), []).append(column)
    return [columns[0] for columns in known.values() if len(columns) >= 2]


def _about(table: Table, common: list[Column]) -> Iterator[str]:
    said = {(column.name, column.meaning, column.more) for column in common}
    shared = [c.name for c in table.columns if (c.name, c.meaning, c.more) in said]
    yield " ".join(filter(None, (f"{table.row}.", table.more, _names("Key", table.key))))
    yield ""
    if shared:
        yield f"- {_code(shared)}"
    for column in table.columns:
        if column.name not in shared:
            yield _line(column)
            for part in column.parts:
                yield f"  {_line(part)}"


def _line(column: Column) -> str:
    meaning = column.meaning.replace(", axis {axis}", ", x, y, z")
    if column.name.endswith("_ns"):
        meaning = meaning.replace(", steady clock of the run", "")
    unsaid = [level for level in column.levels if level not in f"{meaning} {column.more}".lower()]
    unit = "" if not column.unit or column.unit in column.name else f" ({column.unit})"
    parts = (meaning, _names("", unsaid), column.more)
    return f"- `{column.name}`{unit}: {' '.join(filter(None, parts))}"


def _names(title: str, names: list[str] | tuple[str, ...]) -> str:
    if not names:
        return ""
    return f"{title}: {_code(names)}." if title else f"{_code(names)}."


def _code(names: list[str] | tuple[str, ...]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _details(catalogue: Catalogue) -> Iterator[str]:
    measures = MEASURES.read_text(encoding="utf-8")
    for name in _TASKS:
        declared = declared_keys(catalogue.task(name).Details)
        yield f"`details` of the task {name}:\n"
        for key, found in declared.items():
            if name == "keyboard" or f"`{key}`" not in measures:
                yield f"- `{key}`: {found.meaning}"
        if name != "keyboard":
            yield "- the others: [movement measures](movement-measures.md)"
        yield ""
