"""Damaged values of the database: each is named, and everything else leaves."""

import sqlite3
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import islice
from typing import Any, TypeVar

from sar_tui.export.columns import Table, Values
from sar_tui.store.database import StoreError, is_not_text, read_json

T = TypeVar("T")
_NO_JSON = "malformed JSON"
"""SQLite's message about a damaged message."""
_UNREADABLE = "\ufffd"
"""Takes the place of bytes that are no text."""


def is_not_json(error: sqlite3.OperationalError) -> bool:
    """Return True if an error says that SQLite could not read a JSON value."""
    return _NO_JSON in str(error)


def with_any_text(database: sqlite3.Connection, read: Callable[[], T]) -> T:
    """Return what is read, also if the bytes of a text are not UTF-8: then texts are read so from
    now on.
    """
    try:
        return read()
    except sqlite3.OperationalError as error:
        if not is_not_text(error):
            raise
        database.text_factory = partial(str, encoding="utf-8", errors="replace")
        return read()


def _numbers(table: Table) -> list[int]:
    """Return the places of the columns of numbers. Samples, of which there are many, are never
    stored as texts.
    """
    if table.name == "imu":
        return []
    return [
        index for index, column in enumerate(table.columns) if column.type in ("integer", "number")
    ]


class Damage:
    """Reads what may be damaged, and reports what is.

    Args:
        report: is told of each damaged value, or part of a table, in a sentence.
    """

    def __init__(self, database: sqlite3.Connection, report: Callable[[str], None]) -> None:
        self._database = database
        self._report = report
        self._damaged: list[tuple[str, str | None]] = []
        self._has_bad_text = False
        if database.text_factory is not str:
            self._read_any_text()

    def object_of(self, column: str, text: str | None, where: str | None = None) -> dict[str, Any]:
        """Return the object of a JSON column; empty if there is none, or it is damaged.

        Args:
            where: the place in the table, if it is not the row that is read next.
        """
        if text is None:
            return {}
        try:
            found = read_json(text)
        except StoreError:
            self.note(column, where)
            return {}
        return found if isinstance(found, dict) else {}

    def note(self, column: str, where: str | None = None) -> None:
        """Remember that a column of the row that is being read is damaged."""
        self._damaged.append((column, where))

    def rows(
        self, table: Table, owner: str, read: Callable[[], Iterator[Values]]
    ) -> Iterator[Values]:
        """Yield the rows of a session or participant, and report the values in them that are
        damaged.

        Args:
            table: with the columns of the rows.
            owner: an id or a code, as it leaves.
            read: starts to read the rows.
        """
        count, numbers = 0, _numbers(table)
        try:
            for found in read():
                has_text = str in map(type, map(found.__getitem__, numbers))
                row = self._without_texts(table, found, numbers) if has_text else found
                if self._damaged or self._has_bad_text:
                    self._name(table, owner, row)
                yield row
                count += 1
        except sqlite3.OperationalError as error:
            if not is_not_text(error) or self._database.text_factory is not str:
                self._report_rest(table, owner, count, error)
                return
        else:
            self._name(table, owner, ())
            return
        self._read_any_text()
        yield from self.rows(table, owner, lambda: islice(read(), count, None))

    def _without_texts(self, table: Table, row: Values, numbers: Sequence[int]) -> Values:
        """Return a row with nothing where a text is stored for a number, and remember that it was
        damaged.
        """
        kept = list(row)
        for index in numbers:
            if isinstance(row[index], str):
                self.note(table.columns[index].name)
                kept[index] = None
        return tuple(kept)

    def _read_any_text(self) -> None:
        """From now on, read texts whose bytes are not UTF-8 as well. It is slower, so not before
        there is one.
        """

        def decoded(data: bytes) -> str:
            try:
                return data.decode()
            except UnicodeDecodeError:
                self._has_bad_text = True
                return data.decode(errors="replace")

        self._database.text_factory = decoded

    def _name(self, table: Table, owner: str, row: Values) -> None:
        """Report the damaged values of a row."""
        values = dict(zip((column.name for column in table.columns), row, strict=False))
        beside = ", ".join(
            f"{name} {values[name]}" for name in table.key if name in values and name != table.of
        )

        def tell(place: str, said: str) -> None:
            self._report(f"{table.name}, {table.of} {owner}{', ' if place else ''}{place}: {said}")

        for column, where in self._damaged:
            tell(
                beside if where is None else where,
                f"what is stored in {column} is damaged, and left out.",
            )
        if self._has_bad_text:
            for name, value in values.items():
                if isinstance(value, str) and _UNREADABLE in value:
                    tell(
                        beside,
                        f"the text in {name} is damaged; {_UNREADABLE} replaces what cannot be "
                        "read.",
                    )
        self._damaged.clear()
        self._has_bad_text = False

    def _report_rest(
        self, table: Table, owner: str, count: int, error: sqlite3.OperationalError
    ) -> None:
        """Report that rows are missing, if it is damage of single values; raise the error
        otherwise.
        """
        if not is_not_json(error):
            raise error
        self._report(
            f"{table.name}, {table.of} {owner}: a message is damaged, and the rows after the "
            f"first {count} are left "
            "out."
        )
