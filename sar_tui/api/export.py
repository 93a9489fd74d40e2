"""For a format of exports: its contract, and the tables that it writes."""

from typing import TYPE_CHECKING

from sar_tui.api._names import names_on_demand
from sar_tui.export.columns import Column, Reference, Table, Values
from sar_tui.export.contents import Contents
from sar_tui.export.errors import ExportError
from sar_tui.export.registry import Format

__all__ = ["Column", "Contents", "ExportError", "Format", "Reference", "Table", "Values"]

RETIRED: dict[str, str] = {}

if not TYPE_CHECKING:
    __getattr__ = names_on_demand(__name__, {}, RETIRED)
