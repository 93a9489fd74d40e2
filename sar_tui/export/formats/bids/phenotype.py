"""``phenotype/``: scores of instruments, and answers about pain and tiredness, a row for each
person who has one.

A person has one row in such a file, so that what was measured several times has several columns:
score_1, score_2, ….
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec

from sar_tui.export.formats.bids.labels import label
from sar_tui.export.formats.bids.study import Row, Study
from sar_tui.export.formats.bids.tsv import write_json, write_rows
from sar_tui.progress.instruments import INSTRUMENTS

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
