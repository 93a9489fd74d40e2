"""Questions about pain and tiredness: one at a time, nothing chosen beforehand."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Literal, NamedTuple

from textual import events
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import Static

from sar_tui.app.patient_mode import keys_in_mode
from sar_tui.app.screens.switch_choices import answers
from sar_tui.app.screens.waiting_text import decline_text, how_to_answer, option_sentences
from sar_tui.model.gesture import REST
from sar_tui.model.language import Language
from sar_tui.model.spoken_text import sentences
from sar_tui.model.step import Entry, Given, Step, points, press, translated
from sar_tui.model.theme import Theme
from sar_tui.rules.scanning import Choice
from sar_tui.rules.wellbeing import PAIN_ENDS, Advice, Moment, PainLimits, stop_now
from sar_tui.store.wellbeing import NOT_SAID
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.heading import ROOMY, Heading
from sar_tui.tui.key_line import KeyLine
from sar_tui.tui.language import translated as translated_keys
from sar_tui.widgets.answer_options import options_text, with_chosen
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.robot import draw

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
_FACE = "listening"
_LARGEST = 4
"""Most rows of the question in a large window."""
_MARGINS = 12
"""Columns beside the scale, at both sides together."""


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


class WellbeingScreen(DismissedOnce[bool]):
    """Asks each participant; the result is True to go on, False not to begin the session, or to end
    it in a pause.

    Pain above the limits leads to the advice not to train. Enter follows it; to go on takes another
    key, and is stored.

    Args:
        questions: what is asked, and of whom.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("backspace", "back", "Back", id="back"),
        Binding("escape", "leave", "Skip", id="leave"),
    ]
    AUTO_FOCUS = ""

    def __init__(self, questions: Questions) -> None:
        super().__init__()
        self._questions = questions
        people, theme, told = questions.people, questions.theme, questions.told
        self.tr = questions.tr
        self._moment: Moment = questions.moment
        self._people = people
        self._save = questions.save
        self._asked: list[tuple[Person, Question]] = [(people[0], "pain")]
        self._answers: dict[tuple[str, Question], str] = {}
        self._entry = Entry()
        self._said: list[str] = []
        self._marked: Entry | None = None
        face = theme.faces[_FACE] if _FACE in theme.faces else theme.faces["neutral"]
        self._agent = "\n".join(draw(face.splitlines(), REST))
        self._is_advising = False
        if told is not None:
            self._answers[people[0].seat, "pain"] = str(told)

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        """The keys of the footer and the help, in the language of the session.

        The stop key is there only if there is an output to stop, and the help key leaves its room
        to the one that says the screen again.
        """
        app: Any = self.app
        live = app.open_session
        is_silent = live is None or set(live.session.task.parameters.outputs) <= {"screen"}
        hidden = {"help"} if app.aloud.is_on else set()
        names = {"back": self.tr("Backspace")}
        return {
            key: active._replace(
                binding=replace(active.binding, key_display=names.get(active.binding.id or ""))
            )
            for key, active in keys_in_mode(
                self.app, translated_keys(super().active_bindings, self.tr)
            ).items()
            if not (is_silent and active.binding.id == "stop")
            and active.binding.id not in hidden
            # Escape does as Enter there, and skips nothing
            and not (self._is_advising and active.binding.id == "leave")
        }

    @property
    def help_text(self) -> str:
        """Keys of the questions."""
        how = how_to_answer(QUESTIONS["pain"], Entry(), self.tr)
        return f"{how}\n{self.tr('Backspace goes back to the question before.')}\n"

    def compose(self) -> ComposeResult:
        with Vertical(id="questions"):
            yield Static(self._agent, id="asking", markup=False)
            yield Static("", id="who", classes="small", markup=False)
            yield Heading(id="question", largest=_LARGEST)
            yield Static("", id="options", markup=False)
            yield Static("", id="decline", classes="body", markup=False)
            yield Static("", id="given", classes="small", markup=False)
        yield KeyLine(grows=True)
        yield KeyFooter()

    def on_mount(self) -> None:
        if self._in_pain:
            self._finish()
        else:
            self._show()

    def on_resize(self) -> None:
        self._show()

    # --- a switch

    @property
    def switch_choices(self) -> tuple[Choice, ...]:
        """Everything that can be done with a switch: to go on in spite of the advice takes a second
        choice.
        """
        tr = self.tr
        back = Choice(tr("Back"), ("backspace",))
        if not self._is_advising:
            step = translated(QUESTIONS[self._asked[-1][1]], tr)
            can_go_back = len(self._asked) > 1
            return (*answers(step, self._entry, tr), *((back,) * can_go_back))
        stop, go_on = (tr(words) if words else "" for words in _SWITCH_ADVICE[self._moment])
        asked = tr("You chose: {answer}. Is that right?", answer=go_on)
        spite = (Choice(go_on, (GO_ON_KEY,), asked),) if go_on else ()
        return (Choice(stop, ("enter",)), *spite, back)

    def mark(self, _: int, choice: Choice) -> None:
        """Draw an answer that is marked."""
        if choice.entry != self._marked:
            self._marked = choice.entry
            self._show()

    # --- answers

    def only_chooses(self, key: str) -> bool:
        """Return True if a key chooses an answer, which Enter gives."""
        return key in _CHOICE_KEYS and not self._is_advising

    def on_key(self, event: events.Key) -> None:
        if event.key in ("backspace", "escape", "f1", "question_mark", "ctrl+p", "ctrl+q"):
            return
        event.stop()
        event.prevent_default()
        if self._is_advising:
            if event.key == "enter":
                self._close_advice(goes_on=False)
            elif (event.character or event.key).lower() == GO_ON_KEY and self._moment != "after":
                self._close_advice(goes_on=True)
            return
        person, question = self._asked[-1]
        step = QUESTIONS[question]
        pressed = press(step, self._entry, event.key)
        if isinstance(pressed, Given):
            answer = NOT_SAID if pressed.answer is None else str(pressed.answer)
            self._answers[person.seat, question] = answer
            self._save(person, question, answer)
            self._ask_next(person, question, answer)
        else:
            self._entry = pressed
            self._show()

    def _ask(self, person: Person, question: Question) -> None:
        self._asked.append((person, question))
        self._entry = Entry()

    def _ask_next(self, person: Person, question: Question, answer: str) -> None:
        """Ask the next question, if there is one."""
        if following := self._questions.after(person, question, answer):
            self._ask(*following)
            self._show()
        else:
            self._finish()

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
        return [
            person
            for person in self._people
            if self._questions.is_too_much(person, self._answers.get((person.seat, "pain"), ""))
        ]

    def _close_advice(self, *, goes_on: bool) -> None:
        if self._moment != "after":
            self._save_advice("went on" if goes_on else "stopped")
        self.dismiss(goes_on or self._moment == "after")

    def _save_advice(self, came_of_it: Advice) -> None:
        for person in self._in_pain:
            self._save(person, "advice", came_of_it)

    def action_back(self) -> None:
        """Ask the question before again, with what was said chosen."""
        if self._is_advising:
            self._is_advising = False
        elif len(self._asked) > 1:
            self._asked.pop()
        person, question = self._asked[-1]
        said = self._answers.get((person.seat, question))
        values = [str(point.value) for point in points(QUESTIONS[question])]
        self._entry = Entry(chosen=(values.index(said),)) if said in values else Entry()
        self._show()

    def action_leave(self) -> None:
        """Leave the questions out; not the advice, which Escape follows as Enter does."""
        if self._is_advising:
            self._close_advice(goes_on=False)
        else:
            self._finish()

    # --- the screen

    def _show(self) -> None:
        if self._is_advising:
            self._show_advice()
        else:
            self._show_question(*self._asked[-1])
        self.refresh_bindings()
        self.app.look_for_choices()  # type: ignore[attr-defined]
        self.app.aloud.read(self, (*self._asked[-1], self._is_advising))  # type: ignore[attr-defined]

    @property
    def sentences(self) -> list[str]:
        """The question or the advice in sentences, and what is chosen."""
        return sentences(*self._said, self.query_one(KeyLine).text)

    def _show_question(self, person: Person, question: Question) -> None:
        step, tr = translated(QUESTIONS[question], self.tr), self.tr
        entry = self._marked or self._entry
        has_switch = self.app.switch is not None  # type: ignore[attr-defined]
        given = ""
        if len(self._asked) > 1:
            before, asked = self._asked[-2]
            said = self._answers.get((before.seat, asked), NOT_SAID)
            given = tr("You said: {answer}. Backspace goes back.", answer=tr(said))
            if has_switch:
                given = tr("You said: {answer}.", answer=tr(said))
        columns, rows = self.app.size
        self.query_one("#asking").display = step.kind == "number" or rows >= ROOMY[1]
        self.query_one("#question", Heading).show(step.text)
        options, decline = option_sentences(step, entry, tr), decline_text(step, tr)
        decline = "" if has_switch else decline
        self._said = [person.name, step.text, *options, decline, given]
        self._put("who", person.name)
        self._put("options", with_chosen(options_text(step, entry, columns - _MARGINS)))
        self._put("decline", decline)
        self._put("given", given)
        how = tr("Press Enter to go on.") if entry.chosen else how_to_answer(step, entry, tr)
        self.query_one(KeyLine).show(how, tr("Enter"))

    def _show_advice(self) -> None:
        """Show the advice, kindly: to rest, whom to tell, and that nobody else does it."""
        heading, told, go_on, stop = self._questions.advice
        self.query_one("#asking").display = True
        self.query_one("#question", Heading).show(heading)
        has_switch = self.app.switch is not None  # type: ignore[attr-defined]
        who = ", ".join(person.name for person in self._in_pain)
        back = "" if has_switch else self.tr("Backspace goes back to the question before.")
        go_on = "" if has_switch else go_on
        self._put("who", who)
        self._put("options", told.replace(". ", ".\n"))
        self._put("decline", go_on)
        self._put("given", back)
        self._said = [who, heading, told, go_on, back]
        self.query_one(KeyLine).show(stop, self.tr("Enter"))

    def _put(self, name: str, text: str | Content) -> None:
        part = self.query_one(f"#{name}", Static)
        part.update(text)
        part.display = bool(text)
