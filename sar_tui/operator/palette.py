"""Pages of the palette, and the act of each of their numbers."""

from typing import Any, Literal, NamedTuple

import msgspec

from sar_tui.loop.bus import Topic
from sar_tui.loop.topics import COMMAND, DECISION, MODE, REMARK
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
from sar_tui.operator.keymap import KeymapFile
from sar_tui.operator.phrases import Filled, addressed, addressee, fill, slot_values, theme_phrases
from sar_tui.operator.session_state import SessionState

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
        log_text: describes its act in the log.
        topic, message: its act; None if it cannot be chosen now.
        why: reason why it cannot be chosen.
        is_current: True if it is under way.
    """

    text: str
    log_text: str = ""
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
        own = {"Yours": list(file.own_phrases)} if file.phrases else {}
        return cls({**own, **(theme_phrases(state.theme) if state.theme else {})})


def pages(state: SessionState, book: PhraseBook, seat: str) -> list[Page]:
    """Return all pages in order, as of now."""
    values = slot_values(state, seat)
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
        found.append(Page("phrases", "Phrases", (), "The theme's phrases are not known yet."))
    return [*found, _gestures(state, seat), _marks(state), _modes(state), _queue(state)]


def _phrase(filled: Filled, state: SessionState, seat: str) -> Item:
    if filled.missing:
        return Item(filled.text, why=f"{{{filled.missing}}} is not known yet")
    remark = msgspec.structs.replace(
        filled.phrase.remark(addressed(state, seat, filled.text)), seat=seat
    )
    return Item(filled.text, f"Said{addressee(state, seat)} “{filled.text}”", REMARK, remark)


def _gestures(state: SessionState, seat: str) -> Page:
    names = list(state.theme.gestures)[:PER_PAGE] if state.theme else []
    items = [
        Item(title, f"Gesture: {title}", REMARK, Remark(gesture=name, source="gesture", seat=seat))
        for name in names
        for title in [name.replace("_", " ")]
    ]
    return Page("gestures", "Gestures", tuple(items), "The theme's gestures are not known yet.")


def _marks(state: SessionState) -> Page:
    marks = state.welcome.marks[:PER_PAGE] if state.welcome else ()
    items = [
        Item(
            mark.title,
            f"Marked: {mark.title.lower()}",
            COMMAND,
            SessionCommand(command="mark", reason=mark.name),
        )
        for mark in marks
    ]
    return Page("marks", "Marks", tuple(items), "This task has no marks.")


def _modes(state: SessionState) -> Page:
    modes = state.arbiter.modes if state.arbiter else {}
    items = []
    for kind in CONTROLLED_KINDS:
        if mode := modes.get(kind):
            after = MODES[(MODES.index(mode) + 1) % len(MODES)]
            log_text, change = f"{kind.capitalize()}: {after}", ModeChanged(kind=kind, mode=after)
            items.append(Item(f"{kind}: {mode}, {_MEANINGS[mode]}", log_text, MODE, change))
    return Page(
        "modes", "Modes: a number changes one", tuple(items), "The modes are not known yet."
    )


def _queue(state: SessionState) -> Page:
    arbiter = state.arbiter
    queued = [(action, False) for action in arbiter.queued] if arbiter else []
    current = [(arbiter.current, True)] if arbiter and arbiter.current else []
    items = [
        Item(
            _action(action),
            f"Cancelled {action.kind}",
            DECISION,
            Decision(action=action.id, verdict="veto"),
            is_current=is_current,
        )
        for action, is_current in (*current, *queued)
    ]
    return Page(
        "queue",
        "Queue: a number cancels one",
        tuple(items[:PER_PAGE]),
        "Nothing is under way or queued.",
    )


def _action(action: Action) -> str:
    said = (
        f"“{action.text or action.spoken}”"
        if action.text or action.spoken
        else action.gesture or action.tone
    )
    return f"{action.kind} {said}"
