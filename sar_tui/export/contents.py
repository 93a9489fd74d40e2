"""The contents of an export, as every format gets them: tables whose rows come from the database
one by one.
"""

import re
import sqlite3
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from copy import copy
from functools import partial
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import msgspec

from sar_tui.export.columns import Table, Values
from sar_tui.export.damage import Damage
from sar_tui.export.json_columns import Declared, declared_keys
from sar_tui.export.passports import Passport
from sar_tui.export.privacy import Privacy
from sar_tui.export.run_time import run_starts
from sar_tui.export.tables.agent import actions, outputs
from sar_tui.export.tables.answers import answers
from sar_tui.export.tables.imu import IMU_STREAMS, imu, sensor_faults
from sar_tui.export.tables.log import EVENTS, notes, sync_signals, taken_back
from sar_tui.export.tables.parameters import PROGRAMMES, Fields, parameters, programme_parameters
from sar_tui.export.tables.records import records
from sar_tui.export.tables.results import attempts, trials
from sar_tui.export.tables.sessions import PARTICIPANTS, runs, sessions
from sar_tui.plugins import PluginError
from sar_tui.records.kind import kinds
from sar_tui.rules.parameters import TaskParameters
from sar_tui.rules.parameters import fields as declared_fields
from sar_tui.store.selection import Selection

if TYPE_CHECKING:
    from sar_tui.plugins import Catalogue

_MONTH = len("2026-11")
_APART = ("task", "theme")
"""Each task, and each theme, has versions of its own: in the columns whose names begin so."""


class Contents:
    """The tables of the selected sessions, without what does not leave.

    Attributes:
        tables: with the columns that leave.
        problems: sentences on what could not be read; complete when all rows were read.
        left_out: columns that the sessions have and that do not leave, as "trials.details_remark".
        notices: a sentence on each task that cannot be loaded, so that its details are not
            described.
    """

    def __init__(
        self,
        database: sqlite3.Connection,
        selection: Selection,
        privacy: Privacy,
        catalogue: "Catalogue",
        passports: Sequence[Passport] = (),
        *,
        with_events: bool = False,
        study: str = "",
    ) -> None:
        self._database = database
        self._sessions = {privacy.id(session): session for session in selection.ids}
        self.problems: list[str] = []
        self._damage = damage = Damage(database, self._report)
        declared, not_loaded = _declared(catalogue, selection.tasks)
        fields = _fields(catalogue, not_loaded)
        whole = (
            PARTICIPANTS,
            PROGRAMMES,
            programme_parameters(fields, damage),
            sessions(
                {row["id"]: row["status"] for row in selection.sessions},
                {session: each.sha256 for each in passports for session in each.sessions},
                damage,
            ),
            parameters(fields, damage),
            runs(damage),
            sync_signals(damage),
            records(selection.sessions, kinds(), damage, study),
            attempts(database, selection.ids, damage),
            answers(damage),
            trials(database, selection.ids, declared, damage, not_loaded),
            actions(damage),
            outputs(damage),
            notes(damage),
            taken_back(damage),
            IMU_STREAMS,
            sensor_faults(damage),
            imu(self._report),
            *((EVENTS,) if with_events else ()),
        )
        self._whole: dict[str, Table] = {table.name: table for table in whole}
        if privacy.recoded is not None:
            privacy = msgspec.structs.replace(privacy, differing=self._differing())
        self._privacy = privacy
        self.tables = tuple(map(privacy.leaving, whole))
        self.left_out = [
            f"{table.name}.{column.name}"
            for table in whole
            for column in table.columns
            if not privacy.leaves(column)
        ]  # fmt: skip
        self.notices = [_not_loaded(task, self._whole["trials"], privacy) for task in not_loaded]
        self._codes = {privacy.code(code): code for code in selection.participants}
        self._persons = {row["id"]: row["participant"] for row in selection.sessions}
        moments = (
            (privacy.id(row["id"]), privacy.moment(row["started_at"], row["participant"]))
            for row in selection.sessions
        )
        self._months = {session: moment[:_MONTH] for session, moment in moments if moment}
        self._owners = {"session": list(self._sessions), "participant": list(self._codes)}

    def _differing(self) -> frozenset[str]:
        """Return the columns of versions that are not the same in all sessions, or in those with a
        task or theme.
        """
        seen: dict[str, set[Any]] = {}
        for table in self._whole.values():
            names = [column.name for column in table.columns]
            versions = [column.name for column in table.columns if column.treatment == "version"]
            for session in self._sessions.values() if versions else ():
                for values in self._damage.rows(
                    table, session, partial(table.rows, self._database, session)
                ):
                    row = dict(zip(names, values, strict=True))
                    for name in versions:
                        kind = name.partition("_")[0]
                        seen.setdefault(name, set()).add(
                            (row[kind] if kind in _APART else None, row[name])
                        )
        self.problems.clear()  # they are found again when the rows leave
        return frozenset(
            name for name, values in seen.items() if len({of for of, _ in values}) < len(values)
        )

    def _report(self, sentence: str) -> None:
        """Add a problem, with the ids of sessions as they leave."""
        self.problems.append(
            _with_ids(sentence, {here: leaving for leaving, here in self._sessions.items()})
        )

    def here(self, problem: str) -> str:
        """Return a problem with the ids of sessions and the codes that they have in the
        database.
        """
        return _with_ids(problem, self._sessions | self._codes)

    def part(self, names: Collection[str]) -> "Contents":
        """Return these contents with the named tables only."""
        part = copy(self)
        part.tables = tuple(table for table in self.tables if table.name in names)
        return part

    def whole(self, table: Table) -> Table:
        """Return a table with all its columns, also those that do not leave."""
        return self._whole[table.name]

    def by_month(self, table: Table) -> list[tuple[str, list[str]]]:
        """Return the owners of a table by the month in which their sessions began, as it leaves:
        "2026-11".

        The month is empty for a table of participants, and of a session without a date.
        """
        if table.of == "participant":
            return [("", self.owners(table))]
        found: dict[str, list[str]] = {}
        for session in self.owners(table):
            found.setdefault(self._months.get(session, ""), []).append(session)
        return sorted(found.items())

    @property
    def site(self) -> str:
        """The site that recorded these sessions, in a format that writes sites apart."""
        return self._privacy.of_site[0] if self._privacy.of_site else ""

    def owners(self, table: Table) -> list[str]:
        """Return the sessions that the table has rows of, by id, or the participants, by their
        codes as they leave.
        """
        return self._owners[table.of]

    @property
    def sessions(self) -> list[str]:
        """The ids of the sessions, as they leave."""
        return list(self._sessions)

    def measured(self, sessions: Collection[str]) -> list[str]:
        """Return the ids of sessions with the same measured timing, as they leave; none if that
        would tell a time.

        Args:
            sessions: by their ids here.
        """
        if "timing_sha256" in self._privacy.differing:
            return []
        return [leaving for leaving, here in self._sessions.items() if here in sessions]

    @property
    def steps(self) -> int:
        """The number of calls of ``rows`` that yield everything."""
        return sum(len(self.owners(table)) for table in self.tables)

    def rows(self, table: Table, owner: str) -> Iterator[Values]:
        """Yield the rows of one session or participant in a table: a value for each of its columns,
        None if missing.
        """
        whole = self._whole[table.name]
        stored = self._sessions[owner] if table.of == "session" else self._codes[owner]
        kept = [index for index, column in enumerate(whole.columns) if self._privacy.leaves(column)]

        def read() -> Iterator[Values]:
            found = whole.rows(self._database, stored)
            if len(kept) < len(whole.columns):
                found = map(_picker(kept), found)
            is_timed = self._privacy.recoded is not None and table.of == "session"
            starts = run_starts(self._database, stored) if is_timed else None
            return self._privacy.changed(table, found, self._persons.get(stored, stored), starts)

        return self._damage.rows(table, owner, read)


def dataset_name(modes: Set[str]) -> str:
    """Return the name of a data set for people, which tells simulated sessions from live ones.

    Args:
        modes: of the sessions.
    """
    if modes <= {"live"}:
        return "Sessions of motor tasks"
    return f"Sessions of motor tasks ({'some are' if 'live' in modes else 'all'} simulated)"


def _with_ids(sentence: str, names: Mapping[str, str]) -> str:
    """Return a sentence with other names of sessions, or persons, in place of those it has."""
    return re.sub(r"[\w@.-]*\w", lambda word: names.get(word[0], word[0]), sentence)


def _picker(kept: list[int]) -> Any:
    return itemgetter(*kept) if len(kept) > 1 else lambda row: tuple(row[index] for index in kept)


def _not_loaded(task: str, trials: Table, privacy: Privacy) -> str:
    """Return a sentence on a task that cannot be loaded, and on what that means for the export."""
    said = (
        f"The task {task} cannot be loaded, so nothing says what its details are: they leave "
        "as they are stored"
    )
    own = [
        column
        for column in trials.columns
        if column.name.startswith("details_") and task in (column.tasks or ())
    ]
    if withheld := [column.name for column in own if not privacy.leaves(column)]:
        return (
            f"{said}, except for texts of several words, which somebody may have typed "
            f"({', '.join(withheld)}). Give "
            "the folder that the task is in with --tasks DIR to have all of them, each with its "
            "meaning, or add "
            "--with-notes."
        )
    return (
        f"{said}. Give the folder that the task is in with --tasks DIR to have each with its "
        "meaning."
    )


def _declared(catalogue: "Catalogue", tasks: list[str]) -> tuple[Mapping[str, Declared], list[str]]:
    """Return the details that tasks declare, and the tasks that cannot be loaded."""
    found: dict[str, Declared] = {}
    not_loaded = []
    for name in tasks:
        try:
            details = declared_keys(catalogue.task(name).Details)
        except PluginError:
            not_loaded.append(name)
            continue
        for key, declared in details.items():
            known = found.get(key)
            same = known is None or known.meaning == declared.meaning
            found[key] = (
                declared
                if known is None
                else Declared(
                    known.meaning if same else f"{known.meaning} {declared.meaning}",
                    known.types | declared.types,
                )
            )
    return found, not_loaded


def _fields(catalogue: "Catalogue", not_loaded: Collection[str]) -> Fields:
    """Return the parameters that tasks declare; of a task that cannot be loaded, those that all
    tasks have.
    """
    common = {field.name: field for field in declared_fields(TaskParameters)}
    found = dict.fromkeys(not_loaded, common)
    for name in catalogue.task_names():
        try:
            found[name] = {
                field.name: field for field in declared_fields(catalogue.task(name).Parameters)
            }
        except PluginError:
            continue
    return found
