"""Reads what the first screen shows of a participant."""

import sqlite3
from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING

import msgspec
from msgspec.structs import replace

from sar_tui.app.home import words
from sar_tui.app.home.chart import Chart, charted
from sar_tui.app.home.day import Day, day_of
from sar_tui.app.home.session_list import Line
from sar_tui.app.home.words import Programme
from sar_tui.loop.task import Task
from sar_tui.model.language import Language, in_language, language
from sar_tui.model.results_for_people import short_goal
from sar_tui.model.session_mode import is_personal
from sar_tui.model.trial_types import Metric
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.plugins import Catalogue, PluginError, task_folder
from sar_tui.progress.lines import SessionResults
from sar_tui.reports import progress_words
from sar_tui.reports.progress import progress
from sar_tui.reports.wellbeing import advice, marks, worst
from sar_tui.rules.declaration import ParameterError
from sar_tui.rules.parameters import build, usable
from sar_tui.rules.wellbeing import tell_therapist
from sar_tui.runs.plan import Failed, set_up
from sar_tui.runs.start_level import LOOKED_AT, start_after
from sar_tui.store import (
    courses,
    participants,
    programmes,
    provenance,
    results,
    sessions,
    wellbeing,
)
from sar_tui.store.records import Record
from sar_tui.store.training_days import trained_at
from sar_tui.store.wellbeing import PAIN, TIREDNESS

if TYPE_CHECKING:  # loaded if there is a letterbox
    from sar_tui.app.home.homes import Homes

_LISTED = 30
_MODES = {"simulated": "simulated", "replayed": "replayed"}


class CardContents(msgspec.Struct, frozen=True):
    """Contents of a participant's card, for a task.

    Args:
        programme: of the next session in few words, or why it cannot begin.
        programme_in_full: the same with more room.
        chart: of the sessions that can be compared with the next one.
        progress: the verdict on them.
        last: the last session.
        offer: of the newest session if it was interrupted.
        told: what the therapist should know of the last sessions, however long ago.
    """

    programme: str
    programme_in_full: str
    chart: Chart
    progress: str
    last: str
    told: Sequence[str]


def read_card(
    database: sqlite3.Connection,
    folder: Path,
    catalogue: Catalogue,
    participant: str,
    kind: type[Task],
    today: date,
    tr: Language,
) -> CardContents:
    """Return what a participant's card says of a task; ``tr``: in the app's language."""
    tr = progress_words.words(tr.code, kind).including(tr.texts)
    every = results.sessions_of(database, participant, kind.name, folder=folder)
    played = [each for each in every if is_personal(each.mode)]
    found = progress(participant, played, {kind.name: kind}.get, today=today)
    line = found.lines[-1] if found.lines else None
    others = sum(bool(each.results) for each in played) - (len(line.sessions) if line else 0)
    last = played[-1] if played else None
    felt = wellbeing.by_session(database, [last.session]).get(last.session, ()) if last else ()
    mine = [told for told in felt if told.participant == participant]
    programme, in_full = _programme(database, participant, kind, played[-LOOKED_AT:], tr)
    return CardContents(
        programme=programme,
        programme_in_full=in_full,
        chart=charted(line, tr) if line else Chart(),
        progress=words.progress_words(line, others, tr) if line else "",
        last=words.last_words(last, marks(mine, tr), today, tr) if last else "",
        told=advice(tell_therapist(wellbeing.newest_ratings(database, participant)), tr),
    )


def _programme(
    database: sqlite3.Connection,
    participant: str,
    kind: type[Task],
    played: Sequence[SessionResults],
    tr: Language,
) -> tuple[str, str]:
    """Return what the next session will do, or why it cannot begin: in few words, and in full."""
    saved = programmes.newest(database, participant, kind.name)
    try:
        parameters = build(kind.Parameters, usable(kind.Parameters, saved.parameters)[0])
        task = set_up(kind, parameters)
        start = start_after(task, played)
        value = task.goal_value(start.level)
        goal = "" if value is None else short_goal(kind.metric, value)
        prompts = task.trials_at(start.level)
    except (ParameterError, Failed) as error:
        problem = in_language(error, tr)
        return problem, problem
    except PLUGIN_ERRORS:
        problem = tr("The task cannot be set up.")
        return problem, problem
    next_one = Programme(parameters.attempts, prompts, goal, start.level, start.why)
    return (
        words.programme_words(next_one, tr, is_roomy=False),
        words.programme_words(next_one, tr, is_roomy=True),
    )


def read_day(
    database: sqlite3.Connection,
    folder: Path,
    today: date,
    tr: Language,
    homes: Mapping[str, "Homes"] = {},
) -> Day:
    """Return the day: the people of this site, and what is to be said of them; ``homes``: of those
    who train at home, by participant.
    """
    people = [
        replace(each, course=replace(each.course, at_home=homes[each.code].facts))
        if each.code in homes
        else each
        for each in courses.read_people(database, folder, today)
    ]
    said = {code: own.shortly(today, tr) for code, own in homes.items()}
    return day_of(people, participants.last_used(database), today, tr, said)


class Listed(msgspec.Struct, frozen=True):
    """Sessions, newest first, with the line of each. ``offered``: an interrupted one to go on with;
    None without.
    """

    rows: Sequence[sessions.Row]
    lines: Sequence[Line]
    offered: sessions.Row | None


def read_sessions(
    database: sqlite3.Connection,
    folder: Path,
    catalogue: Catalogue,
    participant: str | None,
    tr: Language,
) -> Listed:
    """Return the newest sessions of a participant, or of everyone."""
    rows = sessions.listing(database, folder, participant=participant, limit=_LISTED)
    names = [row["id"] for row in rows]
    felt = wellbeing.by_session(database, names)
    played = results.attempts_of(database, names)
    open_ones = filter(can_resume, rows)
    offered = next(
        (row for row in open_ones if not sessions.came_by_letter(database, row["id"])), None
    )
    titles = {task: _title(catalogue, task, tr) for task in {row["task"] for row in rows}}

    def line(row: sessions.Row) -> Line:
        seat = "B" if participant and row["partner"] == participant else "A"
        attempts = played.get((row["id"], seat), [])
        began = trained_at(row["started_at"], row["utc_offset_s"])
        means = [each.metric for each in attempts if each.metric is not None]
        judged = [each.reached for each in attempts if each.reached is not None]
        metric = _metric(row)
        told = [
            record
            for record in felt.get(row["id"], [])
            if participant in (None, record.participant)
        ]
        return Line(
            day=began.date(),
            clock=f"{began:%H:%M}",
            who=sessions.participant_codes(row),
            task=titles[row["task"]],
            levels=[each.level for each in attempts],
            result=words.short(metric, fmean(means), tr) if means and metric else "",
            reached=tr("{reached} of {count}", reached=sum(judged), count=len(judged))
            if judged
            else "",
            minutes=round(sum(each.seconds for each in attempts) / 60),
            pain=_rating(told, PAIN, tr),
            tired=_rating(told, TIREDNESS, tr),
            note=_note(row, participant, tr, is_offered=row is offered),
        )

    return Listed(rows, [line(row) for row in rows], offered)


def can_resume(row: sessions.Row) -> bool:
    """Return True if a listed session can be gone on with."""
    return bool(row["status"] == "interrupted" and is_personal(row["mode"]) and not row["site"])


def _rating(told: Sequence[Record], kind: str, tr: Language) -> str:
    """Return the worst rating of a symptom; "yes" if it was told in a pause without a number."""
    rating = worst(told, kind)
    in_pause = any(record.kind == kind and record.moment == "pause" for record in told)
    if not rating and in_pause:
        return tr("yes")
    return "" if rating is None else str(rating)


def _note(row: sessions.Row, participant: str | None, tr: Language, *, is_offered: bool) -> str:
    """Return the status, if it is not the usual one, and who else took part."""
    status = words.status_words(row["status"], tr)
    if is_offered:
        status = tr("interrupted: Enter resumes")
    mode = "" if is_personal(row["mode"]) else tr(_MODES.get(row["mode"], str(row["mode"])))
    other = row["participant"] if participant == row["partner"] else row["partner"]
    together = tr("with {who}", who=other) if participant and other else ""
    return ", ".join(filter(None, (status, mode, together)))


def _metric(row: sessions.Row) -> Metric | None:
    try:
        return provenance.metric(row["software"])
    except (KeyError, TypeError, msgspec.ValidationError):
        return None


def _title(catalogue: Catalogue, task: str, tr: Language) -> str:
    try:
        kind = catalogue.task(task)
        return language(tr.code, task_folder(kind))(kind.title)
    except PluginError:  # it is no longer installed
        return task
