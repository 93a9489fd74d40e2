"""The list of the day: people in sections, each with why they are there. Typing finds a person."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

from rich.segment import Segment
from textual.content import Content
from textual.events import Key, Resize
from textual.strip import Strip
from textual.widgets.option_list import Option

from sar_tui.model.language import Language
from sar_tui.widgets.lists import MarkedList

if TYPE_CHECKING:
    from sar_tui.app.home.day import Entry

_NEW = "+"
_BESIDE = 3
"""Columns of a line's padding and the scroll bar."""
_GAP = "  "
_WIDE = 26
"""Fewest columns of why a person is there, with those of when they trained behind them."""
_LONGEST_CODE = 12
"""Longer codes are cut, so that there is room for what is said."""


class ParticipantList(MarkedList):
    """People, each with what the day says of them, and a last line to add one.

    Attributes:
        sought: the part of a code, or a word, that was typed.
    """

    app: Any

    def __init__(self, **how: Any) -> None:
        super().__init__(markup=False, **how)
        self._known: Sequence[Entry] = ()
        self.sought = ""

    def on_mount(self) -> None:
        self.border_title = self.app.tr("People")

    def fill(self, known: "Sequence[Entry]", chosen: str | None) -> None:
        """List people, with one of them chosen."""
        self._known = known
        if chosen and self.sought not in chosen:
            self.sought = ""
        self._list(chosen)
        self._before = self.chosen

    @property
    def code(self) -> str | None:
        """The code of the chosen participant; None on the last line."""
        return None if self.chosen == _NEW else self.chosen

    @property
    def entry(self) -> "Entry | None":
        """The entry of the day on the chosen participant."""
        return next((each for each in self._known if each.code == self.code), None)

    @property
    def is_empty(self) -> bool:
        """True if nobody is known yet."""
        return not self._known

    def is_new(self, option: Option) -> bool:
        """Return True for the line that adds a participant."""
        return option.id == _NEW

    def choose_new(self) -> None:
        """Choose the line that adds a participant."""
        self.choose(_NEW)

    # --- drawing

    def _list(self, chosen: str | None) -> None:
        found = self._found()
        tr: Language = self.app.tr
        self.clear_options()
        between = [Option("", disabled=True)] if found else []
        new = Option(tr("+ New participant"), id=_NEW)
        self.add_options([*self._in_sections(found, tr), *between, new])
        self.choose(chosen)
        if self.highlighted == 1:
            self.scroll_home(animate=False)  # the heading above it is shown, too
        count = len(self._known)
        self.border_title = tr("{count} people", count=count) if count > 1 else tr("People")
        if self._known:
            finds = tr("find: {typed} (Esc)", typed=self.sought)
            self.border_subtitle = finds if self.sought else tr("type to find · + adds")

    def _in_sections(self, entries: "Sequence[Entry]", tr: Language) -> Iterator[Option]:
        from sar_tui.app.home.day import heading

        code_width = min(_LONGEST_CODE, max((len(each.code) for each in entries), default=0))
        width = self.content_size.width - _BESIDE - code_width - len(_GAP)
        trained_width = max((len(each.trained) for each in entries if each.why), default=0)
        above = ""
        for part, group in groupby(entries, key=lambda each: each.part):
            members = list(group)
            title = Content.styled(heading(part, tr), "bold $text-muted")
            if part == "look":
                title = Content.styled(f"! {heading(part, tr)} · {len(members)}", "bold $warning")
            yield Option(Content(above) + title, disabled=True)
            for each in members:
                code = Content.styled(each.code, "bold").truncate(
                    code_width, ellipsis=True, pad=True
                )
                said = _said(each, width, trained_width)
                yield Option(Content.assemble(code, _GAP, said), id=each.code)
            above = "\n"

    def render_line(self, y: int) -> Strip:
        """Draw a line; all words of the chosen one have the same colour."""
        strip = super().render_line(y)
        line = self.scroll_offset.y + y
        if line < len(self._lines) and self._lines[line][0] == self.highlighted:
            style = self.get_visual_style("option-list--option", "option-list--option-highlighted")
            return Strip(Segment.apply_style(strip, post_style=style.rich_style))
        return strip

    def on_resize(self, event: Resize) -> None:
        """Fit the lines into another width."""
        if self._known:
            self._list(self.chosen)

    # --- finding

    def _found(self) -> "list[Entry]":
        """Return the people whose code has what was typed; without one, those of whom it is
        said.
        """
        if not self.sought:
            return list(self._known)
        by_code = [each for each in self._known if self.sought in each.code]
        return by_code or [each for each in self._known if self.sought in each.words.upper()]

    def on_key(self, event: Key) -> None:
        """Narrow the list to the people with the typed characters; Escape shows all again, and who
        was chosen before.
        """
        typed = (event.character or "").upper()
        if event.key == "escape" and self.sought:
            sought = ""
        elif event.key == "backspace" and self.sought:
            sought = self.sought[:-1]
        elif self._known and len(typed) == 1 and (typed.isalnum() or typed in "-_"):
            sought = self.sought + typed
        else:
            return
        event.stop()
        event.prevent_default()
        before, self.sought = self.sought, sought
        if len(sought) > len(before) and not self._found():
            self.sought = before
            self.app.bell()
            return
        if event.key == "escape":
            self._list(self._before)
        else:
            self._list(self.code if not self.sought else self._best())

    def _best(self) -> str | None:
        """Return the first code that begins with what was typed; without one, the first found."""
        found = [each.code for each in self._found()]
        return next(
            (code for code in found if code.startswith(self.sought)), next(iter(found), None)
        )


def _said(entry: "Entry", width: int, trained_width: int) -> Content:
    """Return what is said of a person in a line: why they are there, and behind it, where there is
    room, when they trained.
    """
    if not entry.why:
        return Content.styled(entry.trained, "$text-muted").truncate(width, ellipsis=True)
    why = Content.styled(entry.why, "$warning" if entry.part == "look" else "")
    why_width = width - trained_width - len(_GAP)
    if why_width < _WIDE:
        return why.truncate(width, ellipsis=True)
    why = why.truncate(why_width, ellipsis=True, pad=True)
    return Content.assemble(why, _GAP, (entry.trained, "$text-muted"))
