"""The dose of training: what was planned and done on each day, and over the last weeks."""

from collections.abc import Iterable, Sequence
from datetime import date, timedelta

import msgspec

from sar_tui.model.session_mode import is_personal
from sar_tui.progress.lines import SessionResults

RECENT_DAYS = 28


class Day(msgspec.Struct, frozen=True):
    """The dose of a day with sessions.

    Args:
        planned: attempts that the programmes plan for a day; where one plans none, those of the
            sessions begun.
        done: attempts, without practice.
        repetitions: prompts or reaches in them.
        time_on_task_s: time in attempts, without the rests between them.
    """

    date: str
    sessions: int
    planned: int
    done: int
    repetitions: int
    time_on_task_s: float


class Dose(msgspec.Struct, frozen=True):
    """The sum of some days; ``as_planned``: number of days on which all planned attempts were
    done.
    """

    first: str
    last: str
    days: int
    as_planned: int
    planned: int
    done: int
    repetitions: int
    time_on_task_s: float


def days_of(sessions: Iterable[SessionResults]) -> list[Day]:
    """Return the days with live sessions, first to last."""
    days: dict[str, list[SessionResults]] = {}
    for each in sessions:
        if is_personal(each.mode):
            days.setdefault(each.began.date().isoformat(), []).append(each)
    return [
        Day(
            date=day,
            sessions=len(found),
            planned=_planned_of_day(found),
            done=sum(len(each.results) for each in found),
            repetitions=sum(each.trials for each in found),
            time_on_task_s=sum(each.seconds for each in found),
        )
        for day, found in sorted(days.items())
    ]


def recent(days: Sequence[Day], today: date) -> Dose:
    """Return the dose of the last four weeks, today included."""
    first = (today - timedelta(days=RECENT_DAYS - 1)).isoformat()
    found = [day for day in days if first <= day.date <= today.isoformat()]
    return Dose(
        first=first,
        last=today.isoformat(),
        days=len(found),
        as_planned=sum(day.done >= day.planned for day in found),
        planned=sum(day.planned for day in found),
        done=sum(day.done for day in found),
        repetitions=sum(day.repetitions for day in found),
        time_on_task_s=sum(day.time_on_task_s for day in found),
    )


def planned_attempts(session: SessionResults) -> int:
    """Return the number of attempts that a session was planned to have."""
    planned = session.parameters.get("attempts")
    return planned if isinstance(planned, int) else len(session.results)


def _planned_of_day(sessions: Sequence[SessionResults]) -> int:
    """Return the attempts planned for a day: of each task those of its last session's programme."""
    by_task: dict[str, list[SessionResults]] = {}
    for each in sessions:
        by_task.setdefault(each.task, []).append(each)
    total = 0
    for found in by_task.values():
        of_day = found[-1].parameters.get("planned_attempts_a_day", 0)
        total += (
            of_day if isinstance(of_day, int) and of_day > 0 else sum(map(planned_attempts, found))
        )
    return total
