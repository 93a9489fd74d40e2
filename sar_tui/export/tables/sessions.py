"""Participants, sessions, and the runs of the program on them: a row each."""

import sqlite3
from collections.abc import Iterator, Mapping

from sar_tui.export.columns import (
    TO_SESSION,
    Column,
    Reference,
    Row,
    Stored,
    Table,
    in_order,
    stored,
    with_others,
)
from sar_tui.export.damage import Damage
from sar_tui.export.log import messages_of_topic
from sar_tui.loop.topics import SESSION as SESSION_STARTED
from sar_tui.store import sites
from sar_tui.store.record_changes import BY_MISTAKE, why_discarded
from sar_tui.store.tables import PARTICIPANTS as STORED_PARTICIPANTS
from sar_tui.store.tables import RUNS, SESSIONS

_PARTICIPANTS = Stored(STORED_PARTICIPANTS)


def _participants(database: sqlite3.Connection, code: str) -> Iterator[Row]:
    found = next(_PARTICIPANTS.rows(database, code), None)
    yield found or {"participant": code}


PARTICIPANTS = Table(
    name="participants",
    title=STORED_PARTICIPANTS.row,
    columns=_PARTICIPANTS.columns,
    key=("participant",),
    rows=in_order(_PARTICIPANTS.columns, _participants),
    of="participant",
)
TO_PARTICIPANT = Reference(("participant",), "participants", ("participant",))

_SESSIONS = Stored(SESSIONS)
_SESSION_COLUMNS = with_others(
    _SESSIONS.columns,
    {
        "status": [
            Column(
                "discarded_because",
                "Why it was discarded; missing: it was not.",
                "string",
                levels=(BY_MISTAKE,),
                treatment="open",
            )
        ],
        "ended_at": [
            stored("seats.participant", meaning="Code of the participant at seat A."),
            stored(
                "seats.participant",
                name="partner",
                meaning="Code of the participant at seat B, in a task for two.",
            ),
        ],
        "timing_flags": [
            stored("sessions.machine.timing.sha256", name="timing_sha256"),
            Column(
                "loop_rules",
                "Version of the loop's rules that the session was played by: of how it goes on "
                "with the same inputs.",
                "integer",
                treatment="version",
            ),
        ],
    },
)


def sessions(statuses: Mapping[str, str], passports: Mapping[str, str], damage: Damage) -> Table:
    """Return the table of sessions.

    Args:
        statuses: of the sessions, by id: a session that is stored as running may have been cut off.
        passports: the SHA-256 of their timing passports, by id.
    """

    def rows(database: sqlite3.Connection, session: str) -> Iterator[Row]:
        people = dict(
            database.execute("SELECT seat, participant FROM seats WHERE session=?", (session,))
        )
        for row in _SESSIONS.rows(database, session, damage):
            discarded = None
            if statuses[session] == "discarded":
                discarded = why_discarded(database, session)
            yield {
                **row,
                "status": statuses[session],
                "discarded_because": discarded.reason if discarded else None,
                "participant": people.get("A"),
                "partner": people.get("B"),
                "site": sites.of_session(database, session) or None,
                "timing_sha256": passports.get(session),
                "loop_rules": _rules(damage, database, session),
                "log_sha256": row["log_sha256"] or None,
            }

    return Table(
        name="sessions",
        title=SESSIONS.row,
        columns=_SESSION_COLUMNS,
        key=("session",),
        rows=in_order(_SESSION_COLUMNS, rows),
        references=(TO_PARTICIPANT,),
    )


def _rules(damage: Damage, database: sqlite3.Connection, session: str) -> int | None:
    """Return the rules that a session began with, and keeps; None if its start is not in the
    record.
    """
    started = next(messages_of_topic(database, session, SESSION_STARTED.name, damage), None)
    return None if started is None else started[2].get("rules", 1)


_RUNS = Stored(RUNS, objects=("software",))
_RUN_COLUMNS = (
    *_RUNS.columns,
    stored("sessions.software.sar_tui", meaning="Version of sar-tui."),
    stored("sessions.software.python"),
    stored("sessions.software.packages.numpy"),
)


def runs(damage: Damage) -> Table:
    """Return the table of runs. Resuming a session adds one."""

    def rows(database: sqlite3.Connection, session: str) -> Iterator[Row]:
        for row in _RUNS.rows(database, session, damage):
            software = row["software"]
            packages = software.get("packages")
            row["sar_tui"] = software.get("sar_tui")
            row["python"] = software.get("python")
            row["numpy"] = packages.get("numpy") if isinstance(packages, dict) else None
            yield row

    return Table(
        name="runs",
        title=RUNS.row,
        columns=_RUN_COLUMNS,
        key=RUNS.key,
        rows=in_order(_RUN_COLUMNS, rows),
        references=(TO_SESSION,),
    )
