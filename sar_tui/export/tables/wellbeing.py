"""Answers about pain and tiredness, adverse events, and scores of other instruments: a row each."""

import sqlite3
from collections.abc import Collection, Iterator, Mapping
from functools import partial
from typing import Any

from sar_tui.export.columns import (
    PARTICIPANT,
    SEAT,
    TO_SESSION,
    Table,
    Values,
    as_bool,
    stored,
)
from sar_tui.export.tables.sessions import TO_PARTICIPANT


def _answers(
    sessions: Collection[str], live: Collection[str], database: sqlite3.Connection, participant: str
) -> Iterator[Values]:
    for row in database.execute(
        "SELECT session, participant, seat, moment, question, answer, at FROM wellbeing WHERE "
        "participant=?"
        " ORDER BY at, question",
        (participant,),
    ):
        session = row[0]
        if session in sessions or (session is None and participant in live):
            yield row


def wellbeing(sessions: Collection[Mapping[str, Any]]) -> Table:
    """Return the table of the answers in these sessions, and of their participants before one that
    never began.

    Args:
        sessions: as `store.sessions.listing` returns them. Only persons who had a live one answered
            without a session.
    """
    ids = {row["id"] for row in sessions}
    live = {
        code
        for row in sessions
        if row["mode"] == "live"
        for code in (row["participant"], row["partner"])
    }
    return Table(
        name="wellbeing",
        title="An answer about pain or tiredness",
        columns=(
            stored("wellbeing.session"),
            PARTICIPANT,
            SEAT,
            stored("wellbeing.moment"),
            stored("wellbeing.question"),
            stored("wellbeing.answer"),
            stored("wellbeing.at"),
        ),
        key=("participant", "question", "at"),
        rows=partial(_answers, ids, live),
        of="participant",
        references=(TO_SESSION, TO_PARTICIPANT),
    )


def _events(database: sqlite3.Connection, participant: str) -> Iterator[Values]:
    return database.execute(
        "SELECT event, version, participant, session, onset, severity, recorded_at, what, action, "
        "outcome"
        " FROM adverse_events WHERE participant=? ORDER BY event, version",
        (participant,),
    )


ADVERSE_EVENTS = Table(
    name="adverse_events",
    title="A version of an adverse event; the last one counts",
    columns=(
        stored("adverse_events.event"),
        stored("adverse_events.version"),
        PARTICIPANT,
        stored("adverse_events.session"),
        stored("adverse_events.onset"),
        stored("adverse_events.severity"),
        stored("adverse_events.recorded_at"),
        stored("adverse_events.what"),
        stored("adverse_events.action"),
        stored("adverse_events.outcome"),
    ),
    key=("event", "version"),
    rows=_events,
    of="participant",
    references=(TO_PARTICIPANT,),
)


def _scores(database: sqlite3.Connection, participant: str) -> Iterator[Values]:
    for *row, removed in database.execute(
        "SELECT participant, instrument, date, score, recorded_at, note, removed FROM "
        "instrument_scores"
        " WHERE participant=? ORDER BY instrument, date, recorded_at",
        (participant,),
    ):
        yield (*row, as_bool(removed))


INSTRUMENT_SCORES = Table(
    name="instrument_scores",
    title="A score of another instrument, as entered; of a day, the one recorded last counts",
    columns=(
        PARTICIPANT,
        stored("instrument_scores.instrument"),
        stored("instrument_scores.date"),
        stored("instrument_scores.score"),
        stored("instrument_scores.recorded_at"),
        stored("instrument_scores.note"),
        stored("instrument_scores.removed"),
    ),
    key=("participant", "instrument", "date", "recorded_at"),
    rows=_scores,
    of="participant",
    references=(TO_PARTICIPANT,),
)
