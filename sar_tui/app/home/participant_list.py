"""The list of participants. Typing a code narrows it."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from textual.content import Content
from textual.events import Key, Resize
from textual.widgets.option_list import Option

from sar_tui.widgets.lists import MarkedList

if TYPE_CHECKING:
    from sar_tui.app.home.contents import Waiting

_NEW = "+"
_HINT = "type to find"


class ParticipantList(MarkedList):
    """Participants, each with why they are marked, and a last line to add one.

    Attributes:
        sought: the part of a code that was typed.
    """

    def __init__(self, **how: Any) -> None:
        super().__init__(markup=False, **how)
        self._known: Sequence[Waiting] = ()
        self.sought = ""
        self.border_title = "Who"

    def fill(self, known: "Sequence[Waiting]", chosen: str | None) -> None:
        """List participants, with one of them chosen."""
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
    def is_empty(self) -> bool:
        """True if nobody is known yet."""
        return not self._known

    def is_new(self, option: Option) -> bool:
        """Return True for the line that adds a participant."""
        return option.id == _NEW

    def _list(self, chosen: str | None) -> None:
        found = [each for each in self._known if self.sought in each.code]
        found.sort(key=lambda each: not each.code.startswith(self.sought))
        self.clear_options()
        self.add_options([Option(self._line(each), id=each.code) for each in found])
        self.add_option(Option("+ New participant", id=_NEW))
        self.choose(chosen)
        if self._known:
            self.border_subtitle = f"find: {self.sought} (Esc)" if self.sought else _HINT

    def _line(self, each: "Waiting") -> Content:
        width = max(8, self.content_size.width - 2)
        if not each.waits:
            return Content(each.code).truncate(width, ellipsis=True)
        code = Content(each.code).truncate(max(3, width - len(each.waits) - 2), ellipsis=True)
        return Content.assemble(code, "  ", (each.waits, "$warning"))

    def on_resize(self, event: Resize) -> None:
        """Fit the lines into another width."""
        if self._known:
            self._list(self.chosen)

    def on_key(self, event: Key) -> None:
        """Narrow the list to the codes with the typed characters; Escape shows all again, and who
        was chosen before.
        """
        typed = (event.character or "").upper()
        if event.key == "escape" and self.sought:
            sought = ""
        elif event.key == "backspace" and self.sought:
            sought = self.sought[:-1]
        elif (
            self._known
            and len(typed) == 1
            and typed.isascii()
            and (typed.isalnum() or typed in "-_")
        ):
            sought = self.sought + typed
        else:
            return
        event.stop()
        event.prevent_default()
        before, self.sought = self.sought, sought
        if len(sought) > len(before) and not any(sought in each.code for each in self._known):
            self.sought = before
            self.app.bell()
            return
        if event.key == "escape":
            self._list(self._before)
        else:
            self._list(self.code if not self.sought else self._best())

    def _best(self) -> str | None:
        """Return the first code that begins with what was typed, or contains it."""
        found = [each.code for each in self._known if self.sought in each.code]
        return next(
            (code for code in found if code.startswith(self.sought)), next(iter(found), None)
        )
