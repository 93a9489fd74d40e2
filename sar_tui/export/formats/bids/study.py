"""Sessions of a data set by subject, and their labels in file names: letters and digits only."""

import re
import unicodedata
from collections.abc import Iterable, Iterator
from datetime import datetime, timedelta
from typing import Any

import msgspec

from sar_tui.export.contents import Contents
from sar_tui.export.errors import ExportError

Row = dict[str, Any]
_RECODE = "Give --recode FILE, which makes random codes, or export them into two folders."
_APART = "Export their sessions into two folders."


class Run(msgspec.Struct, frozen=True):
    """A run of the program on a session.

    Attributes:
        clock_ns: the steady clock of the run at its start, from which times are counted; None if it
            is not recorded.
        utc: the time of day at that moment.
    """

    number: int
    clock_ns: int | None = None
    utc: str | None = None

    def time_of_day(self, at_ns: int | None) -> str | None:
        """Return the time of day at a stamp of the run's clock; None if it is not known."""
        if self.utc is None or self.clock_ns is None or at_ns is None:
            return None
        try:
            then = datetime.fromisoformat(self.utc) + timedelta(
                microseconds=(at_ns - self.clock_ns) // 1000
            )
        except (ValueError, OverflowError):
            return None
        return then.isoformat()


class Session(msgspec.Struct, frozen=True):
    """A session of one subject; a session of two persons is one of each.

    Attributes:
        id: in the database.
        row: in the table of sessions.
        subject, label, task_label: as in file names.
        partner: the other subject; empty if there is none.
        runs: by number.
    """

    id: str
    seat: str
    row: Row
    subject: str
    label: str
    task: str
    task_label: str
    partner: str
    runs: dict[int, Run]

    @property
    def folder(self) -> str:
        """The folder of the session in the data set."""
        return f"sub-{self.subject}/ses-{self.label}"

    @property
    def stem(self) -> str:
        """The beginning of the names of its files."""
        return f"sub-{self.subject}_ses-{self.label}"

    def path(self, datatype: str, suffix: str, run: int, *, tracksys: str = "") -> str:
        """Return the path of a file of the session, relative to its folder."""
        tracked = f"_tracksys-{tracksys}" if tracksys else ""
        return f"{datatype}/{self.stem}_task-{self.task_label}{tracked}_run-{run}_{suffix}"


class Study:
    """The sessions of an export, by subject.

    Attributes:
        subjects: labels by the codes of participants.
        tasks: labels by the names of tasks.
        sessions: in the order of the export.

    Raises:
        ExportError: names that BIDS cannot tell apart.
    """

    def __init__(self, contents: Contents) -> None:
        self._contents = contents
        self._tables = {table.name: table for table in contents.tables}
        found = [
            row for session in self.owners("sessions") for row in self.rows("sessions", session)
        ]
        self.subjects = labels("Participants", "sub", self.owners("participants"), _RECODE)
        self.tasks = labels("Tasks", "task", dict.fromkeys(row["task"] for row in found), _APART)
        names = {row["session"]: _name(row) for row in found}
        sessions = labels("Sessions", "ses", names.values(), _APART)
        self.sessions: list[Session] = []
        for row in found:
            codes = {
                seat: row[name]
                for seat, name in (("A", "participant"), ("B", "partner"))
                if row[name]
            }
            for seat, code in codes.items():
                others = [self.subjects[other] for place, other in codes.items() if place != seat]
                self.sessions.append(
                    Session(
                        id=row["session"],
                        seat=seat,
                        row=row,
                        subject=self.subjects[code],
                        label=sessions[names[row["session"]]],
                        task=row["task"],
                        task_label=self.tasks[row["task"]],
                        partner=others[0] if others else "",
                        runs=self._runs(row["session"]),
                    )
                )

    def owners(self, table: str) -> list[str]:
        """Return the sessions, or the codes of participants, that a table has rows of."""
        return self._contents.owners(self._tables[table])

    def columns(self, table: str) -> tuple[Any, ...]:
        """Return the columns of a table."""
        return self._tables[table].columns

    def values(self, table: str, owner: str) -> Iterator[tuple[Any, ...]]:
        """Yield the rows of a session, or of a participant, in a table."""
        return self._contents.rows(self._tables[table], owner)

    def rows(self, table: str, owner: str) -> Iterator[Row]:
        """Yield the same as dictionaries."""
        names = [column.name for column in self._tables[table].columns]
        return (dict(zip(names, values, strict=True)) for values in self.values(table, owner))

    def _runs(self, session: str) -> dict[int, Run]:
        found = {
            row["run"]: Run(row["run"], row["clock_ns"], row["clock_utc"])
            for row in self.rows("runs", session)
        }
        return found or {1: Run(1)}


def _name(session: Row) -> str:
    """Return the visit and the block of a session of a study, and its id; of another one its id."""
    place = (session.get(name) for name in ("visit", "block"))
    return " ".join([*filter(None, place), session["session"]])


def label(text: str) -> str:
    """Return the letters and digits of a text, without accents."""
    return re.sub(r"[^0-9A-Za-z]", "", unicodedata.normalize("NFKD", text))


def labels(kind: str, prefix: str, names: Iterable[str], advice: str) -> dict[str, str]:
    """Return the labels of names, by name.

    Args:
        kind: of the names, in the plural: "Participants".
        prefix: of the label in a file name: "sub".
        advice: what to do about names that cannot be told apart.

    Raises:
        ExportError: two names would have the same label, or labels that differ only in capital
            letters, or one has no letter and no digit.
    """
    found: dict[str, str] = {}
    names_by_label: dict[str, str] = {}
    for name in names:
        found[name] = made = label(name)
        if not made:
            raise ExportError(
                f"{kind}: “{name}” has no letter or digit that BIDS takes. {advice}", bad_input=True
            )
        other = names_by_label.setdefault(made.casefold(), name)
        if other != name:
            raise ExportError(
                f"{kind} {other} and {name} would both be {prefix}-{made} in BIDS, which takes "
                "only letters and "
                f"digits. {advice}",
                bad_input=True,
            )
    return found
