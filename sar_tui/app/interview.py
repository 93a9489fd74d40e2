"""Questions that are asked one after the other: the texts of each, and what asks them.

`QuestionScreen` shows an interview, and `PlainApp` tells it in lines.
"""

from typing import NamedTuple, Protocol, TypeVar

from sar_tui.app.screens.waiting_text import decline_text, how_to_answer, option_sentences
from sar_tui.model.language import Language
from sar_tui.model.spoken_text import sentences
from sar_tui.model.step import Entry, Step
from sar_tui.model.theme import Theme
from sar_tui.rules.scanning import Choice

Result_co = TypeVar("Result_co", covariant=True)


class Page(NamedTuple):
    """Texts of a question, or of the words after the last one.

    Attributes:
        text: the question, or the heading of the words.
        said: the options, what is chosen, or the words, in sentences.
        press: the key that leads on.
        decline: the key that gives no answer, or goes on in spite of an advice.
        given: the answer before, and the way back.
        where: how far a form is filled in.
        who: name of the person, if several are asked.
        instruction: of a form.
        hint: on how the question is answered, such as a unit.
        problem: why the answer cannot be taken.
    """

    text: str
    said: tuple[str, ...]
    press: str
    decline: str = ""
    given: str = ""
    where: str = ""
    who: str = ""
    instruction: str = ""
    hint: str = ""
    problem: str = ""

    @property
    def sentences(self) -> list[str]:
        """All of it, in sentences."""
        above = self.where, self.who, self.instruction, self.text, self.hint
        return sentences(*above, *self.said, self.decline, self.given, self.problem, self.press)


def question_page(step: Step, entry: Entry, said_before: str, tr: Language) -> Page:
    """Return the texts of a question.

    Args:
        step: the question, in the language of the participant.
        entry: what is chosen or typed.
        said_before: the answer to the question before; empty without one.
        tr: the other texts.
    """
    is_chosen = bool(entry.chosen) or entry.place is not None
    way_back = tr("You said: {answer}. Backspace goes back.", answer=said_before)
    return Page(
        text=step.text,
        said=option_sentences(step, entry, tr),
        press=tr("Press Enter to go on.") if is_chosen else how_to_answer(step, entry, tr),
        decline=decline_text(step, tr),
        given=way_back if said_before else "",
    )


class Interview(Protocol[Result_co]):
    """Asks questions one at a time, with a way back and nothing chosen beforehand."""

    @property
    def tr(self) -> Language:
        """Texts in the language of the participant."""
        ...

    @property
    def title(self) -> str:
        """Title of a form; empty of other questions."""
        ...

    @property
    def theme(self) -> Theme | None:
        """The theme whose agent asks; None if none does."""
        ...

    @property
    def help_text(self) -> str:
        """The keys that answer."""
        ...

    @property
    def place(self) -> object:
        """Tells one question from the next."""
        ...

    @property
    def step(self) -> Step | None:
        """The question; None while words stand in its place."""
        ...

    @property
    def entry(self) -> Entry:
        """The answer as it is chosen or typed so far."""
        ...

    @property
    def said_before(self) -> str:
        """The answer to the question before; empty without one."""
        ...

    @property
    def can_go_back(self) -> bool:
        """True if there is a question before."""
        ...

    @property
    def can_leave(self) -> bool:
        """True if Escape does something."""
        ...

    @property
    def choices(self) -> tuple[Choice, ...]:
        """Choices of a switch, beside going back, while words stand in place of a question."""
        ...

    @property
    def is_over(self) -> bool:
        """True once nothing is asked any more."""
        ...

    @property
    def result(self) -> Result_co:
        """The outcome, once it is over."""
        ...

    def page(self, marked: Entry | None = None) -> Page:
        """Return the texts with what is chosen, or with ``marked`` in its place."""
        ...

    def only_chooses(self, key: str) -> bool:
        """Return True if a key chooses an answer, which Enter gives."""
        ...

    def press(self, key: str, character: str | None) -> None:
        """Handle a key."""
        ...
