"""The screen of a form: one item at a time, and nothing chosen beforehand."""

from typing import Any, ClassVar, cast

from textual import events
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.widgets import Static

from sar_tui.app.forms import Filling, Page
from sar_tui.app.patient_mode import keys_in_mode
from sar_tui.app.screens.switch_choices import answers
from sar_tui.app.screens.waiting_text import how_to_answer
from sar_tui.model.language import Language
from sar_tui.model.spoken_text import sentences
from sar_tui.model.step import Entry
from sar_tui.records.kind import Kind
from sar_tui.rules.scanning import Choice
from sar_tui.store.forms import FormAnswers, Occasion
from sar_tui.store.records import Record
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.heading import Heading, most_rows
from sar_tui.tui.key_line import KeyLine
from sar_tui.tui.language import translated as translated_keys
from sar_tui.widgets.answer_options import options_text, with_chosen
from sar_tui.widgets.key_footer import KeyFooter

_MARGINS = 12
"""Columns beside the scale, at both sides together."""
_PASSED_ON = frozenset(("backspace", "escape", "f1", "question_mark", "ctrl+p", "ctrl+q"))
"""Keys that are bound, here or in the app."""


class FormScreen(DismissedOnce[Record | None]):
    """Has a participant fill in a form. Each answer is stored at once, so that a form that was left
    goes on at the item where it was.

    The result is the record, with its scores; None if the form was left before it was complete.

    Args:
        kind: the form.
        of: who fills it in, and where it belongs.
        tr: the app's texts in the language of the participant.
        database: where it is stored.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("backspace", "press('backspace')", "Back", show=False, id="back"),
        Binding("escape", "press('escape')", "Back", id="leave"),
    ]
    AUTO_FOCUS = ""

    def __init__(self, kind: Kind, of: Occasion, tr: Language, database: Any) -> None:
        super().__init__()
        self.tr = tr
        given = FormAnswers(database, kind, of, tr.code)
        self._filling = Filling(kind, given, tr, self._tell)
        self._page: Page = self._filling.page()
        self._marked: Entry | None = None
        self.only_chooses = self._filling.only_chooses

    def _tell(self, text: str) -> None:
        self.notify(text, severity="error", timeout=30)

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        """The keys of the footer and the help, in the language of the participant."""
        bindings = translated_keys(super().active_bindings, self.tr)
        hidden = {"stop", *({"help"} if cast(Any, self.app).aloud.is_on else ())}
        return {
            key: active
            for key, active in keys_in_mode(self.app, bindings).items()
            if active.binding.id not in hidden
        }

    @property
    def help_text(self) -> str:
        """Keys of the form."""
        tr = self.tr
        lines = [tr("Backspace goes back to the question before.")]
        if not self._filling.is_thanking:
            lines.insert(0, how_to_answer(self._filling.step, Entry(), tr))
        lines.append(tr("Each answer is saved at once. A form that is left goes on where it was."))
        return "\n".join(lines) + "\n"

    def compose(self) -> ComposeResult:
        with Horizontal(classes="top-bar"):
            yield Static(self._filling.title, id="who", markup=False)
            yield Static("", id="where", markup=False)
        with Vertical(id="questions"):
            yield Static("", id="instruction", classes="body", markup=False)
            yield Heading(id="question")
            yield Static("", id="hint", classes="body", markup=False)
            yield Static("", id="options", markup=False)
            yield Static("", id="keys", classes="body", markup=False)
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
        tr, filling = self.tr, self._filling
        back = (Choice(tr("Back"), ("backspace",)),) * filling.can_go_back
        if filling.is_thanking:
            return (Choice(tr("Finish"), ("enter",)), *back)
        return (*answers(filling.step, filling.entry, tr), *back)

    def mark(self, _: int, choice: Choice) -> None:
        """Draw an answer that is marked."""
        if choice.entry != self._marked:
            self._marked = choice.entry
            self._show()

    # --- keys

    def on_key(self, event: events.Key) -> None:
        if event.key in _PASSED_ON and not (event.is_printable and self._filling.is_typing):
            return
        event.stop()
        event.prevent_default()
        self._press(event.key, event.character)

    def action_press(self, key: str) -> None:
        """Go back, or leave the form."""
        self._press(key, None)

    def _press(self, key: str, character: str | None) -> None:
        filling, self._marked = self._filling, None
        filling.press(key, character)
        if filling.is_over:
            self.dismiss(filling.record if filling.is_thanking else None)
        else:
            self._show()

    # --- the screen

    @property
    def sentences(self) -> list[str]:
        """The item in sentences, and what is chosen."""
        return [*self._page._replace(press="").sentences, *sentences(self.query_one(KeyLine).text)]

    def _show(self) -> None:
        filling, app = self._filling, cast(Any, self.app)
        page = filling.page(self._marked)
        if app.switch is not None:  # the keys of these are none of the switch's
            said = filling.said_before
            given = self.tr("You said: {answer}.", answer=said) if said else ""
            page = page._replace(decline="", given="" if filling.is_thanking else given)
        self._page = page
        options: str | Content = " ".join(page.said)
        is_scale = False
        if not filling.is_thanking:
            step, entry = filling.step, self._marked or filling.entry
            options = with_chosen(options_text(step, entry, app.size.width - _MARGINS))
            is_scale = step.kind == "number" and app.switch is None
        self.query_one("#question", Heading).show(page.text, most_rows(app.size))
        for name, text in (
            ("where", page.where),
            ("instruction", page.instruction),
            ("hint", page.hint),
            ("options", options),
            ("keys", self.tr("Press ← → or type a number.") if is_scale else ""),
            ("decline", page.decline),
            ("problem", page.problem),
            ("given", page.given),
        ):
            part = self.query_one(f"#{name}", Static)
            part.update(text)
            part.display = bool(text)
        self.query_one(KeyLine).show(page.press, self.tr("Enter"))
        self.refresh_bindings()
        app.look_for_choices()
        app.aloud.read(self, filling.place)
