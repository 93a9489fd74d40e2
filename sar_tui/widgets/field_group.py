"""Fields of the settings form under a heading that folds."""

from collections.abc import Iterable
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.events import Click
from textual.message import Message
from textual.reactive import reactive
from textual.widgets import Static

from sar_tui.framework.parameters import show
from sar_tui.widgets.parameter_field import ParameterField


class Heading(Horizontal, can_focus=True):
    """One line: the title, and beside it what is folded away under it."""

    BINDINGS: ClassVar[list[BindingType]] = [Binding("enter,space", "fold", "Fold or unfold", show=False, id="fold")]

    class Pressed(Message):
        """Somebody wants to fold or unfold it."""

    def __init__(self, title: str) -> None:
        super().__init__()
        self._title = title
        self._told = ("", "", "")

    def compose(self) -> ComposeResult:
        yield Static(classes="heading", markup=False)
        yield Static(classes="told", markup=False)
        yield Static(classes="hint", markup=False)

    def tell(self, words: str, hint: str, is_folded: bool) -> None:
        """Show whether it is folded, some words on what is under it, and a hint while it has the focus."""
        told = (f"{'▶' if is_folded else '▼'} {self._title}", words, hint)
        if told != self._told:  # every update lays out the whole form anew
            self._told = told
            for part, text in zip((".heading", ".told", ".hint"), told, strict=True):
                self.query_one(part, Static).update(text)

    def action_fold(self) -> None:
        """Ask the group to fold or unfold."""
        self.post_message(self.Pressed())

    def on_click(self, event: Click) -> None:
        """A click does what Enter does."""
        event.stop()
        self.action_fold()


class FieldGroup(Vertical):
    """A heading and its fields.

    While it is folded, the heading tells what is set under it that differs from the defaults.

    Args:
        title: the heading.
        fields: what stands under it.
        folded: whether it begins folded.
    """

    DEFAULT_CSS = """
    FieldGroup { height: auto; }
    FieldGroup Heading { height: 1; margin: 0 0 1 0; padding: 0 1; background: $surface; }
    FieldGroup .heading { width: auto; min-width: 26; margin: 0 2 0 0; text-style: bold; color: $accent; }
    FieldGroup .told { width: 1fr; padding: 0 1 0 0; color: $text-muted; text-wrap: nowrap; text-overflow: ellipsis; }
    FieldGroup .hint { width: auto; display: none; color: $text-muted; }
    FieldGroup Heading:focus .hint { display: block; }
    FieldGroup Heading:focus .heading { text-style: bold reverse; }
    FieldGroup.wrong .told { color: $warning; }
    FieldGroup > .fields { height: auto; }
    FieldGroup.folded > .fields { display: none; }
    """

    folded: reactive[bool] = reactive(False, init=False)

    def __init__(self, title: str, fields: Iterable[ParameterField], folded: bool = False) -> None:
        super().__init__()
        self.heading = Heading(title)
        self.fields = tuple(fields)
        self.set_reactive(FieldGroup.folded, folded)

    def compose(self) -> ComposeResult:
        yield self.heading
        with Vertical(classes="fields"):
            yield from self.fields

    def on_mount(self) -> None:
        """Begin folded, or not."""
        self.watch_folded()

    def watch_folded(self) -> None:
        """Hide the fields, or show them."""
        self.set_class(self.folded, "folded")
        self._tell()

    def heed(self) -> None:
        """Its fields hold other values, or have been found wrong: what is wrong is never left folded away."""
        wrong = any(field.has_class("wrong") for field in self.fields)
        self.set_class(wrong, "wrong")
        if wrong:
            self.folded = False
        self._tell()

    def _tell(self) -> None:
        count, wrong = len(self.fields), sum(field.has_class("wrong") for field in self.fields)
        if not self.folded:
            words, hint = "", "Enter folds it"
        elif wrong:
            words, hint = f"{wrong} to mend", "Enter opens it"
        elif changed := [field for field in self.fields if field.is_changed]:
            words, hint = f"● {', '.join(map(_in_short, changed))}", ""  # these words need the room
        else:
            words, hint = f"{count} settings, none changed" if count > 1 else "1 setting, not changed", "Enter opens it"
        self.heading.tell(words, hint, self.folded)

    def on_heading_pressed(self, event: Heading.Pressed) -> None:
        """Fold or unfold, and bring what is unfolded into view."""
        event.stop()
        self.folded = not self.folded
        if not self.folded:
            self._to_top()

    def go_to(self) -> None:
        """Put the cursor on the heading, and as much of what stands under it as there is room for into view."""
        self.heading.focus(scroll_visible=False)
        self._to_top()

    def _to_top(self) -> None:
        self.call_after_refresh(self.heading.scroll_visible, animate=False, top=True)


def _in_short(field: ParameterField) -> str:
    """A field and its value in a few words: "feedback: approve", "time to decide: 6000 ms"."""
    title = field.field.title.removesuffix(" is").removesuffix(" are")
    return f"{title[:1].lower()}{title[1:]}: {show(field.value) or 'none'} {field.field.unit}".rstrip()
