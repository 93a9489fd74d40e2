"""Random codes and date shifts for participants, and the key of other names, in a file that stays
with the study.
"""

import csv
import hmac
import os
import re
import secrets
import sqlite3
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from datetime import date, timedelta
from pathlib import Path
from typing import TypeVar

import filelock
import msgspec

from sar_tui.export.csv_file import CsvWriter
from sar_tui.export.errors import ExportError
from sar_tui.export.target import made_beside

T = TypeVar("T")
HEAD = ("code", "recoded", "shift_days", "key")
EARLIER_HEAD = HEAD[:-1]
"""The columns of maps that earlier versions made, which recoded no ids."""
_LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"
"""Without those that look alike."""
_LENGTH = 6
_MOST_DAYS = 365
_KEY_BYTES = 16
_ID_DIGITS = 10
_SEEDS = 2**31
_LOCK_TIMEOUT_S = 10.0


class Recoded(msgspec.Struct, frozen=True):
    """A participant's code in exports, and the days by which all dates of this person are
    shifted.
    """

    code: str
    shift_days: int


class Recoding(msgspec.Struct, frozen=True):
    """All that an export with a map replaces.

    Attributes:
        people: by their codes here.
        key: makes ids and seeds, the same in all exports with the map; nobody can go back from them
            without it.
    """

    people: Mapping[str, Recoded]
    key: str

    def id(self, known_here: str) -> str:
        """Return the id of a session, or of an adverse event, as it leaves."""
        return self._digest(f"id {known_here}")[:_ID_DIGITS]

    def seed(self, seed: int) -> int:
        """Return a seed as it leaves: equal seeds stay equal."""
        return int(self._digest(f"seed {seed}"), 16) % _SEEDS

    def _digest(self, text: str) -> str:
        return hmac.new(self.key.encode(), text.encode(errors="replace"), "sha256").hexdigest()


def recoding(database: sqlite3.Connection, path: Path, codes: Iterable[str]) -> Recoding:
    """Return the codes, shifts and key of a map; participants that the file lacks are added to it.

    The dates of a person are shifted by the same number of days in all exports with this file.
    Persons who had a session together have the same shift, so that it has one date for both, unless
    both were in the file before.

    Raises:
        ExportError: the file is not one of this kind, or cannot be written.
    """
    wanted = list(codes)
    found = _read(path)
    if found.key and all(code in found.people for code in wanted) and not _left_behind(path):
        return found
    with _locked(path):
        for left in _left_behind(path):
            left.unlink(missing_ok=True)
        found = _read(path)  # again: another export may have added the same codes meanwhile
        known = dict(found.people)
        for code in wanted:
            if code not in known:
                shift = next(
                    (known[each].shift_days for each in _partners(database, code) if each in known),
                    None,
                )
                known[code] = Recoded(
                    _new_code(known), -1 - secrets.randbelow(_MOST_DAYS) if shift is None else shift
                )
        made = Recoding(known, found.key or secrets.token_hex(_KEY_BYTES))
        _write(path, made)
    return made


def _left_behind(path: Path) -> list[Path]:
    """Return the copies of a map that killed programs have left beside it: they hold its codes,
    too.
    """
    half = re.compile(rf"\.{re.escape(path.name)}\.[a-z0-9_]{{8}}")
    folder = path.absolute().parent
    return (
        [each for each in folder.iterdir() if half.fullmatch(each.name)] if folder.is_dir() else []
    )


def shuffled(values: Iterable[T]) -> list[T]:
    """Return values in an order that is drawn anew each time, and kept nowhere."""
    found = list(values)
    secrets.SystemRandom().shuffle(found)
    return found


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Keep other exports from adding to the file. Raises ExportError."""
    lock = filelock.FileLock(
        path.with_name(f".{path.name}.lock"), timeout=_LOCK_TIMEOUT_S, mode=0o600
    )
    with made_beside(path):
        try:
            with lock:
                yield
        except filelock.Timeout as error:
            raise ExportError(
                f"Another export is writing {path}. Try again when it has ended."
            ) from error


def _partners(database: sqlite3.Connection, code: str) -> list[str]:
    rows = database.execute(
        "SELECT DISTINCT other.participant FROM seats AS own JOIN seats AS other USING (session)"
        " WHERE own.participant=? AND other.participant<>own.participant ORDER BY "
        "other.participant",
        (code,),
    )
    return [other for (other,) in rows]


def _new_code(known: dict[str, Recoded]) -> str:
    taken = {each.code for each in known.values()} | set(known)
    while (made := "".join(secrets.choice(_LETTERS) for _ in range(_LENGTH))) in taken:
        pass
    return made


def _read(path: Path) -> Recoding:
    """Return what a map holds; the key is empty if there is no map, or an earlier version made
    it.
    """
    if not path.exists():
        return Recoding({}, "")
    try:
        with path.open(encoding="utf-8", newline="") as file:
            head, *rows = csv.reader(file, strict=True)
        found = {
            code: Recoded(recoded, int(days))
            for code, recoded, days, *_ in rows
            if code and recoded
        }
    except (ValueError, csv.Error) as error:
        raise _not_a_map(path) from error
    keys = {row[-1] for row in rows} if len(head) == len(HEAD) else {""}
    is_whole = all(len(row) == len(head) for row in rows) and len(
        {each.code for each in found.values()}
    ) == len(rows)
    if tuple(head) not in (HEAD, EARLIER_HEAD) or not is_whole or len(keys) > 1:
        raise _not_a_map(path)
    return Recoding(found, next(iter(keys), ""))


def _not_a_map(path: Path) -> ExportError:
    return ExportError(
        f"{path} is not a map of codes: it needs the columns {', '.join(HEAD)}, each code once, "
        "and the same key in "
        "every row. Name a file that does not exist yet to make a new map.",
        bad_input=True,
    )


def _write(path: Path, made: Recoding) -> None:
    """Write the file as a whole, for its owner only."""
    number, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.absolute().parent)
    try:
        with open(number, "w", encoding="utf-8", newline="") as file:
            writer = CsvWriter(file)
            writer.row(HEAD)
            writer.rows(
                (code, each.code, each.shift_days, made.key)
                for code, each in sorted(made.people.items())
            )
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
