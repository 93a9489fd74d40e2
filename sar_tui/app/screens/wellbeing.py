"""Questions about pain and tiredness: one at a time, one key each, nothing chosen beforehand."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import ClassVar, Literal, NamedTuple

from textual import events
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import Vertical
from textual.widgets import Static

from sar_tui.app.patient_mode import keys_in_mode
from sar_tui.model.language import Language
from sar_tui.rules.wellbeing import HIGHEST, PAIN_ENDS, Advice, Moment, PainLimits, stop_now
from sar_tui.store.wellbeing import NOT_SAID
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.language import translated
from sar_tui.widgets.key_footer import KeyFooter

Question = Literal["pain", "place", "fatigue", "advice"]
"""A question, or the ``advice`` not to train."""
_TEN_KEYS = ("t", "d", "x")
"""Keys for 10: of ten, of Spanish diez, and the Roman number. The screen names that of its
language.
"""
_NOT_SAID_KEY = "n"
_GO_ON_KEY = "g"
"""Goes on in spite of the advice not to. It answers no question, so that nobody presses it by
habit.
"""

PLACES = {
    "1": "left hand",
    "2": "right hand",
    "3": "left arm",
    "4": "right arm",
    "5": "left shoulder",
    "6": "right shoulder",
    "7": "neck or back",
    "8": "head",
    "9": "somewhere else",
}
"""Places where it may hurt, by their keys; stored as they are here, in English."""
_QUESTIONS: dict[Question, str] = {
    "pain": "How much pain do you have now?",
    "place": "Where does it hurt?",
    "fatigue": "How tired are you now?",
}
ENDS: dict[Question, tuple[str, str]] = {
    "pain": PAIN_ENDS,
    "fatigue": ("not tired", "exhausted"),
}
"""The two ends of a scale."""
_STEP = 5
"""Columns from one number of the scale to the next."""


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


class WellbeingScreen(DismissedOnce[bool]):
    """Asks each participant; the result is True to go on, False not to begin the session, or to end
    it in a pause.

    Pain above the limits leads to the advice not to train. Enter follows it; to go on takes another
    key, and is stored.

    Args:
        moment: before or after the session, or in a pause for pain, where only pain is asked.
        people: the participants, in the order in which they are asked.
        limits: of pain, as the therapist set them.
        save: stores each answer as soon as it is given.
        tr: language of the session.
        told: pain above the limits that the first of them has told already: the screen begins with
            the advice.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("backspace", "back", "Back", id="back"),
        Binding("escape", "leave", "Skip", id="leave"),
    ]
    AUTO_FOCUS = ""

    def __init__(
        self,
        moment: Moment,
        people: Sequence[Person],
        limits: PainLimits,
        save: Save,
        tr: Language,
        told: int | None = None,
    ) -> None:
        super().__init__()
        self.tr = tr
        self._moment: Moment = moment
        self._people = people
        self._limits = limits
        self._save = save
        self._asked: list[tuple[Person, Question]] = [(people[0], "pain")]
        self._answers: dict[tuple[str, Question], str] = {}
        self._is_advising = False
        if told is not None:
            self._answers[people[0].seat, "pain"] = str(told)

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        """The keys of the footer and the help, in the language of the session.

        The stop key is there only if there is an output to stop.
        """
        live = self.app.live  # type: ignore[attr-defined]
        is_silent = live is None or set(live.session.task.parameters.outputs) <= {"screen"}
        names = {"back": self.tr("Backspace")}
        return {
            key: active._replace(
                binding=replace(active.binding, key_display=names.get(active.binding.id or ""))
            )
            for key, active in keys_in_mode(
                self.app, translated(super().active_bindings, self.tr)
            ).items()
            if not (is_silent and active.binding.id == "stop")
            # Escape does as Enter there, and skips nothing
            and not (self._is_advising and active.binding.id == "leave")
        }

    @property
    def help_text(self) -> str:
        """Keys of the questions."""
        return f"{self._keys('pain')}\n{self.tr('Backspace goes back to the question before.')}\n"

    def compose(self) -> ComposeResult:
        with Vertical(id="questions"):
            for name in ("who", "question", "scale", "keys", "given"):
                yield Static("", id=name, markup=False)
        yield KeyFooter()

    def on_mount(self) -> None:
        if self._in_pain:
            self._finish()
        else:
            self._show()

    # --- answers

    def completes_answer(self, key: str) -> bool:
        """Return True if a key makes 10 of the 1 before it: so the worst pain is often typed, and
        would be taken for 1.

        No place has the key 0, and the key may follow the 1 sooner than the screen can be read.
        """
        person, question = self._asked[-1]
        is_one = self._answers.get((person.seat, "pain")) == "1"
        return key == "0" and question == "place" and is_one and not self._is_advising

    def on_key(self, event: events.Key) -> None:
        if event.key in ("backspace", "escape", "f1", "question_mark", "ctrl+p", "ctrl+q"):
            return
        event.stop()
        if self._is_advising:
            if event.key == "enter":
                self._close_advice(goes_on=False)
            elif (event.character or event.key).lower() == _GO_ON_KEY and self._moment != "after":
                self._close_advice(goes_on=True)
            return
        key = (event.character or event.key).lower()
        if self.completes_answer(key):
            self._asked.pop()
            key = _TEN_KEYS[0]
        person, question = self._asked[-1]
        answer = self._answer(question, key)
        if answer is None:
            self._show(hint=True)
            return
        self._answers[person.seat, question] = answer
        self._save(person, question, answer)
        self._ask_next(person, question, answer)

    def _answer(self, question: Question, key: str) -> str | None:
        """Return the answer that a key gives; None if it gives none."""
        if key == _NOT_SAID_KEY:
            return NOT_SAID
        if question == "place":
            return PLACES.get(key)
        if key in _TEN_KEYS:
            return str(HIGHEST)
        return key if len(key) == 1 and key.isascii() and key.isdigit() else None

    def _ask_next(self, person: Person, question: Question, answer: str) -> None:
        """Ask the next question, if there is one."""
        if question == "pain" and answer not in ("0", NOT_SAID):
            self._asked.append((person, "place"))
        elif question != "fatigue" and self._moment != "pause":
            self._asked.append((person, "fatigue"))
        elif person != self._people[-1]:
            self._asked.append((self._people[self._people.index(person) + 1], "pain"))
        else:
            self._finish()
            return
        self._show()

    def _finish(self) -> None:
        """Go on after the questions; with too much pain, advise not to."""
        if not self._in_pain:
            self.dismiss(True)
            return
        self._is_advising = True
        self._save_advice("shown")
        self._show()

    @property
    def _in_pain(self) -> list[Person]:
        """The participants whose pain is a reason to stop."""

        def is_too_much(person: Person) -> bool:
            said = self._answers.get((person.seat, "pain"), "")
            pain = int(said) if said.isdecimal() else None
            return stop_now(person.pain_before, pain, self._limits) is not None

        return [person for person in self._people if is_too_much(person)]

    def _close_advice(self, *, goes_on: bool) -> None:
        if self._moment != "after":
            self._save_advice("went on" if goes_on else "stopped")
        self.dismiss(goes_on or self._moment == "after")

    def _save_advice(self, came_of_it: Advice) -> None:
        for person in self._in_pain:
            self._save(person, "advice", came_of_it)

    def action_back(self) -> None:
        """Ask the question before again."""
        if self._is_advising:
            self._is_advising = False
        elif len(self._asked) > 1:
            self._asked.pop()
        self._show()

    def action_leave(self) -> None:
        """Leave the questions out; not the advice, which Escape follows as Enter does."""
        if self._is_advising:
            self._close_advice(goes_on=False)
        else:
            self._finish()

    # --- the screen

    def _show(self, *, hint: bool = False) -> None:
        person, question = self._asked[-1]
        texts = self._advice() if self._is_advising else self._texts(person, question, hint=hint)
        for name, text in texts.items():
            self.query_one(f"#{name}", Static).update(text)
        self.refresh_bindings()

    def _texts(self, person: Person, question: Question, *, hint: bool) -> dict[str, str]:
        given = ""
        if len(self._asked) > 1:
            before, asked = self._asked[-2]
            said = self._answers.get((before.seat, asked), NOT_SAID)
            given = self.tr("You said: {answer}. Backspace goes back.", answer=self.tr(said))
        return {
            "who": person.name,
            "question": self.tr(_QUESTIONS[question]),
            "scale": self._places() if question == "place" else self._scale(question),
            "keys": self._keys(question),
            "given": self.tr("Nothing is chosen yet. Please press one of these keys.")
            if hint
            else given,
        }

    def _advice(self) -> dict[str, str]:
        """Return the advice, kindly: to rest, whom to tell, and that nobody else does it."""
        tr, moment = self.tr, self._moment
        return {
            "who": ", ".join(person.name for person in self._in_pain),
            "question": tr(_ADVICE[moment]),
            "scale": f"{tr(TELL_OF_PAIN)}\n{tr(_CALLS_NOBODY[moment])}",
            "keys": f"{tr(_STOP[moment])}\n{tr(_GO_ON[moment])}".rstrip(),
            "given": tr("Backspace goes back to the question before."),
        }

    def _scale(self, question: Question) -> str:
        """Return the numbers, with the names of both ends below them."""
        low, high = (self.tr(end) for end in ENDS[question])
        numbers = "".join(str(number).ljust(_STEP) for number in range(HIGHEST + 1)).rstrip()
        return f"{numbers}\n{low}{high.rjust(len(numbers) - len(low))}"

    def _places(self) -> str:
        places = [f"{key}  {self.tr(place)}" for key, place in PLACES.items()]
        width = max(map(len, places))
        return "\n".join(place.ljust(width) for place in places)

    def _keys(self, question: Question) -> str:
        tr = self.tr
        number = tr("Press a number from 0 to 9. For 10, press T.")
        if question == "place":
            number = tr("Press a number from 1 to 9.")
        return f"{number}\n{tr('Press N if you would rather not say.')}"
