"""Psych-DS: a CSV file a table with keywords in its name, and JSON-LD that describes every
column.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from sar_tui import __version__
from sar_tui.export.columns import Column, Table
from sar_tui.export.contents import Contents, dataset_name
from sar_tui.export.formats.csv import write_table

_CONTEXT = "https://schema.org/"
_VERSION = "Psych-DS 0.4.0"
_DATA = "data"
_BESIDE = ("timing.json", "methods.md", "sar-tui-export.json")
"""Files that every export has beside those of its format."""
_README = """\
# {name}

{description}

| File in `data/` | A row is | A row's key |
|---|---|---|
{tables}

`dataset_description.json` describes every column; the JSON beside a file, the columns of that file. A missing value is
an empty field, booleans are true or false. `mode` tells live sessions from simulated ones, and `practice` marks
practice. Interrupted, dismissed and empty sessions are included; `status` in the table of sessions tells them apart.
Sessions that are discarded (started by mistake) or refused belong into no analysis of training.

`methods.md`, `timing.json` and `sar-tui-export.json` are the methods in words, the measured timing of the machine, and
the SHA-256 of every file; they are named in `.psychdsignore`.

Add the authors, the licence and keywords to `dataset_description.json` before you publish.
"""


class PsychDsFormat:
    """A Psych-DS data set: the files of the format ``csv`` with other names, and another
    description.
    """

    name = "psych-ds"
    title = "a Psych-DS data set: a CSV file a table, with JSON-LD"

    def write(self, contents: Contents, folder: Path, progress: Callable[[], None]) -> None:
        """Write a file and its description for each table, and the description of the data set."""
        data = folder / _DATA
        data.mkdir()
        for table in contents.tables:
            path = data / _file(table)
            write_table(path, table, contents, progress)
            variables = [_variable(column.name, column.meaning, column) for column in table.columns]
            _write_json(path.with_suffix(".json"), {"variableMeasured": variables})
        name = dataset_name(_modes(contents))
        description = f"{name}, with a social agent. Exported by sar-tui {__version__}."
        _write_json(
            folder / "dataset_description.json",
            {
                "@context": _CONTEXT,
                "@type": "Dataset",
                "name": name,
                "description": description,
                "schemaVersion": _VERSION,
                "variableMeasured": _all_variables(contents.tables),
            },
        )
        rows = (
            f"| `{_file(table)}` | {table.title} | {', '.join(table.key) or 'none'} |"
            for table in contents.tables
        )
        readme = _README.format(name=name, description=description, tables="\n".join(rows))
        if contents.notices:
            readme += "".join(
                ["\n## Not described\n\n", *(f"- {notice}\n" for notice in contents.notices)]
            )
        (folder / "README.md").write_text(readme, encoding="utf-8")
        (folder / ".psychdsignore").write_text(
            "".join(f"{each}\n" for each in _BESIDE), encoding="utf-8"
        )


def _file(table: Table) -> str:
    """Return the name of a table's file: keywords and values of letters and digits."""
    label = re.sub(r"_([a-z])", lambda found: found[1].upper(), table.name)
    return f"description-{label}_data.csv"


def _modes(contents: Contents) -> set[str]:
    (table,) = (table for table in contents.tables if table.name == "sessions")
    mode = [column.name for column in table.columns].index("mode")
    return {
        row[mode] for session in contents.owners(table) for row in contents.rows(table, session)
    }


def _all_variables(tables: Iterable[Table]) -> list[Mapping[str, Any]]:
    """Return every column once; one with several meanings has them all, each with its tables."""
    columns: dict[str, Column] = {}
    meanings: dict[str, dict[str, list[str]]] = {}
    for table in tables:
        for column in table.columns:
            columns.setdefault(column.name, column)
            meanings.setdefault(column.name, {}).setdefault(column.meaning, []).append(table.name)
    return [
        _variable(name, next(iter(told)), columns[name])
        if len(told) == 1
        else _variable(
            name, " ".join(f"In {', '.join(where)}: {meaning}" for meaning, where in told.items())
        )
        for name, told in meanings.items()
    ]


def _variable(name: str, meaning: str, column: Column | None = None) -> Mapping[str, Any]:
    """Return the description of a column by schema.org; of one with several meanings only the name
    and the meanings.
    """
    return {
        "@type": "PropertyValue",
        "name": name,
        "description": meaning,
        **({"unitText": column.unit} if column and column.unit else {}),
        **({"valueReference": list(column.levels)} if column and column.levels else {}),
    }


def _write_json(path: Path, content: Mapping[str, Any]) -> None:
    path.write_bytes(msgspec.json.format(msgspec.json.encode(content)) + b"\n")
