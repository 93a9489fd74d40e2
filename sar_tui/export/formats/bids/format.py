"""The format ``bids``."""

from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sar_tui.export.contents import Contents
from sar_tui.export.formats.bids.dataset import (
    SOURCE,
    describe_scans,
    write_dataset,
    write_phenotype,
    write_scans,
    write_sessions,
)
from sar_tui.export.formats.bids.events import (
    Window,
    describe_behaviour,
    describe_events,
    presentation,
    write_behaviour,
    write_events,
)
from sar_tui.export.formats.bids.motion import describe_motion, write_motion
from sar_tui.export.formats.bids.study import Run, Session, Study
from sar_tui.export.formats.bids.tsv import write_json
from sar_tui.export.formats.csv import CsvFormat

_OWN = ("trials", "imu")
"""Tables that are whole in files of BIDS; the others are tables of their own, too."""


class BidsFormat:
    """A BIDS data set: a session of two persons is a session of each."""

    name = "bids"
    title = "a BIDS data set, with events, motion and questionnaires"

    def write(self, contents: Contents, folder: Path, progress: Callable[[], None]) -> None:
        """Write the data set. Raises ExportError if BIDS cannot tell two participants or tasks
        apart.
        """
        study = Study(contents)
        sessions = defaultdict(list)
        for session in study.sessions:
            sessions[session.id].append(session)
        facts = {task: _facts(study, task) for task in study.tasks}
        with_motion = set()
        for id in study.owners("sessions"):
            for session in sessions[id]:
                if _write_session(study, session, facts[session.task], folder / session.folder):
                    with_motion.add(session.task)
            for _ in _OWN:
                progress()
        for task, known in facts.items():
            describe_behaviour(study, task, known, folder)
            describe_events(study, task, known, folder)
            if task in with_motion:
                describe_motion(study, task, folder)
        write_sessions(study, folder)
        describe_scans(folder)
        write_phenotype(study, folder)
        write_dataset(study, contents.problems, contents.notices, folder)
        source = folder / SOURCE
        source.mkdir(parents=True)
        rest = contents.part([table.name for table in contents.tables if table.name not in _OWN])
        CsvFormat().write(rest, source, progress)


def _write_session(study: Study, session: Session, facts: dict[str, Any], folder: Path) -> bool:
    """Write the files of a session of a subject. Return True if it has samples of motion.

    Args:
        facts: about its task.
    """
    recordings: list[tuple[str, str | None]] = []
    shown_by = presentation(session)
    for number in sorted(write_behaviour(study, session, folder)):
        run = session.runs.get(number, Run(number))
        recordings.append((session.path("beh", "beh.tsv", number), run.time_of_day(run.clock_ns)))
        write_events(
            study,
            session,
            number,
            Window(run.clock_ns),
            folder / session.path("beh", "events.tsv", number),
        )
        write_json(folder / session.path("beh", "events.json", number), shown_by)
    motion = list(write_motion(study, session, facts, folder))
    for each in motion:
        run = session.runs.get(each.run, Run(each.run))
        recordings.append((each.path, run.time_of_day(each.first_ns)))
        window = Window(each.first_ns, each.last_ns)
        path = session.path("motion", "events.tsv", each.run, tracksys=each.tracksys)
        write_events(study, session, each.run, window, folder / path)
        write_json((folder / path).with_suffix(".json"), shown_by)
    write_scans(session, recordings, folder)
    return bool(motion)


def _facts(study: Study, task: str) -> dict[str, Any]:
    """Return what is known of a task, for the JSON of its files."""
    titles = (session.row["task_title"] for session in study.sessions if session.task == task)
    return {"TaskName": task, "TaskDescription": next(filter(None, titles), task)}
