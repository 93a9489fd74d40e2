"""A participant's results over all sessions, for reports of progress. A session's prompts are not
looked at.
"""

import sqlite3
from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path

import msgspec

from sar_tui.progress.lines import SessionResults
from sar_tui.progress.task_level import AttemptResult
from sar_tui.store import provenance, wellbeing
from sar_tui.store.counted import COUNTS, KEPT
from sar_tui.store.records import Record
from sar_tui.store.sessions import status_now
from sar_tui.store.training_days import UTC_OFFSET, trained_at

_SESSIONS = (
    "SELECT id, started_at, sessions.task, mode, status, seat, parameters, json_extract(software, "
    "'$.task'),"
    f" {UTC_OFFSET}, json_extract(study, '$.study'), json_extract(study, '$.condition')"
    " FROM seats CROSS JOIN sessions ON sessions.id=seats.session"
    f" WHERE participant=:who AND {KEPT} AND json_type(software, '$.task.metric') IS NOT NULL "
    "{of_task} {among}"
    " ORDER BY sessions.rowid"
)
_ATTEMPTS = (
    "SELECT attempts.session, attempts.seat, level, metric, correct, trials,"
    " nullif(outcome, 'none')='success', max(0, ended_ns - started_ns)"
    " FROM seats CROSS JOIN attempts ON attempts.session=seats.session AND attempts.seat=seats.seat"
    " WHERE participant=:who AND NOT practice {among} ORDER BY attempts.session, attempt"
)
_QUALITIES = (
    "SELECT attempts.session, attempts.seat, quality.key, avg(quality.value)"
    " FROM seats CROSS JOIN attempts ON attempts.session=seats.session AND attempts.seat=seats.seat"
    " JOIN json_each(attempts.qualities) AS quality"
    " WHERE participant=:who AND NOT practice AND qualities<>'{{}}' {among} GROUP BY 1, 2, 3"
)
"""``CROSS``: a participant's seats are looked up first, and only their attempts are read."""
_NEWEST = (
    "SELECT session FROM seats CROSS JOIN sessions ON sessions.id=seats.session"
    f" WHERE participant=? AND sessions.task=? AND {COUNTS} ORDER BY seats.rowid DESC LIMIT ?"
)
_LONGEST_ATTEMPT_NS = 6 * 3600 * 1_000_000_000
"""An attempt that seems longer was begun before the computer was started again: its stamps cannot
be compared.
"""

_Stored = tuple[AttemptResult, int, int | None, int]


def newest_of(
    db: sqlite3.Connection, participant: str, task: str, most: int, *, folder: Path | None = None
) -> list[SessionResults]:
    """Return the results of a participant's newest live sessions of a task that count, the oldest
    of them first.

    ``folder`` is as in `sessions_of`.
    """
    chosen = [session for (session,) in db.execute(_NEWEST, (participant, task, most))]
    return list(_results(db, participant, task, chosen, folder))


def sessions_of(
    db: sqlite3.Connection, participant: str, task: str | None = None, *, folder: Path | None = None
) -> Iterator[SessionResults]:
    """Yield the results of a participant's sessions that count, in the order in which they were
    stored.

    Args:
        db: the database.
        participant: the code.
        task: selects one task.
        folder: of the data; with it, a session that is stored as running but is not has the status
            ``interrupted``.
    """
    return _results(db, participant, task, None, folder)


def _results(
    db: sqlite3.Connection,
    participant: str,
    task: str | None,
    chosen: Sequence[str] | None,
    folder: Path | None,
) -> Iterator[SessionResults]:
    """Yield the results of all sessions, or of those of some ids."""
    among = "" if chosen is None else "AND seats.session IN (SELECT value FROM json_each(:chosen))"
    values = {"who": participant, "task": task, "chosen": msgspec.json.encode(chosen).decode()}
    stored: dict[tuple[str, str], list[_Stored]] = {}
    for session, seat, level, metric, correct, trials, reached, took in db.execute(
        _ATTEMPTS.format(among=among), values
    ):
        result = AttemptResult(level, metric, correct)
        lasted = took if took <= _LONGEST_ATTEMPT_NS else 0
        stored.setdefault((session, seat), []).append((result, trials, reached, lasted))
    qualities: dict[tuple[str, str], dict[str, float]] = {}
    for session, seat, name, mean in db.execute(_QUALITIES.format(among=among), values):
        if isinstance(mean, float):
            qualities.setdefault((session, seat), {})[name] = mean
    felt: dict[tuple[str | None, str], list[Record]] = {}
    for said in (
        wellbeing.of_participant(db, participant) if chosen is None else _said_in(db, chosen)
    ):
        felt.setdefault((said.session, said.seat), []).append(said)
    query = _SESSIONS.format(
        of_task="AND sessions.task=:task" if task is not None else "", among=among
    )
    for row in db.execute(query, values):
        found, began, of_task, mode, status, seat, parameters, software, offset, *study = row
        attempts = stored.get((found, seat), [])
        made_by, stored_parameters = msgspec.json.decode(software), msgspec.json.decode(parameters)
        yield SessionResults(
            session=found,
            began=trained_at(began, offset),
            task=of_task,
            title=made_by.get("title", of_task),
            task_version=str(made_by.get("version", "")),
            seat=seat,
            mode=mode,
            status=status_now(status, found, folder) if folder else status,
            metric=provenance.metric({"task": made_by}),
            parameters=stored_parameters,
            results=[result for result, *_ in attempts],
            reached=_reached([reached for _, _, reached, _ in attempts]),
            trials=sum(trials for _, trials, _, _ in attempts),
            right=sum(result.correct for result, *_ in attempts),
            seconds=sum(lasted for *_, lasted in attempts) / 1e9,
            qualities=qualities.get((found, seat), {}),
            study=", ".join(filter(None, study)),
            felt=wellbeing.ratings(
                felt.get((found, seat), ()), seat, wellbeing.limits_in(stored_parameters)
            ),
        )


def _reached(attempts: Sequence[int | None]) -> int | None:
    """Return how many attempts reached their goal; None if there are some, and none of them had a
    goal.
    """
    judged = [reached for reached in attempts if reached is not None]
    return None if attempts and not judged else sum(judged)


def _said_in(db: sqlite3.Connection, sessions: Sequence[str]) -> Iterator[Record]:
    return chain.from_iterable(wellbeing.by_session(db, sessions).values())


class Played(msgspec.Struct, frozen=True):
    """An attempt of a session: level, result, success (None without a goal), and how long it
    took.
    """

    level: int
    metric: float | None
    reached: bool | None
    seconds: float


def attempts_of(
    db: sqlite3.Connection, sessions: Sequence[str]
) -> dict[tuple[str, str], list[Played]]:
    """Return the attempts of some sessions by session and seat, in order; practice is left out."""
    found: dict[tuple[str, str], list[Played]] = {}
    rows = db.execute(
        "SELECT session, seat, level, metric, nullif(outcome, 'none')='success', max(0, ended_ns "
        "- started_ns)"
        " FROM json_each(?) AS chosen CROSS JOIN attempts ON attempts.session=chosen.value"
        " WHERE NOT practice ORDER BY session, attempt",
        (msgspec.json.encode(list(sessions)).decode(),),
    )
    for session, seat, level, metric, reached, took in rows:
        lasted = took if took <= _LONGEST_ATTEMPT_NS else 0
        found.setdefault((session, seat), []).append(
            Played(level, metric, reached if reached is None else bool(reached), lasted / 1e9)
        )
    return found
