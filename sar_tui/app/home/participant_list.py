"""The list of the day: people in sections, each with why they are there. Typing finds a person."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

from textual.content import Content
from textual.events import Resize
from textual.widgets.option_list import Option

from sar_tui.app.code_list import BESIDE, CodeList, code_cell, code_width
from sar_tui.model.language import Language

if TYPE_CHECKING:
    from sar_tui.app.home.day import Entry

_NEW = "+"
_GAP = "  "
_WIDE = 26
"""Fewest columns of why a person is there, with those of when they trained behind them."""


class ParticipantList(CodeList):
    """People, each with what the day says of them, and a last line to add one."""

    def __init__(self, **how: Any) -> None:
        super().__init__(**how)
        self._entries: dict[str, Entry] = {}

    def on_mount(self) -> None:
        self.border_title = self.app.tr("People")

    def fill(self, known: "Sequence[Entry]", chosen: str | None) -> None:
        """List people, with one of them chosen."""
        self._entries = {each.code: each for each in known}
        words = {each.code: each.words.upper() for each in known}
        self.list_people(words, self._in_sections, chosen)

    @property
    def entry(self) -> "Entry | None":
        """The entry of the day on the chosen participant."""
        return self._entries.get(self.code or "")

    def is_new(self, option: Option) -> bool:
        """Return True for the line that adds a participant."""
        return option.id == _NEW

    def choose_new(self) -> None:
        """Choose the line that adds a participant."""
        self.choose(_NEW)

    # --- drawing

    def draw(self, chosen: str | None) -> None:
        """List the people in sections, with one of them chosen."""
        super().draw(chosen)
        if self.highlighted == 1:
            self.scroll_home(animate=False)  # the heading above it is shown, too
        tr, count = self.app.tr, len(self._entries)
        self.border_title = tr("{count} people", count=count) if count > 1 else tr("People")
        self.border_subtitle = self.find_words(tr("type to find · + adds"))

    def _in_sections(self, codes: Sequence[str]) -> Iterator[Option]:
        from sar_tui.app.home.day import heading

        tr: Language = self.app.tr
        entries = [self._entries[code] for code in codes]
        columns = code_width(codes)
        width = self.content_size.width - BESIDE - columns - len(_GAP)
        trained_width = max((len(each.trained) for each in entries if each.why), default=0)
        above = ""
        for part, group in groupby(entries, key=lambda each: each.part):
            members = list(group)
            title = Content.styled(heading(part, tr), "bold $text-muted")
            if part == "look":
                title = Content.styled(f"! {heading(part, tr)} · {len(members)}", "bold $warning")
            yield Option(Content(above) + title, disabled=True)
            for each in members:
                code = code_cell(each.code, columns)
                said = _said(each, width, trained_width)
                yield Option(Content.assemble(code, _GAP, said), id=each.code)
            above = "\n"
        if entries:
            yield Option("", disabled=True)
        yield Option(tr("+ New participant"), id=_NEW)

    def on_resize(self, event: Resize) -> None:
        """Fit the lines into another width."""
        if not self.is_empty:
            self.draw(self.chosen)


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
