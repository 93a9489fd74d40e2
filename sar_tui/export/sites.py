"""The exports of many sites in one folder, each site's complete or absent."""

import shutil
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any, NamedTuple

import filelock
import msgspec

from sar_tui.drivers.files import make_private, sync_folder
from sar_tui.export.errors import ExportError
from sar_tui.export.recoding import Recoding
from sar_tui.export.target import LOCK, MANIFEST, is_locked, made_beside
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


SITE = "site="
ABOUT = "_sites"
"""The folder of what describes the exports. Programs that read data sets pass over names that begin
like this.
"""
_COMPLETE = ".complete"
"""Ending of the hidden folder's name when all files are written."""
_BEFORE = ".before"
"""In the hidden folder: the earlier files, until they are removed."""
_MOVING = ".sar-tui-lock"
"""Held while files are moved."""


class _File(msgspec.Struct):
    path: str


class Earlier(msgspec.Struct):
    """The parts of a site's manifest that say what it holds, and which other site it takes the
    place of.
    """

    files: list[_File]
    sessions: list[str] = []
    replaces: list[str] = []


def about(site: str) -> Path:
    """Return the place of a site's manifest, relative to the folder."""
    return Path(ABOUT) / f"{SITE}{site}"


def earlier(folder: Path, site: str) -> Earlier | None:
    """Return what a site exported into a folder; None if nothing."""
    try:
        return msgspec.json.decode((folder / about(site) / MANIFEST).read_bytes(), type=Earlier)
    except (OSError, msgspec.MsgspecError):
        return None


@contextmanager
def site_target(folder: Path, site: str) -> Iterator[Path]:
    """Give a hidden folder to write a site's files into; they take the place of its earlier ones at
    the end.

    The block calls `target.sync` when all files are written.

    Raises:
        ExportError: the folder cannot be made, or holds other files than such exports.
    """
    folder = folder.resolve()
    check_folder(folder)
    with made_beside(folder):
        make_private(folder)
    with settled(folder):
        pass
    _remove_left_behind(folder, site)
    hidden = Path(tempfile.mkdtemp(prefix=_prefix(site), dir=folder))
    lock = filelock.FileLock(hidden / LOCK, mode=0o600)
    try:
        lock.acquire(blocking=False)
        yield hidden
        with settled(folder):
            check_folder(folder, site)
            lock.release()
            (hidden / LOCK).unlink(missing_ok=True)
            hidden.rename(folder / f".{SITE}{site}{_COMPLETE}")
            sync_folder(folder)
            _move_complete(folder)
    except BaseException:
        lock.release()
        shutil.rmtree(hidden, ignore_errors=True)
        raise


def check_folder(folder: Path, site: str | None = None) -> None:
    """Raise ExportError unless a folder is absent, or holds exports of sites only, and of this site
    no other files.
    """
    if not folder.exists():
        return
    if not folder.is_dir():
        raise ExportError(
            f"{folder} is a file. Name a folder that does not exist yet, or is empty.",
            bad_input=True,
        )
    for path in sorted(folder.iterdir()):
        if path.name.startswith("."):
            continue
        other = (
            next((each for each in path.iterdir() if not _is_sites(each)), None)
            if path.is_dir()
            else path
        )
        if other is not None:
            raise ExportError(
                f"{folder} holds other files than exports of sites, such as "
                f"{other.relative_to(folder)}. Name another "
                "folder.",
                bad_input=True,
            )
    if site is None:
        return
    made = earlier(folder, site)
    known = {file.path for file in made.files} if made else set()
    for place in sorted(folder.glob(f"*/{SITE}{site}")):
        for path in sorted(place.rglob("*")):
            name = path.relative_to(folder).as_posix()
            if path.is_file() and name not in known and path.name != MANIFEST:
                raise ExportError(
                    f"{folder} holds an earlier export of this site, and files that are not of "
                    f"it, such as {name}. "
                    "Move them, or name another folder.",
                    bad_input=True,
                )


def _is_sites(path: Path) -> bool:
    return (path.is_dir() and path.name.startswith(SITE)) or path.name.startswith(".")


def _prefix(site: str) -> str:
    return f".{SITE}{site}.sar-tui-"


@contextmanager
def settled(folder: Path) -> Iterator[None]:
    """Keep other exports from moving files while the block runs; what a killed one left to move is
    moved before.
    """
    with filelock.FileLock(folder / _MOVING, mode=0o666):
        _move_complete(folder)
        yield


def _move_complete(folder: Path) -> None:
    """Move the files of complete exports to their places; what another program began is done to its
    end.
    """
    for complete in sorted(folder.glob(f".{SITE}*{_COMPLETE}")):
        _move(complete, complete.name.removeprefix(f".{SITE}").removesuffix(_COMPLETE))


def _move(complete: Path, site: str) -> None:
    """Move a site's files from the hidden folder. Begins where a program that was killed has
    stopped.
    """
    folder = complete.parent
    made = earlier(complete, site)
    if made is not None:  # it is moved last
        tables = {Path(file.path).parts[0] for file in made.files} - {ABOUT}
        for each in (site, *made.replaces):
            for place in sorted(folder.glob(f"*/{SITE}{each}")):
                if each != site or place.parent.name not in {*tables, ABOUT}:
                    _set_aside(place, complete)
        for table in (*sorted(tables), ABOUT):
            new, place = complete / table / f"{SITE}{site}", folder / table / f"{SITE}{site}"
            if new.exists():
                _set_aside(place, complete)
                _make_like(folder, place.parent)
                new.rename(place)
                sync_folder(place.parent)
        sync_folder(folder)
    shutil.rmtree(complete)


def _make_like(folder: Path, table: Path) -> None:
    """Make the folder of a table, for those who may write into the folder: each site may have its
    own login.
    """
    if not table.exists():
        table.mkdir()
        table.chmod(folder.stat().st_mode & 0o777)


def _set_aside(place: Path, complete: Path) -> None:
    if place.exists():
        aside = complete / _BEFORE / place.parent.name
        aside.mkdir(parents=True, exist_ok=True)
        place.rename(aside / place.name)


def _remove_left_behind(folder: Path, site: str) -> None:
    """Remove hidden folders that killed exports of a site left before they were complete."""
    for path in folder.glob(f"{_prefix(site)}*"):
        if not is_locked(path):
            shutil.rmtree(path, ignore_errors=True)
