"""Report on a study for a paper: the flow of participants, deviations, dose and what is missing.

The counts are those that CONSORT 2025 asks for (10.1371/journal.pmed.1004587), item 22: by group
allocated, received as intended, completed, lost with reasons, analysed.
"""

import sqlite3
from collections import Counter
from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path

import msgspec

from sar_tui.reports.sections import Section, Table
from sar_tui.store import people_events
from sar_tui.study import ledger
from sar_tui.study.allocation import AllocationError
from sar_tui.study.enrolment import draws_of, names_of
from sar_tui.study.ledger import Differed, Enrolment, Frozen, Participation
from sar_tui.study.plan import Study
from sar_tui.study.results import Row, long_rows
from sar_tui.study.schedule import finished
from sar_tui.study.status import PersonRow, as_of, grid


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


class Short(msgspec.Struct, frozen=True, kw_only=True):
    """A block that was done with fewer attempts than planned. ``attempts``: those that count."""

    participant: str
    visit: str
    block: str
    attempts: int
    of: int


class StudyReport(msgspec.Struct, frozen=True, kw_only=True):
    """The report on a study.

    Attributes:
        versions: of the plan, with the reason of each later one.
        missing: blocks and forms that are missing in visits that people came to or missed, by
            "VISIT/BLOCK".
        short: blocks that were done in part.
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
    short: tuple[Short, ...]
    code_breaks: int
    other_plans: tuple[str, ...]


def make_report(db: sqlite3.Connection, frozen: Frozen, key: Path, now: datetime) -> StudyReport:
    """Return the report on a study as it stands now; on a rehearsal, as it stood at its end."""
    plan = frozen.plan
    people = ledger.people(db, frozen)
    now = as_of(frozen, people, now)
    states = grid(frozen, people, key, now)
    rows = long_rows(db, frozen, people)
    excluded = people_events.excluded(db)
    used = [row for row in rows if row["participant"] not in excluded]
    groups = sorted({one.group for one in states}) or [""]
    compared = _compared(frozen, key)
    deviations = sorted(
        (each for one in people for each in one.deviations), key=lambda each: each.at
    )
    return StudyReport(
        study=plan.name,
        version=plan.version,
        sha256=frozen.sha256,
        versions=tuple((each.plan.version, each.reason) for each in ledger.versions(db, plan.name)),
        groups=tuple(
            _flow(frozen, group, people, states, rows, used, compared) for group in groups
        ),
        dose=tuple(_dose(visit.name, people, used) for visit in plan.visits),
        deviations=tuple(deviations),
        missing=_missing(plan, people, states, now),
        short=tuple(_short(plan, people, now)),
        code_breaks=len(ledger.of_study(db, ledger.CODE_BREAK, plan.name)),
        other_plans=_other_plans(db, frozen),
    )


def _flow(
    frozen: Frozen,
    group: str,
    people: Sequence[Participation],
    states: Sequence[PersonRow],
    rows: Sequence[Row],
    used: Sequence[Row],
    compared: set[str],
) -> GroupFlow:
    """Return the numbers of a group. ``used``: the rows without those of people who have withdrawn,
    and whose data is excluded.
    """
    mine = [one for one in states if one.group == group]
    codes = {one.participant for one in mine}
    began = {row["participant"] for row in rows} & codes
    ended = [one.enrolled for one in people if one.enrolled.participant in codes]
    ended = [one for one in ended if one.ended]
    return GroupFlow(
        group=group,
        allocated=len(mine),
        began=len(began),
        as_intended=sum(one.participant in began and not one.deviations for one in mine),
        completed=sum(all(cell.state == "done" for cell in one.visits.values()) for one in mine),
        ended=dict(Counter(one.ended for one in ended)),
        reasons=tuple(map(_reason, ended)),
        analysed=_analysed(frozen, codes, used, compared),
    )


def _reason(one: Enrolment) -> str:
    """Return who takes part no longer and why, with the command that records it if nothing does."""
    said = f"{one.participant}: {one.ended}, {one.why_ended}"
    is_recorded = not one.by_consent or not ledger.is_own(one.participant)
    return said if is_recorded else f"{said} (to record it: sar-tui study exit {one.participant})"


def _compared(frozen: Frozen, key: Path) -> set[str]:
    """Return the conditions that are compared within people, as rows have them; empty if none are,
    or they are not known here.
    """
    outcome = frozen.plan.outcome
    if outcome is None or outcome.compared != "within":
        return set()
    try:
        names = names_of(frozen.plan, draws_of(frozen, key))
    except AllocationError:
        return set()
    block = frozen.plan.block(outcome.visit, outcome.block)
    return {names.conditions[name] for name in outcome.conditions or block.conditions}


def _analysed(
    frozen: Frozen, codes: set[str], rows: Sequence[Row], compared: set[str]
) -> int | None:
    outcome = frozen.plan.outcome
    if outcome is None:
        return None
    _, dot, _ = outcome.measure.partition(".")
    name = "score" if dot else outcome.measure

    def having(visit: str, block: str) -> dict[str, set[str]]:
        """Return the conditions in which people have a result, by person."""
        found: dict[str, set[str]] = {}
        for row in rows:
            if (row["visit"], row["block"]) == (visit, block) and row.get(name) is not None:
                found.setdefault(row["participant"], set()).add(row["condition"])
        return found

    there = having(outcome.visit, outcome.block)
    least = 2 if outcome.compared == "within" else 1
    found = {
        who
        for who, having_them in there.items()
        if len(having_them) >= least and compared <= having_them
    }
    if outcome.baseline:
        found &= having(outcome.baseline.visit, outcome.baseline.block).keys()
    return len(found & codes)


def _dose(visit: str, people: Sequence[Participation], rows: Sequence[Row]) -> Dose:
    sessions = [
        one for each in people for one in each.played if one.visit == visit and one.condition
    ]
    came = {one.participant for one in sessions}
    seconds = sum(
        (datetime.fromisoformat(one.ended) - datetime.fromisoformat(one.began)).total_seconds()
        for one in sessions
    )
    count = len(came) or 1
    return Dose(
        visit=visit,
        people=len(came),
        sessions=len(sessions) / count,
        attempts=sum(row.get("attempts", 0) for row in rows if row["visit"] == visit) / count,
        minutes=seconds / 60 / count,
    )


def _missing(
    plan: Study, people: Sequence[Participation], states: Sequence[PersonRow], now: datetime
) -> dict[str, int]:
    """Return how many people lack a block of a visit that is over for them."""
    found = Counter[str]()
    for one, row in zip(people, states, strict=True):
        done = Counter(
            (each.visit, each.block)
            for each in finished(plan, one.played, now).values()
            if each.attempts != 0
        )
        for visit, block in plan.blocks():
            is_over = row.ended or row.visits[visit.name].state in ("done", "missed", "late")
            if is_over and done[visit.name, block.name] < (len(block.conditions) or 1):
                found[f"{visit.name}/{block.name}"] += 1
    order = (f"{visit.name}/{block.name}" for visit, block in plan.blocks())
    return {place: found[place] for place in order if place in found}


def _short(plan: Study, people: Sequence[Participation], now: datetime) -> Iterator[Short]:
    """Yield blocks that are done with fewer attempts than planned, but with one or more."""
    for one in people:
        for each in finished(plan, one.played, now).values():
            if each.attempts and each.attempts < each.planned:
                yield Short(
                    participant=each.participant,
                    visit=each.visit,
                    block=each.block,
                    attempts=each.attempts,
                    of=each.planned,
                )


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
        Section("Missing data", [*_missing_words(report)]),
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


def _missing_words(report: StudyReport) -> Iterator[str | Table]:
    if report.missing:
        said = ", ".join(f"{place} of {count}" for place, count in report.missing.items())
        yield f"Of people whose visit is over, or who have left: {said}."
    elif not report.short:
        yield "Nothing is missing in the visits that are over."
    if report.short:
        rows = [
            (each.participant, each.visit, each.block, f"{each.attempts} of {each.of}")
            for each in report.short
        ]
        yield Table(("who", "visit", "block", "attempts"), rows, right=("attempts",))


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
