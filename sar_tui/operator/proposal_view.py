"""Texts of the proposal strip: the proposal to decide on, its remaining time, the others."""

from textual.content import Content

from sar_tui.model.messages import Action, PendingApproval, Proposal
from sar_tui.model.units import SECOND
from sar_tui.operator.event_text import short_name
from sar_tui.operator.keymap import KEY_COMMANDS, KeymapFile, key_name
from sar_tui.operator.palette import CONTROLLED_KINDS, MODES
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import Piece, bar, cut, two_lines

_TONES = {"positive": "$success", "neutral": "$neutral", "negative": "$warning"}
_RANKS: dict[str, int] = {
    "feedback": 0,
    "encouragement": 1,
    "instruction": 2,
    "difficulty": 3,
    "gesture": 4,
}
_TOGETHER = SECOND // 2
"""Proposals whose deadlines are this close were made together."""
_SIMPLE = ("approve", "veto", "edit")
_DECISION_KEYS = ("approve", "veto", "edit", "positive", "neutral", "negative")


def by_urgency(pending: tuple[PendingApproval, ...]) -> tuple[PendingApproval, ...]:
    """Sort proposals by deadline; of those due together, put first what takes longest to read."""
    timed = sorted(
        (each for each in pending if each.deadline is not None), key=lambda each: each.deadline or 0
    )
    ranks: dict[str, tuple[int, int]] = {}
    group, begins = 0, 0
    for approval in timed:
        if (approval.deadline or 0) - begins > _TOGETHER:
            group, begins = group + 1, approval.deadline or 0
        ranks[approval.proposal.id] = (group, _RANKS.get(approval.proposal.kind, len(_RANKS)))
    last = (group + 1, 0)
    return tuple(sorted(pending, key=lambda approval: ranks.get(approval.proposal.id, last)))


def title(approval: PendingApproval, number: int, count: int, to: str) -> str:
    """Return a proposal's title: kind, addressee, valence, mode, changes, and its number if there
    are several.
    """
    proposal = approval.proposal
    parts = [
        proposal.kind.upper() + to,
        *filter(None, (proposal.valence, proposal.degree)),
        approval.mode,
    ]
    parts += [proposal.evidence] if proposal.evidence else []
    return " · ".join(parts) + (f" · {number} of {count}" if count > 1 else "")


def proposal_text(proposal: Proposal | Action, level: int | None) -> str:
    """Return a proposal as it would be said or done."""
    if level is not None:
        return f"{proposal.text or f'Level {level}'}, from the next attempt on"
    text = proposal.text or proposal.spoken
    return (
        f"“{text}”"
        if text
        else f"[{(proposal.gesture or proposal.tone or proposal.face).replace('_', ' ')}]"
    )


def time_left(approval: PendingApproval, now: int) -> str:
    """Return the time left to decide, and what happens then."""
    if approval.deadline is None:
        return "waits for you until the next attempt begins"
    seconds = max(0, approval.deadline - now) / SECOND
    if seconds == 0:
        return "time is up"
    return f"{'acts by itself' if approval.otherwise == 'act' else 'is dropped'} in {seconds:.1f} s"


def body(approval: PendingApproval, now: int, given: int | None, width: int) -> Content:
    """Return the text and the remaining time.

    Args:
        approval: the proposal.
        now: session clock (ns).
        given: time to decide when it was first seen (ns).
        width: length of a line, in characters.
    """
    words = two_lines(proposal_text(approval.proposal, approval.level), width)
    time = time_left(approval, now)
    style = f"{_TONES.get(approval.proposal.valence or '', '$foreground')} bold"
    parts: list[Piece] = [(words, style), ("\n", "")]
    if approval.deadline is None or not given:
        return Content.assemble(*parts, (time, "$accent bold"))
    full, empty = bar((approval.deadline - now) / given, width - 27)
    urgent = "$warning" if approval.deadline - now < SECOND else "$accent"
    return Content.assemble(
        *parts, (full, urgent), (empty, "$text-muted"), (f"  {time}", f"{urgent} bold")
    )


def decision_keys(file: KeymapFile, *, has_words: bool) -> Content:
    """Return the keys that decide."""
    parts: list[Piece] = []
    for command in KEY_COMMANDS:
        if command.id in _DECISION_KEYS and (has_words or command.id in _SIMPLE):
            style = "bold reverse" if command.id == "approve" else "bold"
            key = key_name(file.keys_of(command)[0])
            parts += [
                (f" {key} ", f"$accent {style}"),
                (f" {command.label.lower()} " if command.id in _SIMPLE else "", ""),
            ]
    parts.append((" other face, same words", "") if has_words else ("", ""))
    return Content.assemble(*parts)


def control_hint(state: SessionState, file: KeymapFile) -> Content:
    """Return the text shown instead of those keys to an operator without control, or an
    observer.
    """
    if state.welcome and state.welcome.role == "observer":
        return Content.assemble(("You are an observer.", "$text-muted"))
    control = next(command for command in KEY_COMMANDS if command.id == "control")
    key = key_name(file.keys_of(control)[0])
    return Content.assemble(
        (f"{short_name(state.holder)} decides; {key} takes control.", "$text-muted")
    )


def scheduled_action(state: SessionState) -> Action | None:
    """Return the decided action that is held back until it is due, if any."""
    queued = state.arbiter.queued if state.arbiter and state.is_connected else ()
    return next((each for each in queued if each.due), None)


def expired_edit(approval: PendingApproval, width: int) -> Content:
    """Return a proposal that is edited but no longer pending, and what can be done with the
    text.
    """
    has_words = approval.level is None and approval.proposal.text
    what = "Enter twice says it anyway, Esc discards it." if has_words else "Esc discards it."
    words = two_lines(proposal_text(approval.proposal, approval.level), width)
    return Content.assemble(
        (words, "$text-muted"),
        ("\n", ""),
        (cut(f"Nothing was sent. {what}", width), "$warning bold"),
    )


def nothing_pending(
    state: SessionState, loss: str, now: int, width: int, leave_key: str
) -> Content:
    """Return why nothing is pending: no proposal, no link, or the end of the session."""
    if state.ended:
        report = " For the report: sar-tui report wizard last"
        return Content.assemble(
            (f"The session is over. {leave_key} leaves.", "bold"), (report, "$text-muted")
        )
    if loss:
        return Content.assemble((two_lines(loss, width), "$warning bold"))
    if state.arbiter is None:
        return Content.assemble(("Proposals are not known yet.", "$text-muted"))
    if (action := scheduled_action(state)) and action.due > now:
        words = two_lines(
            f"Nothing is pending. The {action.kind} is decided: {proposal_text(action, None)}",
            width,
        )
        return Content.assemble(
            (words, ""), (f"\ngoes out in {(action.due - now) / SECOND:.1f} s", "$accent bold")
        )
    if all(mode == "autonomous" for mode in state.arbiter.modes.values()):
        return Content.assemble(
            ("Nothing is pending: the agent decides everything by itself.", "$text-muted")
        )
    who = "you" if state.has_control else short_name(state.holder) or "an operator"
    return Content.assemble((f"Nothing is pending for {who}.", "$text-muted"))


def other_proposals(
    pending: tuple[PendingApproval, ...], chosen: PendingApproval | None, now: int, width: int
) -> str:
    """Return the other proposals with their times, on one line."""
    others = [
        f"{_time(each, now)}{each.proposal.kind} {proposal_text(each.proposal, each.level)}"
        for each in pending
        if each is not chosen
    ]
    return cut(f"Also pending: {' · '.join(others)}", width) if others else ""


def _time(approval: PendingApproval, now: int) -> str:
    return "" if approval.deadline is None else f"{max(0, approval.deadline - now) / SECOND:.0f} s "


def mode_summary(state: SessionState, width: int) -> str:
    """Return the kinds of action by mode, without those that the agent decides by itself."""
    if state.arbiter is None:
        return "modes not known yet"
    of = state.arbiter.modes
    kinds = {mode: [kind for kind in CONTROLLED_KINDS if of.get(kind) == mode] for mode in MODES}
    listed = [f"{mode}: {', '.join(kinds[mode])}" for mode in MODES[1:] if kinds[mode]]
    rest = ["the rest: autonomous" if listed else "all: autonomous"] if kinds["autonomous"] else []
    return cut(" · ".join((*listed, *rest)), width)
