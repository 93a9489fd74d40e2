"""Division of sessions by the site that recorded them, for a folder in which the exports of many
sites are one.
"""

import sqlite3
from contextlib import nullcontext
from pathlib import Path
from typing import Any, NamedTuple

from sar_tui.export.errors import ExportError
from sar_tui.export.recoding import Recoding
from sar_tui.export.site_target import about, check_folder, earlier, settled
from sar_tui.store import sites
from sar_tui.store.selection import Selection

NAMELESS = "local"
"""Stands for the site of a database that has no code. The codes of others are in capital
letters.
"""


class Part(NamedTuple):
    """Sessions that are exported together.

    Attributes:
        of_site: as in `privacy.Privacy`.
        about: the place of methods, timing and manifest in the export.
        replaces: sites whose earlier data are the same, under another name.
    """

    selection: Selection
    of_site: tuple[str, str] | None = None
    about: Path = Path()
    replaces: tuple[str, ...] = ()

    @property
    def site(self) -> str:
        """The site; empty if the sessions are not divided by site."""
        return self.of_site[0] if self.of_site else ""


def parts(
    database: sqlite3.Connection,
    selection: Selection,
    folder: Path,
    recoded: Recoding | None = None,
) -> list[Part]:
    """Divide sessions by the site that recorded them.

    Args:
        recoded: how ids leave; None: as they are.

    Raises:
        ExportError: the folder holds sessions of one of these sites that this database does not
            have, or other files.
    """
    here = sites.own(database) or NAMELESS
    known = {id for (id,) in database.execute("SELECT id FROM sessions")}
    if recoded is not None:  # an earlier export may have been made without the map
        known |= set(map(recoded.id, known))
    found: dict[str, list[dict[str, Any]]] = {}
    for row in selection.sessions:
        found.setdefault(sites.of_session(database, row["id"]) or NAMELESS, []).append(row)
    with settled(folder) if folder.exists() else nullcontext():
        return _checked(found, folder, known, here)


def _checked(
    found: dict[str, list[dict[str, Any]]], folder: Path, known: set[str], here: str
) -> list[Part]:
    """Return the parts of an export if each may replace what the folder holds of its site. Raises
    ExportError.
    """
    made = []
    for site, rows in sorted(found.items()):
        check_folder(folder, site)
        if unknown := len(_sessions(folder, site) - known):
            raise ExportError(
                f"{folder} holds {unknown} session{'' if unknown == 1 else 's'} of the site "
                f"{site} that this database "
                "does not have, so the site's data are not replaced. Is there another database of "
                "this site, or an "
                "older copy? Give each a code (sar-tui site BERN), or merge them, or name another "
                "folder. Were they "
                "exported with --recode? Give the same map of codes.",
                bad_input=True,
            )
        is_renamed = (
            site == here != NAMELESS and bool(old := _sessions(folder, NAMELESS)) and old <= known
        )
        made.append(
            Part(
                Selection(tuple(rows)), (site, here), about(site), (NAMELESS,) if is_renamed else ()
            )
        )
    return made


def _sessions(folder: Path, site: str) -> set[str]:
    """Return the sessions of a site's earlier export into a folder."""
    made = earlier(folder, site)
    return set(made.sessions) if made else set()
