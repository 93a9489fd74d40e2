"""A form that a participant fills in, one item after the other; shown on a screen or told in lines."""

import sqlite3
from collections.abc import Callable, Mapping
from typing import NamedTuple

from sar_tui.app.screens.waiting_text import decline_text, how_to_answer, option_sentences
from sar_tui.loop.clock import host_now
from sar_tui.model.language import Language, in_language
from sar_tui.model.spoken_text import sentences
from sar_tui.model.step import FULL, Entry, Step, points, press
from sar_tui.model.units import MS
from sar_tui.records.kind import NOT_SAID, Field, Kind, RecordError, Value
from sar_tui.reports import progress_words
from sar_tui.rules.parameters import TaskParameters, build, usable
from sar_tui.store import programmes
from sar_tui.store.database import StoreError
from sar_tui.store.forms import FormAnswers
from sar_tui.store.records import Record
from sar_tui.tui.language import app_language

_MOST_TICKS = 31
"""Points of a scale that are drawn and chosen one by one; of more, the number is typed."""
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
    if 1 < len(scale) <= _MOST_TICKS:
        ends = (scale[0], scale[-1], scale[1] - scale[0])
        return Step(name=item.name, text=item.title, kind="number", labels=labels, scale=ends)
    return Step(name=item.name, text=item.title, kind="text")


class Page(NamedTuple):
    """Texts of an item, or of the thanks after the last one.

    Attributes:
        where: how far the form is filled in.
        instruction: of the form.
        text: the item. ``hint``: on how it is answered, such as a unit.
        said: the options, and what is chosen, in sentences.
        decline: the key that gives no answer.
        given: the answer before, and the way back.
        problem: why the answer cannot be taken.
        press: the key that leads on.
    """

    where: str
    instruction: str
    text: str
    hint: str
    said: tuple[str, ...]
    decline: str
    given: str
    problem: str
    press: str

    @property
    def sentences(self) -> list[str]:
        """All of it, in sentences."""
        where, instruction, text, hint, said, *rest = self
        return sentences(where, instruction, text, hint, *said, *rest)


class Filling:
    """Asks the items of a form, each with a way back, from the first that has no answer.

    Args:
        kind: the form.
        answers: where the answers go; those that it has are kept.
        tr: the app's texts in the language of the participant.
        tell: tells the therapist that an answer could not be stored.
        now: the present time (ns).

    Attributes:
        entry: what is chosen or typed so far.
        is_over: True once the participant has read the thanks, or left the form.
    """

    def __init__(
        self,
        kind: Kind,
        answers: FormAnswers,
        tr: Language,
        tell: Callable[[str], None],
        now: Callable[[], int] = host_now,
    ) -> None:
        self._answers, self._tr, self._tell, self._now = answers, tr, tell, now
        self._stored = kind.items
        self._kind = kind.in_language(answers.language)
        self._instruction = kind.instruction_in(answers.language)
        given = answers.given
        self._at = next(
            (at for at, item in enumerate(self._stored) if item.name not in given), self._count
        )
        self.is_over = False
        self._appear()

    def _appear(self) -> None:
        self.entry, self._problem, self._shown = self._answered(), "", self._now()

    @property
    def _count(self) -> int:
        return len(self._stored)

    @property
    def title(self) -> str:
        """The title of the form, in the participant's language."""
        return self._kind.title

    @property
    def place(self) -> int:
        """Tells one item from the next."""
        return self._at

    @property
    def record(self) -> Record | None:
        """The form as it is stored; None without an answer."""
        return self._answers.record

    @property
    def is_thanking(self) -> bool:
        """True while the thanks stand in place of an item."""
        return self._at == self._count

    @property
    def is_typing(self) -> bool:
        """True while an item is answered in typed words."""
        return not self.is_thanking and self.step.kind == "text"

    @property
    def can_go_back(self) -> bool:
        """True if there is an item before."""
        return self._at > 0

    @property
    def step(self) -> Step:
        """The item as a question."""
        return step_of(self._kind.items[self._at])

    def page(self, marked: Entry | None = None) -> Page:
        """Return the texts of the item with what is chosen, or with ``marked`` in its place."""
        tr = self._tr
        if self.is_thanking:
            done = tr("Everything is saved."), tr("Backspace goes back to the question before.")
            thanks, finish = tr("Thank you"), tr("Press Enter to finish.")
            return Page("", "", thanks, "", (done[0],), "", done[1], "", finish)
        step, entry, given = self.step, marked or self.entry, ""
        if said := self.said_before:
            given = tr("You said: {answer}. Backspace goes back.", answer=said)
        is_chosen = bool(entry.chosen) or entry.place is not None
        where = tr("Item {number} of {total}", number=self._at + 1, total=self._count)
        return Page(
            where if self._count > 1 else "",
            self._instruction,
            step.text,
            self._kind.items[self._at].hint,
            option_sentences(step, entry, tr),
            decline_text(step, tr),
            given,
            self._problem,
            tr("Press Enter to go on.") if is_chosen else how_to_answer(step, entry, tr),
        )

    @property
    def said_before(self) -> str:
        """The answer to the item before; empty without one."""
        if self._at == 0:
            return ""
        item = self._kind.items[self._at - 1]
        value = self._answers.given.get(item.name)
        if value is None or value == NOT_SAID:
            return self._tr(NOT_SAID)
        if item.type == "choice":
            return item.labels[self._stored[self._at - 1].labels.index(str(value))]
        return f"{value}"

    # --- keys

    def only_chooses(self, key: str) -> bool:
        """Return True if a key chooses an answer, which Enter gives."""
        if self.is_thanking:
            return False
        return (len(key) == 1 and key.isdecimal()) or (self.is_typing and key != "enter")

    def press(self, key: str, character: str | None) -> None:
        """Handle a key."""
        if key in ("backspace", "escape"):
            self._back(key)
        elif not self.is_thanking:
            self._choose(character if character and character.isprintable() else key)
        elif key == "enter":
            self.is_over = True

    def _back(self, key: str) -> None:
        """Take back a typed character, or go back to the item before; from the first, Escape leaves
        the form.
        """
        if key == "backspace" and self.is_typing and self.entry.typed:
            self._choose(key)
        elif self._at > 0:
            self._at -= 1
            self._appear()
        elif key == "escape":
            self.is_over = True

    def _choose(self, key: str) -> None:
        pressed = press(self.step, self.entry, key)
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
            tr = self._tr
            self._problem = tr("It cannot be saved just now. Please fetch the experimenter.")
            self._tell(in_language(error, tr))
        else:
            self._at += 1
            self._appear()

    def _value(self, item: Field, answer: object) -> Value | None:
        """Return an answer as it is stored: of a choice, in the words of the form's declaration.
        Raises RecordError.
        """
        if answer is None:
            return None
        shown = self._kind.items[self._at]
        if item.type == "choice":
            return item.labels[shown.labels.index(str(answer))]
        assert isinstance(answer, str | int | float)
        return shown.read(answer, self._tr)

    def _answered(self) -> Entry:
        """Return the answer that an item has; nothing is chosen without one."""
        if self.is_thanking:
            return Entry()
        item, step = self._stored[self._at], self.step
        value = self._answers.given.get(item.name)
        if value is None or value == NOT_SAID:
            return Entry()
        match step.kind:
            case "choice":
                return Entry(chosen=(item.labels.index(str(value)),))
            case "line":
                return Entry(place=int(value))
            case "text":
                return Entry(typed=str(value))
        values = [point.value for point in points(step)]
        return Entry(chosen=(values.index(value),)) if value in values else Entry()
