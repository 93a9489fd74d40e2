"""The texts of a participant's card and of the list of sessions. Pure."""

from collections.abc import Sequence
from datetime import date
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:  # the empty screen is shown before it is loaded
    from sar_tui.model.trial_types import Metric
    from sar_tui.progress.lines import SessionResults
    from sar_tui.reports.progress import LineProgress

_DAYS = ("Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun")
_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")


class Programme(msgspec.Struct, frozen=True):
    """Figures of the next session of a task.

    ``version`` is that of its programme, 0 without one; ``why`` says why it starts at the level.
    """

    version: int
    attempts: int
    prompts: int
    goal: str
    level: int
    why: str = ""


def short(metric: "Metric", value: float) -> str:
    """Return a result in a few characters; times in seconds, as participants read them: "0.95
    s".
    """
    return f"{value / 1000:.2f} s" if metric.unit == "ms" else metric.show(value)


def day_words(day: date, today: date) -> str:
    """Return a date as people say it: "today", "yesterday", "Tue 17 Nov", "17 Nov 2025"."""
    ago = (today - day).days
    if ago in (0, 1):
        return "yesterday" if ago else "today"
    short_day = f"{day.day} {_MONTHS[day.month - 1]}"
    return (
        f"{_DAYS[day.weekday()]} {short_day}"
        if day.year == today.year
        else f"{short_day} {day.year}"
    )


def programme_words(programme: Programme, *, is_roomy: bool) -> str:
    """Return a programme in a line: "v3: 10 × 20 · goal 1.0 s · start level 4".

    With more room, or if settings were changed, it also says why it starts there.
    """
    amount = f"{programme.attempts} × {programme.prompts}"
    version = f"v{programme.version}: " if programme.version else ""
    if is_roomy:
        attempts = "1 attempt" if programme.attempts == 1 else f"{programme.attempts} attempts"
        amount = f"{attempts} of {programme.prompts}"
        version = f"version {programme.version}: " if programme.version else "none saved: "
    goal = f" · goal {programme.goal}" if programme.goal else ""
    is_told = programme.why and (
        is_roomy or any(what in programme.why for what in ("settings", "new goal"))
    )
    why = f" ({programme.why})" if is_told else ""
    return f"{version}{amount}{goal} · start level {programme.level}{why}"


def progress_words(line: "LineProgress", others: int) -> str:
    """Return the level at goal with the verdict on it: "Level 4.5 at goal: no change can be shown".

    ``others`` is the number of earlier sessions that had other settings.
    """
    from sar_tui.model.language import Language
    from sar_tui.reports.progress_words import standing

    said = standing(line, Language())
    return f"{said} ({others} with other settings)" if others else said


def last_words(last: "SessionResults", felt: str, today: date) -> str:
    """Return the last session in a sentence: "Tue 17 Nov: 12 of 20 reached, tired 3"."""
    attempts = len(last.results)
    of_goal = (
        f"{attempts} attempts" if last.reached is None else f"{last.reached} of {attempts} reached"
    )
    said = [of_goal if attempts else "no attempt was finished"]
    if note := status_words(last.status):
        said.append(note)
    if felt:
        said.append(felt)
    when = day_words(last.began.date(), today)
    return f"{when[0].upper()}{when[1:]}: {', '.join(said)}"


_STATUSES = {
    "completed": "",
    "aborted": "ended early",
    "discarded": "started by mistake",
    "refused": "not agreed to",
}


def status_words(status: str) -> str:
    """Return a session's status if it is not the usual one."""
    return _STATUSES.get(status, status)


def offer_words(day: date, done: int, planned: object, today: date) -> str:
    """Return the offer to go on with an interrupted session."""
    return (
        f"Interrupted {day_words(day, today)} after {done} of {planned}. F6 and Enter go on "
        "with it, Del dismisses it."
    )


def bars(values: Sequence[int], highest: int, width: int) -> str:
    """Return numbers from 1 on as a row of bars, the newest ones if there are more than
    ``width``.
    """
    from sar_tui.reports.charts import BARS

    top = max(highest, len(BARS))
    return "".join(BARS[max(0, min(7, -(-value * 8 // top) - 1))] for value in values[-width:])
