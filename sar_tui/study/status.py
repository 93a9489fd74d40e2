"""The status of a study: each person with each visit, done, due, late or missed."""

from collections.abc import Callable, Sequence
from datetime import date, datetime, time, timedelta
from pathlib import Path

import msgspec

from sar_tui.model.language import ENGLISH, Sentence, in_language
from sar_tui.study.allocation import AllocationError
from sar_tui.study.enrolment import draws_of, names_of
from sar_tui.study.ledger import Enrolment, Frozen, Participation, Played
from sar_tui.study.plan import Study
from sar_tui.study.schedule import (
    Item,
    NothingLeft,
    State,
    items,
    next_item,
    numbers,
    visit_days,
)

_WORDS: dict[State, Sentence] = {
    "done": Sentence("done"),
    "due": Sentence("due"),
    "early": Sentence("not yet"),
    "late": Sentence("late"),
    "missed": Sentence("visit missed"),
}  # fmt: skip


class VisitCell(msgspec.Struct, frozen=True, kw_only=True):
    """State of a visit of a person.

    Attributes:
        first, last: days of its window; None until the first visit was made.
        days: on which something was done.
        done, of: numbers of blocks and forms.
        deviated: True if a deviation is recorded.
        playing: True if the person is in a session of it now.
    """

    state: State
    first: date | None
    last: date | None
    days: tuple[date, ...]
    done: int
    of: int
    deviated: bool
    playing: bool = False

    @property
    def words(self) -> str:
        """The state for people: "due by 2026-12-03", "2 of 3 done"."""
        return in_language(self.sentence(), ENGLISH)

    def sentence(self, day: Callable[[date], str] = date.isoformat) -> str:
        """Return the state as a sentence that can be said in another language.

        Args:
            day: returns the words of a day.
        """
        said = self.when(day)
        if 0 < self.done < self.of:
            part = {"count": self.done, "of": self.of}
            said = (
                Sentence("{count} of {of} done, {state}", **part, state=said)
                if said
                else Sentence("{count} of {of} done", **part)
            )
        return Sentence("{state} !", state=said) if self.deviated else said

    def when(self, day: Callable[[date], str]) -> str:
        """Return when the visit may be, or that it is under way or over, as `sentence`."""
        if self.playing:
            return Sentence("in a session now")
        if self.state == "due" and self.last:
            return Sentence("due by {day}", day=day(self.last))
        if self.state == "early" and self.first:
            return Sentence("from {day}", day=day(self.first))
        return _WORDS.get(self.state, "")


class NextPlace(msgspec.Struct, frozen=True, kw_only=True):
    """The place of the next block or form of a person: numbers of the visit, and of it there."""

    visit: int
    block: int


class PersonRow(msgspec.Struct, frozen=True, kw_only=True):
    """A person of a study, with each visit by its name.

    Attributes:
        next: None if nothing more comes.
    """

    participant: str
    number: int
    group: str
    stratum: str
    visits: dict[str, VisitCell]
    deviations: int
    ended: str
    next: NextPlace | None = None

    @property
    def is_playing(self) -> bool:
        """True if the person is in a session of the study now."""
        return any(cell.playing for cell in self.visits.values())

    def next_visit(self, plan: Study) -> VisitCell | None:
        """Return the visit that comes next, or is under way; None if there is none."""
        return self.visits[plan.visits[self.next.visit - 1].name] if self.next else None


def grid(
    frozen: Frozen, people: Sequence[Participation], key: Path, now: datetime
) -> list[PersonRow]:
    """Return the people of a study in their order, with what they have done.

    Args:
        frozen: the study.
        people: as `ledger.people` reads them.
        key: file of its key.
        now: the present.

    Of people who have left, visits are shown as they were then: nothing is due to them.

    Without the key, of a study in which people are allocated, the states of visits are still right:
    only the conditions in them are not known.

    Raises:
        StoreError: as `schedule.items`.
    """
    plan = frozen.plan
    try:
        draws = draws_of(frozen, key)
    except AllocationError:
        draws = None
    names = names_of(plan, draws)
    any_group = next(iter(plan.groups), "")
    found = []
    for enrolled, played, deviations in people:
        then = datetime.fromisoformat(enrolled.ended_at) if enrolled.ended_at else now
        group = names.group(enrolled.group)
        shown = names.groups.get(group, enrolled.group)
        if draws is None and group not in plan.groups:
            group = any_group
        mine = list(items(plan, enrolled, group))
        at_visits = {each.visit for each in deviations}
        playing = {each.visit for each in played if each.is_running}
        cells = {
            day.visit.name: VisitCell(
                state=_shown(frozen, enrolled, day.state),
                first=day.first,
                last=day.last,
                days=day.days,
                done=day.done,
                of=day.of,
                deviated=day.visit.name in at_visits,
                playing=day.visit.name in playing,
            )
            for day in visit_days(plan, mine, played, min(then, now))
        }
        found.append(
            PersonRow(
                participant=enrolled.participant,
                number=enrolled.number,
                group=shown,
                stratum=enrolled.stratum,
                visits=cells,
                deviations=len(deviations),
                ended=enrolled.ended,
                next=None if enrolled.ended else _next(plan, mine, played, now),
            )
        )
    return found


def _shown(frozen: Frozen, enrolled: Enrolment, state: State) -> State:
    """Return the state of a visit as it is shown: of people who have left, what was not done or
    missed is open; in a rehearsal nobody makes up for a visit any more.
    """
    if enrolled.ended and state not in ("done", "missed"):
        return "open"
    return "missed" if frozen.mode == "simulated" and state == "late" else state


def as_of(frozen: Frozen, people: Sequence[Participation], now: datetime) -> datetime:
    """Return the time for which the status of a study is told: the present; of a rehearsal, whose
    days are its own, the end of the day after its last window and its last session.
    """
    if frozen.mode == "live":
        return now
    visits = frozen.plan.visits
    length = timedelta(days=visits[-1].day - visits[0].day + visits[-1].window[1] + 1)
    days = {date.fromisoformat(one.day) for _, played, _ in people for one in played}
    begun = [
        min(date.fromisoformat(one.day) for one in played) for _, played, _ in people if played
    ]
    last = max((*days, *(day + length for day in begun)), default=now.date())
    return datetime.combine(last, time(12)).astimezone()


def _next(
    plan: Study, mine: Sequence[Item], played: Sequence[Played], now: datetime
) -> NextPlace | None:
    found = next_item(plan, mine, played, now)
    if isinstance(found, NothingLeft):
        return None
    visit, block = numbers(plan, mine, found.item)
    return NextPlace(visit=visit, block=block)
