"""Sentences of ``sar-tui study``: the command to go on with, what is left, what a version changes."""

from collections.abc import Iterator, Mapping
from datetime import date
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sar_tui.app.study.commands import StudyCommands
    from sar_tui.cli.common import Home
    from sar_tui.study.next_block import Person
    from sar_tui.study.plan import Study
    from sar_tui.study.schedule import Item, VisitDay


def commands(home: "Home", study: str = "") -> "StudyCommands":
    """Return what writes commands on a study as they can be typed here.

    ``study``: its name; empty if it was not given, as there is one only.
    """
    from sar_tui.app.study.commands import StudyCommands

    return StudyCommands(home.folder, [folder.absolute() for folder in home.tasks], study)


# --- what is left


def place_words(item: "Item") -> str:
    """Return the names of a visit and a block, without the condition: the participant may read
    it.
    """
    return f"Visit {item.visit.name}, block {item.block.name}"


def why_stopped(one: "Person", item: "Item", now: Any) -> str:
    """Return why nothing more begins after a block; empty if it is completed.

    Args:
        one: the person, read after the block.
        item: the block.
        now: the present.
    """
    from sar_tui.study.schedule import can_resume, finished

    plan, block = one.frozen.plan, item.block
    if done := finished(plan, one.played, now).get(item.key):
        if done.status == "completed":
            return ""
        return f"The block {block.name} was ended early. It counts as done: nothing more is begun."
    if block.form:
        return (
            f"The form {block.form} is not complete. Its answers are kept: today it goes on where "
            "it was left."
        )
    begun = [each for each in one.played if each.key == item.key]
    if not begun:
        return f"The block {block.name} was not begun."
    again = "goes on where it was" if can_resume(plan, begun[-1], now) else "is begun again"
    return f"The block {block.name} was interrupted: it {again}."


def left_words(code: str, day: "VisitDay", today: date) -> str:
    """Return what a person has to do next, and when."""
    count = day.of - day.done
    blocks = "1 block" if count == 1 else f"{count} blocks"
    return f"{code}: the visit {day.visit.name} has {blocks} to do{_when(day, today)}."


def _when(day: "VisitDay", today: date) -> str:
    from sar_tui.app.home.words import day_words
    from sar_tui.model.language import ENGLISH

    if day.first is None or day.last is None:
        return ""
    first, last = (day_words(each, today, ENGLISH) for each in (day.first, day.last))
    if day.last < today:
        return f"; it was due by {last}"
    if day.first <= today:
        return " today" if day.last == today else f" by {last}"
    return f" on {first}" if first == last else f" from {first} to {last}"


# --- what a version changes


def changes(before: "Study", after: "Study") -> Iterator[str]:
    """Yield lines on what a later version of a plan changes, by the names of its parts."""
    for what in ("groups", "conditions"):
        yield from _changed(what[:-1], getattr(before, what), getattr(after, what))
    old, new = ({visit.name: visit for visit in plan.visits} for plan in (before, after))
    own = ({name: _without_blocks(visit) for name, visit in each.items()} for each in (old, new))
    yield from _changed("visit", *own)
    for name in old.keys() & new.keys():
        blocks = ({block.name: block for block in each[name].blocks} for each in (old, new))
        yield from _changed(f"visit {name}, block", *blocks)
    rest = [
        field
        for field in after.__struct_fields__
        if field not in ("version", "groups", "conditions", "visits")
        and getattr(before, field) != getattr(after, field)
    ]
    if rest:
        yield f"changed: {', '.join(rest)}"


def _without_blocks(visit: Any) -> dict[str, Any]:
    return {name: getattr(visit, name) for name in visit.__struct_fields__ if name != "blocks"}


def _changed(what: str, before: Mapping[str, Any], after: Mapping[str, Any]) -> Iterator[str]:
    """Yield lines on parts of a plan that are new, gone or changed."""
    import msgspec

    for name in after:
        if name not in before:
            yield f"new: {what} {name}"
        elif before[name] != after[name]:
            old, new = (msgspec.to_builtins(each[name]) for each in (before, after))
            fields = ", ".join(key for key in new if old.get(key) != new[key])
            yield f"changed: {what} {name} ({fields})"
    for name in before:
        if name not in after:
            yield f"gone: {what} {name}"
