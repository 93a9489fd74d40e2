"""Answers about pain and tiredness, adverse events, and scores of other instruments: a row each."""

import sqlite3
from collections.abc import Collection, Iterator, Mapping
from functools import partial
from typing import Any

from sar_tui.export.columns import (
    PARTICIPANT,
    SEAT,
    TO_SESSION,
    Reference,
    Table,
    Values,
    as_bool,
    stored,
)

_TO_PARTICIPANT = Reference(("participant",), "participants", ("participant",))


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
            stored("wellbeing.session", "string", "Id of the session; missing if it never began."),
            PARTICIPANT,
            SEAT,
            stored("wellbeing.moment", "string", "Before or after the session, or in a pause."),
            stored(
                "wellbeing.question",
                "string",
                "What was asked; advice: not to train, because of pain above the limit.",
                levels=("pain", "place", "fatigue", "advice"),
                required=True,
            ),
            stored(
                "wellbeing.answer",
                "string",
                "0 to 10, or the number of a place; yes: chosen in a pause; not said: would "
                "rather not say. "
                "Of advice: shown, and then stopped or went on.",
            ),
            stored("wellbeing.at", "datetime", "When it was answered, UTC.", required=True),
        ),
        key=("participant", "question", "at"),
        rows=partial(_answers, ids, live),
        of="participant",
        references=(TO_SESSION, _TO_PARTICIPANT),
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
        stored("adverse_events.event", "string", "Id of the event.", required=True),
        stored(
            "adverse_events.version",
            "integer",
            "1 when it was reported; each amendment adds one.",
            required=True,
        ),
        PARTICIPANT,
        stored(
            "adverse_events.session", "string", "The session in which it began; missing if in none."
        ),
        stored(
            "adverse_events.onset", "string", "Local date, or date and time, at which it began."
        ),
        stored(
            "adverse_events.severity", "string", "Severity.", levels=("mild", "moderate", "severe")
        ),
        stored("adverse_events.recorded_at", "datetime", "When this version was recorded, UTC."),
        stored("adverse_events.what", "string", "What happened."),
        stored("adverse_events.action", "string", "What was done."),
        stored("adverse_events.outcome", "string", "How it ended."),
    ),
    key=("event", "version"),
    rows=_events,
    of="participant",
    references=(_TO_PARTICIPANT,),
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
        stored("instrument_scores.instrument", "string", "The instrument.", required=True),
        stored(
            "instrument_scores.date", "string", "Day of the measurement, YYYY-MM-DD.", required=True
        ),
        stored("instrument_scores.score", "number", "The score.", required=True),
        stored(
            "instrument_scores.recorded_at", "datetime", "When it was entered, UTC.", required=True
        ),
        stored("instrument_scores.note", "string", "A remark."),
        stored(
            "instrument_scores.removed",
            "boolean",
            "True: entered by mistake. Then there is no score of that day.",
        ),
    ),
    key=("participant", "instrument", "date", "recorded_at"),
    rows=_scores,
    of="participant",
    references=(_TO_PARTICIPANT,),
)
