"""Answers to questions between attempts, and other steps there: a row each."""

import sqlite3
from collections.abc import Iterator
from functools import partial
from typing import Any

import msgspec

from sar_tui.export.columns import (
    PARTICIPANT,
    SEAT,
    SESSION,
    TO_SESSION,
    Table,
    Values,
    codes_by_seat,
    stored,
)
from sar_tui.export.damage import Damage

_BETWEEN = "; "
"""Stands between several options, or labels, in one value."""


def _rows(damage: Damage, database: sqlite3.Connection, session: str) -> Iterator[Values]:
    codes = codes_by_seat(database, session)
    for (
        number,
        run,
        attempt,
        seat,
        step,
        kind,
        text,
        labels,
        status,
        answer,
        shown,
        ended,
    ) in database.execute(
        "SELECT number, run, attempt, seat, step, kind, text, labels, status, answer, shown_ns, "
        "answered_ns"
        " FROM answers WHERE session=? ORDER BY number",
        (session,),
    ):
        options = _BETWEEN.join(map(str, _read(damage, labels) or ()))
        yield (session, number, codes.get(seat), seat, run, attempt, step, kind, text, options, status,
               *_values(kind, _read(damage, answer)), shown, ended)  # fmt: skip


def _read(damage: Damage, stored_json: str | None) -> Any:
    """Return what a JSON column holds; None if it is empty or damaged."""
    if stored_json is None:
        return None
    try:
        return msgspec.json.decode(stored_json)
    except msgspec.DecodeError:
        damage.note("answer")
        return None


def _values(kind: str, answer: Any) -> tuple[float | None, str | None, str | None]:
    """Return an answer as a number, as chosen options, or as words: whichever it is."""
    if isinstance(answer, int | float):
        return float(answer), None, None
    if isinstance(answer, list):
        return None, _BETWEEN.join(map(str, answer)), None
    if kind == "text":
        return None, None, answer
    return None, answer, None


def answers(damage: Damage) -> Table:
    """Return the table of the answers to questions between attempts."""
    return Table(
        name="answers",
        title="An answer to a question between attempts, or another step there",
        columns=(
            SESSION,
            stored("answers.number"),
            PARTICIPANT,
            SEAT,
            stored("answers.run"),
            stored("answers.attempt"),
            stored("answers.step"),
            stored("answers.kind"),
            stored("answers.text"),
            stored("answers.labels"),
            stored("answers.status"),
            stored("answers.answer.value"),
            stored("answers.answer.options"),
            stored("answers.answer.words"),
            stored("answers.shown_ns"),
            stored("answers.answered_ns"),
        ),
        key=("session", "number"),
        rows=partial(_rows, damage),
        references=(TO_SESSION,),
    )
