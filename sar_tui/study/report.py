"""Report on a study for a paper: the flow of participants, deviations, dose and what is missing.

The counts are those that CONSORT 2025 asks for (10.1371/journal.pmed.1004587), item 22: by group
allocated, received as intended, completed, lost with reasons, analysed.
"""

import sqlite3
from collections import Counter
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

import msgspec

from sar_tui.reports.sections import Section, Table
from sar_tui.store import people_events, sessions
from sar_tui.study import ledger
from sar_tui.study.ledger import Differed, Frozen
from sar_tui.study.results import Row, long_rows
from sar_tui.study.status import PersonRow, grid


class GroupFlow(msgspec.Struct, frozen=True, kw_only=True):
    """The flow of the participants of a group, which is empty without groups.

    Attributes:
        allocated: people who were enrolled.
        began: with a first session.
        as_intended: who began, and have no deviation.
        completed: who did all blocks of all visits.
        ended: people who take part no longer, by how it ended.
        reasons: of these, in words.
        analysed: with the primary outcome (and its baseline); None without an outcome in the plan.
    """

    group: str
    allocated: int
    began: int
    as_intended: int
    completed: int
    ended: dict[str, int]
    reasons: tuple[str, ...]
    analysed: int | None


class Dose(msgspec.Struct, frozen=True, kw_only=True):
    """The dose of a visit: means over the people who came.

    ``minutes``: from the beginning to the end of the sessions.
    """

    visit: str
    people: int
    sessions: float
    attempts: float
    minutes: float


class StudyReport(msgspec.Struct, frozen=True, kw_only=True):
    """The report on a study.

    Attributes:
        versions: of the plan, with the reason of each later one.
        missing: blocks and forms that are missing in visits that people came to or missed, by
            "VISIT/BLOCK".
        code_breaks: times that a group was looked up.
        other_plans: sites that froze another text of the same version.
    """

    study: str
    version: int
    sha256: str
    versions: tuple[tuple[int, str], ...]
    groups: tuple[GroupFlow, ...]
    dose: tuple[Dose, ...]
    deviations: tuple[Differed, ...]
    missing: dict[str, int]
    code_breaks: int
    other_plans: tuple[str, ...]


def make_report(db: sqlite3.Connection, frozen: Frozen, key: Path, now: datetime) -> StudyReport:
    """Return the report on a study as it stands now."""
    plan = frozen.plan
    people = grid(db, frozen, key, now)
    rows = long_rows(db, frozen)
    excluded = people_events.excluded(db)
    used = [row for row in rows if row["participant"] not in excluded]
    groups = sorted({one.group for one in people}) or [""]
    deviations = tuple(ledger.deviations(db, plan.name, frozen.mode))
    return StudyReport(
        study=plan.name,
        version=plan.version,
        sha256=frozen.sha256,
        versions=tuple((each.plan.version, each.reason) for each in ledger.versions(db, plan.name)),
        groups=tuple(_flow(db, frozen, group, people, rows, used) for group in groups),
        dose=tuple(_dose(db, visit.name, used) for visit in plan.visits),
        deviations=deviations,
        missing=_missing(frozen, people, rows),
        code_breaks=len(ledger.of_study(db, ledger.CODE_BREAK, plan.name)),
        other_plans=_other_plans(db, frozen),
    )


def _flow(
    db: sqlite3.Connection,
    frozen: Frozen,
    group: str,
    people: Sequence[PersonRow],
    rows: Sequence[Row],
    used: Sequence[Row],
) -> GroupFlow:
    """Return the numbers of a group. ``used``: the rows without those of people who have withdrawn,
    and whose data is excluded.
    """
    mine = [one for one in people if one.group == group]
    codes = {one.participant for one in mine}
    began = {row["participant"] for row in rows} & codes
    ends = [one for one in ledger.enrolments(db, frozen.plan.name) if one.participant in codes]
    return GroupFlow(
        group=group,
        allocated=len(mine),
        began=len(began),
        as_intended=sum(one.participant in began and not one.deviations for one in mine),
        completed=sum(all(cell.state == "done" for cell in one.visits.values()) for one in mine),
        ended=dict(Counter(one.ended for one in ends if one.ended)),
        reasons=tuple(
            f"{one.participant}: {one.ended}, {one.why_ended}" for one in ends if one.ended
        ),
        analysed=_analysed(frozen, codes, used),
    )


def _analysed(frozen: Frozen, codes: set[str], rows: Sequence[Row]) -> int | None:
    outcome = frozen.plan.outcome
    if outcome is None:
        return None
    _, dot, _ = outcome.measure.partition(".")
    name = "score" if dot else outcome.measure

    def having(visit: str, block: str) -> dict[str, int]:
        return Counter(
            row["participant"]
            for row in rows
            if (row["visit"], row["block"]) == (visit, block) and row.get(name) is not None
        )

    there = having(outcome.visit, outcome.block)
    wanted = 2 if outcome.compared == "within" else 1
    found = {who for who, count in there.items() if count >= wanted}
    if outcome.baseline:
        found &= having(outcome.baseline.visit, outcome.baseline.block).keys()
    return len(found & codes)


def _dose(db: sqlite3.Connection, visit: str, rows: Sequence[Row]) -> Dose:
    mine = [row for row in rows if row["visit"] == visit and row["condition"]]
    people = {row["participant"] for row in mine}
    minutes = 0.0
    for row in mine:
        stored = sessions.stored(db, row["session"])
        if stored and stored["ended_at"]:
            began, ended = (
                datetime.fromisoformat(stored[name]) for name in ("started_at", "ended_at")
            )
            minutes += (ended - began).total_seconds() / 60
    count = len(people) or 1
    return Dose(
        visit=visit,
        people=len(people),
        sessions=len(mine) / count,
        attempts=sum(row["attempts"] or 0 for row in mine) / count,
        minutes=minutes / count,
    )


def _missing(frozen: Frozen, people: Sequence[PersonRow], rows: Sequence[Row]) -> dict[str, int]:
    """Return how many people lack a block of a visit that is over for them."""
    found: dict[str, int] = {}
    for visit, block in frozen.plan.blocks():
        for one in people:
            cell = one.visits[visit.name]
            is_over = cell.state in ("missed", "late") or bool(one.ended)
            needed = len(block.conditions) or 1
            done = sum(
                row["participant"] == one.participant
                and (row["visit"], row["block"]) == (visit.name, block.name)
                for row in rows
            )
            if is_over and done < needed:
                place = f"{visit.name}/{block.name}"
                found[place] = found.get(place, 0) + 1
    return found


def _other_plans(db: sqlite3.Connection, frozen: Frozen) -> tuple[str, ...]:
    """Return the sites that froze another text, or with another key."""
    rows = db.execute(
        "SELECT site FROM studies WHERE name=? AND version=? AND (sha256<>? OR commitment<>?)",
        (frozen.plan.name, frozen.plan.version, frozen.sha256, frozen.commitment),
    )
    return tuple(site for (site,) in rows)


# --- words


def sections(report: StudyReport) -> list[Section]:
    """Return the report as sections."""
    return [
        _flow_section(report),
        Section("Dose", [_dose_table(report)]),
        Section("Deviations", _deviation_parts(report)),
        Section("Missing data", [_missing_words(report)]),
        Section("The plan", _plan_parts(report)),
    ]


def _flow_section(report: StudyReport) -> Section:
    has_groups = any(flow.group for flow in report.groups)
    heads = (
        *(("group",) if has_groups else ()),
        "allocated", "began", "as intended", "completed", "ended", "analysed",
    )  # fmt: skip
    rows = [
        (
            *((flow.group,) if has_groups else ()),
            str(flow.allocated),
            str(flow.began),
            str(flow.as_intended),
            str(flow.completed),
            ", ".join(f"{count} {how}" for how, count in flow.ended.items()) or "0",
            "–" if flow.analysed is None else str(flow.analysed),
        )
        for flow in report.groups
    ]
    right = tuple(head for head in heads if head not in ("group", "ended"))
    reasons = [reason for flow in report.groups for reason in flow.reasons]
    return Section(
        "Flow of participants (CONSORT 2025, item 22)",
        [Table(heads, rows, right=right), *([f"{'. '.join(reasons)}."] if reasons else [])],
    )


def _dose_table(report: StudyReport) -> Table:
    heads = ("visit", "people", "sessions", "attempts", "minutes")
    rows = [
        (
            each.visit,
            str(each.people),
            f"{each.sessions:.1f}",
            f"{each.attempts:.1f}",
            f"{each.minutes:.1f}",
        )
        for each in report.dose
    ]
    return Table(heads, rows, right=heads[1:], more="Means over the people who came.")


def _deviation_parts(report: StudyReport) -> list[str | Table]:
    if not report.deviations:
        return ["No deviation is recorded."]
    counts = Counter(each.what for each in report.deviations)
    said = ", ".join(f"{count} {what}" for what, count in counts.most_common())
    rows = [
        (each.participant, each.visit, each.block, each.what, each.reason)
        for each in report.deviations
    ]
    return [f"{said}.", Table(("who", "visit", "block", "what", "reason"), rows)]


def _missing_words(report: StudyReport) -> str:
    if not report.missing:
        return "Nothing is missing in the visits that are over."
    said = ", ".join(f"{place} of {count}" for place, count in report.missing.items())
    return f"Of people whose visit is over: {said}."


def _plan_parts(report: StudyReport) -> list[str]:
    said = [f"Version {report.version} of the plan {report.study}, SHA-256 {report.sha256}."]
    said += [f"Version {number}: {why}." for number, why in report.versions if why]
    if report.code_breaks:
        said.append(f"Groups were looked up: {report.code_breaks}.")
    if report.other_plans:
        said.append(
            f"Frozen as another text, or with another key: {', '.join(report.other_plans)}."
        )
    return said
