"""Random codes and date shifts for participants, in a file that stays with the study."""

import csv
import os
import secrets
import sqlite3
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from datetime import date, timedelta
from pathlib import Path

import filelock
import msgspec

from sar_tui.export.errors import ExportError
from sar_tui.export.place import made_beside

HEAD = ("code", "recoded", "shift_days")
_LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"
"""Without those that look alike."""
_LENGTH = 6
_MOST_DAYS = 365
_LOCK_TIMEOUT_S = 10.0


class Recoded(msgspec.Struct, frozen=True):
    """A participant's code in exports, and the days by which all dates of this person are shifted."""

    code: str
    shift_days: int


def recoding(database: sqlite3.Connection, path: Path, codes: Iterable[str]) -> dict[str, Recoded]:
    """Return what becomes of participants' codes; those that the file lacks are added to it.

    The dates of a person are shifted by the same number of days in all exports with this file. Persons who had a
    session together have the same shift, so that it has one date for both, unless both were in the file before.

    Raises:
        ExportError: the file is not one of this kind, or cannot be written.
    """
    wanted = list(codes)
    known = _read(path)
    if all(code in known for code in wanted):
        return known
    with _locked(path):
        known = _read(path)  # again: another export may have added the same codes meanwhile
        for code in wanted:
            if code not in known:
                shift = next((known[each].shift_days for each in _partners(database, code) if each in known), None)
                known[code] = Recoded(_new_code(known), -1 - secrets.randbelow(_MOST_DAYS) if shift is None else shift)
        _write(path, known)
    return known


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Keep other exports from adding to the file. Raises ExportError."""
    lock = filelock.FileLock(path.with_name(f".{path.name}.lock"), timeout=_LOCK_TIMEOUT_S, mode=0o600)
    with made_beside(path):
        try:
            with lock:
                yield
        except filelock.Timeout as error:
            raise ExportError(f"Another export is writing {path}. Try again when it has ended.") from error


def _partners(database: sqlite3.Connection, code: str) -> list[str]:
    rows = database.execute(
        "SELECT DISTINCT other.participant FROM seats AS own JOIN seats AS other USING (session)"
        " WHERE own.participant=?1 AND other.participant<>?1 ORDER BY other.participant",
        (code,),
    )
    return [other for (other,) in rows]


def _new_code(known: dict[str, Recoded]) -> str:
    taken = {each.code for each in known.values()} | set(known)
    while (made := "".join(secrets.choice(_LETTERS) for _ in range(_LENGTH))) in taken:
        pass
    return made


def _read(path: Path) -> dict[str, Recoded]:
    if not path.exists():
        return {}
    try:
        with path.open(encoding="utf-8", newline="") as file:
            head, *rows = csv.reader(file, strict=True)
        found = {code: Recoded(recoded, int(days)) for code, recoded, days in rows if code and recoded}
    except (ValueError, csv.Error) as error:
        raise _not_a_map(path) from error
    if tuple(head) != HEAD or len({each.code for each in found.values()}) != len(rows):
        raise _not_a_map(path)
    return found


def _not_a_map(path: Path) -> ExportError:
    return ExportError(
        f"{path} is not a map of codes: it needs the columns {', '.join(HEAD)}, and each code once. Name a file that "
        "does not exist yet to make a new map.",
        bad_input=True,
    )


def _write(path: Path, known: dict[str, Recoded]) -> None:
    """Write the file as a whole, for its owner only."""
    number, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.absolute().parent)
    try:
        with open(number, "w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(HEAD)
            writer.writerows((code, each.code, each.shift_days) for code, each in sorted(known.items()))
            file.flush()
            os.fsync(file.fileno())
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def shifted(stamp: str, days: int) -> str | None:
    """Return a date, with or without the time of day, some days later; None if it is no date."""
    try:
        return f"{date.fromisoformat(stamp[:10]) + timedelta(days=days)}{stamp[10:]}"
    except (ValueError, OverflowError):
        return None
