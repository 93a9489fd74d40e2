"""The fields of the settings form under one heading."""

from collections.abc import Iterable

from textual.app import ComposeResult
from textual.containers import VerticalScroll

from sar_tui.widgets.parameter_field import ParameterField


class FieldPanel(VerticalScroll, can_focus=False, inherit_bindings=False):
    """Fields, which are mounted when the panel is first shown. Page keys are left to the screen.

    Args:
        title: of the heading.
        fields: under it.
    """

    DEFAULT_CSS = "FieldPanel { display: none; height: 1fr; }"

    def __init__(self, title: str, fields: Iterable[ParameterField]) -> None:
        super().__init__()
        self.title = title
        self.fields = tuple(fields)

    def compose(self) -> ComposeResult:
        """Compose nothing: see `show`."""
        return iter(())

    async def show(self, shown: bool) -> None:
        """Show the fields, or hide them."""
        if shown and self.fields and not self.fields[0].is_attached:
            await self.mount(*self.fields)
        self.display = shown

    @property
    def summary(self) -> str:
        """Number of fields that have problems ("! 2") or differ from their defaults ("● 3"); else
        empty.
        """
        if wrong := sum(bool(field.problem) for field in self.fields):
            return f"! {wrong}"
        differing = sum(field.is_changed for field in self.fields)
        return f"● {differing}" if differing else ""

    def on_resize(self) -> None:
        """Keep the focused field in view in a smaller window."""
        for field in self.fields:
            if field.has_focus_within:
                self.call_after_refresh(field.scroll_visible, animate=False, immediate=True)
