"""Exports sessions in a test, and reads the files as other programs do."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sar_tui.export.export import Exported, Options, export
from sar_tui.export.registry import load
from sar_tui.plugins import Catalogue
from sar_tui.store.database import connect_to_read
from sar_tui.store.selection import Request

ALL = Request(everything=True, mixed=True)


def no_bar(steps: int) -> Callable[[], None]:
    return lambda: None


def export_csv(data: Path, folder: Path, request: Request = ALL, **options: Any) -> Exported:
    return export_as("csv", data, folder, request, **options)


def export_as(
    format: str, data: Path, folder: Path, request: Request = ALL, **options: Any
) -> Exported:
    database = connect_to_read(data)
    try:
        return export(
            database, data, Catalogue(), request, load(format), folder, no_bar, Options(**options)
        )
    finally:
        database.close()


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
