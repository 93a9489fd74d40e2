"""Tables and views of a new database, and the migrations of earlier ones.

A new database is made from `store.tables`. The columns are a contract: see docs/data-dictionary.md.
"""

import sqlite3
from datetime import UTC, datetime

import sqlite_utils

from sar_tui.store import tables, views


def create(database: sqlite3.Connection) -> None:
    """Give an empty database all tables and views, as if it had seen all migrations."""
    db = sqlite_utils.Database(database)
    migrations.ensure_migrations_table(db)
    with db.atomic():
        for table in tables.TABLES.values():
            for statement in (table.create, *table.indexes):
                database.execute(statement)
        for statement in (_TOPIC_OF_PRESENCE, *views.ALL):
            database.execute(statement)
        now = datetime.now(UTC).isoformat()
        database.executemany(
            f"INSERT INTO {migrations.migrations_table} (migration_set, name, applied_at)"
            " VALUES (?,?,?)",
            [(migrations.name, each.name, now) for each in migrations.pending(db)],
        )
        database.execute(f"PRAGMA user_version={tables.VERSION}")


def bring_up_to_date(database: sqlite3.Connection, version: int) -> None:
    """Apply the migrations that a database has not seen, up to a version.

    Versions after the last hand-written migration add the columns that `store.tables` declares.
    """
    db = sqlite_utils.Database(database)
    migrations.apply(db, stop_before=f"version_{version + 1}")
    (seen,) = database.execute("PRAGMA user_version").fetchone()
    with db.atomic():
        for later in range(seen + 1, version + 1):
            for statement in tables.added(later):
                database.execute(statement)
        database.execute(f"PRAGMA user_version={version}")


migrations = sqlite_utils.Migrations("sar-tui")
"""One function for each version up to `tables.FIRST_VERSION`, in order."""


@migrations()
def version_1(db: sqlite_utils.Database) -> None:
    """Participants, sessions, runs, attempts, trials, actions, events, notes, settings."""
    create = db.create_table
    create("participants", {"code": str, "created_at": str}, pk="code")
    create(
        "settings",
        {"participant": str, "task": str, "parameters": str, "theme": str, "updated_at": str},
        pk=("participant", "task"),
    )
    create(
        "sessions",
        {
            "id": str,
            "task": str,
            "theme": str,
            "status": str,
            "started_at": str,
            "ended_at": str,
            "seed": int,
            "parameters": str,
            "software": str,
            "machine": str,
            "mode": str,
        },
        pk="id",
    )
    create("seats", {"session": str, "seat": str, "participant": str}, pk=("session", "seat"))
    create(
        "runs",
        {
            "session": str,
            "run": int,
            "clock_anchor": str,
            "boot_id": str,
            "pid": int,
            "software": str,
            "machine": str,
        },
        pk=("session", "run"),
    )
    create(
        "attempts",
        {
            "session": str,
            "attempt": int,
            "seat": str,
            "run": int,
            "practice": int,
            "level": int,
            "metric": float,
            "metric_unit": str,
            "accuracy": float,
            "correct": int,
            "trials": int,
            "outcome": str,
            "feedback": str,
            "started_ns": int,
            "ended_ns": int,
        },
        pk=("session", "attempt", "seat"),
    )
    create(
        "trials",
        {
            "session": str,
            "attempt": int,
            "trial": int,
            "seat": str,
            "run": int,
            "stimulus": str,
            "response": str,
            "correct": int,
            "onset_ns": int,
            "response_ns": int,
            "reaction_time_ms": float,
            "timing": str,
            "details": str,
        },
        pk=("session", "attempt", "trial", "seat"),
    )
    create(
        "actions",
        {
            "session": str,
            "id": str,
            "kind": str,
            "proposed": str,
            "final": str,
            "decision": str,
            "actor": str,
            "proposed_ns": int,
            "decided_ns": int,
            "started_ns": int,
            "ended_ns": int,
        },
        pk=("session", "id"),
    )
    create(
        "events",
        {"session": str, "seq": int, "run": int, "at_ns": int, "topic": str, "message": str},
        pk=("session", "seq"),
    )
    create("notes", {"session": str, "at_ns": int, "author": str, "text": str})
    db["seats"].create_index(["participant"])  # type: ignore[union-attr]
    db["notes"].create_index(["session"])  # type: ignore[union-attr]


@migrations()
def version_2(db: sqlite_utils.Database) -> None:
    """Motion sensors and their samples; the goal and the qualities of an attempt."""
    db["attempts"].add_column("goal", float)  # type: ignore[union-attr]
    db["attempts"].add_column("qualities", str)  # type: ignore[union-attr]
    db.execute(
        "UPDATE attempts SET qualities='{}',"
        " goal=(SELECT json_extract(parameters, '$.threshold') FROM sessions WHERE "
        "id=attempts.session)"
    )
    db.create_table(
        "imu_streams",
        {
            "session": str,
            "stream": int,
            "seat": str,
            "run": int,
            "source": str,
            "model": str,
            "serial": str,
            "rate_hz": float,
            "rate_range_rad_s": float,
            "acceleration_range_m_s2": float,
            "layout": str,
            "attached_ns": int,
        },
        pk=("session", "stream"),
    )
    db.create_table(
        "imu_chunks",
        {
            "session": str,
            "stream": int,
            "seq": int,
            "n": int,
            "t0_ns": int,
            "t1_ns": int,
            "before_event": int,
            "at_ns": int,
            "crc32": int,
            "data": bytes,
        },
        pk=("session", "stream", "seq"),
    )


@migrations()
def version_3(db: sqlite_utils.Database) -> None:
    """The choice of feedback after an attempt."""
    db["attempts"].add_column("choice", str)  # type: ignore[union-attr]


@migrations()
def version_4(db: sqlite_utils.Database) -> None:
    """Decisions on proposals, when an operator saw them, and event marks."""
    actions = db["actions"]
    for name, kind in {
        "mode": str,
        "ground": str,
        "reason": str,
        "shown_ns": int,
        "deadline_ns": int,
    }.items():
        actions.add_column(name, kind)  # type: ignore[union-attr]
    db["notes"].add_column("label", str)  # type: ignore[union-attr]


@migrations()
def version_5(db: sqlite_utils.Database) -> None:
    """Messages as arrays, in half the space; earlier ones stay as they are. The view ``events``
    shows both.

    A program of the version before, whose session is under way, goes on storing its messages
    through the view.
    """
    for statement in _COMPACT_MESSAGES:
        db.execute(statement)


@migrations()
def version_6(db: sqlite_utils.Database) -> None:
    """Settings as versions, and the version that a session ran. The view ``settings`` shows the
    newest ones.

    A program of the version before, which is still open, goes on saving settings through the view.
    """
    for statement in _PROGRAMMES:
        db.execute(statement)


@migrations()
def version_7(db: sqlite_utils.Database) -> None:
    """Pain and tiredness: answers to questions, and what was said in pauses, also of earlier
    sessions.
    """
    for statement in _WELLBEING:
        db.execute(statement)


@migrations()
def version_8(db: sqlite_utils.Database) -> None:
    """Adverse events, each with all its versions."""
    db.execute(
        "CREATE TABLE adverse_events (event TEXT NOT NULL, version INTEGER NOT NULL, participant "
        "TEXT NOT NULL,"
        " session TEXT, onset TEXT NOT NULL, what TEXT NOT NULL, severity TEXT NOT NULL, action "
        "TEXT NOT NULL,"
        " outcome TEXT NOT NULL, recorded_at TEXT NOT NULL, recorded_by TEXT NOT NULL, PRIMARY "
        "KEY (event, version))"
    )


@migrations()
def version_9(db: sqlite_utils.Database) -> None:
    """Start levels that a therapist saved stay fixed: earlier programs knew no others."""
    db.execute(
        "UPDATE programmes SET parameters=json_set(parameters, '$.start_from', 'fixed')"
        " WHERE json_extract(parameters, '$.start_level') IS NOT NULL"
        " AND json_extract(parameters, '$.start_from') IS NULL"
    )


@migrations()
def version_10(db: sqlite_utils.Database) -> None:
    """Scores of other instruments, entered by hand."""
    db.execute(
        "CREATE TABLE instrument_scores (participant TEXT NOT NULL, instrument TEXT NOT NULL, "
        "date TEXT NOT NULL,"
        " score REAL NOT NULL, note TEXT NOT NULL, recorded_at TEXT NOT NULL, recorded_by TEXT "
        "NOT NULL,"
        " PRIMARY KEY (participant, instrument, date, recorded_at))"
    )


@migrations()
def version_11(db: sqlite_utils.Database) -> None:
    """Scores that were entered by mistake: a row says so, and the earlier ones stay."""
    db.execute("ALTER TABLE instrument_scores ADD COLUMN removed INTEGER NOT NULL DEFAULT 0")


@migrations()
def version_12(db: sqlite_utils.Database) -> None:
    """The ledger of exports."""
    db.execute(
        "CREATE TABLE exports (number INTEGER PRIMARY KEY, exported_at TEXT NOT NULL, exported_by "
        "TEXT NOT NULL,"
        " recipient TEXT NOT NULL, format TEXT NOT NULL, sessions TEXT NOT NULL, options TEXT NOT "
        "NULL,"
        " manifest TEXT NOT NULL)"
    )


@migrations()
def version_13(db: sqlite_utils.Database) -> None:
    """Site codes; views of attempts, trials and reaches. An empty site is the database's own."""
    db.execute(
        "CREATE TABLE site (number INTEGER PRIMARY KEY CHECK (number=1), code TEXT NOT NULL)"
    )
    for table in _OF_SITES:
        db.execute(f"ALTER TABLE {table} ADD COLUMN site TEXT NOT NULL DEFAULT ''")
    for statement in _INSERT_SETTINGS:
        db.execute(statement)
    for view in (views.ATTEMPTS, views.TRIALS, views.REACHES):
        db.execute(view)


@migrations()
def version_14(db: sqlite_utils.Database) -> None:
    """Codes of the same person at several sites; versions of records that contradict each other."""
    db.execute(
        "CREATE TABLE same_people (code TEXT NOT NULL, same_as TEXT NOT NULL, PRIMARY KEY (code, "
        "same_as))"
    )
    db.execute(
        "CREATE TABLE conflicts (kind TEXT NOT NULL, key TEXT NOT NULL, digest TEXT NOT NULL, "
        "content BLOB NOT NULL,"
        " PRIMARY KEY (kind, key, digest))"
    )


@migrations()
def version_15(db: sqlite_utils.Database) -> None:
    """The view of reaches has the measures of turning and tremor."""
    db.execute("DROP VIEW v_reaches")
    db.execute(views.REACHES)


@migrations()
def version_16(db: sqlite_utils.Database) -> None:
    """Sensors on the trunk; what they tell of a reach."""
    db.execute("ALTER TABLE imu_streams ADD COLUMN part TEXT NOT NULL DEFAULT 'hand'")
    db.execute("DROP VIEW v_reaches")
    db.execute(views.REACHES)


@migrations()
def version_17(db: sqlite_utils.Database) -> None:
    """The condition of an attempt."""
    db.execute("ALTER TABLE attempts ADD COLUMN condition TEXT NOT NULL DEFAULT ''")
    for name, view in (
        ("v_attempts", views.ATTEMPTS),
        ("v_trials", views.TRIALS),
        ("v_reaches", views.REACHES),
    ):
        db.execute(f"DROP VIEW {name}")
        db.execute(view)


@migrations()
def version_18(db: sqlite_utils.Database) -> None:
    """The data of prompts."""
    db.execute("ALTER TABLE trials ADD COLUMN data TEXT NOT NULL DEFAULT '{}'")


@migrations()
def version_19(db: sqlite_utils.Database) -> None:
    """Answers to questions between attempts."""
    db.execute(
        "CREATE TABLE answers (session TEXT NOT NULL, number INTEGER NOT NULL, run INTEGER NOT "
        "NULL,"
        " attempt INTEGER NOT NULL, seat TEXT NOT NULL, step TEXT NOT NULL, kind TEXT NOT NULL, "
        "text TEXT NOT NULL,"
        " labels TEXT NOT NULL, status TEXT NOT NULL, answer TEXT, shown_ns INTEGER NOT NULL,"
        " answered_ns INTEGER NOT NULL, PRIMARY KEY (session, number))"
    )


@migrations()
def version_20(db: sqlite_utils.Database) -> None:
    """Checkpoints are gone: a session is resumed by a replay, and nothing that is stored is run."""
    db.execute("DROP TABLE IF EXISTS checkpoints")


@migrations()
def version_21(db: sqlite_utils.Database) -> None:
    """The status of the session, beside each attempt and trial: some sessions do not count."""
    for name, view in (
        ("v_attempts", views.ATTEMPTS),
        ("v_trials", views.TRIALS),
        ("v_reaches", views.REACHES),
    ):
        db.execute(f"DROP VIEW {name}")
        db.execute(view)


@migrations()
def version_22(db: sqlite_utils.Database) -> None:
    """Hashes of logs; sessions that were recorded before have none. What is hashed is never
    migrated.
    """
    db.execute(
        "CREATE TABLE log_hashes (session TEXT NOT NULL, number INTEGER NOT NULL, seq INTEGER NOT "
        "NULL,"
        " beside TEXT NOT NULL, hash TEXT NOT NULL, PRIMARY KEY (session, number))"
    )
    db.execute("ALTER TABLE sessions ADD COLUMN log_hash TEXT NOT NULL DEFAULT ''")


_OF_SITES = (
    "participants", "sessions", "programmes", "wellbeing", "adverse_events", "instrument_scores", "exports",
)  # fmt: skip
_INSERT_SETTINGS = ("DROP TRIGGER insert_settings", views.INSERT_SETTINGS)
"""As before, with the names of the columns: there is another one."""
_TOPIC_OF_PRESENCE = "INSERT INTO topics (id, name, fields) VALUES (1, 'operator/presence', '')"
"""Its number is a literal in indexes."""
_COMPACT_MESSAGES = (
    "ALTER TABLE events RENAME TO earlier_events",
    "CREATE TABLE session_numbers (number INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE)",
    "CREATE TABLE topics (id INTEGER PRIMARY KEY, name TEXT NOT NULL, fields TEXT NOT NULL, "
    "UNIQUE (name, fields))",
    _TOPIC_OF_PRESENCE,
    "CREATE TABLE messages (session_number INTEGER NOT NULL, seq INTEGER NOT NULL, run INTEGER "
    "NOT NULL,"
    " at_ns INTEGER NOT NULL, topic INTEGER NOT NULL, message TEXT NOT NULL,"
    " PRIMARY KEY (session_number, seq)) WITHOUT ROWID",
    "CREATE TABLE checkpoints (session TEXT PRIMARY KEY, seq INTEGER NOT NULL, program TEXT NOT "
    "NULL,"
    " crc32 INTEGER NOT NULL, state BLOB NOT NULL)",
    "CREATE INDEX idx_messages_presence ON messages (session_number, seq) WHERE topic=1",
    "CREATE INDEX idx_earlier_events_presence ON earlier_events (session, seq) WHERE "
    "topic='operator/presence'",
    views.EVENTS,
    views.INSERT_EARLIER_EVENT,
)

_PROGRAMMES = (
    "CREATE TABLE programmes (participant TEXT NOT NULL, task TEXT NOT NULL, version INTEGER NOT "
    "NULL,"
    " created_at TEXT NOT NULL, author TEXT NOT NULL, reason TEXT NOT NULL, parameters TEXT NOT "
    "NULL,"
    " theme TEXT NOT NULL, PRIMARY KEY (participant, task, version))",
    "INSERT INTO programmes SELECT participant, task, 1, updated_at, '',"
    " 'Saved before programmes had versions.', parameters, theme FROM settings",
    "DROP TABLE settings",
    views.SETTINGS,
    """CREATE TRIGGER insert_settings INSTEAD OF INSERT ON settings BEGIN
    INSERT INTO programmes SELECT NEW.participant, NEW.task, coalesce(max(version), 0) + 1, NEW.updated_at, '',
        'Saved by an earlier version of sar-tui.', NEW.parameters, NEW.theme
    FROM programmes WHERE participant=NEW.participant AND task=NEW.task;
END""",
    "ALTER TABLE sessions ADD COLUMN programme INTEGER",
)

_WELLBEING = (
    "CREATE TABLE wellbeing (session TEXT, seat TEXT NOT NULL, participant TEXT NOT NULL, moment "
    "TEXT NOT NULL,"
    " question TEXT NOT NULL, answer TEXT NOT NULL, at TEXT NOT NULL, PRIMARY KEY (participant, "
    "question, at))",
    "CREATE INDEX idx_wellbeing_session ON wellbeing (session)",
    """INSERT OR IGNORE INTO wellbeing
SELECT said.session, seats.seat, seats.participant, 'pause',
    CASE json_extract(said.message, '$.reason') WHEN 'pain' THEN 'pain' ELSE 'fatigue' END, 'yes',
    coalesce(
        strftime('%Y-%m-%dT%H:%M:%f+00:00', json_extract(clock_anchor, '$.utc'),
            printf('%+.3f seconds', (said.at_ns - json_extract(clock_anchor, '$.clock_ns')) / 1e9)),
        sessions.started_at)
FROM events AS said
JOIN sessions ON sessions.id=said.session
JOIN seats ON seats.session=said.session AND seats.seat=coalesce(json_extract(said.message, '$.seat'), 'A')
LEFT JOIN runs ON runs.session=said.session AND runs.run=said.run
WHERE said.topic='operator/act' AND json_extract(said.message, '$.command')='pause'
    AND json_extract(said.message, '$.reason') IN ('pain', 'tired')""",
)
