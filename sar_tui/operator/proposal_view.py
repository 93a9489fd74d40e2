"""The strip of proposals: the one that is to be decided, how long there is, and those behind it."""

from textual.content import Content

from sar_tui.framework.clock import SECOND
from sar_tui.framework.messages import Action, PendingApproval, Proposal
from sar_tui.operator.event_log import short
from sar_tui.operator.keymap import DEEDS, key_name
from sar_tui.operator.own_file import KeymapFile
from sar_tui.operator.palette import MODES, RULED
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import Piece, bar, cut, two_lines

_TONES = {"positive": "$success", "neutral": "$neutral", "negative": "$warning"}
_RANKS: dict[str, int] = {"feedback": 0, "encouragement": 1, "instruction": 2, "difficulty": 3, "gesture": 4}
_TOGETHER = SECOND // 2
"""Proposals that are due within so much of each other were made together."""
_SIMPLE = ("approve", "veto", "edit")
_BUTTONS = ("approve", "veto", "edit", "positive", "neutral", "negative")


def in_order(waiting: tuple[PendingApproval, ...]) -> tuple[PendingApproval, ...]:
    """What presses first: the earlier deadline; of those that are due together, what has to be read most carefully."""
    timed = sorted((offer for offer in waiting if offer.deadline is not None), key=lambda offer: offer.deadline or 0)
    ranks: dict[str, tuple[int, int]] = {}
    group, begins = 0, 0
    for offer in timed:
        if (offer.deadline or 0) - begins > _TOGETHER:
            group, begins = group + 1, offer.deadline or 0
        ranks[offer.proposal.id] = (group, _RANKS.get(offer.proposal.kind, len(_RANKS)))
    last = (group + 1, 0)
    return tuple(sorted(waiting, key=lambda offer: ranks.get(offer.proposal.id, last)))


def title(offer: PendingApproval, number: int, count: int, to: str) -> str:
    """What stands above a proposal: its kind, whom it is for, its valence, and its mode."""
    proposal = offer.proposal
    parts = [proposal.kind.upper() + to, *filter(None, (proposal.valence, proposal.degree)), offer.mode]
    return " · ".join(parts) + (f" · {number} of {count}" if count > 1 else "")


def says(proposal: Proposal | Action, level: int | None) -> str:
    """A proposal in words, as it would be said or done."""
    if level is not None:
        return f"{proposal.text or f'Level {level}'}, from the next attempt on"
    text = proposal.text or proposal.spoken
    return f"“{text}”" if text else f"[{(proposal.gesture or proposal.tone or proposal.face).replace('_', ' ')}]"


def left(offer: PendingApproval, now: int) -> str:
    """How long there is to decide, and what happens then."""
    if offer.deadline is None:
        return "waits for you, until the next attempt begins"
    seconds = max(0, offer.deadline - now) / SECOND
    if seconds == 0:
        return "its time is over"
    return f"{'acts by itself' if offer.otherwise == 'act' else 'is dropped'} in {seconds:.1f} s"


def body(offer: PendingApproval, now: int, given: int | None, width: int) -> Content:
    """The words, and the time that is left.

    Args:
        offer: what waits.
        now: on the session's clock (ns).
        given: how long there was to decide when it was first seen (ns).
        width: characters in a line.
    """
    words = two_lines(says(offer.proposal, offer.level), width)
    time = left(offer, now)
    style = f"{_TONES.get(offer.proposal.valence or '', '$foreground')} bold"
    parts: list[Piece] = [(words, style), ("\n", "")]
    if offer.deadline is None or not given:
        return Content.assemble(*parts, (time, "$accent bold"))
    full, empty = bar((offer.deadline - now) / given, width - 27)
    urgent = "$warning" if offer.deadline - now < SECOND else "$accent"
    return Content.assemble(*parts, (full, urgent), (empty, "$text-muted"), (f"  {time}", f"{urgent} bold"))


def buttons(file: KeymapFile, *, has_words: bool) -> Content:
    """The keys that decide."""
    parts: list[Piece] = []
    for deed in DEEDS:
        if deed.id in _BUTTONS and (has_words or deed.id in _SIMPLE):
            style = "bold reverse" if deed.id == "approve" else "bold"
            key = key_name(file.keys_of(deed)[0])
            parts += [(f" {key} ", f"$accent {style}"), (f" {deed.short.lower()} " if deed.id in _SIMPLE else "", "")]
    parts.append((" other face, same words", "") if has_words else ("", ""))
    return Content.assemble(*parts)


def decides(mirror: SessionState, file: KeymapFile) -> Content:
    """In place of those keys, who has them, for those who only see it."""
    if mirror.welcome and mirror.welcome.role == "observer":
        return Content.assemble(("You watch.", "$text-muted"))
    baton = next(deed for deed in DEEDS if deed.id == "baton")
    takes = f"{key_name(file.keys_of(baton)[0])} takes the baton."
    return Content.assemble((f"{short(mirror.holder)} decides; {takes}", "$text-muted"))


def on_its_way(mirror: SessionState) -> Action | None:
    """What is decided, and is held back until its time has come."""
    queued = mirror.standing.queued if mirror.standing and mirror.is_connected else ()
    return next((each for each in queued if each.due), None)


def gone(offer: PendingApproval, width: int) -> Content:
    """A proposal that is edited, and no longer waits; what can be done with the words."""
    has_words = offer.level is None and offer.proposal.text
    what = "Enter twice says your words all the same, Esc leaves them." if has_words else "Esc leaves it."
    words = two_lines(says(offer.proposal, offer.level), width)
    return Content.assemble(
        (words, "$text-muted"), ("\n", ""), (cut(f"Nothing was sent. {what}", width), "$warning bold")
    )


def quiet(mirror: SessionState, loss: str, now: int, width: int, leave_key: str) -> Content:
    """What stands there while nothing waits: why, if the link is down or nothing would ever come."""
    if mirror.ended:
        report = " For the report: sar-tui report wizard last"
        return Content.assemble((f"The session is done. {leave_key} leaves.", "bold"), (report, "$text-muted"))
    if loss:
        return Content.assemble((two_lines(loss, width), "$warning bold"))
    if mirror.standing is None:
        return Content.assemble(("What the agent proposes is not known yet.", "$text-muted"))
    if (action := on_its_way(mirror)) and action.due > now:
        words = two_lines(f"Nothing waits. The {action.kind} is decided: {says(action, None)}", width)
        return Content.assemble((words, ""), (f"\ngoes out in {(action.due - now) / SECOND:.1f} s", "$accent bold"))
    if all(mode == "autonomous" for mode in mirror.standing.modes.values()):
        return Content.assemble(("Nothing waits: the agent decides everything by itself.", "$text-muted"))
    whom = "you" if mirror.steers else short(mirror.holder) or "an operator"
    return Content.assemble((f"Nothing waits for {whom}.", "$text-muted"))


def behind(offers: tuple[PendingApproval, ...], chosen: PendingApproval | None, now: int, width: int) -> str:
    """The other proposals, on one line, each with its time."""
    others = [f"{_time(o, now)}{o.proposal.kind} {says(o.proposal, o.level)}" for o in offers if o is not chosen]
    return cut(f"Behind it: {' · '.join(others)}", width) if others else ""


def _time(offer: PendingApproval, now: int) -> str:
    return "" if offer.deadline is None else f"{max(0, offer.deadline - now) / SECOND:.0f} s "


def modes(mirror: SessionState, width: int) -> str:
    """Who decides, by mode; what the agent decides by itself is not listed."""
    if mirror.standing is None:
        return "modes not known yet"
    of = mirror.standing.modes
    kinds = {mode: [kind for kind in RULED if of.get(kind) == mode] for mode in MODES}
    told = [f"{mode}: {', '.join(kinds[mode])}" for mode in MODES[1:] if kinds[mode]]
    rest = ["the rest: autonomous" if told else "all: autonomous"] if kinds["autonomous"] else []
    return cut(" · ".join((*told, *rest)), width)
