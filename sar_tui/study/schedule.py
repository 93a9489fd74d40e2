"""The schedule of a person of a study: what is done, due, late or missed. Pure functions."""

from collections.abc import Iterator, Sequence
from datetime import date, datetime, timedelta
from typing import Literal

import msgspec

from sar_tui.model.language import Sentence
from sar_tui.store.database import StoreError
from sar_tui.study.ledger import Enrolment, Played
from sar_tui.study.plan import ALLOCATED, Block, Study, Visit, orders

State = Literal["done", "due", "early", "late", "missed", "open"]
"""State of a visit on a day. ``open``: its day has not come, as an earlier one is not done."""
_FINISHED = ("completed", "aborted")


class Item(msgspec.Struct, frozen=True, kw_only=True):
    """A session or a form that a person has in a study.

    Attributes:
        condition: its name; empty for a form.
        position: of the condition in the person's order, from 1.
    """

    visit: Visit
    block: Block
    condition: str = ""
    position: int = 1

    @property
    def key(self) -> tuple[str, str, int]:
        """The key that tells it from the others of the person."""
        return self.visit.name, self.block.name, self.position


def items(plan: Study, enrolled: Enrolment, group: str) -> Iterator[Item]:
    """Yield all that a person has to do, in order.

    Args:
        plan: the study.
        enrolled: the person.
        group: of the person, by its name; empty without groups.

    Raises:
        StoreError: the group or the orders are those of another version of the plan.
    """
    squares = list(plan.squares)
    if len(squares) != len(enrolled.orders) or (plan.groups and group not in plan.groups):
        raise StoreError(
            Sentence(
                "{who} was enrolled in version {version} of the study {study}, which has other "
                "groups or orders of conditions than version {newer}.",
                who=enrolled.participant,
                version=enrolled.version,
                study=plan.name,
                newer=plan.version,
            ),
            bad_input=True,
        )
    for visit, block in plan.blocks():
        if block.form:
            yield Item(visit=visit, block=block)
        elif block.condition:
            name = plan.groups[group].condition if block.condition == ALLOCATED else block.condition
            yield Item(visit=visit, block=block, condition=name)
        else:
            row = block.conditions
            if block.order != "fixed":
                number = enrolled.orders[squares.index(block.conditions)]
                row = orders(plan, block.conditions)[number]
            for position, name in enumerate(row, 1):
                yield Item(visit=visit, block=block, condition=name, position=position)


def numbers(plan: Study, mine: Sequence[Item], item: Item) -> tuple[int, int]:
    """Return the number of the visit of an item, and that of the item in it, from 1."""
    visit = [each.name for each in plan.visits].index(item.visit.name)
    same = [each.key for each in mine if each.visit.name == item.visit.name]
    return visit + 1, same.index(item.key) + 1


class VisitDay(msgspec.Struct, frozen=True, kw_only=True):
    """A visit of a person.

    Attributes:
        first, last: the days on which it may be; None until the first visit was made.
        days: on which something was done.
        done, of: numbers of its items.
    """

    visit: Visit
    state: State
    first: date | None
    last: date | None
    days: tuple[date, ...]
    done: int
    of: int


class Next(msgspec.Struct, frozen=True, kw_only=True):
    """The next item of a person.

    Attributes:
        state: of its visit: due, early or late.
        day: its visit.
        resume: id of an interrupted session of it that goes on where it was; empty without one.
        repeats: True if it is done again, or an interrupted session of it is begun again.
        out_of_order: True if it was asked for before another one.
        passed: visits that are over and were not made, up to it.
    """

    item: Item
    state: State = "due"
    day: VisitDay
    resume: str = ""
    repeats: bool = False
    out_of_order: bool = False
    passed: tuple[Visit, ...] = ()


class NothingLeft(msgspec.Struct, frozen=True):
    """The end of a person's items. ``passed``: visits that are over and were not made."""

    passed: tuple[Visit, ...]


def finished(
    plan: Study, played: Sequence[Played], now: datetime
) -> dict[tuple[str, str, int], Played]:
    """Return the sessions and forms that are done, by `Item.key`. A session that was ended early is
    done, unless no attempt of it counts; one that was cut off, if the plan says that it is left.
    """
    found = {}
    for one in played:
        left = (
            one.status == "interrupted"
            and plan.interrupted.then == "leave"
            and not can_resume(plan, one, now)
        )
        if (one.status in _FINISHED and one.attempts != 0) or left:
            found[one.key] = one
    return found


def can_resume(plan: Study, one: Played, now: datetime) -> bool:
    """Return True if an interrupted session is to go on where it was."""
    ended = datetime.fromisoformat(one.ended)
    return now - ended <= timedelta(hours=plan.interrupted.resume_hours)


def visit_days(
    plan: Study, mine: Sequence[Item], played: Sequence[Played], now: datetime
) -> list[VisitDay]:
    """Return the state of each visit of a person.

    Args:
        plan: the study.
        mine: all that the person has to do.
        played: what was done.
        now: the present, with an offset; its local date is today.
    """
    today = now.astimezone().date()
    done = finished(plan, played, now)
    days = {
        visit.name: sorted(
            {date.fromisoformat(one.day) for one in played if one.visit == visit.name}
        )
        for visit in plan.visits
    }
    began = next((days[visit.name][0] for visit in plan.visits if days[visit.name]), None)
    offset = next((visit.day for visit in plan.visits if days[visit.name]), 0)
    origin = began - timedelta(days=offset) if began else None
    found: list[VisitDay] = []
    for at, visit in enumerate(plan.visits):
        own = [item for item in mine if item.visit.name == visit.name]
        count = sum(item.key in done for item in own)
        first = last = None
        if origin:
            before, after = visit.window
            first = origin + timedelta(days=visit.day - before)
            last = origin + timedelta(days=visit.day + after)
        following = plan.visits[at + 1] if at + 1 < len(plan.visits) else None
        opens = (
            origin + timedelta(days=following.day - following.window[0])
            if origin and following
            else None
        )
        is_last = all(each.state in ("done", "missed") for each in found)
        state = _state(plan, today, first, last, opens, done=count, of=len(own), is_next=is_last)
        found.append(
            VisitDay(
                visit=visit,
                state=state,
                first=first,
                last=last,
                days=tuple(days[visit.name]),
                done=count,
                of=len(own),
            )
        )
    return found


def _state(
    plan: Study,
    today: date,
    first: date | None,
    last: date | None,
    next_opens: date | None,
    *,
    done: int,
    of: int,
    is_next: bool,
) -> State:
    if done == of:
        return "done"
    if first is None or last is None:
        return "due" if is_next else "open"
    if today > last:
        is_over = plan.missed != "late" or (next_opens is not None and today >= next_opens)
        return "missed" if is_over else "late"
    if not is_next:
        return "open"
    return "early" if today < first else "due"


def next_item(
    plan: Study, mine: Sequence[Item], played: Sequence[Played], now: datetime
) -> Next | NothingLeft:
    """Return what is due next: the first item that is not done, of the first visit that is neither
    done nor missed.
    """
    done = finished(plan, played, now)
    passed: list[Visit] = []
    for day in visit_days(plan, mine, played, now):
        if day.state == "missed":
            passed.append(day.visit)
            if plan.missed == "stop":
                break
            continue
        for item in mine:
            if item.visit.name == day.visit.name and item.key not in done:
                return _with_interrupted(plan, item, day, played, tuple(passed), now)
    return NothingLeft(tuple(passed))


def _with_interrupted(
    plan: Study,
    item: Item,
    day: VisitDay,
    played: Sequence[Played],
    passed: tuple[Visit, ...],
    now: datetime,
) -> Next:
    before = [one for one in played if one.key == item.key]
    cut_off = next((one for one in before[::-1] if one.status == "interrupted"), None)
    resumes = cut_off is not None and can_resume(plan, cut_off, now)
    return Next(
        item=item,
        state=day.state,
        day=day,
        resume=cut_off.id if cut_off and resumes else "",
        repeats=cut_off is not None and not resumes,
        passed=passed,
    )
