"""Files about the data set and its sessions: description, participants, README, questionnaires."""

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from sar_tui import __version__
from sar_tui.export.contents import dataset_name
from sar_tui.export.formats.bids.study import Row, Session, Study, label
from sar_tui.export.formats.bids.tsv import described, write_json, write_rows
from sar_tui.progress.instruments import INSTRUMENTS

VERSION = "1.10.0"
"""The version of BIDS that the files follow."""
SOURCE = "sourcedata/sar-tui"
"""The folder of the tables that BIDS has no place for."""
_BESIDE = ("timing.json", "methods.md", "sar-tui-export.json")
"""Files that every export has beside those of its format."""
_README = """\
# {name}

Exported by sar-tui {version} as a BIDS {bids} data set. {modes}

- `sub-*/ses-*/beh/*_beh.tsv`: a row for each trial, practice included (column `practice`). `run` in a file name is the
  run of the program: a session that was resumed has several.
- `*_events.tsv`: trials, attempts, the agent's actions, notes, and faults of sensors. In `beh/`, onsets count from
  `acq_time` in `_scans.tsv`; in `motion/`, from the first sample.
- `sub-*/ses-*/motion/`: the samples of motion sensors. Where samples are missing, a row of n/a stands.
- `sub-*/*_sessions.tsv`: each session with its status. Interrupted, dismissed and empty sessions are included;
  those that are discarded (started by mistake) or refused belong into no analysis of training.
- `phenotype/`: scores of instruments, and answers about pain and tiredness.
- `{source}/`: all tables that BIDS has no place for, as CSV with `datapackage.json`: parameters of the sessions,
  programmes, attempts, all actions with the decisions on them, adverse events, and others.
- `methods.md`, `timing.json`, `sar-tui-export.json`: methods in words, the measured timing of the machine, and the
  SHA-256 of every file. BIDS has no place for them: they are named in `.bidsignore`.

In a text, a tab, a line end, a backslash, and a quote at its beginning are written as in JSON: `\\t`, `\\n`, `\\r`,
`\\\\`, `\\"`. A value that is missing is n/a.

Age, sex and handedness are not in the database, so `participants.tsv` does not have them. Add them, and the authors and
the licence in `dataset_description.json`, before you publish.
"""


def write_dataset(
    study: Study, left_out: Iterable[str], notices: Iterable[str], folder: Path
) -> None:
    """Write the description, the participants, the README, and the names of the files that BIDS
    does not know.

    Args:
        left_out: sentences on what is not in the data set.
        notices: sentences on what is not described.
    """
    name = dataset_name({session.row["mode"] for session in study.sessions})
    write_json(
        folder / "dataset_description.json",
        {
            "Name": name,
            "BIDSVersion": VERSION,
            "DatasetType": "raw",
            "GeneratedBy": [
                {
                    "Name": "sar-tui",
                    "Version": __version__,
                    "Description": "Sessions were recorded by sar-tui, and exported from its "
                    "database.",
                }
            ],
        },
    )
    columns = study.columns("participants")
    rows = [
        (f"sub-{study.subjects[code]}", *row)
        for code in study.owners("participants")
        for row in study.values("participants", code)
    ]
    write_rows(
        folder / "participants.tsv", ("participant_id", *(column.name for column in columns)), rows
    )
    write_json(folder / "participants.json", described(columns))
    said = [
        _README.format(
            name=name, version=__version__, bids=VERSION, modes=_modes(study), source=SOURCE
        )
    ]
    for title, told in (("Not described", notices), ("Left out", left_out)):
        if sentences := [f"- {sentence}\n" for sentence in dict.fromkeys(told)]:
            said.append("".join([f"## {title}\n\n", *sentences]))
    (folder / "README.md").write_text("\n".join(said), encoding="utf-8")
    (folder / ".bidsignore").write_text("".join(f"{name}\n" for name in _BESIDE), encoding="utf-8")


def _modes(study: Study) -> str:
    """Return a sentence on how many sessions are live, and how many are not."""
    counts = Counter({session.id: session.row["mode"] for session in study.sessions}.values())
    told = ", ".join(f"{number} {mode}" for mode, number in sorted(counts.items()))
    return f"Sessions: {told or 'none'} (column `mode` of `_sessions.tsv` and `_beh.tsv`)."


_ELSEWHERE = ("session", "participant", "partner", "started_at")
_ACQ_TIME = "acq_time"


def write_sessions(study: Study, folder: Path) -> None:
    """Write the sessions of each subject, and what their columns mean."""
    columns = {
        column.name: column for column in study.columns("sessions") if column.name not in _ELSEWHERE
    }
    sessions: dict[str, list[Session]] = {}
    for session in study.sessions:
        sessions.setdefault(session.subject, []).append(session)
    for subject, own in sessions.items():
        rows = (
            (
                f"ses-{session.label}",
                session.row["started_at"],
                session.seat,
                f"sub-{session.partner}" if session.partner else None,
                *(session.row[name] for name in columns),
            )
            for session in own
        )
        path = folder / f"sub-{subject}" / f"sub-{subject}_sessions.tsv"
        path.parent.mkdir(exist_ok=True)
        write_rows(path, ("session_id", _ACQ_TIME, "seat", "partner", *columns), rows)
    added = {
        _ACQ_TIME: {"Description": "When the session began, UTC."},
        "seat": {"Description": "The participant's place: A, or B in a task for two."},
        "partner": {"Description": "The other participant, in a task for two."},
    }
    write_json(folder / "sessions.json", {**added, **described(columns.values())})


def write_scans(
    session: Session, recordings: Iterable[tuple[str, str | None]], folder: Path
) -> None:
    """Write the recordings of a session, each with the time of day of its zero.

    Args:
        folder: of the session.
    """
    write_rows(folder / f"{session.stem}_scans.tsv", ("filename", _ACQ_TIME), recordings)


def describe_scans(folder: Path) -> None:
    """Write what the columns of recordings mean."""
    meaning = "The time of day of the recording's zero, UTC."
    write_json(folder / "scans.json", {_ACQ_TIME: {"Description": meaning}})


_FOLDER = "phenotype"
_WELLBEING = "wellbeing"
_DAY = len("2026-11-23")
_MOMENTS = {"before": "before the session", "pause": "in a pause", "after": "after the session"}
_QUESTIONS = {
    "pain": "Pain, 0 (none) to 10; yes: chosen in a pause; not said: would rather not say.",
    "place": "The number of the place of the pain.",
    "fatigue": "Tiredness, 0 (none) to 10; not said: would rather not say.",
    "advice": "What came of the advice not to train: shown, stopped, went on.",
}


class Tool(msgspec.Struct, frozen=True):
    """A measurement tool.

    Attributes:
        columns: descriptions of what is measured on an occasion, by name.
        occasions: of each person, by code, each with values by the names of columns.
    """

    description: str
    columns: Mapping[str, Mapping[str, Any]]
    occasions: Mapping[str, list[Row]]


def write_phenotype(study: Study, folder: Path) -> None:
    """Write a file for each tool that was used."""
    tools: dict[str, Tool] = {}
    for name, tool in _instruments(study).items():
        file = label(name).lower() or "instrument"
        while file in (*tools, _WELLBEING):
            file += "x"
        tools[file] = tool
    if (wellbeing := _wellbeing(study)).occasions:
        tools[_WELLBEING] = wellbeing
    for name, tool in tools.items():
        _write(study, name, tool, folder / _FOLDER)


def _write(study: Study, name: str, tool: Tool, folder: Path) -> None:
    times = range(1, max(map(len, tool.occasions.values())) + 1)
    head = [f"{column}_{time}" for time in times for column in tool.columns]
    rows = (
        [f"sub-{study.subjects[code]}", *map(_numbered(occasions).get, head)]
        for code, occasions in tool.occasions.items()
    )
    folder.mkdir(exist_ok=True)
    write_rows(folder / f"{name}.tsv", ("participant_id", *head), rows)
    described = {
        f"{column}_{time}": {**told, "Description": f"Occasion {time}: {told['Description']}"}
        for time in times
        for column, told in tool.columns.items()
    }
    write_json(
        folder / f"{name}.json",
        {"MeasurementToolMetadata": {"Description": tool.description}, **described},
    )


def _numbered(occasions: Iterable[Row]) -> Row:
    return {
        f"{name}_{time}": value
        for time, row in enumerate(occasions, 1)
        for name, value in row.items()
    }


def _instruments(study: Study) -> dict[str, Tool]:
    """Return the scores of each instrument. Of a day, what was recorded last counts."""
    last: dict[str, dict[str, dict[str, Row]]] = {}
    for code in study.owners("instrument_scores"):
        for row in study.rows("instrument_scores", code):
            last.setdefault(row["instrument"], {}).setdefault(code, {})[row["date"]] = row
    found: dict[str, Tool] = {}
    for name, persons in sorted(last.items()):
        occasions = {
            code: [
                {"date": day, "score": row["score"]}
                for day, row in sorted(days.items())
                if not row["removed"]
            ]
            for code, days in persons.items()
        }
        if kept := {code: scores for code, scores in occasions.items() if scores}:
            found[name] = _tool(name, kept)
    return found


def _tool(name: str, occasions: Mapping[str, list[Row]]) -> Tool:
    known = INSTRUMENTS.get(name)
    score: dict[str, Any] = {"Description": f"Score of {name}."}
    if known is not None:
        better = f"{known.better} is better"
        score = {"Description": f"Score of {name}, {known.lowest:g} to {known.highest:g}; {better}.",
                 "Units": known.unit}  # fmt: skip
    columns = {"date": {"Description": "Day of the measurement."}, "score": score}
    return Tool(f"{known.title} ({name})" if known else name, columns, occasions)


def _wellbeing(study: Study) -> Tool:
    """Return the answers about pain and tiredness. The last answer to a question counts.

    An occasion is a session, or the day of answers before a session that never began.
    """
    labels = {session.id: f"ses-{session.label}" for session in study.sessions}
    occasions: dict[str, dict[str, Row]] = {}
    asked: set[str] = set()
    for code in study.owners("wellbeing"):
        for row in study.rows("wellbeing", code):
            session = row["session"]
            if code in study.subjects and (session is None or session in labels):
                column = f"{row['question']}_{row['moment']}"
                asked.add(column)
                answers = occasions.setdefault(code, {}).setdefault(session or row["at"][:_DAY], {})
                answers |= {"session": labels.get(session), column: row["answer"]}
    columns = {
        f"{question}_{moment}": {"Description": f"{told} Asked {when}."}
        for moment, when in _MOMENTS.items()
        for question, told in _QUESTIONS.items()
        if f"{question}_{moment}" in asked
    }
    return Tool(
        "Questions about pain and tiredness with numeric rating scales, asked by sar-tui in its "
        "sessions.",
        {"session": {"Description": "The session; n/a: it never began."}, **columns},
        {code: list(sessions.values()) for code, sessions in occasions.items()},
    )
