"""Results of a study as two tables: a row for each block of a person, and a row for each person.

In a blind study both have the neutral codes of groups and conditions, and nothing that tells what
these are.
"""

import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path
from statistics import fmean
from typing import Any

import msgspec

from sar_tui import __version__
from sar_tui.drivers.files import make_private
from sar_tui.export.columns import Column, Type
from sar_tui.export.csv_file import CsvWriter
from sar_tui.export.formats.csv import described_field
from sar_tui.store import forms, people_events, records, sessions, sites
from sar_tui.store.database import StoreError
from sar_tui.study import ledger
from sar_tui.study.allocation import AllocationError
from sar_tui.study.enrolment import draws_of, names_of
from sar_tui.study.ledger import Enrolment, Frozen, Participation, Played
from sar_tui.study.plan import Block, Study, orders

Row = dict[str, Any]
LONG, WIDE = "long", "wide"
_OF_PERSON = ("site", "group", "stratum", "order", "consent")
_SESSION_MEASURES, _SCORE = ("metric", "accuracy", "success_rate", "level"), "score"
"""Columns of the long table that the wide one has for each block."""


def _column(name: str, meaning: str, type: Type = "string", unit: str = "") -> Column:
    return Column(name, meaning, type, unit=unit, treatment="open")


LONG_COLUMNS = (
    _column("study", "Name of the study."),
    _column("version", "Version of its plan.", "integer"),
    _column("site", "Code of the site; missing: it has none."),
    _column("participant", "Code of the participant."),
    _column("group", "Group that the person came to; of a blind study a neutral code."),
    _column("stratum", "Site and factors of the allocation."),
    _column("order", "Number of the person's order of conditions, from 1; several with commas."),
    _column("consent", "Last answer to the consent: yes, no or withdrawn; missing: none."),
    _column("visit", "Visit."),
    _column("block", "Block of the visit."),
    _column("purpose", "Training, practice, probe, retention or transfer."),
    _column("condition", "Condition; of a blind study a neutral code; missing for a form."),
    _column("position", "Position of the condition in the person's order, from 1.", "integer"),
    _column("form", "The form that was filled in; missing for a session."),
    _column("session", "Id of the session, or of the record of the answers."),
    _column("status", "Completed, aborted (ended by a person) or interrupted (cut off)."),
    _column("day", "Days since the first session of the person.", "integer", "d"),
    _column("attempts", "Attempts that count.", "integer"),
    _column("metric", "Mean of the attempts' measure.", "number"),
    _column("metric_unit", "Its unit."),
    _column("accuracy", "Mean accuracy of the attempts, 0 to 1.", "number"),
    _column("success_rate", "Share of the attempts that reached the goal.", "number"),
    _column("level", "Mean level of the attempts.", "number"),
    _column("last_level", "Level of the last attempt.", "integer"),
    _column("score", "Score of the form.", "number"),
    _column("deviations", "Deviations from the plan that are recorded.", "integer"),
)


def long_rows(db: sqlite3.Connection, frozen: Frozen, people: Sequence[Participation]) -> list[Row]:
    """Return a row for each block that was begun, by person in the order of enrolment.

    ``people``: of the study, as `ledger.people` reads them.
    """
    plan, site = frozen.plan, sites.own(db)
    found = []
    for enrolled, played, deviations in people:
        of_person = _of_person(plan, enrolled, site)
        first = min((one.day for one in played), default="")
        for one in played:
            deviated = sum(
                each.visit == one.visit and each.block in ("", one.block) for each in deviations
            )
            row = {
                **of_person,
                **_place(plan, one),
                "day": (date.fromisoformat(one.day) - date.fromisoformat(first)).days,
                **_results(db, one),
                "deviations": deviated,
            }
            found.append(row)
    return found


def _of_person(plan: Study, enrolled: Enrolment, own_site: str) -> Row:
    _, _, site = enrolled.participant.partition("@")
    return {
        "study": plan.name,
        "site": site or own_site or None,
        "participant": enrolled.participant,
        "group": enrolled.group or None,
        "stratum": enrolled.stratum or None,
        "order": ",".join(str(number + 1) for number in enrolled.orders) or None,
        "consent": enrolled.consent or None,
    }


def _place(plan: Study, one: Played) -> Row:
    block = _block(plan, one)
    return {
        "version": one.version,
        "visit": one.visit,
        "block": one.block,
        "purpose": block.purpose if block else None,
        "condition": one.condition or None,
        "position": one.position,
        "form": (block.form or None) if block else None,
        "session": one.id,
        "status": one.status,
    }


def _block(plan: Study, one: Played) -> Block | None:
    """Return a block of the plan; None if a later version has it no more."""
    try:
        return plan.block(one.visit, one.block)
    except KeyError:
        return None


def _results(db: sqlite3.Connection, one: Played) -> Row:
    if not one.condition:
        answers = records.find_record(db, one.id)
        return {"score": None if answers.removed else answers.content.get("score")}
    attempts = [row for row in sessions.rows(db, "attempts", one.id) if not row["practice"]]
    metrics = [row["metric"] for row in attempts if row["metric"] is not None]
    accuracies = [row["accuracy"] for row in attempts if row["accuracy"] is not None]
    return {
        "attempts": len(attempts),
        "metric": fmean(metrics) if metrics else None,
        "metric_unit": attempts[0]["metric_unit"] if attempts else None,
        "accuracy": fmean(accuracies) if accuracies else None,
        "success_rate": (
            fmean(row["outcome"] == "success" for row in attempts) if attempts else None
        ),
        "level": fmean(row["level"] for row in attempts) if attempts else None,
        "last_level": attempts[-1]["level"] if attempts else None,
    }


def wide(
    plan: Study, rows: Sequence[Row], people: Sequence[Row], shown: Mapping[str, str]
) -> tuple[list[Column], list[Row]]:
    """Return the columns and the rows of the wide table: of each block and condition its measures.

    All columns of the plan are there, also without data yet, and then those of blocks that only an
    earlier version has. Of a block that was begun again the last session counts.

    Args:
        plan: the study.
        rows: of the long table.
        people: columns of the long table that belong to each person.
        shown: conditions as rows have them, by their names.
    """
    of_person = ("participant", *_OF_PERSON)
    by_person = {one["participant"]: {name: one[name] for name in of_person} for one in people}
    columns = {"participant": _column("participant", "Code of the participant.")}
    for name in _OF_PERSON:
        columns[name] = next(each for each in LONG_COLUMNS if each.name == name)
    declared = {each.name: each for each in LONG_COLUMNS}
    several = {(row["visit"], row["block"]) for row in rows if row["position"] > 1}
    several |= {(visit.name, block.name) for visit, block in plan.blocks() if block.conditions}

    def column(visit: str, block: str, condition: str, name: str) -> str:
        """Add the column of a measure if it is not there, and return its name."""
        of_condition = condition if (visit, block) in several else ""
        part = "_".join(filter(None, (visit, block, of_condition)))
        key = f"{part}_{name}".replace("-", ".")
        under = f", condition {of_condition}" if of_condition else ""
        meaning = f"In the block {block} of the visit {visit}{under}: {declared[name].meaning}"
        columns.setdefault(key, msgspec.structs.replace(declared[name], name=key, meaning=meaning))
        return key

    for visit, block in plan.blocks():
        named = [shown[each] for each in block.conditions if each in shown]
        if plan.allocation.blind:  # their order in the plan would tell what the codes are
            named.sort()
        for condition in named if block.conditions else [""]:
            for measure in _measures(block):
                column(visit.name, block.name, condition, measure)
    for row in rows:
        for name in (*_SESSION_MEASURES, _SCORE):
            if row.get(name) is not None:
                key = column(row["visit"], row["block"], row["condition"] or "", name)
                by_person[row["participant"]][key] = row[name]
    return list(columns.values()), list(by_person.values())


def _measures(block: Block) -> Sequence[str]:
    """Return the columns that a block has in the wide table: of a form its score, if it has one."""
    if not block.form:
        return _SESSION_MEASURES
    try:
        fields = forms.form(block.form).fields
    except StoreError:  # it is declared elsewhere
        return (_SCORE,)
    return (_SCORE,) if any(field.name == _SCORE for field in fields) else ()


def _shown_conditions(frozen: Frozen, key: Path) -> dict[str, str]:
    """Return conditions as people may see them, by name; none of a blind study without its key."""
    plan = frozen.plan
    try:
        return dict(names_of(plan, draws_of(frozen, key)).conditions)
    except AllocationError:
        return {} if plan.allocation.blind else {name: name for name in plan.conditions}


def _with_orders(columns: Sequence[Column], plan: Study) -> list[Column]:
    """Return columns of which that of the order says which conditions each number stands for."""
    told = _orders(plan)
    return [
        msgspec.structs.replace(each, meaning=f"{each.meaning} {told}")
        if told and each.name == "order"
        else each
        for each in columns
    ]


def _orders(plan: Study) -> str:
    """Return the conditions of each order in words: "1: slow, fast; 2: fast, slow". Empty without
    orders, and in a blind study, where they would tell which condition a code is.
    """
    if plan.allocation.blind:
        return ""
    return " Then ".join(
        "; ".join(f"{at}: {', '.join(row)}" for at, row in enumerate(orders(plan, each), 1)) + "."
        for each in plan.squares
    )


def export(db: sqlite3.Connection, frozen: Frozen, folder: Path, key: Path) -> list[Path]:
    """Write both tables and their description (``datapackage.json``) into a new or empty folder.
    People who have withdrawn, and whose data is excluded, are left out.

    ``key``: file of the study's key, without which a blind study's conditions have no columns until
    they have data.

    Raises:
        StoreError: the folder has files, or cannot be written.
    """
    left_out = people_events.excluded(db)
    people = [one for one in ledger.people(db, frozen) if one.enrolled.participant not in left_out]
    rows = long_rows(db, frozen, people)
    site = sites.own(db)
    of_people = [_of_person(frozen.plan, each.enrolled, site) for each in people]
    columns, persons = wide(frozen.plan, rows, of_people, _shown_conditions(frozen, key))
    tables: Mapping[str, tuple[Sequence[Column], Sequence[Row], str]] = {
        LONG: (_with_orders(LONG_COLUMNS, frozen.plan), rows, "A row for each block of a person"),
        WIDE: (_with_orders(columns, frozen.plan), persons, "A row for each person"),
    }
    try:
        if folder.exists() and any(folder.iterdir()):
            raise StoreError(f"{folder} is not empty: name a new folder.", bad_input=True)
        make_private(folder)
        for name, (heads, content, _) in tables.items():
            with (folder / f"{name}.csv").open("w", encoding="utf-8", newline="") as file:
                writer = CsvWriter(file)
                writer.row(column.name for column in heads)
                writer.rows([row.get(column.name) for column in heads] for row in content)
        package = {
            "profile": "tabular-data-package",
            "name": f"study-{frozen.plan.name}",
            "title": frozen.plan.title or frozen.plan.name,
            "sar_tui": __version__,
            "plan_version": frozen.plan.version,
            "plan_sha256": frozen.sha256,
            "resources": list(_resources(tables)),
        }
        path = folder / "datapackage.json"
        path.write_bytes(msgspec.json.format(msgspec.json.encode(package)) + b"\n")
        written = [*(folder / f"{name}.csv" for name in tables), path]
        for each in written:
            each.chmod(0o600)
    except OSError as error:
        raise StoreError(f"{folder} cannot be written: {error.strerror}.") from error
    return written


def _resources(
    tables: Mapping[str, tuple[Sequence[Column], Sequence[Row], str]],
) -> Iterator[dict[str, Any]]:
    for name, (columns, _, title) in tables.items():
        yield {
            "name": name,
            "title": title,
            "path": f"{name}.csv",
            "profile": "tabular-data-resource",
            "format": "csv",
            "encoding": "utf-8",
            "dialect": {"lineTerminator": "\r\n"},
            "schema": {
                "fields": [described_field(column) for column in columns],
                "missingValues": [""],
                "primaryKey": ["session"] if name == LONG else ["participant"],
            },
        }
