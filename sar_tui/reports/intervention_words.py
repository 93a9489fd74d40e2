"""The intervention report in words, by the items of TIDieR and what TIDieR-Rehab adds to them."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from sar_tui.reports.intervention import (
    InterventionReport,
    PersonChallenge,
    PersonDose,
    Spread,
    days_between,
)
from sar_tui.reports.sections import Section, Table
from sar_tui.reports.wizard_words import DEVIATIONS, count, percent

_LISTED = 40
"""Rows of a table that are shown; JSON has all."""
_MORE = "… and {left} more: --json has them all."
_PROCEDURE = {
    "attempts": "attempts planned in a session",
    "prompts_per_attempt": "prompts in an attempt",
    "reaches_per_attempt": "reaches in an attempt",
    "practice_attempts": "attempts for practice before them",
    "planned_attempts_a_day": "attempts planned for a day",
    "attempts_a_day": "most attempts a day",
    "minutes_a_day": "most minutes a day",
    "session_minutes": "most minutes a session",
    "days_between_visits": "days between visits",
    "rest_every": "a rest is suggested every … attempts",
    "rest_after_attempts": "a rest must be taken after … attempts",
    "rest_seconds": "seconds of such a rest",
    "difficulty_policy": "rule of the level",
    "start_from": "start level",
    "min_level": "lowest level",
    "max_level": "highest level",
    "threshold": "goal at the start",
    "min_accuracy": "least share of right responses",
    "feedback_schedule": "feedback is given",
    "feedback_form": "form of feedback",
    "feedback_compared_with": "feedback compares with",
    "feedback_delay_ms": "delay of feedback, ms",
    "outputs": "outputs",
    "language": "language",
    "switch": "switches in place of the keys",
    "scan_interval_ms": "scan interval, ms (0: follows the person)",
    "bounce_ms": "presses of one key within … ms are one",
    "system_keys": "slow or sticky keys of the system",
    "added_delay_ms": "delay of the system's slow keys, ms: part of each reaction time",
}
_UNUSED = {"0", "0.0"}
"""Values of a limit, a rest or a delay that is not used."""
NOT_RECORDED = (
    "The record does not know, and a report must add: why the intervention should help (2); who "
    "gave it, with which training (5); whether they were there, and how (6); where (7); how "
    "adherence was to be kept up (11); the participants' needs and wishes that it was fitted to."
)


def sections(found: InterventionReport) -> list[Section]:
    """Return the report in words."""
    return [
        Section("1 Brief name", [_name(found)]),
        Section("3 What: materials", [_materials(found)]),
        Section("4 What: procedures", list(_procedures(found))),
        Section("8 When and how much: dose", list(_dose(found))),
        Section("Challenge: how it was set, and how it progressed", list(_challenge(found))),
        Section("Feedback", [_feedback(found)]),
        Section("9 Tailoring", [_tailoring(found)]),
        Section("10 Modifications", list(_modifications(found))),
        Section("12 How well: adherence", [_adherence(found)]),
        Section("12 How well: deviations", list(_deviations(found))),
        Section("Harms", [_harms(found)]),
        Section("To add", [NOT_RECORDED]),
    ]


def _name(found: InterventionReport) -> str:
    *others, last = (f"“{each.title}”" for each in found.tasks)
    names = f"{', '.join(others)} and {last}" if others else last
    modes = "" if set(found.modes) == {"live"} else f" ({_counted(found.modes)})"
    return (
        f"Training with the task{'' if len(found.tasks) == 1 else 's'} {names}: "
        f"{count(len(found.participants), 'participant')}, "
        f"{count(len(found.sessions), 'session')}{modes}, from {found.first} to {found.last}."
    )


def _materials(found: InterventionReport) -> str:
    tasks = ", ".join(
        f"{each.task} {' and '.join(each.versions) or '(version not recorded)'}"
        for each in found.tasks
    )
    outputs = ", ".join(f"{name} in {count(n, 'session')}" for name, n in found.outputs.items())
    said = f"sar-tui {' and '.join(found.software) or '(version not recorded)'}; tasks: {tasks}."
    return f"{said} Beside the screen, the agent answered by: {outputs}." if outputs else said


def _procedures(found: InterventionReport) -> Iterator[str | Table]:
    heads = ("setting", *(each.task for each in found.tasks))
    rows: list[tuple[str, ...]] = []
    for name, words in _PROCEDURE.items():
        cells = [_setting(each.settings.get(name, [])) for each in found.tasks]
        is_used = name != "rest_seconds" or any(
            row[0] == _PROCEDURE["rest_after_attempts"] for row in rows
        )
        if is_used and not set(cells) <= {"", *_UNUSED}:
            rows.append((words, *cells))
    yield Table(heads, rows)
    if any(len(values) > 1 for each in found.tasks for values in each.settings.values()):
        yield "Where there are several values, sessions differed; the commonest comes first."


def _setting(values: Sequence[Any]) -> str:
    return " / ".join(
        ", ".join(map(str, value)) if isinstance(value, list) else _figure(value)
        for value in values
    )


def _figure(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _dose(found: InterventionReport) -> Iterator[str | Table]:
    yield (
        f"Within {count(days_between(found.first, found.last), 'day')}. A session had "
        f"{_spread(found.repetitions_a_session)} repetitions and "
        f"{_spread(found.minutes_a_session)} min on task, "
        "without instructions, feedback and rests (median and range)."
    )
    numbers = ("sessions", "days", "a week", "done", "planned", "trials", "on task", "in all")
    yield _table(("code", *numbers), [_dose_row(each) for each in found.dose], numbers)
    yield (
        "a week: sessions. done, planned: attempts without practice. trials: repetitions, that is "
        "prompts or reaches. on task: minutes in attempts. in all: minutes in sessions."
    )


def _dose_row(each: PersonDose) -> tuple[str, ...]:
    return (
        each.participant,
        str(each.sessions),
        str(each.days),
        "" if each.sessions_a_week is None else f"{each.sessions_a_week:.1f}",
        str(each.done),
        str(each.planned),
        str(each.repetitions),
        f"{each.time_on_task_min:.1f}",
        "" if each.time_in_sessions_min is None else f"{each.time_in_sessions_min:.1f}",
    )


def _challenge(found: InterventionReport) -> Iterator[str | Table]:
    reached = percent(found.reached_share) or "none"
    judged = any(each.reached_share is not None for each in found.challenge)
    told = f"Of all attempts, {reached} reached their goal." if judged else "No attempt had a goal."
    yield f"{told} Each change of level, with its reason, is in the record."
    numbers = ("levels", "played", "reached", "right", "up", "down", "hand", "goals")
    yield _table(
        ("code", "task", *numbers), [_challenge_row(each) for each in found.challenge], numbers
    )
    yield (
        "levels: the first and the last. reached: attempts that reached the goal. right: right "
        "responses. up, down: changes of level by the rule. hand: changes by a therapist or "
        "operator. goals: changes of the goal alone."
    )


def _challenge_row(each: PersonChallenge) -> tuple[str, ...]:
    return (
        each.participant,
        each.task,
        f"{each.first_level} → {each.last_level}",
        f"{each.lowest}–{each.highest}",
        percent(each.reached_share),
        percent(each.right_share),
        *map(str, (each.up, each.down, each.by_person, each.goals)),
    )


def _feedback(found: InterventionReport) -> str:
    total = sum(found.feedback.values())
    if not total:
        return "No attempt was finished."
    given = {name: n for name, n in found.feedback.items() if name != "none"}
    without = total - sum(given.values())
    return (
        f"After {count(total, 'attempt')}: {_counted(given) or 'none'}; {without} without feedback."
    )


def _tailoring(found: InterventionReport) -> str:
    differing = [
        f"{_PROCEDURE[name]} ({task.task})" for task in found.tasks for name,
        values in task.settings.items()
        if len(values) > 1
    ]  # fmt: skip
    starts = {(each.task, each.first_level) for each in found.challenge}
    levels = (
        f"First levels: {', '.join(f'{level} ({task})' for task, level in sorted(starts))}."
        if starts
        else ""
    )
    if not differing:
        return f"All sessions of a task had the same settings. {levels}".rstrip()
    return f"Not the same in all sessions: {', '.join(differing)}. {levels}".rstrip()


def _modifications(found: InterventionReport) -> Iterator[str | Table]:
    if not found.programmes:
        yield "No saved programme was changed."
        return
    rows = [
        (
            each.participant,
            each.task,
            str(each.version),
            each.saved_at[:10],
            ", ".join(
                f"{name} {'default' if value is None else value}"
                for name, value in each.changed.items()
            ),
            each.reason,
        )
        for each in found.programmes
    ]
    yield _table(("code", "task", "version", "date", "changed", "why"), rows, ("version",))


def _adherence(found: InterventionReport) -> str:
    done, planned = sum(each.done for each in found.dose), sum(each.planned for each in found.dose)
    statuses = _counted(found.statuses)
    return (
        f"{done} of {planned} planned attempts were done "
        f"({percent(found.adherence) or 'none'}). Sessions: {statuses}."
    )


def _deviations(found: InterventionReport) -> Iterator[str | Table]:
    with_operator = (
        f"An operator took part in {count(found.operated, 'session')}. " if found.operated else ""
    )
    skipped = f"{count(found.skipped, 'attempt')} left out. " if found.skipped else ""
    pauses = ", ".join(f"{reason or 'no reason'} {n}" for reason, n in found.pauses.items())
    paused = f"Pauses of participants: {pauses}." if pauses else "No participant paused."
    yield f"{with_operator}{skipped}{paused}"
    rows = [
        (actor, DEVIATIONS.get(what, what), str(n))
        for actor, counts in found.deviations.items()
        for what, n in counts.items()
    ]
    if rows:
        yield _table(("by", "deviation from the plan", "n"), rows, ("n",))
    else:
        yield "There was no deviation from the plans of the sessions."


def _harms(found: InterventionReport) -> str:
    harms = found.harms
    events = (
        f"Adverse events: {_counted(harms.events)}."
        if harms.events
        else "No adverse event is recorded."
    )
    if not harms.asked:
        return f"{events} Nothing is known of pain: it was not asked."
    return (
        f"{events} Pain is known of {count(harms.asked, 'session')}: some in "
        f"{harms.sessions_with_pain}, severe (7 or more of 10) in {harms.severe}; the worst was "
        f"{harms.worst_pain}. The greatest tiredness was "
        f"{'not asked' if harms.worst_tiredness is None else harms.worst_tiredness}."
    )


def _spread(values: Spread | None) -> str:
    return "no" if values is None else f"{values.median:g} ({values.least:g} to {values.most:g})"


def _counted(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{n} {name}" for name, n in counts.items())


def _table(
    heads: tuple[str, ...], rows: Sequence[tuple[str, ...]], right: tuple[str, ...]
) -> Table:
    left = len(rows) - _LISTED
    return Table(
        heads,
        rows[:_LISTED],
        right,
        ("code", "task", *right),
        _MORE.format(left=left) if left > 0 else "",
    )
