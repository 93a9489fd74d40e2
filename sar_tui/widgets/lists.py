"""Lists of options: Textual's own without two failures, and lists whose chosen line is marked by a
bar and not filled.
"""

import textwrap
from typing import Any, Literal

from rich.segment import Segment
from textual.content import Content
from textual.events import Click, Key
from textual.strip import Strip
from textual.widgets import OptionList as TextualOptionList

from sar_tui.model.spoken_text import sentences

_MARK = "▌"
_SUMMARY_WIDTH = 33
"""Characters of a line of a summary."""


class OptionList(TextualOptionList):
    """Textual's list, without two of its failures.

    It fails on Page Up and Page Down before it is laid out, or without a column to stand in; and on
    a click at an option that has been taken away and still stands on the screen.
    """

    async def _on_click(self, event: Click) -> None:
        if event.style.meta.get("option", 0) >= self.option_count:
            event.prevent_default()

    def _move_page(self, direction: Literal[-1, 1]) -> None:
        if self._lines and (self.highlighted or 0) in self._index_to_line:
            super()._move_page(direction)


def menu_sentences(menu: OptionList) -> list[str]:
    """Return a menu in sentences: its title, what its first line says, how to choose, and the choice
    that is marked.
    """
    chosen = menu.highlighted_option
    return sentences(
        str(menu.border_title),
        str(menu.get_option_at_index(0).prompt) if menu.option_count else "",
        str(menu.border_subtitle),
        str(chosen.prompt) if chosen else "",
    )


class MarkedList(OptionList):
    """A list that marks its chosen line with a bar at the left. Escape chooses what was chosen on
    entering it.
    """

    _before: str | None = None

    DEFAULT_CSS = """
    MarkedList, MarkedList:focus { background: $background; background-tint: $foreground 0%; padding: 0; }
    MarkedList { text-wrap: nowrap; text-overflow: ellipsis; }
    MarkedList > .option-list--option { padding: 0 1; }
    MarkedList > .option-list--option-highlighted {
        background: $background; color: $foreground; text-style: none;
    }
    MarkedList:focus > .option-list--option-highlighted {
        background: $background; color: $accent; text-style: bold;
    }
    """

    @property
    def chosen(self) -> str | None:
        """The id of the chosen option."""
        return self.highlighted_option.id if self.highlighted_option else None

    def choose(self, name: str | None) -> None:
        """Choose the option of an id; the first that can be chosen if there is none."""
        names = [option.id for option in self.options if not option.disabled]
        if names:
            self.highlighted = self.get_option_index(name if name in names else names[0])  # type: ignore[arg-type]

    def on_focus(self) -> None:
        self._before = self.chosen

    def on_key(self, event: Key) -> None:
        """Take back what was chosen since the list was entered. What else Escape does is up to the
        screen.
        """
        if event.key == "escape" and self._before is not None and self.chosen != self._before:
            self.choose(self._before)

    def render_line(self, y: int) -> Strip:
        """Draw a line, with the bar if it is the chosen one."""
        strip = super().render_line(y)
        line = self.scroll_offset.y + y
        if (
            line < len(self._lines)
            and self._lines[line][0] == self.highlighted
            and strip.cell_length > 1
        ):
            style = self.get_visual_style("option-list--option", "option-list--option-highlighted")
            return Strip.join([Strip([Segment(_MARK, style.rich_style)], 1), strip.crop(1)])
        return strip


class PickList(MarkedList):
    """A list of one line, the chosen one, that opens while it has the focus.

    Attributes:
        summaries: title and summary of options, by id; that of the chosen one stands below it.
    """

    DEFAULT_CSS = """
    PickList { height: 1; border: none; overflow: hidden; }
    PickList:focus {
        width: 32; height: auto; max-height: 12; overlay: screen; constrain: none inside; overflow-y: auto;
        border: round $accent; offset: -2 0;
    }
    """

    def __init__(self, **how: Any) -> None:
        super().__init__(**how)
        self.summaries: dict[str, tuple[str, str]] = {}
        self._expanded = ""

    def watch_has_focus(self, has_focus: bool) -> None:
        super().watch_has_focus(has_focus)
        self._expand()

    def watch_highlighted(self, highlighted: int | None) -> None:
        super().watch_highlighted(highlighted)
        self._expand()

    def on_resize(self) -> None:
        """Show the chosen option in the list that has opened."""
        if self.has_focus:
            self.scroll_to_highlight(top=True)

    def _expand(self) -> None:
        """Show the summary of the chosen option while the list is open."""
        chosen = (self.chosen or "") if self.has_focus else ""
        if chosen == self._expanded or not self.summaries:
            return
        for name in (self._expanded, chosen):
            if name in self.summaries:
                title, summary = self.summaries[name]
                lines = textwrap.wrap(summary, _SUMMARY_WIDTH) if name == chosen else []
                below = "".join(f"\n  {line}" for line in lines)
                prompt = Content.assemble(title, (below, "$text-muted not bold"))
                self.replace_option_prompt(name, prompt)
        self._expanded = chosen
        if all(option.disabled for option in self.options[(self.highlighted or 0) + 1 :]):
            self.scroll_end(animate=False)  # shows those below that cannot be chosen
        else:
            self.scroll_to_highlight()

    def render_line(self, y: int) -> Strip:
        """Draw the chosen option alone, unless the list is open."""
        if self.has_focus or self.highlighted_option is None:
            return super().render_line(y)
        style = self.get_visual_style("option-list--option")
        if y:
            return Strip.blank(self.size.width, style.rich_style)
        title = str(self.highlighted_option.prompt).partition("\n")[0]
        words = Content(f"{title} ▾").truncate(self.size.width, ellipsis=True, pad=True)
        return Strip([Segment(words.plain, style.rich_style)], self.size.width)
