"""Trials: a row for each seat that took part, with the details of its task as columns."""

import sqlite3
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from sar_tui.export.columns import (
    MODE,
    PARTICIPANT,
    SEAT,
    SESSION,
    TASK,
    TO_SESSION,
    Column,
    Table,
    Values,
    as_bool,
    finite,
    stored,
)
from sar_tui.export.damage import Damage
from sar_tui.export.json_columns import Declared, columns, value_for
from sar_tui.export.seats import codes_by_seat

_TIMING = {
    "onset_source": stored(
        "trials.timing.onset_source",
        "string",
        "The onset was stamped when its frame was flushed to the terminal, at the refresh, or on a virtual clock.",
    ),
    "handler_delay_ms": stored(
        "trials.timing.handler_delay_ms", "number", "From the stamp of the key to its handling.", unit="ms"
    ),
    "loop_lag_ms": stored(
        "trials.timing.loop_lag_ms",
        "number",
        "Largest lag of the program's event loop while the response was awaited.",
        unit="ms",
    ),
    "false_starts": stored("trials.timing.false_starts", "integer", "Number of keys in the foreperiod."),
    "presentation": stored("trials.timing.presentation", "integer", "1, or more if pauses cancelled the prompt."),
    "foreperiod_ms": stored(
        "trials.timing.foreperiod_ms", "number", "Random wait before the prompt.", unit="ms"
    ),
    "flags": stored(
        "trials.timing.flags", "string", "Reasons to look at the trial twice, with spaces between them; empty: none."
    ),
    "frame_onsets_ns": stored(
        "trials.timing.frame_onsets_ns",
        "string",
        "When each frame of the prompt was on the terminal, session's clock, with spaces between; missing: no frames.",
        unit="ns",
    ),
    "tone_onsets_ns": stored(
        "trials.timing.tone_onsets_ns",
        "string",
        "When each tone of the prompt began, session's clock, with spaces between; missing: no tones.",
        unit="ns",
    ),
    "tone_source": stored(
        "trials.timing.tone_source",
        "string",
        "The onsets of tones are by the clock of the sound card (device), by that of the program (host), or virtual.",
    ),
}  # fmt: skip
_PLAIN = (
    SESSION,
    MODE,
    TASK,
    PARTICIPANT,
    stored(
        "trials.attempt", "integer", "Number of the attempt in the session, from 1.", required=True
    ),
    stored("trials.trial", "integer", "Number of the trial in the attempt, from 1.", required=True),
    SEAT,
    stored("trials.run", "integer", "The run of the program.", required=True),
    stored(
        "attempts.practice", "boolean", "True for practice; missing if the attempt was cut off."
    ),
    stored(
        "attempts.level", "integer", "The level of the attempt; missing if the attempt was cut off."
    ),
    stored("trials.stimulus", "string", "The prompt."),
    stored("trials.response", "string", "The pressed key, or the typed text; missing for a miss."),
    stored("trials.correct", "boolean", "True if the response was right."),
    stored(
        "trials.onset_ns",
        "integer",
        "When the prompt was on the terminal; in the reaching task: movement onset. Steady clock "
        "of the run.",
        unit="ns",
    ),
    stored(
        "trials.response_ns",
        "integer",
        "When the response came; in the reaching task: movement end. Steady clock of the run.",
        unit="ns",
    ),
    stored(
        "trials.reaction_time_ms",
        "number",
        "Response minus onset; in the reaching task: from the go signal to movement onset. "
        "Missing for a miss.",
        unit="ms",
    ),
    *_TIMING.values(),
)


def trials(
    database: sqlite3.Connection,
    sessions: Sequence[str],
    declared: Mapping[str, Declared],
    damage: Damage,
    not_loaded: Collection[str] = (),
) -> Table:
    """Return the table of the trials of these sessions.

    Args:
        declared: the details that the tasks of these sessions declare, by name.
        not_loaded: tasks that cannot be loaded, so that what they declare is not known.
    """
    details = columns(database, sessions, "trials", "details", declared, not_loaded=not_loaded)
    data = columns(
        database, sessions, "trials", "data", {}, other="Kept with the prompt by its task."
    )
    return Table(
        name="trials",
        title="A trial at a seat",
        columns=(*_PLAIN, *details.values(), *data.values()),
        key=("session", "attempt", "trial", "seat"),
        rows=partial(_rows, details, data, damage),
        references=(TO_SESSION,),
    )


def _rows(
    details: Mapping[str, Column],
    data: Mapping[str, Column],
    damage: Damage,
    database: sqlite3.Connection,
    session: str,
) -> Iterator[Values]:
    codes = codes_by_seat(database, session)
    (mode, task) = database.execute(
        "SELECT mode, task FROM sessions WHERE id=?", (session,)
    ).fetchone()
    for row in database.execute(
        "SELECT trials.attempt, trial, trials.seat, trials.run, practice, level, stimulus, "
        "response, trials.correct,"
        " onset_ns, response_ns, reaction_time_ms, timing, details, data FROM trials LEFT JOIN "
        "attempts ON"
        " attempts.session=trials.session AND attempts.attempt=trials.attempt AND "
        "attempts.seat=trials.seat"
        " WHERE trials.session=? ORDER BY trials.attempt, trial, trials.seat",
        (session,),
    ):
        (
            attempt,
            trial,
            seat,
            run,
            practice,
            level,
            stimulus,
            response,
            correct,
            onset,
            end,
            *rest,
        ) = row
        reaction, timed, told, kept = rest
        found, of_prompt = damage.object_of("details", told), damage.object_of("data", kept)
        yield (
            session, mode, task, codes.get(seat), attempt, trial, seat, run, as_bool(practice), level, stimulus,
            response, as_bool(correct), onset, end,
            finite(reaction),
            *_timing(damage.object_of("timing", timed)),
            *(value_for(column, found.get(key)) for key, column in details.items()),
            *(value_for(column, of_prompt.get(key)) for key, column in data.items()),
        )  # fmt: skip


def _timing(timing: dict[str, Any]) -> Iterator[Any]:
    for key in _TIMING:
        value = timing.get(key)
        yield " ".join(map(str, value)) if isinstance(value, list) else value
