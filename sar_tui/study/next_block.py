"""The next block of a person: what it is, whether it may begin, and the plan of its session."""

import sqlite3
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from sar_tui.model.language import Sentence, joined
from sar_tui.model.study_place import StudyPlace
from sar_tui.plugins import Catalogue
from sar_tui.runs.plan import Plan
from sar_tui.store import programmes, sessions
from sar_tui.store.database import StoreError
from sar_tui.study import ledger
from sar_tui.study.conditions import session_plan
from sar_tui.study.enrolment import Names, draws_of, names_of
from sar_tui.study.ledger import Enrolment, Frozen, Played
from sar_tui.study.plan import OWN
from sar_tui.study.schedule import (
    Item,
    Next,
    NothingLeft,
    State,
    VisitDay,
    items,
    next_item,
    numbers,
    visit_days,
)

_OTHER_DAY: dict[State, str] = {
    "early": "The visit {visit} of {who} is from {first} to {last}: today is too early.",
    "late": "The visit {visit} of {who} is from {first} to {last}: today is too late.",
}
_OTHER_PLACE = {
    "repeated": "The block {block} of the visit {visit} is repeated.",
    "out of order": "The block {block} of the visit {visit} is out of order.",
}


class Person(NamedTuple):
    """A person of a study, with all that was done."""

    frozen: Frozen
    enrolled: Enrolment
    names: Names
    items: list[Item]
    played: list[Played]


class NeedsReason(StoreError):
    """A block is possible, and differs from the plan: a reason must be given.

    Attributes:
        what: as the kind ``deviation`` has it.
        found: the block.
    """

    def __init__(self, message: str, what: str, found: Next) -> None:
        super().__init__(message, bad_input=True)
        self.what = what
        self.found = found


def person(db: sqlite3.Connection, frozen: Frozen, participant: str, key: Path) -> Person:
    """Return a person of a study.

    Raises:
        StoreError: they are not enrolled.
        AllocationError: the key is not here.
    """
    enrolled = ledger.enrolment(db, frozen.plan.name, participant)
    names = names_of(frozen.plan, draws_of(frozen, key))
    group = names.group(enrolled.group)
    return Person(
        frozen=frozen,
        enrolled=enrolled,
        names=names,
        items=list(items(frozen.plan, enrolled, group)),
        played=ledger.played(db, frozen.plan.name, frozen.mode, participant),
    )


def due(
    db: sqlite3.Connection,
    one: Person,
    now: datetime,
    *,
    visit: str = "",
    block: str = "",
    reason: str = "",
) -> Next:
    """Return the next block of a person, if it may begin.

    Args:
        db: the database.
        one: the person.
        now: the present.
        visit, block: those that are wanted; others than the next ones need a reason.
        reason: why it differs from the plan.

    Raises:
        StoreError: there is nothing more, participation has ended, consent is missing, or the
            person is in a session.
        NeedsReason: it differs from the plan, and no reason was given.
    """
    plan, who = one.frozen.plan, one.enrolled.participant
    if one.enrolled.by_consent:
        check_consent(db, one)
    if one.enrolled.ended:
        raise StoreError(
            Sentence(
                "{who} takes part no longer: {how} ({why}).",
                who=who,
                how=ledger.ENDS.get(one.enrolled.ended, one.enrolled.ended),
                why=one.enrolled.why_ended,
            ),
            bad_input=True,
        )
    check_consent(db, one)
    if any(each.is_running for each in one.played):
        raise StoreError(Sentence("{who} is in a session now.", who=who), bad_input=True)
    found = next_item(plan, one.items, one.played, now)
    if visit or block:
        alike = _alike(one, visit, block)
        if isinstance(found, NothingLeft) or found.item not in alike:
            return _out_of_order(one, now, alike, reason)
    if isinstance(found, NothingLeft):
        told = [Sentence("{who} has done all of the study {study}.", who=who, study=plan.name)]
        told += [
            Sentence("The visit {visit} was missed.", visit=each.name) for each in found.passed
        ]
        raise StoreError(joined(told), bad_input=True)
    if found.state in _OTHER_DAY and not reason and not _is_noted(db, one, found):
        raise NeedsReason(_other_day(one, found), found.state, found)
    return found


def _is_noted(db: sqlite3.Connection, one: Person, found: Next) -> bool:
    """Return True if a reason was given for the day of a visit, with an earlier block of it."""
    who, study = one.enrolled.participant, one.frozen.plan.name
    place = (found.item.visit.name, found.state)
    return any(
        (each.content.get("visit"), each.content["what"]) == place
        for each in ledger.of_study(db, ledger.DEVIATION, study, who)
    )


def _alike(one: Person, visit: str, block: str) -> list[Item]:
    """Return the blocks of these names; an empty name is of any. Raises StoreError: there are
    none.
    """
    alike = [
        item
        for item in one.items
        if visit in ("", item.visit.name) and block in ("", item.block.name)
    ]
    if not alike:
        any_name = Sentence("of any name")
        raise StoreError(
            Sentence(
                "{who} has no block {block} in the visit {visit}.",
                who=one.enrolled.participant,
                block=block or any_name,
                visit=visit or any_name,
            ),
            bad_input=True,
        )
    return alike


def _out_of_order(one: Person, now: datetime, alike: Sequence[Item], reason: str) -> Next:
    """Return a block that is not the next one: the first of those that were asked for that was not
    begun. Raises NeedsReason.
    """
    begun = {each.key for each in one.played}
    item = next((each for each in alike if each.key not in begun), alike[0])
    days = visit_days(one.frozen.plan, one.items, one.played, now)
    day = next(day for day in days if day.visit.name == item.visit.name)
    found = Next(
        item=item,
        state=_state_of(day, now),
        day=day,
        repeats=item.key in begun,
        out_of_order=item.key not in begun,
    )
    if not reason:
        what = "repeated" if found.repeats else "out of order"
        said = [Sentence(_OTHER_PLACE[what], block=item.block.name, visit=item.visit.name)]
        if found.state in _OTHER_DAY:
            said.append(_other_day(one, found))
        raise NeedsReason(joined(said), what, found)
    return found


def _state_of(day: VisitDay, now: datetime) -> State:
    """Return if today is before or after the window of a visit that is not done, whatever was done
    before it.
    """
    today = now.astimezone().date()
    if day.state == "done" or day.first is None or day.last is None:
        return "due"
    return "early" if today < day.first else "late" if today > day.last else "due"


def _other_day(one: Person, found: Next) -> Sentence:
    """Return the sentence on a visit that is not in its window."""
    return Sentence(
        _OTHER_DAY[found.state],
        visit=found.item.visit.name,
        who=one.enrolled.participant,
        first=found.day.first,
        last=found.day.last,
    )


def check_consent(db: sqlite3.Connection, one: Person) -> None:
    """Raise StoreError if the plan needs a consent that this person has not given."""
    wanted = one.frozen.plan.consent
    if wanted is None or one.frozen.mode == "simulated":
        return
    who, study = one.enrolled.participant, one.frozen.plan.name
    given = ledger.consent_of(db, study, who)
    how = f"sar-tui study consent {who} --answer yes"
    if given is None:
        said = Sentence(
            "{who} has not agreed to the study {study} yet. When they have: {how}",
            who=who,
            study=study,
            how=how,
        )
        raise StoreError(said, bad_input=True)
    answer = given.content["answer"]
    if answer == "no":
        said = Sentence(
            "{who} did not agree to the study {study}: no session starts.", who=who, study=study
        )
        raise StoreError(said, bad_input=True)
    if answer != "yes":
        said = Sentence(
            "{who} has withdrawn the consent to the study {study}: no session starts. If they "
            "leave: {how}",
            who=who,
            study=study,
            how=f"sar-tui study exit {who} --reason …",
        )
        raise StoreError(said, bad_input=True)
    if given.content["version"] != wanted.version:
        said = Sentence(
            "{who} agreed to version {given} of the text; this plan needs version {wanted}. When "
            "they have agreed to that: {how}",
            who=who,
            given=str(given.content["version"]),
            wanted=wanted.version,
            how=how,
        )
        raise StoreError(said, bad_input=True)


def plan_of(
    db: sqlite3.Connection,
    catalogue: Catalogue,
    one: Person,
    found: Next,
    *,
    seed: int | None = None,
) -> Plan:
    """Return the plan of the session of a block.

    Raises:
        StoreError: the level is to be carried over from a block that was not done.
        PluginError, ParameterError, Failed: the condition cannot run here.
    """
    item = found.item
    plan, who = one.frozen.plan, one.enrolled.participant
    condition = plan.conditions[item.condition]
    own = programmes.newest(db, who, condition.task).parameters
    return session_plan(
        plan,
        catalogue,
        condition,
        item.block,
        who,
        own,
        level=_carried_level(db, one, item),
        place=place_of(one, item),
        seed=seed,
        mode=one.frozen.mode,
        id=sessions.new_id(),
    )


def place_of(one: Person, item: Item) -> StudyPlace:
    """Return what is stored with the session of a block."""
    return StudyPlace(
        study=one.frozen.plan.name,
        version=one.frozen.plan.version,
        visit=item.visit.name,
        block=item.block.name,
        condition=one.names.conditions[item.condition],
        position=item.position,
    )


def _carried_level(db: sqlite3.Connection, one: Person, item: Item) -> int | None:
    """Return the last level of the block that a level is carried over from; None if none is."""
    level = item.block.level
    if not isinstance(level, str) or level == OWN:
        return None
    visit, _, block = level.partition("/")
    for each in reversed(one.played):
        if (each.visit, each.block) == (visit, block):
            attempts = [
                row for row in sessions.rows(db, "attempts", each.id) if not row["practice"]
            ]
            if attempts:
                return int(attempts[-1]["level"])
    said = Sentence(
        "The level of {block} is that of the block {level}, which {who} has not done.",
        block=item.block.name,
        level=level,
        who=one.enrolled.participant,
    )
    raise StoreError(said, bad_input=True)


def note_deviations(
    db: sqlite3.Connection,
    one: Person,
    found: Next,
    reason: str,
    *,
    author: str,
    now: datetime | None = None,
) -> None:
    """Record what differs from the plan when a block begins: visits that were missed, a day that is
    early or late, an order, a block that is begun again. What is recorded already, for the same
    reason if a block is begun again, is not recorded once more.
    """
    plan, who = one.frozen.plan, one.enrolled.participant
    contents = [each.content for each in ledger.of_study(db, ledger.DEVIATION, plan.name, who)]
    noted = {
        tuple(str(content.get(name, "")) for name in ("what", "visit", "block", "reason"))
        for content in contents
    }
    noted |= {(what, visit, of_block, "") for what, visit, of_block, _ in noted}
    entries = [("missed", visit.name, "", "") for visit in found.passed]
    name, block = found.item.visit.name, found.item.block.name
    if found.state in ("early", "late"):
        entries.append((found.state, name, "", reason))
    if found.repeats:
        entries.append(("repeated", name, block, reason or "the session before was cut off"))
    elif found.out_of_order:
        entries.append(("out of order", name, block, reason))
    for what, visit, of_block, why in entries:
        if (what, visit, of_block, why if what == "repeated" else "") in noted:
            continue
        content = {"visit": visit, "block": of_block, "what": what, "reason": why}
        ledger.note(db, ledger.DEVIATION, plan, who, content, author=author, now=now)


def note_form(
    db: sqlite3.Connection,
    one: Person,
    found: Next,
    record: str,
    *,
    author: str,
    now: datetime | None = None,
) -> None:
    """Record that a form of a study was filled in."""
    content = {
        "visit": found.item.visit.name,
        "block": found.item.block.name,
        "record": record,
    }
    ledger.note(
        db, ledger.FORM, one.frozen.plan, one.enrolled.participant, content, author=author, now=now
    )


def in_words(one: Person, item: Item) -> Sentence:
    """Return what a block is, as whoever is blind may see it: "Visit 2, block 3 (C1)"."""
    visit, block = numbers(one.frozen.plan, one.items, item)
    what = item.block.form or one.names.conditions[item.condition]
    return Sentence("Visit {visit}, block {block} ({what})", visit=visit, block=block, what=what)
