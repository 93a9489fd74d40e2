"""Questions about pain and tiredness: one at a time, one key each, nothing chosen beforehand."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import ClassVar, NamedTuple

from textual import events
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import Vertical
from textual.widgets import Static

from sar_tui.app.patient_keys import keys_in_mode
from sar_tui.framework.language import Language
from sar_tui.framework.policies.wellbeing import HIGHEST, Moment, StopReason, stop_now
from sar_tui.store.wellbeing import NOT_SAID, Question
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.language import translated
from sar_tui.widgets.key_footer import KeyFooter

_TEN_KEYS = ("t", "d", "x")
"""Keys for 10: of ten, of Spanish diez, and the Roman number. The screen names that of its language."""
_NOT_SAID_KEY = "n"
_REPEAT_SECONDS = 0.6
"""A key that is held must not answer the next question, too."""

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
    "pain": ("no pain", "worst pain"),
    "fatigue": ("not tired", "exhausted"),
}
"""The two ends of a scale."""
_STEP = 5
"""Columns from one number of the scale to the next."""


class Person(NamedTuple):
    """A participant who is asked. ``name``: shown above the questions if there are two. ``pain_before``: for a rule."""

    seat: str
    code: str
    name: str = ""
    pain_before: int | None = None


Save = Callable[[Person, Question, str], None]
"""Stores an answer."""


class WellbeingScreen(DismissedOnce[bool]):
    """Asks each participant; the result is True to go on, False not to begin the session.

    Args:
        moment: before or after the session, or in a pause for pain, where only pain is asked.
        people: the participants, in the order in which they are asked.
        save: stores each answer as soon as it is given.
        tr: language of the session.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("backspace", "back", "Back", id="back"),
        Binding("escape", "leave", "Skip", id="leave"),
    ]
    AUTO_FOCUS = ""

    def __init__(self, moment: Moment, people: Sequence[Person], save: Save, tr: Language) -> None:
        super().__init__()
        self.tr = tr
        self._moment: Moment = moment
        self._people = people
        self._save = save
        self._asked: list[tuple[Person, Question]] = [(people[0], "pain")]
        self._answers: dict[tuple[str, Question], str] = {}
        self._last_key = ("", 0.0)
        self._is_advising = False

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        """The keys of the footer and the help, in the language of the session.

        The stop key is there only if there is an output to stop.
        """
        live = self.app.live  # type: ignore[attr-defined]
        is_silent = live is None or set(live.run.session.task.parameters.outputs) <= {"screen"}
        names = {"back": self.tr("Backspace")}
        return {
            key: active._replace(binding=replace(active.binding, key_display=names.get(active.binding.id or "")))
            for key, active in keys_in_mode(self.app, translated(super().active_bindings, self.tr)).items()
            if not (is_silent and active.binding.id == "stop")
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
        self._show()

    # --- answers ------------------------------------------------------------------------------------------

    def on_key(self, event: events.Key) -> None:
        (last, before), self._last_key = self._last_key, (event.key, event.time)
        is_repeat = event.key == last and event.time - before < _REPEAT_SECONDS
        if event.key in ("backspace", "escape", "f1", "question_mark", "ctrl+p", "ctrl+q"):
            return
        event.stop()
        if is_repeat:
            return
        if self._is_advising:
            if event.key == "enter":
                self.dismiss(True)
            return
        person, question = self._asked[-1]
        answer = self._answer(question, (event.character or event.key).lower())
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
        """Ask the next question; after the last one go on, or advise to stop."""
        if question == "pain" and answer not in ("0", NOT_SAID):
            self._asked.append((person, "place"))
        elif question != "fatigue" and self._moment != "pause":
            self._asked.append((person, "fatigue"))
        elif person != self._people[-1]:
            self._asked.append((self._people[self._people.index(person) + 1], "pain"))
        elif any(self._stop_reason(each) for each in self._people):
            self._is_advising = True
        else:
            self.dismiss(True)
            return
        self._show()

    def _stop_reason(self, person: Person) -> StopReason | None:
        said = self._answers.get((person.seat, "pain"), "")
        return stop_now(person.pain_before, int(said) if said.isdecimal() else None)

    def action_back(self) -> None:
        """Ask the question before again."""
        if self._is_advising:
            self._is_advising = False
        elif len(self._asked) > 1:
            self._asked.pop()
        self._show()

    def action_leave(self) -> None:
        """Leave the questions out; before a session, it does not begin if pain speaks against it."""
        self.dismiss(not (self._is_advising and self._moment == "before"))

    # --- the screen ------------------------------------------------------------------------------------------

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
            "given": self.tr("Please press one of these keys.") if hint else given,
        }

    def _advice(self) -> dict[str, str]:
        tr = self.tr
        if self._moment != "before":
            keys = tr("Press Enter to close.")
        else:
            keys = f"{tr('Press Enter to begin, if your therapist agrees.')}\n{tr('Press Escape to stop for today.')}"
        return {
            "who": "",
            "question": tr("Please stop and rest"),
            "scale": tr("Tell your therapist about the pain now."),
            "keys": keys,
            "given": "",
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
