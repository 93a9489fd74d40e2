"""One field of the settings form, made from a parameter's declaration."""

from functools import lru_cache

from textual import on
from textual.app import ComposeResult
from textual.content import Content
from textual.geometry import Size
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Input

from sar_tui.framework.declaration import Field, show
from sar_tui.widgets.choice import Choice

_YES_NO = ("yes", "no")
_MARK, _TITLE, _EDITOR = 2, 26, 20
"""Columns."""


class ParameterField(Widget):
    """Title, value, unit and bounds, with the meaning or a problem below.

    It has its value and problem even while it is not mounted. It draws everything except the value itself, because
    a form of many fields would be slow with a widget for each text.

    Args:
        field: the declaration.
        value: the current value.
    """

    DEFAULT_CSS = f"""
    ParameterField {{ width: 1fr; height: auto; padding: 0 1; margin: 0 0 1 0; }}
    ParameterField > Input, ParameterField > Choice {{ width: {_EDITOR}; margin: 0 0 0 {_MARK + _TITLE}; }}
    """

    class Changed(Message):
        """The field holds another value."""

    def __init__(self, field: Field, value: object) -> None:
        super().__init__(id=f"parameter-{field.name}")
        self.field = field
        self.value = value
        """The saved value or the default; after an edit, a bool or the typed text."""
        self.problem = ""
        """Problem of the value; empty for none."""
        self._drawn = (self.is_changed, self.note)

    def compose(self) -> ComposeResult:
        match self.field.kind:
            case "choice":
                yield Choice(self.field.choices, str(self.value))
            case "bool":
                yield Choice(_YES_NO, show(bool(self.value)))
            case _:
                yield Input(show(self.value), compact=True)

    def render(self) -> Content:
        """Draw everything except the value, for which room is left."""
        mark = "●" if self.is_changed else ""
        lines = (
            Content.assemble(
                (f"{mark:{_MARK}}", "$accent"),
                (f"{self.field.title:{_TITLE}}", "bold" if self.has_focus_within else ""),
                (f"{'':{_EDITOR}} {self._about}", "$text-muted"),
            ),
            *(
                Content.styled(f"  {line}", "$warning" if self.problem else "$text-muted")
                for line in _wrapped(self.note, self.content_size.width)
            ),
        )
        return Content("\n").join(lines)

    def get_content_height(self, container: Size, viewport: Size, width: int) -> int:
        """Return the number of lines at this width."""
        return 1 + len(_wrapped(self.note, width))

    @property
    def _about(self) -> str:
        bounds = "" if self.field.choices else self.field.bounds
        return " ".join(filter(None, (self.field.unit, f"({bounds})" if bounds else "")))

    @property
    def note(self) -> str:
        """The problem, or the meaning of the parameter and its default."""
        default = f" Default: {show(self.field.default) or 'none'}." if self.is_changed else ""
        return self.problem or self.field.help + default

    @property
    def is_changed(self) -> bool:
        """True if it differs from the default."""
        return show(self.value) != show(self.field.default)

    def focus_editor(self) -> None:
        """Focus the editor."""
        self.query_exactly_one("Input, Choice").focus()

    def reset(self) -> None:
        """Put the default back, selected if it is being edited, so that what is typed next replaces it."""
        self.value = self.field.default
        for editor in self.children:
            if isinstance(editor, Input | Choice):
                editor.value = show(self.value)
                if isinstance(editor, Input) and editor.has_focus:
                    editor.select_all()

    @on(Input.Changed)
    @on(Choice.Changed)
    def _edited(self, event: Input.Changed | Choice.Changed) -> None:
        event.stop()
        if event.value != show(self.value):
            self.value = event.value == _YES_NO[0] if self.field.kind == "bool" else event.value
            self.post_message(self.Changed())

    def on_descendant_focus(self) -> None:
        """Highlight the title, and scroll the editor and its note into view.

        If a heading has just unfolded, the position of a field is known only after the next refresh.
        """
        self.refresh()
        self.scroll_visible(animate=False, immediate=True)
        self.call_after_refresh(self.scroll_visible, animate=False, immediate=True)

    def on_descendant_blur(self) -> None:
        """Draw the title without highlight."""
        self.refresh()

    def show_problem(self, problem: str) -> None:
        """Show a problem (empty for none), and mark a value that differs from its default."""
        self.problem = problem
        drawn = self.is_changed, self.note
        if drawn != self._drawn:
            self._drawn = drawn
            if self.is_mounted:
                self.refresh(layout=True)  # lays out the whole form again


@lru_cache(maxsize=1024)
def _wrapped(text: str, width: int) -> tuple[str, ...]:
    """Wrap a text with two columns left on either side. Cached: a form measures every field several times."""
    return tuple(line.plain for line in Content(text).wrap(max(width - 4, 1))) if text else ("",)
