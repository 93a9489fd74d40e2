"""The texts of a participant's card and of the list of sessions. Pure."""

from collections.abc import Sequence
from datetime import date
from typing import TYPE_CHECKING

import msgspec

from sar_tui.model.language import Language

if TYPE_CHECKING:  # the empty screen is shown before it is loaded
    from sar_tui.model.trial_types import Metric
    from sar_tui.progress.lines import SessionResults
    from sar_tui.reports.progress import LineProgress

DAYS = ("Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun")
"""Days of the week."""
_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")


class Programme(msgspec.Struct, frozen=True):
    """Figures of the next session of a task. ``why`` says why it starts at the level."""

    attempts: int
    prompts: int
    goal: str
    level: int
    why: str = ""


def short(metric: "Metric", value: float, tr: Language) -> str:
    """Return a result in a few characters; times in seconds, as participants read them: "0.95
    s".
    """
    return tr.figures(f"{value / 1000:.2f} s" if metric.unit == "ms" else metric.show(value))


def day_words(day: date, today: date, tr: Language) -> str:
    """Return a date as people say it: "today", "yesterday", "Tue 17 Nov", "17 Nov 2025"."""
    ago = (today - day).days
    if ago in (0, 1):
        return tr("yesterday" if ago else "today")
    if day.year == today.year:
        return weekday_words(day, tr)
    month = tr(_MONTHS[day.month - 1])
    return tr("{day} {month} {year}", day=day.day, month=month, year=day.year)


def weekday_words(day: date, tr: Language) -> str:
    """Return a date with its weekday: "Tue 17 Nov"."""
    weekday, month = tr(DAYS[day.weekday()]), tr(_MONTHS[day.month - 1])
    return tr("{weekday} {day} {month}", weekday=weekday, day=day.day, month=month)


def short_day(day: date, tr: Language) -> str:
    """Return a date without its year: "17 Nov"."""
    return tr("{day} {month}", day=day.day, month=tr(_MONTHS[day.month - 1]))


def programme_words(programme: Programme, tr: Language, *, is_roomy: bool) -> str:
    """Return a programme in a line: "10 attempts, 20 prompts each · goal 1.0 s · start level 4".

    With more room, or if settings were changed, it also says why it starts there.
    """
    attempts, prompts = programme.attempts, programme.prompts
    done = tr("1 attempt") if attempts == 1 else tr("{count} attempts", count=attempts)
    asked = tr("1 prompt") if prompts == 1 else tr("{count} prompts", count=prompts)
    parts = [
        f"{done}, {asked}"
        if attempts == 1
        else tr("{attempts}, {prompts} each", attempts=done, prompts=asked)
    ]
    if programme.goal:
        parts.append(tr("goal {goal}", goal=programme.goal))
    is_told = programme.why and (
        is_roomy or any(what in programme.why for what in ("settings", "new goal"))
    )
    start = tr("start level {level}", level=programme.level)
    parts.append(f"{start} ({tr(programme.why)})" if is_told else start)
    return " · ".join(parts)


def progress_words(line: "LineProgress", others: int, tr: Language) -> str:
    """Return the level at goal with the verdict on it: "Level 4.5: no change can be shown".

    ``others`` is the number of earlier sessions that had other settings.
    """
    from sar_tui.reports.progress_words import standing

    said = standing(line, tr)
    return f"{said} ({tr('{count} with other settings', count=others)})" if others else said


def last_words(last: "SessionResults", felt: str, today: date, tr: Language) -> str:
    """Return the last session in a sentence: "Tue 17 Nov: 12 of 20 reached, tired 3"."""
    attempts = len(last.results)
    if not attempts:
        said = [tr("no attempt was finished")]
    elif last.reached is not None:
        said = [tr("{reached} of {count} reached", reached=last.reached, count=attempts)]
    else:
        said = [tr("1 attempt") if attempts == 1 else tr("{count} attempts", count=attempts)]
    said += filter(None, (status_words(last.status, tr), felt))
    when = day_words(last.began.date(), today, tr)
    return f"{when[0].upper()}{when[1:]}: {', '.join(said)}"


_STATUSES = {
    "completed": "",
    "aborted": "ended early",
    "discarded": "started by mistake",
    "refused": "not agreed to",
    "interrupted": "interrupted",
    "dismissed": "dismissed",
}


def status_words(status: str, tr: Language) -> str:
    """Return a session's status if it is not the usual one."""
    return tr(_STATUSES.get(status, status))


def offer_words(day: date, done: int, planned: object, today: date, tr: Language) -> str:
    """Return the offer to go on with an interrupted session."""
    return tr(
        "Interrupted {day} after {done} of {planned}. F6 and Enter go on with it, Del dismisses it.",
        day=day_words(day, today, tr),
        done=done,
        planned=planned,
    )


def bars(values: Sequence[int], highest: int, width: int) -> str:
    """Return numbers from 1 on as a row of bars, the newest ones if there are more than
    ``width``.
    """
    from sar_tui.reports.charts import BARS

    top = max(highest, len(BARS))
    return "".join(BARS[max(0, min(7, -(-value * 8 // top) - 1))] for value in values[-width:])
