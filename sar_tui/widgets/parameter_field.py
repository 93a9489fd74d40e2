"""One field of the settings form, made from a parameter's declaration."""

from collections.abc import Iterable

from textual import on
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.message import Message
from textual.widgets import Input, Label, Select, Static

from sar_tui.framework.parameters import Field, show

_YES_NO = ("yes", "no")


class ParameterField(Vertical):
    """Title, value, unit, and under it what is allowed, what it means, or what is wrong.

    Args:
        field: the declaration.
        value: what it is set to.
    """

    DEFAULT_CSS = """
    ParameterField { height: auto; padding: 0 1; margin: 0 0 1 0; }
    ParameterField > Horizontal { height: 1; }
    ParameterField .mark { width: 2; color: $accent; }
    ParameterField .title { width: 26; }
    ParameterField Input, ParameterField Select { width: 20; }
    ParameterField .unit { width: 1fr; padding: 0 1; color: $text-muted; }
    ParameterField .help { padding: 0 2; color: $text-muted; height: auto; }
    ParameterField.wrong .help { color: $warning; }
    ParameterField:focus-within .title { text-style: bold; }
    """

    class Changed(Message):
        """The field holds another value."""

        def __init__(self, field: "ParameterField") -> None:
            super().__init__()
            self.field = field

    def __init__(self, field: Field, value: object) -> None:
        super().__init__(id=f"parameter-{field.name}")
        self.field = field
        self._value = value
        self._told = ("  ", field.help)

    def compose(self) -> ComposeResult:
        with Horizontal():
            yield Static(self._told[0], classes="mark")
            yield Label(self.field.title, classes="title", markup=False)
            yield self._editor()
            yield Label(self._about(), classes="unit", markup=False)
        yield Static(self._told[1], classes="help", markup=False)

    def _editor(self) -> Input | Select[str]:
        match self.field.kind:
            case "choice":
                return _select(self.field.choices, str(self._value))
            case "bool":
                return _select(_YES_NO, show(bool(self._value)))
            case _:
                return Input(show(self._value), compact=True)

    def _about(self) -> str:
        bounds = "" if self.field.choices else self.field.bounds
        unit = f"{self.field.unit} " if self.field.unit else ""
        return f"{unit}{f'({bounds})' if bounds else ''}"

    @property
    def value(self) -> object:
        """What the field holds: a truth value, or text as it was typed."""
        return self._value

    @property
    def is_changed(self) -> bool:
        """Whether it differs from the default."""
        return show(self._value) != show(self.field.default)

    def reset(self) -> None:
        """Put the default back."""
        editor = self.query_one("Input, Select")
        if isinstance(editor, Input | Select):
            editor.value = show(self.field.default)

    @on(Input.Changed)
    @on(Select.Changed)
    def _edited(self, event: Input.Changed | Select.Changed) -> None:
        event.stop()
        self._value = event.value == _YES_NO[0] if self.field.kind == "bool" else event.value
        self.post_message(self.Changed(self))

    def on_descendant_focus(self) -> None:
        """The help beneath the editor is shown with it."""
        self.call_after_refresh(self.scroll_visible, animate=False)

    def tell(self, problem: str) -> None:
        """Mark the field as changed from its default, and as wrong if there is a problem."""
        default = f" Default: {show(self.field.default) or 'none'}." if self.is_changed else ""
        told = ("● " if self.is_changed else "  ", problem or self.field.help + default)
        if told != self._told:  # every update lays out the whole form anew
            self._told = told
            self.query_one(".mark", Static).update(told[0])
            self.query_one(".help", Static).update(told[1])
        self.set_class(bool(problem), "wrong")


def _select(choices: Iterable[str], value: str) -> Select[str]:
    return Select([(choice, choice) for choice in choices], value=value, allow_blank=False, compact=True)
