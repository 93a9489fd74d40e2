"""One field of the settings form, made from a parameter's declaration."""

import textwrap
from collections.abc import Sequence

from textual import on
from textual.app import ComposeResult
from textual.content import Content
from textual.events import Key
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Input

from sar_tui.model.language import Language
from sar_tui.rules.declaration import ENDLESS, Field, in_seconds, show
from sar_tui.widgets.choice import Choice, ChoiceList
from sar_tui.widgets.lists import OptionList

_YES_NO = ("yes", "no")
_NUMBERS = ("int", "float")
_MARK, _TITLE, _EDITOR, _NUMBER = 2, 24, 17, 9
"""Columns."""
_LONGEST_LINE = 72
"""Most columns of a line of the note."""
UNSAVED = "◆"
"""Sign of a value that differs from the saved one."""
CHANGED = "●"
"""Sign of a value that differs from the default."""


class NumberInput(Input):
    """Input of numbers, which leaves the key / to the screen."""

    def check_consume_key(self, key: str, character: str | None) -> bool:
        return character != "/" and super().check_consume_key(key, character)

    def on_key(self, event: Key) -> None:
        """Keep Input from inserting it."""
        if event.character == "/":
            event.prevent_default()


class ParameterField(Widget):
    """Title, value and unit in a line; below it, while it is edited, what it means, unless the
    screen shows that elsewhere.

    Numbers are shown and typed in the unit of the form (`Field.on_form`), with the decimal sign of
    the language, and kept as they are stored.

    It has its value and problem even while it is not mounted. It draws everything except the value
    itself, because a form of many fields would be slow with a widget for each text.

    Args:
        field: the declaration.
        value: the current value.
        saved: the saved one.
        known: values of a text to pick from, if they are known; of a list of words, the words.
        tr: the language of the note, in which ``field`` already is.
    """

    DEFAULT_CSS = f"""
    ParameterField {{ width: 1fr; height: 1; padding: 0 1; }}
    ParameterField > Input, ParameterField > Choice, ParameterField > WordPicker {{
        width: {_EDITOR}; margin: 0 0 0 {_MARK + _TITLE};
    }}
    ParameterField > NumberInput {{ width: {_NUMBER}; }}
    """

    class Changed(Message):
        """The field holds another value."""

    def __init__(
        self,
        field: Field,
        value: object,
        saved: object,
        known: Sequence[str] = (),
        tr: Language | None = None,
    ) -> None:
        super().__init__(id=f"parameter-{field.name}")
        self.field = field
        self.tr = tr or Language()
        self.known = tuple(known)
        self.value = value
        """The saved value or the default; after an edit, a bool or the typed text, of a number as it
        is stored.
        """
        self.saved = saved
        """The saved value or the default."""
        self.more = ""
        """A sentence about this value, at the end of the note; empty for none."""
        self.problem = ""
        """Problem of the value; empty for none."""
        self.used_by = ""
        """Policies that use it, if none of them is chosen; empty if it has an effect."""
        self._is_note_elsewhere = False
        self._drawn: object = None

    def compose(self) -> ComposeResult:
        value = self._text
        match self.field.kind:
            case "choice":
                yield Choice(self.field.choices, str(self.value), self.field.labels)
            case "bool":
                yield Choice(
                    _YES_NO, show(bool(self.value)), {"yes": self.tr("yes"), "no": self.tr("no")}
                )
            case "text" if self.known:
                yield Choice([*self.known, *([] if value in self.known else [value])], value)
            case "list" if self.known:
                yield WordPicker(self.known, value)
            case "int" | "float":
                yield NumberInput(value, compact=True)
            case _:
                yield Input(value, compact=True)

    @property
    def _text(self) -> str:
        """The value as it is typed."""
        is_number = self.field.kind in _NUMBERS
        return self.field.shown(self.value, self.tr) if is_number else show(self.value)

    def render(self) -> Content:
        """Draw everything except the value, for which room is left."""
        mark, colour = self._mark
        title = ("bold " if self.has_focus_within else "") + (colour if self.problem else "")
        before = self.tr("was {value}", value=self._shown(self.saved)) if self.is_unsaved else ""
        field = self.field
        beside = " ".join(filter(None, (field.on_form.unit, before)))
        line = Content.assemble(
            (f"{mark:{_MARK}}", colour or "$accent"),
            (f"{field.title:{_TITLE}}", title.strip()),
            (f"{'':{_NUMBER if field.kind in _NUMBERS else _EDITOR}} {beside}", "$text-muted"),
        ).truncate(self.content_size.width, ellipsis=True)
        colour = "$warning" if self.problem else "$text-muted"
        note = (Content.assemble(f"\n{'':{_MARK}}", (text, colour)) for text in self._note_lines())
        return Content.assemble(line, *note)

    @property
    def _mark(self) -> tuple[str, str]:
        """The sign before the title, and its colour."""
        if self.problem:
            return "!", "$warning"
        if self.is_unsaved:
            return UNSAVED, "$accent bold"
        return (CHANGED, "$accent") if self.is_changed else ("", "")

    def _shown(self, value: object) -> str:
        """Return a value as it is shown."""
        return self.field.shown(value, self.tr) or self.tr("none")

    def _note_lines(self) -> list[str]:
        """Return the lines below the title while it is edited: the problem at least."""
        note = ""
        if self.has_focus_within:
            note = self.problem if self._is_note_elsewhere else self.note
        width = max(12, min(self.content_size.width - _MARK, _LONGEST_LINE))
        return [line for text in note.split("\n") for line in textwrap.wrap(text, width)]

    def put_note_elsewhere(self, is_elsewhere: bool) -> None:
        """Leave it to the screen to show the note, or show it below the title."""
        if is_elsewhere != self._is_note_elsewhere:
            self._is_note_elsewhere = is_elsewhere
            self.redraw()

    def redraw(self) -> None:
        """Draw it again if it looks different, with as many lines as it needs now."""
        note = self._note_lines()
        drawn = (self._mark, show(self.saved), self.has_focus_within, note)
        if self.is_attached and drawn != self._drawn:
            self._drawn = drawn
            self.styles.height = 1 + len(note)
            self.refresh()

    def on_resize(self) -> None:
        """Wrap the note anew."""
        self.redraw()

    @property
    def note(self) -> str:
        """The problem, or the meaning of the parameter, its limits and its default."""
        if self.problem:
            return self.problem
        said = [self.field.help, self._limits()]
        if self.is_changed or self._is_note_elsewhere:
            value = f"{self._shown(self.field.default)} {self.field.on_form.unit}".rstrip()
            said.append(self.tr("Default: {value}.", value=value))
        note = " ".join(filter(None, (*said, self.more)))
        return self.tr.figures(in_seconds(note)) if self._is_in_seconds else note

    @property
    def _is_in_seconds(self) -> bool:
        return self.field.unit == "ms"

    def explained(self, problem: str) -> str:
        """Return a problem of the value in the unit of the form."""
        field, tr = self.field.on_form, self.tr
        if field is self.field:
            return problem
        if self._is_within(1):
            return tr.figures(in_seconds(problem))
        told = tr(
            "{title} is a number, {range}, not {shown}.",
            title=field.title,
            range=self._range(field),
            shown=self._text or tr("empty"),
        )
        if not (self._is_in_seconds and self._is_within(1 / self.field.size)):
            return told
        return f"{told} {tr('For milliseconds, type {text} ms.', text=self._text)}"

    def _is_within(self, factor: float) -> bool:
        """Return True if the value times a factor is a number within its bounds."""
        try:
            number = float(show(self.value)) * factor
        except ValueError:
            return False
        low, high = self.field.ge, self.field.le
        return (low is None or low <= number) and (high is None or number <= high)

    def _limits(self) -> str:
        """Return the bounds of a number, or what a list may hold, as a sentence; empty where there
        is a choice.
        """
        field, tr = self.field.on_form, self.tr
        if field.kind in ("choice", "bool", "text") or self.known:
            return ""
        low, high = _bounds(field)
        if field.kind == "list":
            of_numbers = (
                tr("Numbers {low} to {high}, spaced.", low=low, high=high)
                if low
                else tr("Numbers, spaced.")
            )
            return of_numbers if field.items == "numbers" else tr("Words, spaced.")
        return f"{self._range(field)}." if low else ""

    def _range(self, field: Field) -> str:
        """Return the bounds of a number with its unit: "0.1 to 60 s"."""
        low, high = _bounds(field)
        if not low:
            return ""
        said = (
            self.tr("{low} to {high}", low=low, high=high)
            if (field.le or 0) < ENDLESS
            else self.tr("{low} or more", low=low)
        )
        return f"{said} {field.unit}".strip()

    @property
    def is_changed(self) -> bool:
        """True if it differs from the default."""
        return show(self.value) != show(self.field.default)

    @property
    def is_unsaved(self) -> bool:
        """True if it differs from the saved value."""
        return show(self.value) != show(self.saved)

    def focus_editor(self) -> None:
        """Focus the editor."""
        self.query_exactly_one("Input, Choice").focus()

    def reset(self) -> None:
        """Put the default back, selected if it is being edited, so that what is typed next replaces
        it.
        """
        self.set_value(self.field.default)

    def set_value(self, value: object) -> None:
        """Put another value in, selected if it is being edited."""
        self.value = value
        for editor in self.query("Input, Choice"):
            if isinstance(editor, Input | Choice):
                editor.value = self._text
                if isinstance(editor, Input) and editor.has_focus:
                    editor.select_all()

    @on(Input.Changed)
    @on(Choice.Changed)
    def _edited(self, event: Input.Changed | Choice.Changed) -> None:
        event.stop()
        value = self.field.stored(event.value)
        if value != show(self.value):
            self.value = value == _YES_NO[0] if self.field.kind == "bool" else value
            self.post_message(self.Changed())

    def on_descendant_focus(self) -> None:
        """Show the note, and scroll into view; after the next refresh too, as the panel may just
        have opened.
        """
        self.redraw()
        self.scroll_visible(animate=False, immediate=True)
        self.call_after_refresh(self.scroll_visible, animate=False, immediate=True)

    def on_descendant_blur(self) -> None:
        """Hide the note, and show a number that was typed with a unit in that of the form."""
        for editor in self.query(Input):
            if self.field.kind in _NUMBERS and not self.problem:
                editor.value = self._text
        self.redraw()

    def show_problem(self, problem: str, used_by: str = "") -> None:
        """Show a problem. Without one, the field is hidden if it has no effect without the policies
        in ``used_by``.
        """
        self.problem, self.used_by = problem, used_by
        self.display = bool(problem) or not used_by
        self.redraw()


def _bounds(field: Field) -> tuple[str, str]:
    """Return the lowest and the highest number as texts; empty without bounds."""
    if field.ge is None or field.le is None:
        return "", ""
    return f"{field.ge:g}", f"{field.le:g}"


# --- a list of words


class WordPicker(Widget):
    """A line to type words into. Enter opens a list of the known ones, where Enter adds a word or
    removes it.

    Args:
        known: the words to pick from.
        value: the words now, with spaces between them.
    """

    DEFAULT_CSS = """
    WordPicker { height: 1; }
    WordPicker > ChoiceList {
        width: 1fr; height: auto; max-height: 12; overlay: screen; constrain: none inside; background: $surface;
    }
    WordPicker > ChoiceList > .option-list--option { padding: 0 1; }
    """

    def __init__(self, known: Sequence[str], value: str) -> None:
        super().__init__()
        self._known = tuple(known)
        self._value = value

    def compose(self) -> ComposeResult:
        yield Input(self._value, compact=True)

    @property
    def _input(self) -> Input:
        return self.query_exactly_one(Input)

    @on(Input.Submitted)
    def _open(self, event: Input.Submitted) -> None:
        event.stop()
        words = ChoiceList(*self._lines(), compact=True)
        self.mount(words)
        words.highlighted = 0
        words.focus(scroll_visible=False)

    def _lines(self) -> list[Content]:
        chosen = self._input.value.split()
        return [Content(f"{'✓' if word in chosen else ' '} {word}") for word in self._known]

    @on(OptionList.OptionSelected)
    def _picked(self, event: OptionList.OptionSelected) -> None:
        event.stop()
        word, words = self._known[event.option_index], self._input.value.split()
        words = [each for each in words if each != word] if word in words else [*words, word]
        self._input.value = " ".join(words)
        for at, line in enumerate(self._lines()):
            event.option_list.replace_option_prompt_at_index(at, line)

    @on(OptionList.OptionHighlighted)
    def _looked_at(self, event: OptionList.OptionHighlighted) -> None:
        event.stop()
