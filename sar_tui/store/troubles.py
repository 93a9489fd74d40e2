"""Troubles with the data that a person must know of: rescue files that wait, and data that was
lost.
"""

import os
import sqlite3
from pathlib import Path

from sar_tui.model.language import ENGLISH, Language
from sar_tui.store.database import RESCUE, SAVED


def troubles(database: sqlite3.Connection, folder: Path, tr: Language = ENGLISH) -> list[str]:
    """Return a sentence or two for each trouble."""
    if not may_have_any(folder):
        return []
    from sar_tui.store.rescue import rescue_files
    from sar_tui.store.safeguard import losses

    return [
        *(
            tr(
                "{path} holds data that is not in the database. `sar-tui rescue` brings it back.",
                path=path,
            )
            for path in rescue_files(folder)
        ),
        *(
            f"{loss} {tr('Restore a backup, or delete {path} to accept it.', path=loss.note)}"
            for loss in losses(database, folder)
        ),
    ]


def may_have_any(folder: Path) -> bool:
    """Look for troubles by the names of files only, which every command has time for."""
    try:
        with os.scandir(folder) as entries:
            names = [entry.name for entry in entries]
        return any(name.startswith(RESCUE) for name in names) or (
            SAVED in names and bool(os.listdir(folder / SAVED))
        )
    except OSError:
        return False
