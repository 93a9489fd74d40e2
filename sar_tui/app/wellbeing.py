"""When the app asks about pain and tiredness, and where the answers go."""

import sqlite3
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from sar_tui.app.wellbeing_interview import Person, Question, Questions, Save, WellbeingInterview
from sar_tui.loop.task import Task
from sar_tui.model.language import Language
from sar_tui.model.messages import StepEnded
from sar_tui.model.theme import Theme
from sar_tui.records.kind import NOT_SAID, Value
from sar_tui.reports.wellbeing import advice
from sar_tui.rules.parameters import pain_limits
from sar_tui.rules.questions import PAIN as PAIN_QUESTION
from sar_tui.rules.wellbeing import Moment, stop_now, tell_therapist
from sar_tui.store import records, wellbeing
from sar_tui.store.database import StoreError
from sar_tui.store.wellbeing import PAIN, RATED, TIREDNESS
from sar_tui.tui.language import session_language

if TYPE_CHECKING:
    from sar_tui.app.live import LiveSession
    from sar_tui.store.database import StoreConnection


class Asking(Protocol):
    """An app that asks: where the answers go, and how it tells the therapist."""

    @property
    def database(self) -> "StoreConnection":
        """The open database."""
        ...

    def notify(self, message: str, /, *, severity: Any = ..., timeout: float | None = ...) -> None:
        """Show a message."""


def ask_before(app: "Asking", task: Task, theme: Theme, codes: Sequence[str]) -> WellbeingInterview:
    """Return what is asked before a session."""
    people = _people(task, dict(zip(task.seats, codes, strict=False)))
    tr = session_language(task).including(theme.texts)
    limits = pain_limits(task.parameters)
    questions = Questions("before", people, limits, _saving(app, "before"), tr, theme)
    return WellbeingInterview(questions)


def ask_after(app: "Asking", live: "LiveSession", moment: Moment = "after") -> WellbeingInterview:
    """Return what is asked after a session, or in a pause of it."""
    return _interview(app, live, moment, _people_of(app, live))


def advise(app: "Asking", live: "LiveSession", ended: StepEnded) -> WellbeingInterview | None:
    """Return the advice to stop after a question between attempts; None if no pain
    speaks against it.
    """
    if ended.name != PAIN_QUESTION or ended.kind != "number" or not isinstance(ended.answer, int):
        return None
    (person,) = (each for each in _people_of(app, live) if each.seat == ended.seat)
    if (
        stop_now(person.pain_before, ended.answer, pain_limits(live.session.task.parameters))
        is None
    ):
        return None
    _saving(app, "pause", live.run.id)(person, "pain", str(ended.answer))
    return _interview(app, live, "pause", [person], told=ended.answer)


def had_better_rest(app: "Asking", live: "LiveSession") -> bool:
    """Return True if a participant was advised to stop, in a session or after it, and did not
    choose to go on.
    """
    rows, limits = (
        wellbeing.of_session(app.database, live.run.id),
        pain_limits(live.session.task.parameters),
    )
    said = [wellbeing.ratings(rows, seat, limits) for seat in live.codes]
    return any(each.is_reason_to_stop and each.advice in ("shown", "stopped") for each in said)


def _people_of(app: "Asking", live: "LiveSession") -> list[Person]:
    """Return the participants of a session, with their pain before it."""
    rows = wellbeing.of_session(app.database, live.run.id)
    people = _people(live.session.task, dict(live.codes))
    return [
        person._replace(pain_before=wellbeing.ratings(rows, person.seat).pain_before)
        for person in people
    ]


def _interview(
    app: "Asking",
    live: "LiveSession",
    moment: Moment,
    people: Sequence[Person],
    told: int | None = None,
) -> WellbeingInterview:
    session = live.session
    tr = session_language(session.task).including(session.theme.texts)
    limits = pain_limits(session.task.parameters)
    save = _saving(app, moment, live.run.id)
    return WellbeingInterview(Questions(moment, people, limits, save, tr, session.theme, told))


def warnings(app: "Asking", codes: Sequence[str], tr: Language) -> list[str]:
    """Return a sentence for each thing that the therapist should be told of some participants."""
    from sar_tui.reports import progress_words

    tr = progress_words.words(tr.code, None)
    return [
        f"{code}: {text}"
        for code in codes
        for text in advice(tell_therapist(wellbeing.history(app.database, code)), tr)
    ]


def _people(task: Task, codes: dict[str, str]) -> list[Person]:
    """Return the participants by seat, named if there are several."""
    several = len(codes) > 1
    return [
        Person(seat, code, f"{task.seat_name(seat)} ({code})" if several else "")
        for seat, code in codes.items()
    ]


def _saving(app: "Asking", moment: Moment, session: str | None = None) -> Save:
    """Return what stores an answer at once: a new record, or more of the one of this person."""
    known: dict[tuple[str, str], str] = {}

    def save(person: Person, question: Question, answer: str) -> None:
        kind = TIREDNESS if question == "fatigue" else PAIN
        given = _content(question, answer)
        try:
            id = known.get((person.seat, kind))
            if id is None and question == "advice":
                id = _last_told(app.database, person, moment, session)
            if id is not None:
                correct_if_new(app.database, id, given)
                return
            entered = records.add(
                app.database,
                records.kind_of(kind),
                person.code,
                "",
                given,
                session=session,
                seat=person.seat,
                moment=moment,
            )
            known[person.seat, kind] = entered.id
        except StoreError as error:
            app.notify(str(error), severity="error", timeout=15)

    return save


def correct_if_new(database: sqlite3.Connection, id: str, given: dict[str, Value | None]) -> None:
    """Store another version of a record, unless it says the same. Raises StoreError."""
    content = records.find_record(database, id).content
    if any(content.get(name) != value for name, value in given.items()):
        records.correct(database, id, given)


def _last_told(
    database: sqlite3.Connection, person: Person, moment: Moment, session: str | None
) -> str | None:
    """Return the id of the pain that a person told last at a moment; None if they told none."""
    told = records.listing(database, kinds=(PAIN,), participant=person.code, session=session)
    ids = [each.id for each in told if each.moment == moment and "rating" in each.content]
    return ids[-1] if ids else None


def _content(question: Question, answer: str) -> dict[str, Value | None]:
    """Return the values of a record that an answer gives."""
    if question in ("place", "advice"):
        return {question: answer}
    rating = None if answer == NOT_SAID else int(answer)
    given: dict[str, Value | None] = {
        "answer": NOT_SAID if rating is None else RATED,
        "rating": rating,
    }
    if question == "pain" and not rating:  # it hurts nowhere, whatever was said before
        given["place"] = None
    return given
