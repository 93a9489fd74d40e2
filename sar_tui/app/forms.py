"""A form that a participant fills in, one item after the other; shown on a screen or told in lines."""

import sqlite3
from collections.abc import Callable, Mapping

from sar_tui.app.interview import Page, question_page
from sar_tui.app.screens.waiting_text import how_to_answer
from sar_tui.loop.clock import host_now
from sar_tui.model.language import BUNDLED, Language, in_language
from sar_tui.model.step import FULL, Entry, Step, points, press
from sar_tui.model.units import MS
from sar_tui.records.kind import MOST_SHOWN_POINTS, NOT_SAID, Field, Kind, RecordError, Value
from sar_tui.reports import progress_words
from sar_tui.rules.declaration import show
from sar_tui.rules.parameters import TaskParameters, build, usable
from sar_tui.rules.scanning import Choice
from sar_tui.store import programmes
from sar_tui.store.database import StoreError
from sar_tui.store.forms import FormAnswers, Occasion, is_complete
from sar_tui.store.records import Record
from sar_tui.tui.language import app_language

_LINE = (0, FULL)


_ACCESS = (
    "language", "switch", "scan_interval_ms", "bounce_ms", "read_aloud", "outputs", "speech",
)  # fmt: skip
"""Settings of a participant that hold outside of sessions, too."""


def access_settings(
    database: sqlite3.Connection, participant: str, language: str = ""
) -> tuple[TaskParameters, str]:
    """Return how a participant uses the program, and their theme, as their programme that was saved
    last says.

    Args:
        database: the database.
        participant: code of the participant.
        language: overrides that of the programme; empty keeps it.
    """
    saved = programmes.last_saved(database, participant)
    values = {name: saved.parameters[name] for name in _ACCESS if name in saved.parameters}
    kept, _ = usable(TaskParameters, values | ({"language": language} if language else {}))
    return build(TaskParameters, kept), saved.theme


def begin_form(
    database: sqlite3.Connection, kind: Kind, of: Occasion, language: str = ""
) -> tuple[FormAnswers, TaskParameters, str]:
    """Return the answers of a form, which go on where they were left, with the settings and the
    theme of the participant, in the language in which the form was begun.

    Args:
        database: the database.
        kind: the form.
        of: who fills it in, and where it belongs.
        language: as for `access_settings`.
    """
    parameters, theme = access_settings(database, of.participant, language)
    answers = FormAnswers(database, kind, of, parameters.language)
    begun_in = answers.language
    if begun_in != kind.language_shown(parameters.language) and begun_in in BUNDLED:
        parameters, theme = access_settings(database, of.participant, begun_in)
    return answers, parameters, theme


def form_language(code: str, texts: Mapping[str, str] = {}) -> Language:
    """Return the texts of a form's screen, with those of the kinds of record; ``texts``, such as a
    theme's, take precedence.
    """
    return app_language(code, {**progress_words.words(code, None).texts, **texts})


def step_of(item: Field) -> Step:
    """Return the question that asks for an item."""
    scale, labels = item.points, item.labels
    if item.type == "choice":
        return Step(name=item.name, text=item.title, kind="choice", labels=labels)
    if len(scale) == FULL + 1 and (scale[0], scale[-1]) == _LINE:
        return Step(name=item.name, text=item.title, kind="line", labels=labels)
    if 1 < len(scale) <= MOST_SHOWN_POINTS:
        ends = (scale[0], scale[-1], scale[1] - scale[0])
        return Step(name=item.name, text=item.title, kind="number", labels=labels, scale=ends)
    return Step(name=item.name, text=item.title, kind="text")


def _typed(item: Field, value: Value, tr: Language) -> str:
    """Return an answer as it would be typed."""
    return tr.figures(show(value)) if item.is_number else str(value)


def _hint(item: Field, step: Step, tr: Language) -> str:
    """Return the hint on an item; of a number that is typed also its range, and words at its
    ends.
    """
    if step.kind != "text" or not (said := item.range_in(tr)):
        return item.hint
    if item.labels:
        said = f"{said} ({' – '.join(item.labels)})"
    return f"{item.hint}, {said}" if item.hint else said


class FormInterview:
    """Asks the items of a form, each with a way back, from the first that has no answer.

    Args:
        kind: the form.
        answers: where the answers go; those that it has are kept.
        tr: the app's texts in the language of the participant.
        tell: tells the therapist that an answer could not be stored.
        now: the present time (ns).

    Attributes:
        title: of the form, in the participant's language.
        step: the item as a question; None while the thanks stand in its place.
        entry: what is chosen or typed so far.
        is_over: True once the participant has read the thanks, or left the form.
    """

    theme = None
    can_leave = True

    def __init__(
        self,
        kind: Kind,
        answers: FormAnswers,
        tr: Language,
        tell: Callable[[str], None],
        now: Callable[[], int] = host_now,
    ) -> None:
        self._answers, self.tr, self._tell, self._now = answers, tr, tell, now
        self._stored = kind.items
        shown = kind.in_language(answers.language)
        self._items, self.title = shown.items, shown.title
        self._instruction = kind.instruction_in(answers.language)
        given = answers.given
        self._at = next(
            (at for at, item in enumerate(self._stored) if item.name not in given), self._count
        )
        self.is_over = False
        self._appear()

    def _appear(self) -> None:
        """Show an item, or the thanks after the last one."""
        self.step = None if self._at == self._count else step_of(self._items[self._at])
        self.entry = self._answered(self.step) if self.step else Entry()
        self._problem, self._shown = "", self._now()

    @property
    def _count(self) -> int:
        return len(self._stored)

    @property
    def help_text(self) -> str:
        """The keys that answer."""
        tr = self.tr
        lines = [
            tr("Backspace goes back to the question before."),
            tr("Each answer is saved at once. A form that is left goes on where it was."),
        ]
        if self.step:
            lines.insert(0, how_to_answer(self.step, Entry(), tr))
        return "\n".join(lines) + "\n"

    @property
    def place(self) -> int:
        """Tells one item from the next."""
        return self._at

    @property
    def result(self) -> Record | None:
        """The form as it is stored, with its scores; None if it is not complete."""
        record = self._answers.record
        return record if record and is_complete(record) else None

    @property
    def can_go_back(self) -> bool:
        """True if there is an item before."""
        return self._at > 0

    @property
    def choices(self) -> tuple[Choice, ...]:
        """Choices of a switch while the thanks are there."""
        return (Choice(self.tr("Finish"), ("enter",)),)

    def page(self, marked: Entry | None = None) -> Page:
        """Return the texts of the item with what is chosen, or with ``marked`` in its place."""
        tr = self.tr
        if self.step is None:
            return Page(
                tr("Thank you"),
                (tr("Everything is saved."),),
                tr("Press Enter to finish."),
                given=tr("Backspace goes back to the question before."),
            )
        where = tr("Item {number} of {total}", number=self._at + 1, total=self._count)
        page = question_page(self.step, marked or self.entry, self.said_before, tr)
        return page._replace(
            where=where if self._count > 1 else "",
            instruction=self._instruction,
            hint=_hint(self._items[self._at], self.step, tr),
            problem=self._problem,
        )

    @property
    def said_before(self) -> str:
        """The answer to the item before; empty without one."""
        if self._at == 0:
            return ""
        item, stored = self._items[self._at - 1], self._stored[self._at - 1]
        value = self._answers.given.get(item.name)
        if value is None or value == NOT_SAID:
            return self.tr(NOT_SAID)
        if item.type == "choice":
            return item.labels[stored.labels.index(str(value))]
        return _typed(item, value, self.tr)

    # --- keys

    def only_chooses(self, key: str) -> bool:
        """Return True if a key chooses an answer, which Enter gives."""
        if self.step is None:
            return False
        is_typed = self.step.kind == "text" and key != "enter"
        is_sign = self.step.kind == "number" and key == "minus"
        return is_typed or is_sign or (len(key) == 1 and key.isdecimal())

    def press(self, key: str, character: str | None) -> None:
        """Handle a key."""
        if key in ("backspace", "escape"):
            self._back(key)
        elif self.step:
            self._choose(self.step, character if character and character.isprintable() else key)
        elif key == "enter":
            self.is_over = True

    def _back(self, key: str) -> None:
        """Take back a typed character, or go back to the item before; from the first, Escape leaves
        the form.
        """
        if key == "backspace" and self.step and self.step.kind == "text" and self.entry.typed:
            self._choose(self.step, key)
        elif self._at > 0:
            self._at -= 1
            self._appear()
        elif key == "escape":
            self.is_over = True

    def _choose(self, step: Step, key: str) -> None:
        pressed = press(step, self.entry, key)
        self._problem = ""
        if isinstance(pressed, Entry):
            self.entry = pressed
            return
        item = self._stored[self._at]
        try:
            value = self._value(item, pressed.answer)
            took = (self._now() - self._shown) // MS
            self._answers.answer(item, value, took)
        except RecordError as error:
            self._problem = str(error)
        except StoreError as error:
            self._problem = self.tr("It cannot be saved just now. Please fetch the experimenter.")
            self._tell(in_language(error, self.tr))
        else:
            self._at += 1
            self._appear()

    def _value(self, item: Field, answer: object) -> Value | None:
        """Return an answer as it is stored: of a choice, in the words of the form's declaration.
        Raises RecordError.
        """
        if answer is None:
            return None
        shown = self._items[self._at]
        if item.type == "choice":
            return item.labels[shown.labels.index(str(answer))]
        assert isinstance(answer, str | int | float)
        return shown.read(answer, self.tr)

    def _answered(self, step: Step) -> Entry:
        """Return the answer that an item has; nothing is chosen without one."""
        item = self._stored[self._at]
        value = self._answers.given.get(item.name)
        if value is None or value == NOT_SAID:
            return Entry()
        match step.kind:
            case "choice":
                return Entry(chosen=(item.labels.index(str(value)),))
            case "line":
                return Entry(place=int(value))
            case "text":
                return Entry(typed=_typed(item, value, self.tr))
        values = [point.value for point in points(step)]
        return Entry(chosen=(values.index(value),)) if value in values else Entry()
