"""The sentence that every report of progress begins with: a verdict on comparable sessions."""

from collections.abc import Sequence
from datetime import date
from typing import Literal

import msgspec

from sar_tui.model.language import Language
from sar_tui.progress.change import BASELINE, FAMILIARISATION, Verdict
from sar_tui.progress.lines import Side
from sar_tui.progress.task_level import to_level
from sar_tui.reports import dose_words, progress_words
from sar_tui.reports.progress import LineProgress, Progress, SessionProgress

Outlook = Literal["improving", "steady", "behind", "too little", "changed", "not measured"]
"""Verdicts on a line. The first three follow from `LineProgress.verdict`; they are given only if
the session that it is on came after the baseline.

- improving, behind: more than noise and practice, or noise, explain.
- steady: no more than that. A change may still be there.
- too little: not yet known.
- changed: not yet known, as earlier sessions had another goal or other settings.
- not measured: the task has no result, or no goal.
"""
FEWEST = FAMILIARISATION + BASELINE + 1
"""Sessions with a known value before a verdict is given: the last one is not of the baseline."""
_MIDDLE = FAMILIARISATION + BASELINE // 2
"""Number of the session in the middle of the baseline, from which the time is counted."""
_WEEKS_FROM, _MONTHS_FROM = 14, 26 * 7
"""Days from which a time is told in weeks, and in months."""
_DAYS_OF_MONTH = 30.44


class Headline(msgspec.Struct, frozen=True):
    """A verdict, and the sentence that tells it."""

    outlook: Outlook
    text: str


def headline(found: Progress, line: LineProgress, tr: Language) -> Headline:
    """Return the sentence on one of a person's lines.

    It claims no more than `progress_words.sentences` do. Earlier lines, which had other settings
    than the newest sessions of the task, say so first.
    """
    alike = [each for each in found.lines if _who(each) == _who(line)]
    if line is not alike[-1]:
        said = _headline(line, None, tr)
        text = f"{tr('These are earlier sessions, with other settings.')} {said.text}"
        return Headline(said.outlook, text)
    return _headline(line, alike[-2] if len(alike) > 1 else None, tr)


def _who(line: LineProgress) -> tuple[str, str, str]:
    return line.task, line.seat, line.mode


def _headline(line: LineProgress, before: LineProgress | None, tr: Language) -> Headline:
    known = [each for each in line.sessions if each.value is not None]
    if line.metric.is_none or (not line.measure and _has_no_goal(line)):
        return Headline("not measured", _not_measured(line, tr))
    if len(known) < FEWEST:
        return _too_little(line, before, known, tr)
    if line.verdict == "not yet known":
        return Headline("too little", _contradicted(line, known[-1], tr))
    return Headline(_OUTLOOKS[line.verdict], _judged(line, known, tr))


def _has_no_goal(line: LineProgress) -> bool:
    return all(each.reached is None for each in line.sessions)


def _not_measured(line: LineProgress, tr: Language) -> str:
    if line.metric.is_none:
        text = "{sessions}. This task has no result, so progress in it is not judged."
    else:
        text = "{sessions}. This task has no goal, so there is no level at goal to judge."
    return tr(text, sessions=sessions_text(len(line.sessions), tr))


# --- too little is known


def _too_little(
    line: LineProgress,
    before: LineProgress | None,
    known: Sequence[SessionProgress],
    tr: Language,
) -> Headline:
    last, more = line.sessions[-1], FEWEST - len(known)
    if not known and (last.side or before is None):
        return Headline("too little", tr(_NONE_KNOWN[last.side]))
    if before is not None:
        return Headline("changed", _changed(line, before, more, tr))
    return Headline("too little", _too_few(line, known, more, tr))


_NONE_KNOWN = {
    "easier": "Too early to say: in the last session every result was better than the goal. "
    "Harder levels would tell more.",
    "harder": "Too early to say: in the last session no result reached the goal. Easier levels "
    "would tell more.",
    "": "Too early to say: these results do not tell yet how they grow with the level. More "
    "attempts, at several levels, would tell more.",
}
"""No session has a known value: the sentence by the side of the last one."""


def _too_few(line: LineProgress, known: Sequence[SessionProgress], more: int, tr: Language) -> str:
    """Return how many sessions there are, and how many more are needed."""
    count = len(line.sessions)
    if len(known) == count:
        text = tr("{sessions}: too few to say.", sessions=sessions_text(count, tr))
        return f"{text} {_after(more, tr)}"
    return tr(
        "{sessions}, {known} of them with a known value: too few to say. It takes {number} of "
        "these to tell a change from noise and practice.",
        sessions=sessions_text(count, tr),
        known=str(len(known)),
        number=str(FEWEST),
    )


def _after(more: int, tr: Language) -> str:
    if more == 1:
        return tr("After one more, a change can be told from noise and practice.")
    return tr(
        "After {number} more, a change can be told from noise and practice.", number=str(more)
    )


def _changed(line: LineProgress, before: LineProgress, more: int, tr: Language) -> str:
    """Return what the earlier sessions had, and how many of the present ones there are."""
    slots = {
        "day": progress_words.day(before.sessions[-1].began),
        "sessions": sessions_text(len(line.sessions), tr),
    }
    if line.goal is not None and before.goal is not None and line.goal != before.goal:
        text = tr(
            "The goal is {new} now, and was {old} until {day}. {sessions} with it: too few to say.",
            new=progress_words.goal(line, tr),
            old=progress_words.goal(before, tr),
            **slots,
        )
    else:
        text = tr(
            "The settings were others until {day}. {sessions} with those of now: too few to say.",
            **slots,
        )
    return f"{text} {_after(more, tr)}"


_CONTRADICTED = {
    "easier": "Too early to say: after {day} there was a session in which every result was better "
    "than the goal. Harder levels would tell more.",
    "harder": "Too early to say: after {day} there was a session in which no result reached the "
    "goal. Easier levels would tell more.",
}


def _contradicted(line: LineProgress, judged: SessionProgress, tr: Language) -> str:
    """Return that a session after the one that is judged, without a known value, speaks against
    it.
    """
    assert line.baseline is not None
    assert judged.value is not None
    side = "easier" if judged.value < line.baseline.mean else "harder"
    return tr(_CONTRADICTED[side], day=progress_words.day(judged.began))


# --- a verdict


_OUTLOOKS: dict[Verdict, Outlook] = {"more": "improving", "noise": "steady", "less": "behind"}
_JUDGED: dict[Verdict, tuple[str, str]] = {
    "more": (
        "Improving: {change} in {time}, more than noise and practice explain.",
        "Improving until {day}: {change} in {time}, more than noise and practice explain.",
    ),
    "noise": (
        "Steady, as far as can be told: {change} in {time}, no more than noise and practice.",
        "Steady until {day}, as far as can be told: {change} in {time}, no more than noise and "
        "practice.",
    ),
    "less": (
        "Behind the earlier level: {change} in {time}, more than noise explains.",
        "Behind the earlier level on {day}: {change} in {time}, more than noise explains.",
    ),
}
"""The sentence of each verdict: if the last session is judged, and if it has no known value."""


_SINCE: dict[Side, str] = {
    "easier": "The last session was too easy to tell.",
    "harder": "The last session was too hard to tell.",
    "": "The last session does not tell.",
}


def _judged(line: LineProgress, known: Sequence[SessionProgress], tr: Language) -> str:
    judged = known[-1]
    assert line.baseline is not None
    assert judged.value is not None
    days = (_day(judged) - _day(known[_MIDDLE])).days
    last = line.sessions[-1]
    text = tr(
        _JUDGED[line.verdict][judged is not last],
        change=_change(line, line.baseline.mean, judged.value, tr),
        time=_time(days, tr),
        day=progress_words.day(judged.began),
    )
    return text if judged is last else f"{text} {tr(_SINCE[last.side])}"


def _change(line: LineProgress, first: float, last: float, tr: Language) -> str:
    """Return two values of the line's measure: "level 5.1 → 6.4", "0.95 → 0.81 s"."""
    if line.measure == "level":
        levels = [to_level(line.places, value) for value in (first, last)]
        begun, ended = (None if level is None else f"{level:.1f}" for level in levels)
        if begun and ended:
            return tr("level {first} → {last}", first=begun, last=ended)
    shown = [progress_words.figure(line, value, tr) for value in (first, last)]
    numbers, units = zip(*(text.partition(" ")[::2] for text in shown), strict=True)
    if units[0] == units[1]:
        return f"{numbers[0]} → {shown[1]}"
    return " → ".join(shown)


def _time(days: int, tr: Language) -> str:
    """Return a time as it is said after "in": "9 days", "4 weeks", "7 months"."""
    if days < _WEEKS_FROM:
        return dose_words.days_text(max(1, days), tr)
    if days < _MONTHS_FROM:
        return tr("{count} weeks", count=str(round(days / 7)))
    return tr("{count} months", count=str(round(days / _DAYS_OF_MONTH)))


def _day(session: SessionProgress) -> date:
    return date.fromisoformat(session.began[:10])


def sessions_text(count: int, tr: Language) -> str:
    return tr("1 session") if count == 1 else tr("{count} sessions", count=str(count))
