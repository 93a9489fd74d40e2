"""The palette: what a number does, on each of its pages."""

from typing import Any, Literal, NamedTuple

import msgspec

from sar_tui.framework.bus import Topic
from sar_tui.framework.messages import Action, ControlledKind, Decision, Message, Mode, ModeChanged, Operator, Remark
from sar_tui.framework.topics import DECISION, MODE, OPERATOR, REMARK
from sar_tui.operator.keymap import KeymapFile
from sar_tui.operator.phrases import Filled, addressed, addressee, fill, slot_values, theme_phrases
from sar_tui.operator.session_state import SessionState

PER_PAGE = 10
CONTROLLED_KINDS: tuple[ControlledKind, ...] = ("feedback", "encouragement", "instruction", "gesture", "difficulty")
MODES: tuple[Mode, ...] = ("autonomous", "veto", "approve", "manual")
_MEANS: dict[Mode, str] = {
    "autonomous": "the agent decides",
    "veto": "the agent acts, unless you stop it in time",
    "approve": "you decide",
    "manual": "only you act",
}
Kind = Literal["phrases", "gestures", "marks", "modes", "queue"]


class Item(NamedTuple):
    """What stands beside a number, what is sent when it is chosen, and how the log calls that.

    ``why``: why it cannot be chosen now; then nothing is sent.
    """

    text: str
    words: str = ""
    topic: Topic[Any] | None = None
    message: Message | None = None
    why: str = ""
    now: bool = False


class Page(NamedTuple):
    """A page: what it is called, and its numbers. ``empty`` says what there would be."""

    kind: Kind
    title: str
    items: tuple[Item, ...]
    empty: str = ""


class PhraseBook(NamedTuple):
    """The phrases there are, by heading."""

    headings: dict[str, list[Any]]

    @classmethod
    def of(cls, state: SessionState, file: KeymapFile) -> "PhraseBook":
        """The operator's own first, then those of the theme that is worn."""
        own = {"Yours": list(file.own_phrases)} if file.phrases else {}
        return cls({**own, **(theme_phrases(state.theme) if state.theme else {})})


def pages(state: SessionState, words: PhraseBook, seat: str) -> list[Page]:
    """All pages as they stand now, in their order."""
    values = slot_values(state, seat)
    found: list[Page] = []
    for heading, phrases in words.headings.items():
        for begin in range(0, len(phrases), PER_PAGE):
            filled = [fill(phrase, values) for phrase in phrases[begin : begin + PER_PAGE]]
            more = f" {begin // PER_PAGE + 1}" if len(phrases) > PER_PAGE else ""
            found.append(Page("phrases", heading + more, tuple(_phrase(each, state, seat) for each in filled)))
    if not found:
        found.append(Page("phrases", "Phrases", (), "The theme's phrases are not known yet."))
    return [*found, _gestures(state, seat), _marks(state), _modes(state), _queue(state)]


def _phrase(filled: Filled, state: SessionState, seat: str) -> Item:
    if filled.missing:
        return Item(filled.text, why=f"{{{filled.missing}}} is not known yet")
    remark = msgspec.structs.replace(filled.phrase.remark(addressed(state, seat, filled.text)), seat=seat)
    return Item(filled.text, f"Said{addressee(state, seat)} “{filled.text}”", REMARK, remark)


def _gestures(state: SessionState, seat: str) -> Page:
    names = list(state.theme.gestures)[:PER_PAGE] if state.theme else []
    items = [
        Item(called, f"Gesture: {called}", REMARK, Remark(gesture=name, source="gesture", seat=seat))
        for name in names
        for called in [name.replace("_", " ")]
    ]
    return Page("gestures", "Gestures", tuple(items), "The theme's gestures are not known yet.")


def _marks(state: SessionState) -> Page:
    marks = state.welcome.marks[:PER_PAGE] if state.welcome else ()
    items = [
        Item(mark.title, f"Marked: {mark.title.lower()}", OPERATOR, Operator(command="mark", reason=mark.name))
        for mark in marks
    ]
    return Page("marks", "Marks", tuple(items), "This task has no marks.")


def _modes(state: SessionState) -> Page:
    modes = state.arbiter.modes if state.arbiter else {}
    items = []
    for kind in CONTROLLED_KINDS:
        if mode := modes.get(kind):
            after = MODES[(MODES.index(mode) + 1) % len(MODES)]
            words, chosen = f"{kind.capitalize()}: {after}", ModeChanged(kind=kind, mode=after)
            items.append(Item(f"{kind}: {mode}, {_MEANS[mode]}", words, MODE, chosen))
    return Page("modes", "Modes: a number changes", tuple(items), "The modes are not known yet.")


def _queue(state: SessionState) -> Page:
    arbiter = state.arbiter
    waiting = [(action, False) for action in arbiter.queued] if arbiter else []
    current = [(arbiter.current, True)] if arbiter and arbiter.current else []
    items = [
        Item(_action(action), f"Cancelled {action.kind}", DECISION, Decision(action=action.id, verdict="veto"), now=now)
        for action, now in (*current, *waiting)
    ]
    return Page("queue", "Queue: a number cancels", tuple(items[:PER_PAGE]), "Nothing is under way or waits its turn.")


def _action(action: Action) -> str:
    said = f"“{action.text or action.spoken}”" if action.text or action.spoken else action.gesture or action.tone
    return f"{action.kind} {said}"
