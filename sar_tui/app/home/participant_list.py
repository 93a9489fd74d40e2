"""The list of the day: people in sections, each with why they are there. Typing finds a person."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

from textual.content import Content
from textual.events import Resize
from textual.widgets.option_list import Option

from sar_tui.app.code_list import CodeList
from sar_tui.model.language import Language

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


class ParticipantList(CodeList):
    """People, each with what the day says of them, and a last line to add one."""

    def __init__(self, **how: Any) -> None:
        super().__init__(**how)
        self._known: Sequence[Entry] = ()

    def on_mount(self) -> None:
        self.border_title = self.app.tr("People")

    def fill(self, known: "Sequence[Entry]", chosen: str | None) -> None:
        """List people, with one of them chosen."""
        self._known = known
        if chosen and self.sought not in chosen:
            self.sought = ""
        self.draw(chosen)
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

    def draw(self, chosen: str | None) -> None:
        """List the people in sections, with one of them chosen."""
        found = self._entries()
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

    def on_resize(self, event: Resize) -> None:
        """Fit the lines into another width."""
        if self._known:
            self.draw(self.chosen)

    # --- finding

    def found(self) -> Sequence[str]:
        """Return the codes of the people that are listed."""
        return [each.code for each in self._entries()]

    def _entries(self) -> "list[Entry]":
        """Return the people whose code has what was typed; without one, those of whom it is
        said.
        """
        if not self.sought:
            return list(self._known)
        by_code = [each for each in self._known if self.sought in each.code]
        return by_code or [each for each in self._known if self.sought in each.words.upper()]


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
