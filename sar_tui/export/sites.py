"""Exports of many sites in one folder: each site has a folder of its own in it, which only its data replace."""

import sqlite3
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from sar_tui.export.errors import ExportError
from sar_tui.export.target import MANIFEST
from sar_tui.store import sites
from sar_tui.store.selection import Selection

_FOLDER = "site="


class Part(NamedTuple):
    """Sessions that are exported into a folder. ``of_site``: as in `privacy.Privacy`."""

    folder: Path
    selection: Selection
    of_site: tuple[str, str] | None = None


class _Manifest(msgspec.Struct):
    """The sessions of an earlier export."""

    sessions: list[str] = []


def check_sites(folder: Path, format: str) -> None:
    """Raise ExportError unless a folder is absent, empty, or holds folders of sites and nothing else."""
    if not folder.exists():
        return
    if not folder.is_dir():
        raise ExportError(f"{folder} is a file. Name a folder that does not exist yet, or is empty.", bad_input=True)
    for path in sorted(folder.iterdir()):
        if not path.name.startswith((_FOLDER, f".{_FOLDER}")):
            raise ExportError(
                f"{folder} holds other files than {format} data of sites, such as {path.name}. Name another folder.",
                bad_input=True,
            )


def parts(database: sqlite3.Connection, selection: Selection, folder: Path) -> list[Part]:
    """Divide sessions by the site that recorded them.

    Raises:
        ExportError: this database has no site code, or the folder holds sessions of one of these sites that this
            database does not have.
    """
    here = sites.own(database)
    if not here:
        raise ExportError(
            "The data of each site are in a folder of its own, and this site has no code yet. Give it one: "
            "sar-tui site BERN.",
            bad_input=True,
        )
    found: dict[str, list[dict[str, Any]]] = {}
    for row in selection.sessions:
        found.setdefault(sites.of_session(database, row["id"]), []).append(row)
    made = []
    for site, rows in sorted(found.items()):
        place = folder / f"{_FOLDER}{site}"
        if unknown := _unknown(database, place):
            raise ExportError(
                f"{place} holds {unknown} session{'' if unknown == 1 else 's'} that this database does not have, so it "
                "is not replaced. Is there another database of this site, or an older copy? Merge them first, or name "
                "another folder.",
                bad_input=True,
            )
        made.append(Part(place, Selection(tuple(rows)), (site, here)))
    return made


def _unknown(database: sqlite3.Connection, place: Path) -> int:
    """Return the number of sessions in the export in a folder that are not in a database."""
    try:
        manifest = msgspec.json.decode((place / MANIFEST).read_bytes(), type=_Manifest)
    except (OSError, msgspec.MsgspecError):
        return 0
    known = {id for (id,) in database.execute("SELECT id FROM sessions")}
    return len(set(manifest.sessions) - known)
