"""The status of a study: each person with each visit, done, due, late or missed."""

import sqlite3
from datetime import datetime
from pathlib import Path

import msgspec

from sar_tui.study import ledger
from sar_tui.study.allocation import AllocationError
from sar_tui.study.enrolment import draws_of, group_named, names_of
from sar_tui.study.ledger import Frozen
from sar_tui.study.schedule import State, items, visit_days

_WORDS: dict[State, str] = {
    "done": "done",
    "due": "due",
    "early": "not yet",
    "late": "late",
    "missed": "missed",
    "open": "",
}  # fmt: skip


class VisitCell(msgspec.Struct, frozen=True, kw_only=True):
    """State of a visit of a person.

    Attributes:
        first, last: days of its window, ISO 8601; None until the first visit was made.
        days: on which something was done.
        done, of: numbers of blocks and forms.
        deviated: True if a deviation is recorded.
    """

    state: State
    first: str | None
    last: str | None
    days: tuple[str, ...]
    done: int
    of: int
    deviated: bool

    @property
    def words(self) -> str:
        """The state for people: "due by 2026-12-03", "2 of 3 done"."""
        said = _WORDS[self.state]
        if self.state == "due" and self.last:
            said = f"due by {self.last}"
        elif self.state == "early" and self.first:
            said = f"from {self.first}"
        if 0 < self.done < self.of:
            said = f"{self.done} of {self.of} done, {said}".rstrip(", ")
        return f"{said} !" if self.deviated else said


class PersonRow(msgspec.Struct, frozen=True, kw_only=True):
    """A person of a study, with each visit by its name."""

    participant: str
    number: int
    group: str
    stratum: str
    visits: dict[str, VisitCell]
    deviations: int
    ended: str


def grid(db: sqlite3.Connection, frozen: Frozen, key: Path, now: datetime) -> list[PersonRow]:
    """Return the people of a study in the order of their enrolment, with what they have done.

    Without the key, of a study in which people are allocated, the states of visits are still right:
    only the conditions in them are not known.
    """
    plan = frozen.plan
    try:
        draws = draws_of(frozen, key)
    except AllocationError:
        draws = None
    names = names_of(plan, draws)
    deviations = ledger.of_study(db, ledger.DEVIATION, plan.name)
    everything = ledger.played(db, plan.name, frozen.mode)
    found = []
    for enrolled in ledger.enrolments(db, plan.name):
        who = enrolled.participant
        group = group_named(plan, enrolled, names)
        mine = list(
            items(plan, enrolled, group if group in plan.groups else next(iter(plan.groups), ""))
        )
        own = [one for one in everything if one.participant == who]
        noted = [each for each in deviations if each.participant == who]
        at_visits = {each.content.get("visit") for each in noted}
        cells = {
            day.visit.name: VisitCell(
                state=day.state,
                first=day.first.isoformat() if day.first else None,
                last=day.last.isoformat() if day.last else None,
                days=tuple(each.isoformat() for each in day.days),
                done=day.done,
                of=day.of,
                deviated=day.visit.name in at_visits,
            )
            for day in visit_days(plan, mine, own, now)
        }
        found.append(
            PersonRow(
                participant=who,
                number=enrolled.number,
                group=enrolled.group,
                stratum=enrolled.stratum,
                visits=cells,
                deviations=len(noted),
                ended=enrolled.ended,
            )
        )
    return found
