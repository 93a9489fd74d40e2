"""Files about the data set and its sessions: description, participants, README, questionnaires."""

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from sar_tui import __version__
from sar_tui.export.contents import dataset_name
from sar_tui.export.formats.bids.study import Row, Session, Study, label
from sar_tui.export.formats.bids.tsv import described, text, write_json, write_rows
from sar_tui.records.kind import NOT_SAID, Field, Kind, kinds

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
- `phenotype/`: records of people: pain and tiredness, scores of other tests, adverse events.
- `{source}/`: all tables that BIDS has no place for, as CSV with `datapackage.json`: parameters of the sessions,
  programmes, attempts, all actions with the decisions on them, and others.
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


_ELSEWHERE = ("participant", "partner", "started_at")
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
_OCCASION = {
    "date": {"Description": "When it was, or when it was told."},
    "session": {"Description": "The session; n/a: none."},
    "moment": {"Description": "Before or after the session, or in a pause of it; n/a: none."},
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
    """Write a file for each kind of record that is there."""
    used: set[str] = set()
    for name, tool in _tools(study).items():
        file = label(name).lower() or "record"
        while file in used:
            file += "x"
        used.add(file)
        _write(study, file, tool, folder / _FOLDER)


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


def _tools(study: Study) -> dict[str, Tool]:
    """Return what is known of each kind of record: its last versions, but for those removed."""
    declared = kinds()
    found: dict[str, dict[str, dict[str, Row]]] = {}
    for code in study.owners("records"):
        if code in study.subjects:
            for id, (kind, occasion) in _occasions(study, code).items():
                found.setdefault(kind, {}).setdefault(code, {})[id] = occasion
    return {
        kind: _tool(
            kind, declared.get(kind), {code: list(own.values()) for code, own in of.items()}
        )
        for kind, of in sorted(found.items())
    }


def _occasions(study: Study, code: str) -> dict[str, tuple[str, Row]]:
    """Return the kind and the values of each record of a person, by its id, in their order."""
    sessions = {session.id: f"ses-{session.label}" for session in study.sessions}
    last: dict[str, list[Row]] = {}
    for row in study.rows("records", code):
        known = last.setdefault(row["record"], [])
        if known and known[0]["version"] < row["version"]:
            known.clear()
        known.append(row)
    found = {}
    for id, rows in last.items():
        first = rows[0]
        session = first["session"]
        if first["removed"] or (session is not None and session not in sessions):
            continue
        values = {row["field"]: _value(row) for row in rows}
        found[id] = (
            first["kind"],
            {
                "date": first["at"],
                "session": sessions.get(session or ""),
                "moment": first["moment"] or None,
                **values,
            },
        )
    return found


def _value(row: Row) -> Any:
    values = (row["value"], row["option"], row.get("words"))
    return next((value for value in values if value is not None), None)


def _tool(name: str, kind: Kind | None, occasions: Mapping[str, list[Row]]) -> Tool:
    known = {field.name: _described(field) for field in kind.fields} if kind else {}
    given = {name for own in occasions.values() for row in own for name in row} - set(_OCCASION)
    columns = {name: known.get(name, {"Description": f"{name}."}) for name in sorted(given)}
    title = f"{kind.title} ({name})" if kind else name
    return Tool(title, {**_OCCASION, **columns}, occasions)


def _described(field: Field) -> dict[str, Any]:
    better = f"; {field.better} is better" if field.better else ""
    described: dict[str, Any] = {
        "Description": f"{field.title}{f', {field.range}' * bool(field.range)}{better}."
    }
    if field.unit:
        described["Units"] = field.unit
    if field.type == "choice":
        declined = (NOT_SAID,) if field.may_decline else ()
        described["Levels"] = {text(level): level for level in (*field.labels, *declined)}
    return described
