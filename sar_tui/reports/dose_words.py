"""The dose in words: marks of days that say it without colour, and the last weeks in a sentence."""

from collections.abc import Callable, Sequence
from datetime import date, timedelta

from sar_tui.model.language import Language
from sar_tui.reports import progress_words
from sar_tui.reports.charts import EVENT
from sar_tui.reports.dose import Day, Dose
from sar_tui.reports.progress import Progress

MARKS: tuple[tuple[str, str, Callable[[Day], bool]], ...] = (
    ("■", "all planned attempts done", lambda day: day.done >= day.planned),
    ("◧", "half or more", lambda day: 2 * day.done >= day.planned),
    ("□", "fewer", lambda day: True),
)
"""Marks of a day that say its dose without colour: the first whose condition holds."""
NO_SESSION = "·"


def mark(found: Day | None) -> str:
    """Return the mark of a day."""
    if found is None:
        return NO_SESSION
    return next(sign for sign, _, holds in MARKS if holds(found))


def legend(tr: Language) -> str:
    """Return the meaning of the marks."""
    named = [f"{sign} {tr(meaning)}" for sign, meaning, _ in MARKS]
    return "   ".join([*named, f"{NO_SESSION} {tr('no session')}"])


def calendar(days: Sequence[Day], today: date) -> list[tuple[str, str]]:
    """Return a mark for each day of the months from the first session until today, as ("2026-03",
    "··■··◧").
    """
    if not days:
        return []
    by_date = {day.date: day for day in days}
    at = date.fromisoformat(days[0].date).replace(day=1)
    last = max(today, date.fromisoformat(days[-1].date))
    months: dict[str, str] = {}
    while at <= last:
        day = at.isoformat()
        months[day[:7]] = months.get(day[:7], "") + mark(by_date.get(day))
        at += timedelta(days=1)
    return list(months.items())


def calendar_lines(found: Progress, months: int, tr: Language) -> list[str]:
    """Return the last months of the calendar under the days, adverse events below their days, and
    the legend.
    """
    shown = calendar(found.days, date.fromisoformat(found.today))[-months:]
    names = [progress_words.month(month, tr) for month, _ in shown]
    margin = max(map(len, names), default=0) + 2
    lines = [f"{'':{margin}}1   5    10   15   20   25   30"]
    has_event = False
    for (month, marks), name in zip(shown, names, strict=True):
        lines.append(f"{name:{margin}}{marks}")
        on = {int(event.at[8:10]) for event in found.events if event.at[:7] == month}
        if on:
            has_event = True
            lines.append(
                f"{'':{margin}}{''.join(EVENT if day in on else ' ' for day in range(1, max(on) + 1))}"
            )
    return [*lines, "", legend(tr), *([f"{EVENT} {tr('adverse event')}"] if has_event else [])]


def days_text(days: int, tr: Language) -> str:
    """Return a number of days: "1 day", "3 days"."""
    return tr("1 day") if days == 1 else tr("{days} days", days=str(days))


def recent_text(found: Dose, tr: Language, today: str = "") -> str:
    """Return the dose of the last weeks in a sentence; with short dates if today is given."""
    first, last = found.first, found.last
    if today:
        first, last = (progress_words.short_day(day, today, tr) for day in (first, last))
    return tr(
        "From {first} to {last}: sessions on {days}, on {as_planned} of them all that was "
        "planned; {done} of "
        "{planned} attempts, {repetitions} repetitions, {minutes} min on task without rests.",
        first=first,
        last=last,
        days=days_text(found.days, tr),
        as_planned=str(found.as_planned),
        done=str(found.done),
        planned=str(found.planned),
        repetitions=str(found.repetitions),
        minutes=f"{found.time_on_task_s / 60:.0f}",
    )
