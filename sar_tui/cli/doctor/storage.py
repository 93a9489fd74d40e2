"""The database, and the disk that it is on."""

import os
import shutil
from contextlib import closing
from pathlib import Path

from sar_tui.cli.common import Home
from sar_tui.cli.doctor.finding import Finding, State

_MEGABYTE = 1_000_000
_LITTLE, _TOO_LITTLE = 500 * _MEGABYTE, 20 * _MEGABYTE


def database(home: Home) -> Finding:
    """Check that the database can be opened and is not damaged."""
    from sar_tui.store.database import FILE, StoreError, connect

    try:
        with closing(connect(home.folder)) as opened:
            (version,) = opened.execute("PRAGMA user_version").fetchone()
            (state,) = opened.execute("PRAGMA quick_check(1)").fetchone()
    except StoreError as error:
        return Finding(
            "Data", "bad", str(error), "Choose another folder with --data or SAR_TUI_DATA."
        )
    path = home.folder / FILE
    if state != "ok":
        return Finding(
            "Data",
            "bad",
            f"{path} is damaged: {state}.",
            "Restore a backup, or save what can be read: `sar-tui check --repair`.",
        )
    return Finding("Data", "ok", f"{path}, data version {version}, can be written to")


def saved_data(folder: Path) -> Finding:
    """Check that the database has all that was saved."""
    from sar_tui.store.database import FILE, SAVED, StoreError, connect_to_read
    from sar_tui.store.rescue import rescue_files
    from sar_tui.store.safeguard import losses

    if files := rescue_files(folder):
        found = f"{', '.join(map(str, files))}: holds data that is not in the database."
        return Finding("Saved data", "bad", found, "Run `sar-tui rescue`, which brings it back.")
    if not any(os.path.exists(folder / name) for name in (FILE, SAVED)):
        return Finding("Saved data", "ok", "nothing was saved yet")
    try:
        with closing(connect_to_read(folder)) as opened:
            lost = losses(opened, folder)
    except StoreError as error:
        return Finding("Saved data", "bad", str(error))
    if not lost:
        return Finding("Saved data", "ok", "all that was saved is in the database")
    notes = " and ".join(str(loss.note) for loss in lost)
    advice = (
        "The log of the database was damaged or deleted. Restore a backup, or delete "
        f"{notes} to accept it."
    )
    return Finding("Saved data", "bad", " ".join(map(str, lost)), advice)


def disk_space(folder: Path) -> Finding:
    """Check that the disk of the data folder has room."""
    place = next(
        existing for existing in (folder.resolve(), *folder.resolve().parents) if existing.exists()
    )
    free = shutil.disk_usage(place).free
    found = (
        f"{free / 1000 / _MEGABYTE:.1f} GB free"
        if free > 1000 * _MEGABYTE
        else f"{free / _MEGABYTE:.0f} MB free"
    )
    state: State = "bad" if free < _TOO_LITTLE else "care" if free < _LITTLE else "ok"
    return Finding(
        "Disk space",
        state,
        found,
        "" if state == "ok" else "Free some space: a full disk pauses a session.",
    )
