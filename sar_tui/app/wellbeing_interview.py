"""Questions about pain and tiredness, and the advice not to train."""

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

from sar_tui.app.interview import Page, question_page
from sar_tui.app.screens.waiting_text import how_to_answer
from sar_tui.model.language import Language
from sar_tui.model.step import Entry, Step, points, press, translated
from sar_tui.model.theme import Theme
from sar_tui.records.kind import NOT_SAID
from sar_tui.rules.scanning import Choice
from sar_tui.rules.wellbeing import PAIN_ENDS, Advice, Moment, PainLimits, stop_now

Question = Literal["pain", "place", "fatigue", "advice"]
"""A question, or the ``advice`` not to train."""
GO_ON_KEY = "g"
"""Goes on in spite of the advice not to. It answers no question, so that nobody presses it by
habit.
"""

PLACES = (
    "left hand",
    "right hand",
    "left arm",
    "right arm",
    "left shoulder",
    "right shoulder",
    "neck or back",
    "head",
    "somewhere else",
)
"""Places where it may hurt, numbered from 1; stored as they are here, in English."""
QUESTIONS: dict[Question, Step] = {
    "pain": Step(
        name="pain", text="How much pain do you have now?", kind="number", labels=PAIN_ENDS
    ),
    "place": Step(name="place", text="Where does it hurt?", kind="choice", labels=PLACES),
    "fatigue": Step(
        name="fatigue",
        text="How tired are you now?",
        kind="number",
        labels=("not tired", "exhausted"),
    ),
}
_CHOICE_KEYS = frozenset("0123456789")
"""Keys that choose, as the arrows do, and answer nothing yet."""
_ADVICE: dict[Moment, str] = {
    "before": "Please do not train now",
    "pause": "Please stop for today",
    "after": "Please rest now",
}
TELL_OF_PAIN = "Rest, and tell your therapist about the pain now."
ALONE = "Nobody is watching this screen, and it calls nobody. Please tell them yourself."
_CALLS_NOBODY: dict[Moment, str] = {
    "before": ALONE,
    # there may be an operator, and none may show
    "pause": "This screen calls nobody. Please tell them yourself.",
    "after": ALONE,
}
_STOP: dict[Moment, str] = {
    "before": "Press Enter to stop for today.",
    "pause": "Press Enter to end the session.",
    "after": "Press Enter to close.",
}
_GO_ON: dict[Moment, str] = {
    "before": "If you want to train all the same, press G.",
    "pause": "If you want to go on all the same, press G.",
    "after": "",
}
_SWITCH_ADVICE: dict[Moment, tuple[str, str]] = {
    "before": ("Stop for today", "Train all the same"),
    "pause": ("End the session", "Go on all the same"),
    "after": ("Close", ""),
}
"""Words of the same choices for a switch: to stop, and to go on."""


class Person(NamedTuple):
    """A participant who is asked. ``name``: shown above the questions if there are two.
    ``pain_before``: for a rule.
    """

    seat: str
    code: str
    name: str = ""
    pain_before: int | None = None


Save = Callable[[Person, Question, str], None]
"""Stores an answer."""


class Questions(NamedTuple):
    """Questions to some people at a moment, and what becomes of the answers.

    Attributes:
        moment: before or after the session, or in a pause for pain, where only pain is asked.
        people: the participants, in the order in which they are asked.
        limits: of pain, as the therapist set them.
        save: stores each answer as soon as it is given.
        tr: language of the session.
        theme: its agent asks.
        told: pain above the limits that the first of them has told already: they begin with the
            advice.
    """

    moment: Moment
    people: Sequence[Person]
    limits: PainLimits
    save: Save
    tr: Language
    theme: Theme
    told: int | None = None

    def after(
        self, person: Person, question: Question, answer: str
    ) -> tuple[Person, Question] | None:
        """Return the next question, and who is asked; None after the last."""
        if question == "pain" and answer not in ("0", NOT_SAID):
            return person, "place"
        if question != "fatigue" and self.moment != "pause":
            return person, "fatigue"
        if person != self.people[-1]:
            return self.people[self.people.index(person) + 1], "pain"
        return None

    def is_too_much(self, person: Person, answer: str) -> bool:
        """Return True if the pain of an answer is a reason to stop."""
        pain = int(answer) if answer.isdecimal() else None
        return stop_now(person.pain_before, pain, self.limits) is not None

    @property
    def advice(self) -> tuple[str, str, str, str]:
        """The advice not to train: its heading, what to do, how to go on all the same (or empty),
        and how to follow it.
        """
        tr, moment = self.tr, self.moment
        told = f"{tr(TELL_OF_PAIN)} {tr(_CALLS_NOBODY[moment])}"
        return tr(_ADVICE[moment]), told, tr(_GO_ON[moment]), tr(_STOP[moment])


class WellbeingInterview:
    """Asks the questions one at a time, with a way back: from the first, to what was there before.
    Pain above the limits leads to the advice not to train. Enter follows it; to go on takes another
    key, and is stored.

    Args:
        questions: what is asked, and of whom.

    Attributes:
        entry: what is chosen so far.
        is_advising: True while the advice stands in place of a question.
        result: None until the interview is over; then True to go on, False not to begin the
            session, or to end it in a pause.
        is_left: True if it was left from the first question, so that nothing begins or ends.
    """

    title = ""

    def __init__(self, questions: Questions) -> None:
        self._questions = questions
        self._asked: list[tuple[Person, Question]] = [(questions.people[0], "pain")]
        self._answers: dict[tuple[str, Question], str] = {}
        self.entry = Entry()
        self.is_advising = False
        self.result: bool | None = None
        self.is_left = False
        if questions.told is not None:
            self._answers[questions.people[0].seat, "pain"] = str(questions.told)
            if self._in_pain:
                self._finish()

    @property
    def tr(self) -> Language:
        """Texts in the language of the session."""
        return self._questions.tr

    @property
    def theme(self) -> Theme:
        """The theme whose agent asks."""
        return self._questions.theme

    @property
    def help_text(self) -> str:
        """The keys that answer."""
        how = how_to_answer(QUESTIONS["pain"], Entry(), self.tr)
        return f"{how}\n{self.tr('Backspace goes back to the question before.')}\n"

    @property
    def place(self) -> tuple[object, ...]:
        """Tells one question from the next."""
        return (*self._asked[-1], self.is_advising)

    @property
    def step(self) -> Step | None:
        """The question, in the language of the session; None while the advice stands there."""
        return None if self.is_advising else translated(self._question, self.tr)

    @property
    def _question(self) -> Step:
        return QUESTIONS[self._asked[-1][1]]

    @property
    def can_go_back(self) -> bool:
        """True if there is a question before."""
        return self.is_advising or len(self._asked) > 1

    @property
    def can_leave(self) -> bool:
        """True if Escape leads back. A session that is over cannot be gone back to."""
        return self.can_go_back or self._questions.moment != "after"

    @property
    def is_over(self) -> bool:
        """True once it is known what becomes of the session, or if the questions were left."""
        return self.is_left or self.result is not None

    def page(self, marked: Entry | None = None) -> Page:
        """Return the texts of the question with what is chosen, or with ``marked`` in its place."""
        if (step := self.step) is None:
            return self._advice
        page = question_page(step, marked or self.entry, self.said_before, self.tr)
        return page._replace(who=self._asked[-1][0].name)

    @property
    def _advice(self) -> Page:
        """The advice, kindly: to rest, whom to tell, and that nobody else does it."""
        heading, told, go_on, stop = self._questions.advice
        who = ", ".join(person.name for person in self._in_pain)
        back = self.tr("Backspace goes back to the question before.")
        return Page(heading, (told,), stop, decline=go_on, given=back, who=who)

    @property
    def choices(self) -> tuple[Choice, ...]:
        """Choices of a switch about the advice: to go on in spite of it takes a second one."""
        words = _SWITCH_ADVICE[self._questions.moment]
        stop, go_on = (self.tr(each) if each else "" for each in words)
        asked = self.tr("You chose: {answer}. Is that right?", answer=go_on)
        spite = (Choice(go_on, (GO_ON_KEY,), asked),) if go_on else ()
        return (Choice(stop, ("enter",)), *spite)

    @property
    def said_before(self) -> str:
        """The answer to the question before; empty without one."""
        if len(self._asked) == 1:
            return ""
        before, question = self._asked[-2]
        return self.tr(self._answers.get((before.seat, question), NOT_SAID))

    # --- keys

    def only_chooses(self, key: str) -> bool:
        """Return True if a key chooses an answer, which Enter gives."""
        return key in _CHOICE_KEYS and not self.is_advising

    def press(self, key: str, character: str | None) -> None:
        """Handle a key."""
        match key:
            case "backspace":
                self._go_back()
            case "escape" if self.can_go_back:
                self._go_back()
            case "escape":
                self._leave()
            case _ if self.is_advising:
                self._answer_advice(key, (character or key).lower())
            case _:
                self._choose(key)

    def _choose(self, key: str) -> None:
        person, question = self._asked[-1]
        pressed = press(self._question, self.entry, key)
        if isinstance(pressed, Entry):
            self.entry = pressed
            return
        answer = NOT_SAID if pressed.answer is None else str(pressed.answer)
        self._answers[person.seat, question] = answer
        self._questions.save(person, question, answer)
        if following := self._questions.after(person, question, answer):
            self._asked.append(following)
            self.entry = Entry()
        else:
            self._finish()

    def _finish(self) -> None:
        """Go on after the questions; with too much pain, advise not to."""
        if self._in_pain:
            self.is_advising = True
            self._save_advice("shown")
        else:
            self.result = True

    @property
    def _in_pain(self) -> list[Person]:
        """The participants whose pain is a reason to stop."""
        return [
            person
            for person in self._questions.people
            if self._questions.is_too_much(person, self._answers.get((person.seat, "pain"), ""))
        ]

    def _answer_advice(self, key: str, letter: str) -> None:
        if key == "enter":
            self._close_advice(goes_on=False)
        elif letter == GO_ON_KEY and self._questions.moment != "after":
            self._close_advice(goes_on=True)

    def _close_advice(self, *, goes_on: bool) -> None:
        is_after = self._questions.moment == "after"
        if not is_after:
            self._save_advice("went on" if goes_on else "stopped")
        self.result = goes_on or is_after

    def _save_advice(self, came_of_it: Advice) -> None:
        for person in self._in_pain:
            self._questions.save(person, "advice", came_of_it)

    def _go_back(self) -> None:
        """Ask the question before again, with what was said chosen."""
        if self.is_advising:
            self.is_advising = False
        elif len(self._asked) > 1:
            self._asked.pop()
        person, question = self._asked[-1]
        said = self._answers.get((person.seat, question))
        values = [str(point.value) for point in points(self._question)]
        self.entry = Entry(chosen=(values.index(said),)) if said in values else Entry()

    def _leave(self) -> None:
        """Go back to what was there before the questions. Too much pain leads to the advice."""
        if self._in_pain:
            self._finish()
        else:
            self.is_left = self.can_leave
