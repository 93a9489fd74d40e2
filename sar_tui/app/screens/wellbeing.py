"""Questions about pain and tiredness: one at a time, nothing chosen beforehand."""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar, Literal, NamedTuple, cast

from textual import events
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import Static

from sar_tui.app.patient_mode import keys_in_mode
from sar_tui.app.screens.switch_choices import answers
from sar_tui.app.screens.waiting_text import decline_text, how_to_answer, option_sentences
from sar_tui.model.gesture import Pose
from sar_tui.model.language import Language
from sar_tui.model.spoken_text import sentences
from sar_tui.model.step import Entry, Step, points, press, translated
from sar_tui.model.theme import Theme
from sar_tui.records.kind import NOT_SAID
from sar_tui.rules.scanning import Choice
from sar_tui.rules.wellbeing import PAIN_ENDS, Advice, Moment, PainLimits, stop_now
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.heading import ROOMY, Heading, most_rows
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
_FACE, _LISTENS = "listening", Pose(lean=1)
_MARGINS = 2
"""Columns beside the scale, at both sides together."""
_TALL = 46
"""Least rows of a window in which two blank rows are between the parts."""


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


class Asked(NamedTuple):
    """Texts of a question, or of the advice not to train.

    Attributes:
        who: name of the person, if there are several.
        text: the question, or the heading of the advice.
        said: the options, what is chosen, or what to do, in sentences.
        decline: the key that gives no answer, or goes on in spite of the advice.
        given: the answer before, and the way back.
        press: the key that leads on.
    """

    who: str
    text: str
    said: tuple[str, ...]
    decline: str
    given: str
    press: str

    @property
    def sentences(self) -> list[str]:
        """All of it, in sentences."""
        return sentences(*self[:2], *self.said, *self[3:])


class Interview:
    """Asks the questions one at a time, with a way back: from the first, to what was there before.
    Pain above the limits leads to the advice not to train. Enter follows it; to go on takes another
    key, and is stored.

    Args:
        questions: what is asked, and of whom.

    Attributes:
        entry: what is chosen so far.
        is_advising: True while the advice stands in place of a question.
        goes_on: None until the interview is over; then True to go on, False not to begin the
            session, or to end it in a pause.
        is_left: True if it was left from the first question, so that nothing begins or ends.
    """

    def __init__(self, questions: Questions) -> None:
        self._questions = questions
        self._asked: list[tuple[Person, Question]] = [(questions.people[0], "pain")]
        self._answers: dict[tuple[str, Question], str] = {}
        self.entry = Entry()
        self.is_advising = False
        self.goes_on: bool | None = None
        self.is_left = False
        if questions.told is not None:
            self._answers[questions.people[0].seat, "pain"] = str(questions.told)
            if self._in_pain:
                self._finish()

    @property
    def place(self) -> tuple[object, ...]:
        """Tells one question from the next."""
        return (*self._asked[-1], self.is_advising)

    @property
    def step(self) -> Step:
        """The question, in the language of the session."""
        return translated(QUESTIONS[self._asked[-1][1]], self._questions.tr)

    @property
    def can_go_back(self) -> bool:
        """True if there is a question before."""
        return self.is_advising or len(self._asked) > 1

    @property
    def can_leave(self) -> bool:
        """True if Escape leads back. A session that is over cannot be gone back to."""
        return self.can_go_back or self._questions.moment != "after"

    def texts(self, marked: Entry | None = None) -> Asked:
        """Return the texts of the question with what is chosen, or with ``marked`` in its place."""
        return self._advice if self.is_advising else self._question(marked or self.entry)

    def _question(self, entry: Entry) -> Asked:
        step, tr, given = self.step, self._questions.tr, ""
        if said := self.said_before:
            given = tr("You said: {answer}. Backspace goes back.", answer=said)
        press = tr("Press Enter to go on.") if entry.chosen else how_to_answer(step, entry, tr)
        options, decline = option_sentences(step, entry, tr), decline_text(step, tr)
        return Asked(self._asked[-1][0].name, step.text, options, decline, given, press)

    @property
    def _advice(self) -> Asked:
        """The advice, kindly: to rest, whom to tell, and that nobody else does it."""
        heading, told, go_on, stop = self._questions.advice
        who = ", ".join(person.name for person in self._in_pain)
        back = self._questions.tr("Backspace goes back to the question before.")
        return Asked(who, heading, (told,), go_on, back, stop)

    @property
    def said_before(self) -> str:
        """The answer to the question before; empty without one."""
        if len(self._asked) == 1:
            return ""
        before, question = self._asked[-2]
        return self._questions.tr(self._answers.get((before.seat, question), NOT_SAID))

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
        pressed = press(QUESTIONS[question], self.entry, key)
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
            self.goes_on = True

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
        self.goes_on = goes_on or is_after

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
        values = [str(point.value) for point in points(QUESTIONS[question])]
        self.entry = Entry(chosen=(values.index(said),)) if said in values else Entry()

    def _leave(self) -> None:
        """Go back to what was there before the questions. Too much pain leads to the advice."""
        if self._in_pain:
            self._finish()
        else:
            self.is_left = self.can_leave


class WellbeingScreen(DismissedOnce[bool]):
    """Shows an interview; the result is True to go on, False not to begin the session, or to end
    it in a pause; None if it was left.

    Args:
        questions: what is asked, and of whom.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("backspace", "press('backspace')", "Back", show=False, id="back"),
        Binding("escape", "press('escape')", "Back", id="leave"),
    ]
    AUTO_FOCUS = ""

    def __init__(self, questions: Questions) -> None:
        super().__init__()
        self.tr, theme = questions.tr, questions.theme
        self._moment: Moment = questions.moment
        self._interview = Interview(questions)
        self._said: list[str] = []
        self._marked: Entry | None = None
        face = theme.faces[_FACE] if _FACE in theme.faces else theme.faces["neutral"]
        self._agent = "\n".join(draw(face.splitlines(), _LISTENS)).strip("\n")
        self.only_chooses = self._interview.only_chooses

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
        return {
            key: active
            for key, active in keys_in_mode(
                self.app, translated_keys(super().active_bindings, self.tr)
            ).items()
            if not (is_silent and active.binding.id == "stop")
            and active.binding.id not in hidden
            and (active.binding.id != "leave" or self._interview.can_leave)
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
            yield Heading(id="question")
            yield Static("", id="options", markup=False)
            yield Static("", id="keys", classes="body", markup=False)
            yield Static("", id="decline", classes="body", markup=False)
            yield Static("", id="given", classes="small", markup=False)
        yield KeyLine(grows=True)
        yield KeyFooter(for_participant=True)

    def on_mount(self) -> None:
        self._show()

    def on_resize(self) -> None:
        self._show()

    # --- a switch

    @property
    def switch_choices(self) -> tuple[Choice, ...]:
        """Everything that can be done with a switch: to go on in spite of the advice takes a second
        choice.
        """
        tr, interview = self.tr, self._interview
        back = Choice(tr("Back"), ("backspace",))
        if not interview.is_advising:
            found = answers(interview.step, interview.entry, tr)
            return (*found, *((back,) * interview.can_go_back))
        stop, go_on = (tr(words) if words else "" for words in _SWITCH_ADVICE[self._moment])
        asked = tr("You chose: {answer}. Is that right?", answer=go_on)
        spite = (Choice(go_on, (GO_ON_KEY,), asked),) if go_on else ()
        return (Choice(stop, ("enter",)), *spite, back)

    def mark(self, _: int, choice: Choice) -> None:
        """Draw an answer that is marked."""
        if choice.entry != self._marked:
            self._marked = choice.entry
            self._show()

    # --- keys

    def on_key(self, event: events.Key) -> None:
        if event.key in ("backspace", "escape", "f1", "question_mark", "ctrl+p", "ctrl+q"):
            return
        event.stop()
        event.prevent_default()
        self._press(event.key, event.character)

    def action_press(self, key: str) -> None:
        """Go back, or leave the questions."""
        self._press(key, None)

    def _press(self, key: str, character: str | None) -> None:
        interview = self._interview
        interview.press(key, character)
        if interview.goes_on is None and not interview.is_left:
            self._show()
        else:
            self.dismiss(interview.goes_on)

    # --- the screen

    @property
    def sentences(self) -> list[str]:
        """The question or the advice in sentences, and what is chosen."""
        return [*self._said, *sentences(self.query_one(KeyLine).text)]

    def _show(self) -> None:
        interview, app = self._interview, cast(Any, self.app)
        asked = interview.texts(self._marked)
        if app.switch is not None:  # the keys of these are none of the switch's
            said = interview.said_before
            given = self.tr("You said: {answer}.", answer=said) if said else ""
            asked = asked._replace(decline="", given="" if interview.is_advising else given)
        self._said = asked._replace(press="").sentences
        columns, rows = app.size
        self.set_class(rows >= _TALL, "tall")
        if interview.is_advising:
            options: str | Content = " ".join(asked.said).replace(". ", ".\n")
        else:
            entry, room = self._marked or interview.entry, columns - _MARGINS
            options = with_chosen(options_text(interview.step, entry, room))
        is_scale = interview.step.kind == "number" and not interview.is_advising
        keys = self.tr("Press ← → or type a number.") if is_scale and app.switch is None else ""
        has_room = rows >= ROOMY[1] or interview.is_advising
        self.query_one("#asking").display = has_room or interview.step.kind == "number"
        self.query_one("#question", Heading).show(asked.text, most_rows(app.size))
        self._put("who", asked.who)
        self._put("options", options)
        self._put("keys", _with_key(keys, "← →"))
        self._put("decline", _with_key(asked.decline, "Tab"))
        self._put("given", asked.given)
        self.query_one(KeyLine).show(asked.press, self.tr("Enter"))
        self.refresh_bindings()
        app.look_for_choices()
        app.aloud.read(self, interview.place)

    def _put(self, name: str, text: str | Content) -> None:
        part = self.query_one(f"#{name}", Static)
        part.update(text)
        part.display = bool(text)


def _with_key(text: str, key: str) -> Content:
    """Return a text in which the name of a key looks as in the footer."""
    before, found, after = text.partition(key)
    return Content.assemble(before, (found, "bold $accent"), after)
