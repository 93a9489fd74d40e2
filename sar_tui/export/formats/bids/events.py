"""Trials of a run (``_beh.tsv``), and all that happened by its onset (``_events.tsv``)."""

from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from heapq import merge
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple, TextIO

from sar_tui.export.columns import Column
from sar_tui.export.formats.bids.study import Row, Session, Study
from sar_tui.export.formats.bids.tsv import (
    described,
    description,
    line,
    seconds,
    write_json,
    write_rows,
)

_IN_THE_PATH = ("session", "participant", "task", "seat", "run")
RESPONSE_TIME = Column(
    "response_time",
    "Time from the onset to the response; in the reaching task: from the go signal to movement "
    "onset. n/a for a miss.",
    "number",
    "s",
)


def write_behaviour(study: Study, session: Session, folder: Path) -> set[int]:
    """Write the trials of a session, and return the runs. A run without a trial has a file with its
    header line.

    Args:
        folder: of the session.
    """
    names = [column.name for column in study.columns("trials")]
    seat, run, reaction = (names.index(name) for name in ("seat", "run", "reaction_time_ms"))
    kept = [names.index(column.name) for column in _columns_of_trials(study, session.task)]
    pick = itemgetter(*kept)
    head = line(["response_time", *(names[index] for index in kept)])
    with ExitStack() as open_files:
        files: dict[int, TextIO] = {}

        def file_of(number: int) -> TextIO:
            path = folder / session.path("beh", "beh.tsv", number)
            path.parent.mkdir(parents=True, exist_ok=True)
            file = files[number] = open_files.enter_context(
                path.open("w", encoding="utf-8", newline="")
            )
            file.write(head)
            return file

        for number in session.runs:
            file_of(number)
        for row in study.values("trials", session.id):
            if row[seat] == session.seat:
                file = files.get(row[run]) or file_of(row[run])
                file.write(line((in_seconds(row[reaction]), *pick(row))))
    return set(files)


def describe_behaviour(study: Study, task: str, facts: dict[str, Any], folder: Path) -> None:
    """Write what the columns of a task's trials mean, for all of its files.

    Args:
        facts: about the task.
        folder: of the data set.
    """
    columns = (RESPONSE_TIME, *_columns_of_trials(study, task))
    write_json(folder / f"task-{study.tasks[task]}_beh.json", {**facts, **described(columns)})


def in_seconds(milliseconds: float | None) -> float | None:
    """Return milliseconds as seconds."""
    return None if milliseconds is None else milliseconds / 1000


def _columns_of_trials(study: Study, task: str) -> list[Column]:
    """Return the columns of trials that a task has, without those that the names of files and
    folders tell.
    """
    return [
        column
        for column in study.columns("trials")
        if column.name not in _IN_THE_PATH and (column.tasks is None or task in column.tasks)
    ]


_TYPES = {
    "attempt": "An attempt, from its first to its last moment.",
    "trial": "A trial: the onset is that of its prompt; in the reaching task, of the movement.",
    "action": "An action of the agent, from its first output to the end of its last one.",
    "step": "A question, or another step between attempts, from its first moment to its answer or "
    "end.",
    "note": "A note, or an event mark.",
    "sensor": "A fault of a motion sensor; a gap lasts from the last sample before it to the "
    "first after it.",
}
_TRIAL_TYPE = Column("trial_type", "What the event is.", "string", levels=tuple(_TYPES))
_COPIED = {
    "trials": ("attempt", "trial", "practice", "level", "stimulus", "response", "correct"),
    "attempts": ("metric", "metric_unit", "outcome", "feedback"),
    "actions": ("kind", "decision", "decided_by", "final_text"),
    "answers": ("step", "status", "value", "chosen", "words"),
    "notes": ("written_by", "label", "text"),
    "sensor_faults": ("state", "samples"),
}
"""The columns that tell about events, by the table that describes them. A column of typed texts may
not leave.
"""


class Event(NamedTuple):
    """An event: its onset on the steady clock of its run, its duration, and the columns that tell
    about it.
    """

    onset_ns: int
    duration_ns: int | None
    kind: str
    told: Mapping[str, Any]


class Window(NamedTuple):
    """The time that a file of events covers: from its zero; ``last_ns`` is None if there is no
    end.
    """

    zero_ns: int | None
    last_ns: int | None = None


def write_events(study: Study, session: Session, run: int, window: Window, path: Path) -> None:
    """Write the events of a run.

    Args:
        window: the time that onsets count from, None: from the first event. If it has an end, as
            that of a recording of motion, only the events inside of it are written.
    """
    told = [column.name for column in _columns(study)]
    path.parent.mkdir(parents=True, exist_ok=True)
    head = ("onset", "duration", "trial_type", "response_time", *told)
    write_rows(path, head, _rows(study, session, run, window, told))


def _rows(
    study: Study, session: Session, run: int, window: Window, told: list[str]
) -> Iterator[list[Any]]:
    zero, last = window
    unplaced: list[Row] = []
    for event in _events(study, session, run, unplaced):
        if zero is None:
            zero = event.onset_ns
        if last is None or zero <= event.onset_ns <= last:
            lasted = None if event.duration_ns is None else seconds(event.duration_ns)
            response_time = in_seconds(event.told.get("reaction_time_ms"))
            yield [
                seconds(event.onset_ns - zero),
                lasted,
                event.kind,
                response_time,
                *map(event.told.get, told),
            ]
    if last is None:
        for trial in unplaced:
            yield [
                None,
                None,
                "trial",
                in_seconds(trial["reaction_time_ms"]),
                *map(trial.get, told),
            ]


def describe_events(study: Study, task: str, facts: dict[str, Any], folder: Path) -> None:
    """Write what the columns of events mean, for all files of a task."""
    columns = {
        "trial_type": description(_TRIAL_TYPE, _TYPES),
        **described((RESPONSE_TIME, *_columns(study))),
    }
    write_json(folder / f"task-{study.tasks[task]}_events.json", {**facts, **columns})


def presentation(session: Session) -> dict[str, Any]:
    """Return the software that showed the prompts of a session, for the JSON beside its events."""
    facts = {
        "OperatingSystem": session.row.get("system"),
        "SoftwareName": "sar-tui",
        "SoftwareVersion": session.row.get("sar_tui"),
    }
    return {"StimulusPresentation": {name: fact for name, fact in facts.items() if fact}}


def _columns(study: Study) -> list[Column]:
    return [
        column
        for table, names in _COPIED.items()
        for name in names
        for column in study.columns(table)
        if column.name == name
    ]


def _events(study: Study, session: Session, run: int, unplaced: list[Row]) -> Iterator[Event]:
    """Yield the events of a run by onset. Trials come from the database one by one, as they are
    many.

    Args:
        unplaced: gets the trials without an onset.
    """
    few = [
        *_attempts(study, session, run),
        *_actions(study, session, run),
        *_steps(study, session, run),
        *_notes(study, session, run),
        *_faults(study, session, run),
    ]

    def trials() -> Iterator[Event]:
        for trial in study.rows("trials", session.id):
            if trial["seat"] != session.seat or trial["run"] != run:
                continue
            if trial["onset_ns"] is None:
                unplaced.append(trial)
            else:
                yield Event(
                    trial["onset_ns"],
                    _between(trial["onset_ns"], trial["response_ns"]),
                    "trial",
                    trial,
                )

    return merge(sorted(few, key=_onset), trials(), key=_onset)


def _onset(event: Event) -> int:
    return event.onset_ns


def _attempts(study: Study, session: Session, run: int) -> Iterator[Event]:
    for row in study.rows("attempts", session.id):
        if row["seat"] == session.seat and row["run"] == run and row["started_ns"] is not None:
            told = {
                name: row[name] for name in ("attempt", "practice", "level", *_COPIED["attempts"])
            }
            yield Event(
                row["started_ns"], _between(row["started_ns"], row["ended_ns"]), "attempt", told
            )


def _actions(study: Study, session: Session, run: int) -> Iterator[Event]:
    for row in study.rows("actions", session.id):
        if row["run"] == run and row["started_ns"] is not None:
            yield Event(
                row["started_ns"], _between(row["started_ns"], row["ended_ns"]), "action", row
            )


def _steps(study: Study, session: Session, run: int) -> Iterator[Event]:
    for row in study.rows("answers", session.id):
        if row["seat"] == session.seat and row["run"] == run and row["shown_ns"] is not None:
            told = {name: row.get(name) for name in ("attempt", *_COPIED["answers"])}
            yield Event(
                row["shown_ns"], _between(row["shown_ns"], row["answered_ns"]), "step", told
            )


def _notes(study: Study, session: Session, run: int) -> Iterator[Event]:
    for row in study.rows("notes", session.id):
        if row["run"] == run and row["at_ns"] is not None:
            yield Event(row["at_ns"], 0, "note", row)


def _faults(study: Study, session: Session, run: int) -> Iterator[Event]:
    for row in study.rows("sensor_faults", session.id):
        if row["seat"] == session.seat and row["run"] == run and row["at_ns"] is not None:
            lasted = None if row["duration_ms"] is None else round(row["duration_ms"] * 1e6)
            began = row["at_ns"] - (lasted or 0) if row["state"] == "gap" else row["at_ns"]
            yield Event(began, lasted, "sensor", row)


def _between(onset_ns: int, end_ns: int | None) -> int | None:
    """Return a duration; None if the end is not known, or is before the onset: the response came
    early.
    """
    return None if end_ns is None or end_ns < onset_ns else end_ns - onset_ns
