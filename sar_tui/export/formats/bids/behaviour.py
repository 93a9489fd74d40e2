"""``_beh.tsv``: a row for each trial of a run."""

from contextlib import ExitStack
from operator import itemgetter
from pathlib import Path
from typing import Any, TextIO

from sar_tui.export.columns import Column
from sar_tui.export.formats.bids.study import Session, Study
from sar_tui.export.formats.bids.tsv import described, line, write_json

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
    kept = [names.index(column.name) for column in _columns(study, session.task)]
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
    columns = (RESPONSE_TIME, *_columns(study, task))
    write_json(folder / f"task-{study.tasks[task]}_beh.json", {**facts, **described(columns)})


def in_seconds(milliseconds: float | None) -> float | None:
    """Return milliseconds as seconds."""
    return None if milliseconds is None else milliseconds / 1000


def _columns(study: Study, task: str) -> list[Column]:
    """Return the columns of trials that a task has, without those that the names of files and
    folders tell.
    """
    return [
        column
        for column in study.columns("trials")
        if column.name not in _IN_THE_PATH and (column.tasks is None or task in column.tasks)
    ]
