"""The screen of an interview: one question at a time, and nothing chosen beforehand."""

from typing import Any, ClassVar, TypeVar, cast

from textual import events
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.geometry import Region
from textual.widgets import Static

from sar_tui.app.interview import Interview
from sar_tui.app.patient_mode import keys_in_mode
from sar_tui.app.screens.switch_choices import answers
from sar_tui.model.gesture import Pose
from sar_tui.model.spoken_text import sentences
from sar_tui.model.step import Entry
from sar_tui.model.theme import Theme
from sar_tui.rules.scanning import Choice
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.heading import ROOMY, Heading, in_blocks, is_roomy, most_rows
from sar_tui.tui.key_line import KeyLine
from sar_tui.tui.language import translated as translated_keys
from sar_tui.widgets.answer_options import options_text, rows_of_chosen, with_chosen
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.robot import draw

Result = TypeVar("Result")

_FACE, _LISTENS = "listening", Pose(lean=1)
_MARGINS, _MARGINS_OF_FORM = 2, 12
"""Columns beside the options, at both sides together."""
_LEAST_OF_FORM = 68
"""Least columns of a window in which a form has its margins."""
_CAN_WAIT = ("given", "instruction")
"""Parts that leave their room to a question that would not fit, in this order."""
_TALL = 46
"""Least rows of a window in which two blank rows are between the parts, unless it is a form."""
_WIDEST = 72
"""Most columns of the words of a letter."""
_BESIDE_LETTER = 14
"""Rows of all else beside the words of a letter."""
_PASSED_ON = frozenset(("backspace", "escape", "f1", "question_mark", "ctrl+p", "ctrl+q"))
"""Keys that are bound, here or in the app."""


class QuestionScreen(DismissedOnce[Result]):
    """Shows an interview. The result is that of the interview.

    Args:
        interview: what is asked.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("backspace", "press('backspace')", "Back", show=False, id="back"),
        Binding("escape", "press('escape')", "Back", id="leave"),
    ]
    AUTO_FOCUS = ""

    def __init__(self, interview: Interview[Result]) -> None:
        super().__init__(classes="-form" if interview.title else None)
        self._interview, self.tr = interview, interview.tr
        self._page = interview.page()
        self._marked: Entry | None = None
        self._read: object = None
        self.only_chooses = interview.only_chooses

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        """The keys of the footer and the help, in the language of the participant.

        The stop key is there only if there is an output to stop, and the help key leaves its room
        to the one that says the screen again.
        """
        app = cast(Any, self.app)
        live = app.open_session
        hidden = {"help"} if app.aloud.is_on else set()
        if live is None or set(live.session.task.parameters.outputs) <= {"screen"}:
            hidden.add("stop")
        if not self._interview.can_leave:
            hidden.add("leave")
        bindings = keys_in_mode(app, translated_keys(super().active_bindings, self.tr))
        return {key: each for key, each in bindings.items() if each.binding.id not in hidden}

    @property
    def help_text(self) -> str:
        """Keys of the questions."""
        return self._interview.help_text

    def compose(self) -> ComposeResult:
        interview = self._interview
        if interview.title:
            with Horizontal(classes="top-bar"):
                yield Static(interview.title, id="title", markup=False)
                yield Static("", id="where", markup=False)
        with Vertical(id="questions"):
            if interview.theme:
                yield Static(_listening(interview.theme), id="asking", markup=False)
            yield Static("", id="who", classes="small", markup=False)
            yield Static("", id="instruction", classes="body", markup=False)
            yield Heading(id="question")
            yield Static("", id="hint", classes="body", markup=False)
            yield Static("", id="options", markup=False)
            yield Static("", id="decline", classes="body", markup=False)
            yield Static("", id="problem", classes="body", markup=False)
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
        """Everything that can be done with a switch."""
        interview = self._interview
        back = (Choice(self.tr("Back"), ("backspace",)),) * interview.can_go_back
        if interview.step is None:
            return (*interview.choices, *back)
        return (*answers(interview.step, interview.entry, self.tr), *back)

    def mark(self, _: int, choice: Choice) -> None:
        """Draw an answer that is marked."""
        if choice.entry != self._marked:
            self._marked = choice.entry
            self._show()

    # --- keys

    def on_key(self, event: events.Key) -> None:
        step = self._interview.step
        is_typed = event.is_printable and step is not None and step.kind == "text"
        if event.key in _PASSED_ON and not is_typed:
            return
        if event.key in ("pageup", "pagedown"):
            body = self.query_one("#questions")
            page = body.size.height if event.key == "pagedown" else -body.size.height
            body.scroll_relative(y=page, animate=False)
        event.stop()
        event.prevent_default()
        self._press(event.key, event.character)

    def action_press(self, key: str) -> None:
        """Go back, or leave the questions."""
        self._press(key, None)

    def _press(self, key: str, character: str | None) -> None:
        interview, self._marked = self._interview, None
        interview.press(key, character)
        if interview.is_over:
            self.dismiss(interview.result)
        else:
            self._show()

    # --- the screen

    @property
    def sentences(self) -> list[str]:
        """The question or the words in sentences, and what is chosen."""
        return [*self._page._replace(press="").sentences, *sentences(self.query_one(KeyLine).text)]

    def _show(self) -> None:
        interview, app, tr = self._interview, cast(Any, self.app), self.tr
        page, step = interview.page(self._marked), interview.step
        rows = app.size.height
        if app.switch is not None:  # the keys of these are none of the switch's
            said = interview.said_before if step else ""
            given = tr("You said: {answer}.", answer=said) if said else ""
            page = page._replace(decline="", given=given)
        self._page = page
        if interview.theme:
            has_room = rows >= ROOMY[1] or step is None or step.kind == "number"
            self.query_one("#asking").display = has_room
            self.set_class(rows >= _TALL, "tall")
        if interview.title:
            self._put("where", page.where)
        self._put("who", page.who)
        self._put("instruction", page.instruction)
        self.query_one("#question", Heading).show(page.text, self._largest)
        self._put("hint", page.hint)
        if step is None:
            self._put("options", " ".join(page.said).replace(". ", ".\n"))
        else:
            drawn = options_text(step, self._marked or interview.entry, self._columns)
            self._put("options", drawn if step.kind == "text" else with_chosen(drawn))
        self._put("decline", _with_key(page.decline, "Tab"))
        self._put("problem", page.problem)
        self._put("given", page.given)
        self.query_one(KeyLine).show(page.press, tr("Enter"))
        self._make_room()
        self.refresh_bindings()
        app.look_for_choices()
        app.aloud.read(self, interview.place)

    @property
    def _largest(self) -> int:
        """The most rows of the question."""
        return most_rows(self.app.size)

    @property
    def _columns(self) -> int:
        """The columns that a part has."""
        columns = self.app.size.width
        is_wide = bool(self._interview.title) and columns >= _LEAST_OF_FORM
        return columns - (_MARGINS_OF_FORM if is_wide else _MARGINS)

    def _make_room(self) -> None:
        """Leave out the blank rows, and then what can wait, if the question would not fit. What is
        still too long is scrolled.
        """
        size, body = self.app.size, self.query_one("#questions")
        line = self.query_one(KeyLine).get_content_height(size, size, size.width)
        room = size.height - len(self.query(".top-bar")) - line - len(self.query(KeyFooter))

        def rows(blank: int = 0) -> int:
            return sum(
                part.get_content_height(size, size, self._columns) + blank
                for part in body.children
                if part.display
            )

        body.set_class(size.width < _LEAST_OF_FORM, "narrow")
        body.set_class(rows(blank=2 if self.has_class("tall") else 1) > room, "dense")
        for name in _CAN_WAIT:
            if rows() > room:
                self.query_one(f"#{name}").display = False
        if self._interview.place != self._read:
            self._read = self._interview.place
            body.scroll_home(animate=False)
        else:
            self.call_after_refresh(self._reveal_chosen)

    def _reveal_chosen(self) -> None:
        """Scroll to what is chosen, or marked, or to why it cannot be taken."""
        if not self.is_current:  # it was closed meanwhile
            return
        body, problem = self.query_one("#questions"), self.query_one("#problem")
        options = self.query_one("#options", Static)
        if problem.display:
            body.scroll_to_widget(problem, animate=False)
        elif rows := rows_of_chosen(str(options.content)):
            region = options.virtual_region
            chosen = Region(region.x, region.y + rows.start, region.width, len(rows))
            body.scroll_to_region(chosen, animate=False, force=True)

    def _put(self, name: str, text: str | Content) -> None:
        part = self.query_one(f"#{name}", Static)
        part.update(text)
        part.display = bool(text)


class LetterScreen(QuestionScreen[bool]):
    """Shows words that were written to the participant, as large as the window allows."""

    def _show(self) -> None:
        text, size = self._interview.page().text, self.app.size
        drawn = in_blocks(text, self._columns, self._largest) if is_roomy(*size) else []
        beside = 0 if drawn else max(0, (self._columns - _WIDEST) // 2)
        self.query_one("#question").styles.padding = (0, beside)
        super()._show()

    @property
    def _largest(self) -> int:
        return max(most_rows(self.app.size), self.app.size.height - _BESIDE_LETTER)


def _listening(theme: Theme) -> str:
    """Return the agent of a theme, which listens."""
    face = theme.faces[_FACE] if _FACE in theme.faces else theme.faces["neutral"]
    return "\n".join(draw(face.splitlines(), _LISTENS)).strip("\n")


def _with_key(text: str, key: str) -> Content:
    """Return a text in which the name of a key looks as in the footer."""
    before, found, after = text.partition(key)
    return Content.assemble(before, (found, "bold $accent"), after)
