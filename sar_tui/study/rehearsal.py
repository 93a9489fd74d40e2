"""A rehearsal of a study: simulated people go through the whole plan, in a data folder of its own,
on dates of its own.
"""

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from random import Random

import msgspec

from sar_tui.plugins import Catalogue
from sar_tui.records.kind import Field, Value
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE, Person
from sar_tui.store import forms, records, sessions, sites
from sar_tui.store.database import connect
from sar_tui.study import enrolment, ledger, next_block
from sar_tui.study.plan import Study
from sar_tui.study.schedule import Next, NothingLeft, next_item

_HOUR = 9


class Habits(msgspec.Struct, frozen=True, kw_only=True):
    """The shares by which simulated people miss visits, come late, or leave.

    Attributes:
        misses: share of visits, after the first, to which a person does not come.
        late: share of visits after their window.
        leaves: share of people who leave after a visit.
    """

    misses: float = 0.0
    late: float = 0.0
    leaves: float = 0.0


PUNCTUAL = Habits()


class BlockTime(msgspec.Struct, frozen=True, kw_only=True):
    """The time that a block took in the rehearsal (s)."""

    visit: str
    block: str
    condition: str
    seconds: float


class Rehearsed(msgspec.Struct, frozen=True, kw_only=True):
    """The result of a rehearsal at one site.

    Attributes:
        folder: of its data.
        people: their codes.
        times: of the blocks that were played.
    """

    site: str
    folder: Path
    people: tuple[str, ...]
    times: tuple[BlockTime, ...]


def rehearse(
    plan: Study,
    text: str,
    catalogue: Catalogue,
    folder: Path,
    key: Path,
    *,
    people: int,
    seed: int,
    start: datetime,
    habits: Habits = PUNCTUAL,
    persons: Callable[[int], Person] | None = None,
    effects: dict[str, float] | None = None,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> list[Rehearsed]:
    """Let simulated people go through a study.

    Each site has a data folder of its own in ``folder``, as sites share no ledger.

    Args:
        plan, text: the study.
        catalogue: of tasks and themes.
        folder: new or empty.
        key: file of the rehearsal's own key.
        people: number of people, over all sites.
        seed: decides everything but the allocation.
        start: day on which the first person comes.
        habits: how they come.
        persons: returns the model of the nth person; by default those of `simulate`, in turn.
        effects: milliseconds that a condition adds to their reaction times.
        progress: called with the number of people that are done, and of all.
    """
    named = plan.sites or ("",)
    models = persons or (lambda number: list(PEOPLE.values())[number % len(PEOPLE)])
    found = []
    done = 0
    for at, site in enumerate(named):
        data = folder / (site or "data")
        share = people // len(named) + (at < people % len(named))
        times: list[BlockTime] = []
        codes = []
        with closing(connect(data)) as db:
            if site:
                sites.set_own(db, site)
            enrolment.freeze(db, catalogue, text, plan, key, mode="simulated", author="", now=start)
            frozen = ledger.find(db, plan.name)
            for number in range(share):
                code = f"R{number + 1:02}"
                draw = Random(f"{seed} {site} {number}")
                factors = {name: draw.choice(v) for name, v in plan.allocation.strata.items()}
                now = start + timedelta(days=number % 5, hours=_HOUR, minutes=number)
                enrolment.enrol(db, frozen, code, key, factors=factors, now=now)
                model = models(done)
                times += _visits(
                    db, data, catalogue, frozen, code, key, model, draw, now, habits, effects
                )
                codes.append(code)
                done += 1
                progress(done, people)
        found.append(Rehearsed(site=site, folder=data, people=tuple(codes), times=tuple(times)))
    return found


def _visits(
    db: sqlite3.Connection,
    data: Path,
    catalogue: Catalogue,
    frozen: ledger.Frozen,
    code: str,
    key: Path,
    model: Person,
    draw: Random,
    began: datetime,
    habits: Habits,
    effects: dict[str, float] | None,
) -> Iterator[BlockTime]:
    """Play all visits of a person, and yield the time of each block."""
    plan = frozen.plan
    for at, visit in enumerate(plan.visits):
        earlier, later = visit.window
        away = at > 0 and draw.random() < habits.misses
        late = at > 0 and draw.random() < habits.late
        offset = draw.randint(-earlier, later) if at else 0
        offset = later + 1 if late else offset
        now = began + timedelta(days=visit.day - plan.visits[0].day + offset)
        if away:
            continue
        while found := _due_now(db, frozen, code, key, visit.name, now, late=late):
            one, what = found
            next_block.note_deviations(
                db, one, what, "came later" if what.state == "late" else "", author="", now=now
            )
            if what.item.block.form:
                record = _filled(db, what.item.block.form, code, draw, now)
                next_block.note_form(db, one, what, record, author="", now=now)
                now += timedelta(minutes=3)
                continue
            session = next_block.plan_of(db, catalogue, one, what, seed=draw.randrange(2**31))
            changed = (effects or {}).get(what.item.condition, 0.0)
            person = msgspec.structs.replace(model, base_ms=model.base_ms + changed)
            id = simulate(session, person, data, catalogue, began=now)
            row = sessions.stored(db, id)
            assert row
            ended = datetime.fromisoformat(row["ended_at"])
            yield BlockTime(
                visit=visit.name,
                block=what.item.block.name,
                condition=one.names.conditions[what.item.condition],
                seconds=(ended - now).total_seconds(),
            )
            now = ended + timedelta(minutes=1)
        if at + 1 < len(plan.visits) and draw.random() < habits.leaves:
            content = {"what": "lost", "reason": "does not come any more"}
            ledger.note(db, ledger.EXIT, plan, code, content, author="", now=now)
            return


def _filled(
    db: sqlite3.Connection, name: str, participant: str, draw: Random, now: datetime
) -> str:
    """Fill in a form with random answers, and return the id of the record."""
    kind = forms.form(name)

    def answer(item: Field) -> Value:
        if item.type == "choice":
            return draw.choice(item.labels)
        if item.is_number:
            steps = round((item.highest - item.lowest) / item.step)
            return item.lowest + item.step * draw.randint(0, steps)
        return "Said in a rehearsal."

    answers = {item.name: answer(item) for item in kind.items}
    return records.add(db, kind, participant, "", answers, now=now).id


def _due_now(
    db: sqlite3.Connection,
    frozen: ledger.Frozen,
    code: str,
    key: Path,
    visit: str,
    now: datetime,
    *,
    late: bool,
) -> tuple[next_block.Person, Next] | None:
    """Return the next block of a person, if it is of a visit that they are at; None if not."""
    one = next_block.person(db, frozen, code, key)
    found = next_item(frozen.plan, one.items, one.played, now)
    if isinstance(found, NothingLeft) or found.item.visit.name != visit or found.state == "early":
        return None
    return one, next_block.due(db, one, now, reason="came later" if late else "")


def monday(today: datetime) -> datetime:
    """Return the beginning of the Monday on or after a day, UTC."""
    days = -today.weekday() % 7
    return datetime(today.year, today.month, today.day, tzinfo=UTC) + timedelta(days=days)
