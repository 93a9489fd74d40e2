"""Methods of the exported sessions in words, for a paper: what their record says, and no more."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from sar_tui.export.passports import Passport
from sar_tui.store.counted import is_set_aside

FILE = "methods.md"
Row = Mapping[str, Any]
_MANY = 4
"""Number of different numbers from which only their range is told."""


def methods(rows: Sequence[Row], passports: Sequence[Passport]) -> str:
    """Return a page with a section for each task.

    Args:
        rows: sessions as `store.sessions.listing` returns them.
    """
    set_aside = [row for row in rows if is_set_aside(row)]
    rows = [row for row in rows if not is_set_aside(row)]
    tasks = dict.fromkeys(row["task"] for row in rows)
    parts = [_of_task([row for row in rows if row["task"] == task]) for task in tasks]
    if rows:
        parts.append("## Timing\n\n" + _timing(rows, passports))
    if set_aside:
        parts.append(
            f"{_count(len(set_aside), 'session')} of the data (`status` discarded or refused) "
            f"{'does' if len(set_aside) == 1 else 'do'} not count, and "
            f"{'is' if len(set_aside) == 1 else 'are'} left "
            "out above: started by mistake, or not agreed to."
        )
    return "# Methods\n\n" + "\n\n".join(parts) + "\n"


def _of_task(rows: Sequence[Row]) -> str:
    title = _software(rows, "task", "title") or rows[0]["task"]
    return f"## {title}\n\n" + "\n".join([*_sessions(rows, title), *_design(rows)])


def _sessions(rows: Sequence[Row], title: str) -> Iterator[str]:
    """Yield sentences on who did what, and with which software."""
    persons = {code for row in rows for code in (row["participant"], row["partner"]) if code}
    modes = _told(row["mode"] for row in rows)
    version, program, python = (
        _software(rows, *path) for path in (("task", "version"), ("sar_tui",), ("python",))
    )
    yield (
        f"{_count(len(persons), 'participant')} did the task “{title}” (version "
        f"{version or 'not recorded'}) in "
        f"{_count(len(rows), f'{modes} session')}, with sar-tui "
        f"{program or '(version not recorded)'} on Python "
        f"{python or '(version not recorded)'}."
    )
    if cut := sum(row["status"] != "completed" for row in rows):
        yield f"Of these sessions, {cut} ended before all attempts were done."


def _design(rows: Sequence[Row]) -> Iterator[str]:
    """Yield sentences on attempts, goal, level and feedback. A sentence whose values are not
    recorded is left out.
    """

    def value(name: str) -> str:
        return _told(row["parameters"].get(name) for row in rows)

    planned = [
        f"{number} {noun}"
        for name, noun in (
            ("practice_attempts", "for practice"),
            ("prompts_per_attempt", "prompts in each"),
            ("reaches_per_attempt", "reaches in each"),
        )
        if (number := value(name)) not in ("", "0")
    ]
    if attempts := value("attempts"):
        yield f"Attempts planned in a session: {', '.join([attempts, *planned])}."
    if (metric := _told(map(_metric, rows))) and (goal := value("threshold")):
        yield (
            f"The result of an attempt was its {metric}. The goal was {goal} at the start of a "
            "session, with a share "
            f"of right responses of at least {value('min_accuracy') or '0'}; that of each attempt "
            "is in the data."
        )
    if rule := value("difficulty_policy"):
        yield f"The level followed the rule “{rule}”, up to level {value('max_level')}."
    if schedule := value("feedback_schedule"):
        yield (
            f"Feedback followed the schedule “{schedule}” (form: {value('feedback_form')}; "
            "compared with: "
            f"{value('feedback_compared_with')}; delay: {value('feedback_delay_ms')} ms)."
        )
    switched = [row for row in rows if row["parameters"].get("switch", "none") != "none"]
    if switched:
        kinds = _told(f"{row['parameters']['switch']}-switch" for row in switched)
        yield (
            f"{_count(len(switched), 'session')} used {kinds} scanning in place of the keys; the "
            "interval of each choice is in the data (`input/switch`)."
        )
    yield "All that is random follows from the seed of each session."


def _software(rows: Sequence[Row], *path: str) -> str:
    return _told(_at(row["software"], *path) for row in rows)


def _timing(rows: Sequence[Row], passports: Sequence[Passport]) -> str:
    machines = [row["machine"] for row in rows if _at(row["machine"], "system")]
    systems = _told(
        f"{_at(machine, 'system')} ({_at(machine, 'processor')})" for machine in machines
    )
    sentences = [f"Sessions ran on {systems or 'a system that is not recorded'}."]
    if unknown := len(rows) - len(machines):
        sentences += (
            [f"Of {_count(unknown, 'session')}, the system is not recorded."] if machines else []
        )
    for each in passports:
        median, spread, worst = (
            each.timing.get(name) for name in ("median_ms", "robust_sd_ms", "p99_ms")
        )
        if None not in (median, spread, worst):
            sentences.append(
                f"Before {_count(len(each.sessions), 'session')}, the error of reaction times had "
                "been measured on "
                f"that machine with a scripted participant: median {median:.2f} ms, robust SD "
                f"{spread:.2f} ms, "
                f"99th percentile {worst:.2f} ms ({each.timing.get('verdict', 'no verdict')})."
            )
    slowed = [row for row in rows if row["parameters"].get("added_delay_ms")]
    if slowed:
        delay = _told(row["parameters"]["added_delay_ms"] for row in slowed)
        sentences.append(
            f"In {_count(len(slowed), 'session')} the system's slow keys added {delay} ms to each "
            "press, as somebody told; it is contained in the reaction times, and not subtracted."
        )
    if missing := len(rows) - sum(len(each.sessions) for each in passports):
        sentences.append(
            f"Before {_count(missing, 'session')}, the error of reaction times had not been "
            "measured."
        )
    return "\n".join(sentences)


def _metric(row: Row) -> str:
    name, unit = (_at(row["software"], "task", "metric", key) for key in ("name", "unit"))
    return f"{str(name or 'result').replace('_', ' ')} ({unit})" if unit else str(name or "result")


def _at(value: Any, *path: str) -> Any:
    for key in path:
        value = value.get(key) if isinstance(value, Mapping) else None
    return value


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _told(values: Iterable[Any]) -> str:
    """Return the different values of sessions in words: "20", "20 or 30", "1 to 12"; empty if there
    is none.
    """
    different = list(
        dict.fromkeys(value for value in values if isinstance(value, int | float | str))
    )
    numbers = [value for value in different if isinstance(value, int | float)]
    if len(numbers) == len(different) >= _MANY:
        return f"{min(numbers):g} to {max(numbers):g}"
    return " or ".join(value if isinstance(value, str) else f"{value:g}" for value in different)
