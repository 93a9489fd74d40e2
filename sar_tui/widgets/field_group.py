"""Fields of the settings form under a heading that folds."""

from collections.abc import Iterable
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.content import Content
from textual.events import Click
from textual.message import Message
from textual.reactive import reactive
from textual.widget import Widget

from sar_tui.framework.declaration import show
from sar_tui.widgets.parameter_field import ParameterField

_TITLE = 28
"""Least columns for a title, so that the summaries beside the titles are aligned."""


class Heading(Widget, can_focus=True):
    """One line: the title, a summary of the folded fields, and while focused, what Enter does."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("enter,space", "fold", "Fold or unfold", show=False, id="fold")]
    DEFAULT_CSS = "Heading { height: 1; margin: 0 0 1 0; padding: 0 1; background: $surface; }"

    title: reactive[str] = reactive("")
    summary: reactive[str] = reactive("")
    hint: reactive[str] = reactive("")
    is_wrong: reactive[bool] = reactive(False)

    class Pressed(Message):
        """Requests that the group be folded or unfolded."""

    def render(self) -> Content:
        """Draw the title, as much of the summary as fits, and the hint."""
        style = "bold reverse $accent" if self.has_focus else "bold $accent"
        title = Content.assemble((self.title, style), " " * (_TITLE - len(self.title)))
        hint = Content.styled(f" {self.hint}" if self.has_focus else "", "$text-muted")
        room = max(self.content_size.width - title.cell_length - hint.cell_length, 0)
        summary = Content(self.summary).truncate(room, ellipsis=True, pad=True)
        return title + summary.stylize("$warning" if self.is_wrong else "$text-muted") + hint

    def action_fold(self) -> None:
        """Request that the group be folded or unfolded."""
        self.post_message(self.Pressed())

    def on_focus(self) -> None:
        """Scroll into view at once."""
        self.scroll_visible(animate=False, immediate=True)

    def on_click(self, event: Click) -> None:
        """Fold or unfold, as Enter does."""
        event.stop()
        self.action_fold()


class FieldGroup(Vertical):
    """A heading and its fields, which are mounted when first unfolded.

    While folded, the heading lists the values that differ from their defaults.

    Args:
        title: of the heading.
        fields: under it.
        folded: True to begin folded.
    """

    DEFAULT_CSS = """
    FieldGroup { height: auto; }
    FieldGroup > .fields { height: auto; }
    """

    def __init__(self, title: str, fields: Iterable[ParameterField], folded: bool = False) -> None:
        super().__init__()
        self.heading = Heading()
        self.fields = tuple(fields)
        self._title = title
        self._folded = folded
        self._under = Vertical(*self.fields, classes="fields")

    @property
    def folded(self) -> bool:
        """True if only the heading is shown."""
        return self._folded

    def compose(self) -> ComposeResult:
        yield self.heading
        if not self.folded:
            yield self._under

    async def fold(self, folded: bool) -> None:
        """Hide the fields, or show them."""
        self._folded = folded
        if not folded and not self._under.is_attached:
            await self.mount(self._under)
        self._under.display = not folded
        self._show_state()

    async def update(self) -> None:
        """Update the heading after a change of values or problems; unfold fields that have problems."""
        if self.folded and any(field.problem for field in self.fields):
            await self.fold(False)
        self._show_state()

    def _show_state(self) -> None:
        count, wrong = len(self.fields), sum(bool(field.problem) for field in self.fields)
        if not self.folded:
            words, hint = "", "Enter folds it"
        elif wrong:
            words, hint = f"{wrong} to fix", "Enter opens it"
        elif changed := [field for field in self.fields if field.is_changed]:
            words, hint = f"● {', '.join(map(_in_short, changed))}", ""  # these words need the room
        else:
            words, hint = f"{count} settings, none changed" if count > 1 else "1 setting, not changed", "Enter opens it"
        self.heading.title = f"{'▶' if self.folded else '▼'} {self._title}"
        self.heading.summary, self.heading.hint, self.heading.is_wrong = words, hint, bool(wrong)

    async def on_heading_pressed(self, event: Heading.Pressed) -> None:
        """Fold or unfold, and scroll unfolded fields into view."""
        event.stop()
        await self.fold(not self.folded)
        if not self.folded:
            self._to_top()

    def go_to(self) -> None:
        """Focus the heading, and scroll as many of its fields as fit into view."""
        self.heading.focus(scroll_visible=False)
        self._to_top()

    def _to_top(self) -> None:
        self.call_after_refresh(self.heading.scroll_visible, animate=False, top=True, immediate=True)


def _in_short(field: ParameterField) -> str:
    """Return a short text of a field and its value: "feedback: approve", "time to decide: 6000 ms"."""
    title = field.field.title.removesuffix(" mode")
    return f"{title[:1].lower()}{title[1:]}: {show(field.value) or 'none'} {field.field.unit}".rstrip()
