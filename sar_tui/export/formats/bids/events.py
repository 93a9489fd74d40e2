"""``_events.tsv``: trials, attempts, the agent's actions, notes, and faults of sensors, by their onsets."""

from collections.abc import Iterator, Mapping
from heapq import merge
from pathlib import Path
from typing import Any, NamedTuple

from sar_tui.export.columns import Column
from sar_tui.export.formats.bids.behaviour import RESPONSE_TIME, in_seconds
from sar_tui.export.formats.bids.study import Row, Session, Study
from sar_tui.export.formats.bids.tsv import MISSING, described, description, seconds, write_json, write_rows

_TYPES = {
    "attempt": "An attempt, from its first to its last moment.",
    "trial": "A trial: the onset is that of its prompt; in the reaching task, of the movement.",
    "action": "An action of the agent, from its first output to the end of its last one.",
    "note": "A note, or an event mark.",
    "sensor": "A fault of a motion sensor; a gap lasts from the last sample before it to the first after it.",
}
_TRIAL_TYPE = Column("trial_type", "What the event is.", "string", levels=tuple(_TYPES))
_COPIED = {
    "trials": ("attempt", "trial", "practice", "level", "stimulus", "response", "correct"),
    "attempts": ("metric", "metric_unit", "outcome", "feedback"),
    "actions": ("kind", "decision", "decided_by", "final_text"),
    "notes": ("written_by", "label", "text"),
    "sensor_faults": ("state", "samples"),
}
"""The columns that tell about events, by the table that describes them. A column of typed texts may not leave."""


class Event(NamedTuple):
    """An event: its onset on the steady clock of its run, its duration, and the columns that tell about it."""

    onset_ns: int
    duration_ns: int | None
    kind: str
    told: Mapping[str, Any]


class Window(NamedTuple):
    """The time that a file of events covers: from its zero; ``last_ns`` is None if there is no end."""

    zero_ns: int | None
    last_ns: int | None = None


def write_events(study: Study, session: Session, run: int, window: Window, path: Path) -> None:
    """Write the events of a run.

    Args:
        window: the time that onsets count from, None: from the first event; events outside of it are left out if it has
            an end, as there is a recording of motion then.
    """
    told = [column.name for column in _columns(study)]

    def rows() -> Iterator[list[Any]]:
        zero = window.zero_ns
        for event in _events(study, session, run):
            if zero is None:
                zero = event.onset_ns
            if window.last_ns is not None and not zero <= event.onset_ns <= window.last_ns:
                continue
            lasting = MISSING if event.duration_ns is None else seconds(event.duration_ns)
            start = [
                seconds(event.onset_ns - zero),
                lasting,
                event.kind,
                in_seconds(event.told.get("reaction_time_ms")),
            ]
            yield [*start, *map(event.told.get, told)]
        if window.last_ns is None:
            for trial in _trials(study, session, run):
                if trial["onset_ns"] is None:  # it has no place in time
                    yield [MISSING, MISSING, "trial", in_seconds(trial["reaction_time_ms"]), *map(trial.get, told)]

    path.parent.mkdir(parents=True, exist_ok=True)
    write_rows(path, ("onset", "duration", "trial_type", "response_time", *told), rows())


def describe_events(study: Study, task: str, facts: dict[str, Any], folder: Path) -> None:
    """Write what the columns of events mean, for all files of a task."""
    columns = {"trial_type": description(_TRIAL_TYPE, _TYPES), **described((RESPONSE_TIME, *_columns(study)))}
    write_json(folder / f"task-{study.tasks[task]}_events.json", {**facts, **columns})


def presentation(session: Session) -> dict[str, Any]:
    """Return the software that showed the prompts of a session, for the JSON beside its events."""
    facts = {
        "OperatingSystem": session.row["system"],
        "SoftwareName": "sar-tui",
        "SoftwareVersion": session.row["sar_tui"],
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


def _events(study: Study, session: Session, run: int) -> Iterator[Event]:
    """Yield the events of a run by onset. Trials come from the database one by one, as they are many."""
    few = [
        *_attempts(study, session, run),
        *_actions(study, session, run),
        *_notes(study, session, run),
        *_faults(study, session, run),
    ]
    trials = (
        Event(trial["onset_ns"], _between(trial["onset_ns"], trial["response_ns"]), "trial", trial)
        for trial in _trials(study, session, run)
        if trial["onset_ns"] is not None
    )
    return merge(sorted(few, key=_onset), trials, key=_onset)


def _onset(event: Event) -> int:
    return event.onset_ns


def _trials(study: Study, session: Session, run: int) -> Iterator[Row]:
    return (row for row in study.rows("trials", session.id) if row["seat"] == session.seat and row["run"] == run)


def _attempts(study: Study, session: Session, run: int) -> Iterator[Event]:
    for row in study.rows("attempts", session.id):
        if row["seat"] == session.seat and row["run"] == run and row["started_ns"] is not None:
            told = {name: row[name] for name in ("attempt", "practice", "level", *_COPIED["attempts"])}
            yield Event(row["started_ns"], _between(row["started_ns"], row["ended_ns"]), "attempt", told)


def _actions(study: Study, session: Session, run: int) -> Iterator[Event]:
    for row in study.rows("actions", session.id):
        if row["run"] == run and row["started_ns"] is not None:
            yield Event(row["started_ns"], _between(row["started_ns"], row["ended_ns"]), "action", row)


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
    """Return a duration; None if the end is not known, or is before the onset: the response came early."""
    return None if end_ns is None or end_ns < onset_ns else end_ns - onset_ns
