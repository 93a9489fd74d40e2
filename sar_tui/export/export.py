"""Exports sessions: selects them, and lets a format write them into a folder that is complete or absent."""

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from sar_tui.export.contents import Contents
from sar_tui.export.manifest import write_manifest
from sar_tui.export.privacy import Privacy
from sar_tui.export.registry import Format
from sar_tui.export.selection import Request, select
from sar_tui.export.target import check, target

if TYPE_CHECKING:
    from sar_tui.plugins import Catalogue


class Exported(msgspec.Struct, frozen=True, kw_only=True):
    """Result of an export.

    Attributes:
        sessions: the ids of those that it holds.
        left_out: columns that did not leave.
        problems: a sentence on each session, or part of one, that it lacks.
        manifest: SHA-256 of the manifest.
    """

    folder: str
    format: str
    sessions: list[str]
    left_out: list[str]
    problems: list[str]
    manifest: str


Start = Callable[[int], Callable[[], None]]
"""Called with a number of steps; returns what is called after each."""


def export(
    database: sqlite3.Connection,
    data: Path,
    catalogue: "Catalogue",
    request: Request,
    format: Format,
    folder: Path,
    start: Start,
    *,
    with_notes: bool = False,
    with_events: bool = False,
) -> Exported:
    """Export sessions into a folder.

    Args:
        data: the data folder of the database.
        folder: made, or replaced if it holds an earlier export in the same format.
        start: for a progress bar.
        with_notes: texts that somebody may have typed leave, too.
        with_events: with a row for each message of the sessions.

    Raises:
        ExportError: nothing can be exported, or not there.
        StoreError: a session does not exist, or the database cannot be read.
    """
    check(folder.resolve(), format.name)
    with _snapshot(database):
        selection = select(database, data, request)
        contents = Contents(database, selection, Privacy(with_notes), catalogue, with_events=with_events)
        with target(folder, format.name) as hidden:
            format.write(contents, hidden, start(contents.steps))
            problems = [*selection.refused, *contents.problems]
            manifest = write_manifest(
                hidden,
                format=format.name,
                created=datetime.now(UTC).isoformat(timespec="seconds"),
                options={"with_notes": with_notes, "with_events": with_events},
                sessions=selection.ids,
                left_out=contents.left_out,
                problems=problems,
            )
    return Exported(
        folder=str(folder),
        format=format.name,
        sessions=selection.ids,
        left_out=contents.left_out,
        problems=problems,
        manifest=manifest,
    )


@contextmanager
def _snapshot(database: sqlite3.Connection) -> Iterator[None]:
    """Read the database as it is now, whatever other programs write meanwhile."""
    database.execute("BEGIN")
    try:
        yield
    finally:
        database.execute("ROLLBACK")
