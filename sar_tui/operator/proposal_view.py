"""The strip of proposals: the one that is to be decided, how long there is, and those behind it."""

from textual.content import Content

from sar_tui.framework.clock import SECOND
from sar_tui.framework.messages import Action, PendingApproval, Proposal
from sar_tui.operator.event_log import short
from sar_tui.operator.keymap import KEY_COMMANDS, KeymapFile, key_name
from sar_tui.operator.palette import CONTROLLED_KINDS, MODES
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import Piece, bar, cut, two_lines

_TONES = {"positive": "$success", "neutral": "$neutral", "negative": "$warning"}
_RANKS: dict[str, int] = {"feedback": 0, "encouragement": 1, "instruction": 2, "difficulty": 3, "gesture": 4}
_TOGETHER = SECOND // 2
"""Proposals that are due within so much of each other were made together."""
_SIMPLE = ("approve", "veto", "edit")
_DECISION_KEYS = ("approve", "veto", "edit", "positive", "neutral", "negative")


def by_urgency(waiting: tuple[PendingApproval, ...]) -> tuple[PendingApproval, ...]:
    """What presses first: the earlier deadline; of those that are due together, what has to be read most carefully."""
    timed = sorted(
        (approval for approval in waiting if approval.deadline is not None), key=lambda approval: approval.deadline or 0
    )
    ranks: dict[str, tuple[int, int]] = {}
    group, begins = 0, 0
    for approval in timed:
        if (approval.deadline or 0) - begins > _TOGETHER:
            group, begins = group + 1, approval.deadline or 0
        ranks[approval.proposal.id] = (group, _RANKS.get(approval.proposal.kind, len(_RANKS)))
    last = (group + 1, 0)
    return tuple(sorted(waiting, key=lambda approval: ranks.get(approval.proposal.id, last)))


def title(approval: PendingApproval, number: int, count: int, to: str) -> str:
    """What stands above a proposal: its kind, whom it is for, its valence, and its mode."""
    proposal = approval.proposal
    parts = [proposal.kind.upper() + to, *filter(None, (proposal.valence, proposal.degree)), approval.mode]
    return " · ".join(parts) + (f" · {number} of {count}" if count > 1 else "")


def proposal_text(proposal: Proposal | Action, level: int | None) -> str:
    """A proposal in words, as it would be said or done."""
    if level is not None:
        return f"{proposal.text or f'Level {level}'}, from the next attempt on"
    text = proposal.text or proposal.spoken
    return f"“{text}”" if text else f"[{(proposal.gesture or proposal.tone or proposal.face).replace('_', ' ')}]"


def time_left(approval: PendingApproval, now: int) -> str:
    """How long there is to decide, and what happens then."""
    if approval.deadline is None:
        return "waits for you, until the next attempt begins"
    seconds = max(0, approval.deadline - now) / SECOND
    if seconds == 0:
        return "its time is over"
    return f"{'acts by itself' if approval.otherwise == 'act' else 'is dropped'} in {seconds:.1f} s"


def body(approval: PendingApproval, now: int, given: int | None, width: int) -> Content:
    """The words, and the time that is left.

    Args:
        approval: what waits.
        now: on the session's clock (ns).
        given: how long there was to decide when it was first seen (ns).
        width: characters in a line.
    """
    words = two_lines(proposal_text(approval.proposal, approval.level), width)
    time = time_left(approval, now)
    style = f"{_TONES.get(approval.proposal.valence or '', '$foreground')} bold"
    parts: list[Piece] = [(words, style), ("\n", "")]
    if approval.deadline is None or not given:
        return Content.assemble(*parts, (time, "$accent bold"))
    full, empty = bar((approval.deadline - now) / given, width - 27)
    urgent = "$warning" if approval.deadline - now < SECOND else "$accent"
    return Content.assemble(*parts, (full, urgent), (empty, "$text-muted"), (f"  {time}", f"{urgent} bold"))


def decision_keys(file: KeymapFile, *, has_words: bool) -> Content:
    """The keys that decide."""
    parts: list[Piece] = []
    for key_command in KEY_COMMANDS:
        if key_command.id in _DECISION_KEYS and (has_words or key_command.id in _SIMPLE):
            style = "bold reverse" if key_command.id == "approve" else "bold"
            key = key_name(file.keys_of(key_command)[0])
            parts += [
                (f" {key} ", f"$accent {style}"),
                (f" {key_command.short.lower()} " if key_command.id in _SIMPLE else "", ""),
            ]
    parts.append((" other face, same words", "") if has_words else ("", ""))
    return Content.assemble(*parts)


def control_hint(state: SessionState, file: KeymapFile) -> Content:
    """In place of those keys, who has them, for those who only see it."""
    if state.welcome and state.welcome.role == "observer":
        return Content.assemble(("You watch.", "$text-muted"))
    baton = next(key_command for key_command in KEY_COMMANDS if key_command.id == "baton")
    takes = f"{key_name(file.keys_of(baton)[0])} takes the baton."
    return Content.assemble((f"{short(state.holder)} decides; {takes}", "$text-muted"))


def scheduled_action(state: SessionState) -> Action | None:
    """What is decided, and is held back until its time has come."""
    queued = state.arbiter.queued if state.arbiter and state.is_connected else ()
    return next((each for each in queued if each.due), None)


def expired_edit(approval: PendingApproval, width: int) -> Content:
    """A proposal that is edited, and no longer waits; what can be done with the words."""
    has_words = approval.level is None and approval.proposal.text
    what = "Enter twice says your words all the same, Esc leaves them." if has_words else "Esc leaves it."
    words = two_lines(proposal_text(approval.proposal, approval.level), width)
    return Content.assemble(
        (words, "$text-muted"), ("\n", ""), (cut(f"Nothing was sent. {what}", width), "$warning bold")
    )


def nothing_pending(state: SessionState, loss: str, now: int, width: int, leave_key: str) -> Content:
    """What stands there while nothing waits: why, if the link is down or nothing would ever come."""
    if state.ended:
        report = " For the report: sar-tui report wizard last"
        return Content.assemble((f"The session is done. {leave_key} leaves.", "bold"), (report, "$text-muted"))
    if loss:
        return Content.assemble((two_lines(loss, width), "$warning bold"))
    if state.arbiter is None:
        return Content.assemble(("What the agent proposes is not known yet.", "$text-muted"))
    if (action := scheduled_action(state)) and action.due > now:
        words = two_lines(f"Nothing waits. The {action.kind} is decided: {proposal_text(action, None)}", width)
        return Content.assemble((words, ""), (f"\ngoes out in {(action.due - now) / SECOND:.1f} s", "$accent bold"))
    if all(mode == "autonomous" for mode in state.arbiter.modes.values()):
        return Content.assemble(("Nothing waits: the agent decides everything by itself.", "$text-muted"))
    whom = "you" if state.has_control else short(state.holder) or "an operator"
    return Content.assemble((f"Nothing waits for {whom}.", "$text-muted"))


def other_proposals(offers: tuple[PendingApproval, ...], chosen: PendingApproval | None, now: int, width: int) -> str:
    """The other proposals, on one line, each with its time."""
    others = [
        f"{_time(o, now)}{o.proposal.kind} {proposal_text(o.proposal, o.level)}" for o in offers if o is not chosen
    ]
    return cut(f"Behind it: {' · '.join(others)}", width) if others else ""


def _time(approval: PendingApproval, now: int) -> str:
    return "" if approval.deadline is None else f"{max(0, approval.deadline - now) / SECOND:.0f} s "


def mode_summary(state: SessionState, width: int) -> str:
    """Who decides, by mode; what the agent decides by itself is not listed."""
    if state.arbiter is None:
        return "modes not known yet"
    of = state.arbiter.modes
    kinds = {mode: [kind for kind in CONTROLLED_KINDS if of.get(kind) == mode] for mode in MODES}
    told = [f"{mode}: {', '.join(kinds[mode])}" for mode in MODES[1:] if kinds[mode]]
    rest = ["the rest: autonomous" if told else "all: autonomous"] if kinds["autonomous"] else []
    return cut(" · ".join((*told, *rest)), width)
