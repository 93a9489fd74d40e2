"""The texts of a participant's card and of the list of sessions. Pure."""

from collections.abc import Sequence
from datetime import date
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:  # the empty screen is shown before it is loaded
    from sar_tui.framework.trial_types import Metric

BARS = "▁▂▃▄▅▆▇█"
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


class Past(msgspec.Struct, frozen=True):
    """A session of a participant as a result.

    Args:
        level: at which it was played: see `level_played`.
        result: mean of its attempts, with its unit; empty if there is none.
        reached: number of attempts that reached the goal; None if they had none.
        felt: the worst pain and tiredness, in words.
    """

    day: date
    level: int | None
    result: str
    reached: int | None
    attempts: int
    status: str = "completed"
    felt: str = ""


def level_played(levels: Sequence[int]) -> int:
    """Return the level at which a session was played: the middle one of the second half of its attempts.

    The last level alone would alternate with each success and miss.
    """
    late = sorted(levels[len(levels) // 2 :])
    return late[(len(late) - 1) // 2]


def short(metric: "Metric", value: float) -> str:
    """Return a result in a few characters; times in seconds, as participants read them: "0.95 s"."""
    return f"{value / 1000:.2f} s" if metric.unit == "ms" else metric.show(value)


def day_words(day: date, today: date) -> str:
    """Return a date as people say it: "today", "yesterday", "Tue 17 Nov", "17 Nov 2025"."""
    ago = (today - day).days
    if ago in (0, 1):
        return "yesterday" if ago else "today"
    short_day = f"{day.day} {_MONTHS[day.month - 1]}"
    return f"{_DAYS[day.weekday()]} {short_day}" if day.year == today.year else f"{short_day} {day.year}"


def span_words(days: int) -> str:
    """Return a length of time as people say it: "1 day", "9 days", "2 weeks", "3 months"."""
    if days < 14:
        return "1 day" if days == 1 else f"{days} days"
    return f"{round(days / 7)} weeks" if days < 60 else f"{round(days / 30.4)} months"


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
    is_told = programme.why and (is_roomy or any(what in programme.why for what in ("settings", "new goal")))
    why = f" ({programme.why})" if is_told else ""
    return f"{version}{amount}{goal} · start level {programme.level}{why}"


def progress_words(past: Sequence[Past], others: int) -> str:
    """Return how the level went over comparable sessions: "Played at level 4, up 3 in 2 weeks; up to 1 by chance".

    ``others`` is the number of earlier sessions that had other settings.
    """
    known = [(each.day, each.level) for each in past if each.level is not None]
    if not known:
        return ""
    (began, first), (ended, last) = known[0], known[-1]
    said = f"Played at level {last}"
    if len(known) > 1:
        change = f"up {last - first}" if last > first else f"down {first - last}" if last < first else "as before"
        days = (ended - began).days
        said += f", {change} {f'in {span_words(days)}' if days > 0 else 'in one day'}"
        said += _chance_words([level for _, level in known]) if last != first else ""
    if others:
        said += f" ({others} earlier with other settings)"
    return said


def _chance_words(levels: Sequence[int]) -> str:
    """Return how many levels of a change may be chance: the MDC95 of the baseline sessions, and one at least."""
    from sar_tui.progress.change import baseline  # the empty screen is shown before it is loaded

    found = baseline(levels)
    return f"; up to {max(1, int(found.mdc95))} by chance" if found else "; chance not known yet"


def last_words(last: Past, today: date) -> str:
    """Return the last session in a sentence: "Tue 17 Nov: 12 of 20 reached, tired 3"."""
    of_goal = f"{last.attempts} attempts" if last.reached is None else f"{last.reached} of {last.attempts} reached"
    said = [of_goal if last.attempts else "no attempt was finished"]
    if note := status_words(last.status):
        said.append(note)
    if last.felt:
        said.append(last.felt)
    when = day_words(last.day, today)
    return f"{when[0].upper()}{when[1:]}: {', '.join(said)}"


def status_words(status: str) -> str:
    """Return a session's status if it is not the usual one."""
    return {"completed": "", "aborted": "ended early"}.get(status, status)


def offer_words(day: date, done: int, planned: object, today: date) -> str:
    """Return the offer to go on with an interrupted session."""
    return (
        f"Interrupted {day_words(day, today)} after {done} of {planned}. F6 and Enter go on with it, Del dismisses it."
    )


def waits_words(*, is_interrupted: bool, pain: str, is_due: bool = False) -> str:
    """Return why a participant is marked in the list: pain that was reported comes first, a visit that is due last."""
    return pain or ("unfinished" if is_interrupted else "due" if is_due else "")


def bars(values: Sequence[int], highest: int, width: int) -> str:
    """Return numbers from 1 on as a row of bars, the newest ones if there are more than ``width``."""
    top = max(highest, len(BARS))
    return "".join(BARS[max(0, min(7, -(-value * 8 // top) - 1))] for value in values[-width:])
