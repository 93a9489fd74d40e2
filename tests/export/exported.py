"""Exports sessions in a test, and reads the files as other programs do."""

import csv
import json
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from sar_tui.export.export import Exported, Options, export
from sar_tui.export.registry import Format, load
from sar_tui.store.database import connect_to_read
from sar_tui.store.selection import Request
from tests.played import catalogue

ALL = Request(everything=True, mixed=True)


def no_bar(steps: int) -> Callable[[], None]:
    return lambda: None


def export_csv(data: Path, folder: Path, request: Request = ALL, **options: Any) -> Exported:
    return export_as("csv", data, folder, request, **options)


def export_as(
    form: str | Format, data: Path, folder: Path, request: Request = ALL, **options: Any
) -> Exported:
    """Export sessions in a format, or in the format of a name."""
    made = load(form) if isinstance(form, str) else form
    with closing(connect_to_read(data)) as database:
        given = Options(**options)
        return export(database, data, catalogue(), request, made, folder, no_bar, given)


def csv_of(data: Path, table: str, **options: Any) -> list[dict[str, Any]]:
    """Export sessions as CSV files into a folder of its own, and return the rows of a table."""
    with TemporaryDirectory() as folder:
        export_csv(data, Path(folder) / "out", **options)
        return read_csv(Path(folder) / "out", table)


def read_csv(folder: Path, table: str) -> list[dict[str, Any]]:
    """Return the rows of a table with the types that ``datapackage.json`` declares, None for an
    empty field.
    """
    package = json.loads((folder / "datapackage.json").read_text("utf-8"))
    (resource,) = (each for each in package["resources"] if each["name"] == table)
    types = {field["name"]: _READ[field["type"]] for field in resource["schema"]["fields"]}
    with (folder / resource["path"]).open(encoding="utf-8", newline="") as file:
        return [
            {name: types[name](text) if text else None for name, text in row.items()}
            for row in csv.DictReader(file, strict=True)
        ]


_READ: dict[str, Callable[[str], Any]] = {
    "string": str,
    "datetime": str,
    "integer": int,
    "number": float,
    "boolean": {"true": True, "false": False}.__getitem__,
}
