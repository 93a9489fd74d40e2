"""Sessions: a row each."""

import sqlite3
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

from sar_tui.export.columns import MODE, SESSION, TASK, Column, Reference, Table, Values, stored
from sar_tui.export.damage import Damage
from sar_tui.export.messages_of_topic import messages_of_topic
from sar_tui.loop.topics import SESSION as SESSION_STARTED
from sar_tui.store.record_changes import BY_MISTAKE, why_discarded
from sar_tui.store.sites import resolved

_SOFTWARE = {
    "sar_tui": stored(
        "sessions.software.sar_tui", "string", "Version of sar-tui at the start of the session."
    ),
    "python": stored("sessions.software.python", "string", "Version of Python."),
    "packages.numpy": stored(
        "sessions.software.packages.numpy",
        "string",
        "Version of numpy, by which movements are measured.",
    ),
    "task.title": stored(
        "sessions.software.task.title", "string", "The task's name for people.", name="task_title"
    ),
    "task.version": stored(
        "sessions.software.task.version",
        "string",
        "Version of the task; results of different versions cannot be compared.",
        name="task_version",
    ),
    "task.source": stored(
        "sessions.software.task.source",
        "string",
        "The task is built in, a user's own, or of an installed package.",
        name="task_source",
    ),
    "task.hash": stored(
        "sessions.software.task.hash",
        "string",
        "SHA-256 of the files of the task's folder.",
        name="task_sha256",
    ),
    "theme.hash": stored(
        "sessions.software.theme.hash",
        "string",
        "SHA-256 of the files of the theme's folder.",
        name="theme_sha256",
    ),
    "task.metric.name": stored(
        "sessions.software.task.metric.name",
        "string",
        "The measure of an attempt.",
        name="metric_name",
    ),
    "task.metric.unit": stored(
        "sessions.software.task.metric.unit", "string", "Its unit.", name="metric_unit"
    ),
    "task.metric.better": stored(
        "sessions.software.task.metric.better",
        "string",
        "The better results are the lower ones, or the higher ones.",
        name="metric_better",
        levels=("lower", "higher"),
    ),
}
_MACHINE = {
    "system": stored("sessions.machine.system", "string", "Operating system."),
    "processor": stored("sessions.machine.processor", "string", "Architecture of the processor."),
    "cores": stored("sessions.machine.cores", "integer", "Number of the processor's cores."),
    "clock": stored(
        "sessions.machine.clock", "string", "The steady clock that stamps are taken from."
    ),
    "terminal": stored("sessions.machine.terminal", "string", "Program or kind of the terminal."),
    "ssh": stored(
        "sessions.machine.ssh", "boolean", "True if the terminal was connected through SSH."
    ),
    "multiplexer": stored(
        "sessions.machine.multiplexer",
        "string",
        "The terminal multiplexer that the program ran in; missing: none.",
    ),
    "flags": stored(
        "sessions.machine.flags",
        "string",
        "Conditions known to make timing less exact, with spaces between them.",
        name="timing_flags",
    ),
}
_COLUMNS = (
    SESSION,
    MODE,
    TASK,
    stored("sessions.theme", "string", "Name of the agent's theme."),
    stored(
        "sessions.status",
        "string",
        "The session had all its attempts (completed), was ended by a person (aborted), was cut "
        "off (interrupted), or "
        "was cut off and given up (dismissed). It does not count, and belongs into no analysis of "
        "training, if it was "
        "started by mistake (discarded), or a question that must be agreed to was not (refused).",
        levels=("completed", "aborted", "interrupted", "dismissed", "discarded", "refused"),
        required=True,
    ),
    Column(
        "discarded_because",
        "Why it was discarded; missing: it was not.",
        "string",
        levels=(BY_MISTAKE,),
        treatment="open",
    ),
    stored("sessions.started_at", "datetime", "When it began, UTC."),
    stored("sessions.ended_at", "datetime", "When it ended, UTC."),
    stored("seats.participant", "string", "Code of the participant at seat A."),
    stored(
        "seats.participant",
        "string",
        "Code of the participant at seat B, in a task for two.",
        name="partner",
    ),
    stored("sessions.seed", "integer", "Seed of all that is random."),
    stored(
        "sessions.site", "string", "Code of the site that recorded it; missing: the site has none."
    ),
    stored(
        "sessions.programme",
        "integer",
        "Version of the participant's programme; missing: there was none.",
    ),
    *_SOFTWARE.values(),
    *_MACHINE.values(),
    stored(
        "sessions.machine.timing.sha256",
        "string",
        "The measured timing of the machine in timing.json; missing: not measured.",
        name="timing_sha256",
    ),
    stored(
        "started.rules",
        "integer",
        "Version of the loop's rules that the session was played by: of how it goes on with the "
        "same inputs.",
        name="loop_rules",
    ),
    stored(
        "sessions.log_hash",
        "string",
        "The last hash of the session's log, a running SHA-256; missing: it was recorded before "
        "there were hashes.",
        name="log_sha256",
    ),
)


def sessions(statuses: Mapping[str, str], passports: Mapping[str, str], damage: Damage) -> Table:
    """Return the table of sessions.

    Args:
        statuses: of the sessions, by id: a session that is stored as running may have been cut off.
        passports: the SHA-256 of their timing passports, by id.
    """
    return Table(
        name="sessions",
        title="A session",
        columns=_COLUMNS,
        key=("session",),
        rows=partial(_rows, statuses, passports, damage),
        references=(Reference(("participant",), "participants", ("participant",)),),
    )


def _rows(
    statuses: Mapping[str, str],
    passports: Mapping[str, str],
    damage: Damage,
    database: sqlite3.Connection,
    session: str,
) -> Iterator[Values]:
    for row in database.execute(
        "SELECT id, mode, task, theme, NULL, NULL, started_at, ended_at, own.participant, "
        "other.participant, seed,"
        f" nullif({resolved('sessions.site')}, ''), programme, software, machine, "
        "nullif(log_hash, '') FROM sessions"
        " LEFT JOIN seats AS own ON own.session=id AND own.seat='A'"
        " LEFT JOIN seats AS other ON other.session=id AND other.seat='B' WHERE id=?",
        (session,),
    ):
        *plain, software, machine, log_hash = row
        plain[4] = statuses[session]
        discarded = why_discarded(database, session) if plain[4] == "discarded" else None
        plain[5] = discarded.reason if discarded else None
        yield (
            *plain,
            *_parts(damage.object_of("software", software), _SOFTWARE),
            *_parts(damage.object_of("machine", machine), _MACHINE),
            passports.get(session),
            _rules(damage, database, session),
            log_hash,
        )


def _rules(damage: Damage, database: sqlite3.Connection, session: str) -> int | None:
    """Return the rules that a session began with, and keeps; None if its start is not in the
    record.
    """
    started = next(messages_of_topic(database, session, SESSION_STARTED.name, damage), None)
    return None if started is None else started[2].get("rules", 1)


def _parts(value: dict[str, Any], columns: Mapping[str, Column]) -> Iterator[Any]:
    """Yield the parts of a JSON object, by their paths."""
    for path in columns:
        part: Any = value
        for key in path.split("."):
            part = part.get(key) if isinstance(part, dict) else None
        yield " ".join(map(str, part)) if isinstance(part, list) else part
