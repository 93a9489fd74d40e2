"""The choices of a session's screens and of questions, for one or two switches."""

from collections.abc import Callable

from sar_tui.model.language import Language
from sar_tui.model.messages import Waiting
from sar_tui.model.step import FULL, SCALES, TIMED, Entry, Step, points
from sar_tui.rules.scanning import Choice

_TENTH = 10
START_ROUNDS = 6
"""Intervals for which the start of a trial is marked, before a pause is offered: it comes often."""


def session_choices(  # noqa: PLR0911
    waiting: Waiting, start_key: str, tr: Language, *, can_undo: bool, can_pause: bool
) -> tuple[Choice, ...]:
    """Return what can be done while a session waits; nothing in a trial, or if it waits for
    something else than the participant.

    Nothing can be taken back while a question is asked: each answer with a switch is asked about.
    """
    go_on = Choice(tr("Go on"), ("enter",))
    undo = (Choice(tr("Take back"), ("ctrl+z",)),) if can_undo else ()
    pause = (Choice(tr("Pause"), ("escape",)),) if can_pause else ()
    if waiting.reason == "visit":
        return (Choice(tr("Yes"), ("enter",)), Choice(tr("Not today"), ("escape",)))
    match waiting.what:
        case "nothing":
            return (Choice(tr("Finish"), ("enter",)),)
        case "start":
            return (Choice(tr("Start"), (start_key,), rounds=START_ROUNDS), *undo, *pause)
        case "sensor":
            return pause
        case "step" if waiting.step and waiting.step.step.kind not in TIMED:
            step, entry = waiting.step.step, waiting.step.entry
            found = answers(step, entry, tr) if step.is_question else (go_on,)
            return (*found, *pause) if found else ()
        case "enter":
            hear = (Choice(tr("Hear how it went"), (waiting.ask,)),) if waiting.ask else ()
            return (go_on, *undo, *hear, *pause)
    return ()


def answers(step: Step, entry: Entry, tr: Callable[..., str]) -> tuple[Choice, ...]:
    """Return the answers of a question, each of which is asked about, and to give none.

    A line is answered in tenths. Words cannot be chosen: such a question can only be declined, and
    once somebody types, nothing is offered.

    Args:
        step: the question, in the language of the session.
        entry: what was chosen or typed so far.
        tr: translates.
    """

    def answer(label: str, keys: tuple[str, ...], shown: Entry) -> Choice:
        asked = tr("You chose: {answer}. Is that right?", answer=label)
        return Choice(label, (*keys, "enter"), asked, shown)

    decline = Choice(tr("I would rather not say"), ("tab",))
    found = points(step)
    names = [" ".join(filter(None, (point.typed, point.label))) for point in found]
    match step.kind:
        case "text":
            return () if entry.typed else (decline,)
        case "line":
            tenths = range(0, FULL + 1, _TENTH)
            digits = [str(place // _TENTH) if place < FULL else "end" for place in tenths]
            marks = [
                answer(str(at), (key,), Entry(place=at))
                for at, key in zip(tenths, digits, strict=True)
            ]
            return (*marks, decline)
        case "choices":
            toggles = [
                Choice(name, (point.typed,), "", Entry(chosen=entry.chosen, place=index))
                for index, (name, point) in enumerate(zip(names, found, strict=True))
            ]
            chosen = ", ".join(found[index].label for index in entry.chosen)
            asked = tr("You chose: {answer}. Is that right?", answer=chosen)
            done = (Choice(tr("Done"), ("enter",), asked),) if chosen else ()
            return (*toggles, *done, decline)
        case kind if kind in SCALES:
            forget = ("right",) if entry.typed else ()  # digits that were typed by hand
            scale = [
                answer(name, (*forget, *point.typed), Entry(chosen=(index,)))
                for index, (name, point) in enumerate(zip(names, found, strict=True))
            ]
            return (*scale, decline)
    return ()
