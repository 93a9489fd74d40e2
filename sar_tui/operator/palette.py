"""The palette: its pages, the act of each of their numbers, and the page that is open."""

from typing import Any, Literal, NamedTuple

import msgspec
from rich.cells import set_cell_size
from textual.content import Content

from sar_tui.loop.bus import Topic
from sar_tui.loop.topics import COMMAND, DECISION, MODE, REMARK
from sar_tui.model.language import Language
from sar_tui.model.messages import (
    Action,
    ControlledKind,
    Decision,
    Message,
    Mode,
    ModeChanged,
    Remark,
    SessionCommand,
)
from sar_tui.operator.act_log import (
    Wording,
    cancelled_wording,
    gesture_wording,
    mark_wording,
    mode_wording,
    said_wording,
)
from sar_tui.operator.keymap import KeymapFile
from sar_tui.operator.phrases import (
    Filled,
    addressed,
    addressee_code,
    fill,
    not_known,
    slot_values,
    theme_phrases,
)
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import Piece, cut

PER_PAGE = 10
CONTROLLED_KINDS: tuple[ControlledKind, ...] = (
    "feedback",
    "encouragement",
    "instruction",
    "gesture",
    "difficulty",
)
MODES: tuple[Mode, ...] = ("autonomous", "veto", "approve", "manual")
_MEANINGS: dict[Mode, str] = {
    "autonomous": "the agent decides",
    "veto": "the agent acts unless you stop it in time",
    "approve": "you decide",
    "manual": "only you act",
}
Kind = Literal["phrases", "gestures", "marks", "modes", "queue"]


class Item(NamedTuple):
    """Item of a page.

    Attributes:
        text: shown beside its number.
        wording: texts of its act in the log.
        topic, message: its act; None if it cannot be chosen now.
        why: reason why it cannot be chosen.
        is_current: True if it is under way.
    """

    text: str
    wording: Wording = Wording("", "")
    topic: Topic[Any] | None = None
    message: Message | None = None
    why: str = ""
    is_current: bool = False


class Page(NamedTuple):
    """Page of at most ten items. ``empty``: shown if there are none."""

    kind: Kind
    title: str
    items: tuple[Item, ...]
    empty: str = ""


class PhraseBook(NamedTuple):
    """Phrases by heading."""

    headings: dict[str, list[Any]]

    @classmethod
    def of(cls, state: SessionState, file: KeymapFile) -> "PhraseBook":
        """Return the operator's own phrases, then those of the active theme."""
        own = {state.tr("Yours"): list(file.own_phrases)} if file.phrases else {}
        return cls({**own, **(theme_phrases(state.theme, state.tr) if state.theme else {})})


def pages(state: SessionState, book: PhraseBook, seat: str) -> list[Page]:
    """Return all pages in order, as of now."""
    values, tr = slot_values(state, seat), state.tr
    found: list[Page] = []
    for heading, phrases in book.headings.items():
        for begin in range(0, len(phrases), PER_PAGE):
            filled = [fill(phrase, values) for phrase in phrases[begin : begin + PER_PAGE]]
            more = f" {begin // PER_PAGE + 1}" if len(phrases) > PER_PAGE else ""
            found.append(
                Page(
                    "phrases", heading + more, tuple(_phrase(each, state, seat) for each in filled)
                )
            )
    if not found:
        empty = tr("The theme's phrases are not known yet.")
        found.append(Page("phrases", tr("Phrases"), (), empty))
    return [*found, _gestures(state, seat), _marks(state), _modes(state), _queue(state)]


def _phrase(filled: Filled, state: SessionState, seat: str) -> Item:
    if filled.missing:
        return Item(filled.text, why=not_known(filled.missing, state.tr))
    text = filled.text
    remark = msgspec.structs.replace(filled.phrase.remark(addressed(state, seat, text)), seat=seat)
    return Item(text, said_wording(text, addressee_code(state, seat), state.tr), REMARK, remark)


def _gestures(state: SessionState, seat: str) -> Page:
    tr = state.tr
    names = list(state.theme.gestures)[:PER_PAGE] if state.theme else []
    items = [
        Item(
            name.replace("_", " "),
            gesture_wording(name, tr),
            REMARK,
            Remark(gesture=name, source="gesture", seat=seat),
        )
        for name in names
    ]
    empty = tr("The theme's gestures are not known yet.")
    return Page("gestures", tr("Gestures"), tuple(items), empty)


def _marks(state: SessionState) -> Page:
    tr = state.tr
    marks = state.welcome.marks[:PER_PAGE] if state.welcome else ()
    items = [
        Item(
            tr(mark.title),
            mark_wording(mark.title, tr),
            COMMAND,
            SessionCommand(command="mark", reason=mark.name),
        )
        for mark in marks
    ]
    return Page("marks", tr("Marks"), tuple(items), tr("This task has no marks."))


def _modes(state: SessionState) -> Page:
    tr = state.tr
    modes = state.arbiter.modes if state.arbiter else {}
    items = []
    for kind in CONTROLLED_KINDS:
        if mode := modes.get(kind):
            after = MODES[(MODES.index(mode) + 1) % len(MODES)]
            change = ModeChanged(kind=kind, mode=after)
            text = f"{tr(kind)}: {tr(mode)}, {tr(_MEANINGS[mode])}"
            items.append(Item(text, mode_wording(change, tr), MODE, change))
    title, empty = tr("Modes: a number changes one"), tr("The modes are not known yet.")
    return Page("modes", title, tuple(items), empty)


def _queue(state: SessionState) -> Page:
    tr, arbiter = state.tr, state.arbiter
    queued = [(action, False) for action in arbiter.queued] if arbiter else []
    current = [(arbiter.current, True)] if arbiter and arbiter.current else []
    items = [
        Item(
            _action(action, tr),
            cancelled_wording(action.kind, tr),
            DECISION,
            Decision(action=action.id, verdict="veto"),
            is_current=is_current,
        )
        for action, is_current in (*current, *queued)
    ]
    title, empty = tr("Queue: a number cancels one"), tr("Nothing is under way or queued.")
    return Page("queue", title, tuple(items[:PER_PAGE]), empty)


def _action(action: Action, tr: Language) -> str:
    kind = tr(action.kind)
    if text := action.text or action.spoken:
        return tr("{kind} “{text}”").format(kind=kind, text=text)
    return f"{kind} {action.gesture or action.tone}"


class Palette:
    """The open page of the palette, and the participant that its acts are for.

    Args:
        file: the operator's own phrases.
    """

    def __init__(self, file: KeymapFile) -> None:
        self._file = file
        self._book = PhraseBook({})
        self._open: tuple[str, str] = ("", "")
        self.seat = "A"

    def use_theme(self, state: SessionState) -> None:
        """Take over the phrases of the session's theme."""
        self._book = PhraseBook.of(state, self._file)

    def find(self, state: SessionState) -> tuple[Page, int, int]:
        """Return the open page, its index and the number of pages."""
        found = pages(state, self._book, self.seat)
        names = [(page.kind, page.title) for page in found]
        index = names.index(self._open) if self._open in names else 0
        return found[index], index, len(found)

    def turn(self, state: SessionState, step: int) -> None:
        """Open another page, so many pages further."""
        found = pages(state, self._book, self.seat)
        page = found[(self.find(state)[1] + step) % len(found)]
        self._open = (page.kind, page.title)

    def open(self, state: SessionState, kind: str) -> None:
        """Open the first page of a kind."""
        page = next(p for p in pages(state, self._book, self.seat) if p.kind == kind)
        self._open = (page.kind, page.title)

    def close(self) -> None:
        """Go back to the first page."""
        self._open = ("", "")

    def take_next_seat(self, state: SessionState) -> None:
        """Turn to the next participant."""
        names = sorted(state.welcome.participants if state.welcome else ())
        if self.seat in names:
            self.seat = names[(names.index(self.seat) + 1) % len(names)]
        elif names:
            self.seat = names[0]


def palette_page(page: Page, width: int, rows: int) -> Content:
    """Return a page of the palette, in two columns if one is too short."""
    if not page.items:
        return Content.assemble((page.empty, "$text-muted"))
    is_wide = len(page.items) > rows
    column = width // 2 - 1 if is_wide else width
    parts: list[Piece] = []
    for row in range(min(rows, len(page.items))):
        for index in (row, row + rows) if is_wide else (row,):
            if index < len(page.items):
                parts += _item(
                    page.items[index], (index + 1) % 10, column, pads=is_wide and index == row
                )
        parts.append(("\n", ""))
    return Content.assemble(*parts[:-1])


def _item(item: Item, number: int, width: int, *, pads: bool) -> list[Piece]:
    text = cut(f"{'▶ ' if item.is_current else ''}{item.text}", width - 3)
    style = "$text-muted" if item.topic is None else ""
    return [
        (f"{number} ", "$accent bold"),
        (f"{set_cell_size(text, width - 1)} " if pads else text, style),
    ]
