"""Acts that an operator's keys send to the session, or the reasons why none is sent. No screen."""

import secrets
from collections.abc import Set
from typing import Any, Literal, NamedTuple

from msgspec.structs import replace

from sar_tui.link.peer import Connection, Peer, PeerEvent, Welcome
from sar_tui.link.presence import needs_control
from sar_tui.loop.bus import Topic
from sar_tui.loop.marks import TrialMark
from sar_tui.loop.topics import (
    COMMAND,
    DECISION,
    MODE,
    NOTE_ADDED,
    PROPOSAL_SEEN,
    REASON,
    REMARK,
)
from sar_tui.model.language import ENGLISH, Language
from sar_tui.model.messages import (
    Decision,
    Message,
    Mode,
    ModeChanged,
    NoteAdded,
    PendingApproval,
    ProposalSeen,
    ReasonGiven,
    Remark,
    SessionCommand,
    Valence,
)
from sar_tui.model.units import MS, SECOND
from sar_tui.operator.act_log import (
    ActLog,
    Wait,
    Wording,
    command_wording,
    decision_wording,
    note_wording,
    said_wording,
    same,
)
from sar_tui.operator.event_text import in_line, short_name
from sar_tui.operator.palette import MODES, Item
from sar_tui.operator.phrases import addressed, addressee_code, fill_slots, not_known, slot_values
from sar_tui.operator.session_state import SessionState

TOO_SOON = 150 * MS
"""Nobody reads and answers a proposal faster: an earlier key was meant for the proposal before."""

CONFIRM_SECONDS = 3
"""Time for the second key that ends a pause made by the participant."""
REASON_FOR = 10 * SECOND
"""Time in which a digit gives the reason for a veto or an edit."""
_RANKS: dict[str, int] = {
    "feedback": 0,
    "encouragement": 1,
    "instruction": 2,
    "difficulty": 3,
    "gesture": 4,
}
_TOGETHER = SECOND // 2
"""Proposals whose deadlines are this close were made together."""


class AskedReason(NamedTuple):
    """A veto or an edit, by the id of its action and its time (ns), whose reason is asked."""

    action: str
    verdict: Literal["veto", "edit"]
    at: int


class Commands:
    """One operator's commands: knows the session's state, sends acts through the peer, keeps the
    log.

    Methods that take ``at``, the key's time stamp (ns, session clock), return True if an act was
    sent.

    Args:
        tr: language of the panel.

    Attributes:
        state: the session as this panel knows it.
        peer: the link, once it is made.
        log: acts of this operator.
        shown: id of the proposal that keys apply to, and since when (ns) it is on the screen.
        control_key: label of the key that takes control.
    """

    def __init__(self, tr: Language = ENGLISH) -> None:
        self.tr = tr
        self.state = SessionState(tr)
        self.peer: Peer | None = None
        self.log = ActLog(tr)
        self._painted: dict[str, ProposalSeen] = {}
        self._reported: set[str] = set()
        self.shown: tuple[str, int] = ("", 0)
        self.control_key = ""
        self._mode_before_hold: Mode | None = None
        self._resume_asked_at = 0
        self._mark_asked = (TrialMark(), "")
        self._asked: AskedReason | None = None

    def receive(self, event: PeerEvent) -> None:
        """Handle an event of the link."""
        self.state = self.state.receive(event)
        if isinstance(event, Welcome):
            self.log.rejoined()
        if isinstance(event, Connection) and event.state != "connected":
            is_over = event.state == "ended"
            why = "the session is over" if is_over else "the connection was lost"
            self.log.lose_answers(self.tr(why))
        if isinstance(event, list) and self.state.welcome:
            for frame in event:
                self.log.receive(frame, self.state.welcome)
            self._report_painted({each.proposal.id for each in self.pending})

    @property
    def pending(self) -> tuple[PendingApproval, ...]:
        """Proposals that wait for an operator, most urgent first; none while the link is down."""
        state = self.state
        return by_urgency(state.arbiter.pending) if state.arbiter and state.is_connected else ()

    def refusal(self, act: Message | None = None) -> str:
        """Return why an act would be refused; empty if it would be accepted. Without one, any that
        needs control.
        """
        state, tr = self.state, self.tr
        if not state.is_connected:
            return tr("There is no connection.")
        if act and not needs_control(act):
            return ""
        if state.welcome and state.welcome.role == "observer":
            return tr("You are an observer: you can only stop the agent.")
        if state.has_control:
            return ""
        text = tr("{who} has control; {key} takes it.")
        return text.format(who=short_name(state.holder), key=self.control_key)

    # --- proposals

    def report_seen(self, approval: PendingApproval, at: int) -> None:
        """Note that a proposal is on the screen, and report it once if this operator may decide on
        it.
        """
        if self.shown[0] != approval.proposal.id:  # a slow screen may report it twice
            self.shown = (approval.proposal.id, at)
        if approval.proposal.id not in self._painted:
            pending = {each.proposal.id for each in self.pending}
            self._painted = {id: seen for id, seen in self._painted.items() if id in pending}
            self._painted[approval.proposal.id] = ProposalSeen(
                action=approval.proposal.id, seat=approval.proposal.seat, at=at
            )
            self._reported &= pending
        self._report_painted({approval.proposal.id})

    def _report_painted(self, ids: Set[str]) -> None:
        """Report proposals that are or were on the screen, if this operator may decide on them
        now.
        """
        if self.peer and not self.refusal():
            for id in (ids & self._painted.keys()) - self._reported:
                self._reported.add(id)
                self.peer.send(PROPOSAL_SEEN, self._painted[id])

    def decide(
        self, approval: PendingApproval, verdict: Literal["accept", "veto"], at: int
    ) -> bool:
        """Approve or veto a proposal."""
        decision = Decision(action=approval.proposal.id, verdict=verdict)
        return self._send_decision(approval, decision, at)

    def change_valence(self, approval: PendingApproval, valence: Valence, at: int) -> bool:
        """Send a proposal with the face, gesture and tone of another valence."""
        decision = Decision(action=approval.proposal.id, verdict="edit", valence=valence)
        return self._send_decision(approval, decision, at)

    def edit(self, approval: PendingApproval, text: str, at: int) -> bool:
        """Send a proposal with another text, gesture or level. Unchanged, it is approved."""
        text = text.strip()
        if text == editable(approval, self.state):
            return self.decide(approval, "accept", at)
        decision = Decision(action=approval.proposal.id, verdict="edit")
        if approval.level is not None:
            if not text.isdecimal():
                why = self.tr("A level is a number, not {text!r}.").format(text=text)
                return self._not_sent(why, at)
            if not self._is_level(int(text), at):
                return False
            decision = replace(decision, level=int(text))
        elif approval.proposal.text:
            filled = self.fill(text, approval.proposal.seat, at)
            if not filled:
                return False
            has_name = approval.proposal.text != editable(approval, self.state)
            full = addressed(self.state, approval.proposal.seat, filled) if has_name else filled
            decision = replace(decision, text=full)
        elif self.state.theme and text.replace(" ", "_") not in self.state.theme.gestures:
            why = self.tr("The theme has no gesture {text!r}.").format(text=text)
            return self._not_sent(why, at)
        else:
            decision = replace(decision, gesture=text.replace(" ", "_"))
        return self._send_decision(approval, decision, at, typed=text)

    def _send_decision(
        self, approval: PendingApproval, decision: Decision, at: int, typed: str = ""
    ) -> bool:
        if self.log.deciding(decision.action):
            return False
        shown, since = self.shown
        if shown != decision.action or at - since < TOO_SOON:
            why = self.tr("Too soon: that proposal had only just appeared.")
            return self._not_sent(why, at)
        wording = decision_wording(decision, approval.proposal.kind, self.tr)
        decision = replace(decision, seat=approval.proposal.seat)
        return self.send(wording, DECISION, decision, at, typed)

    # --- reasons

    def asked_reason(self, now: int) -> AskedReason | None:
        """Return the veto or edit whose reason a digit would give now, if there is one."""
        asked = self._asked
        return asked if asked and self.state.protocol and now - asked.at <= REASON_FOR else None

    def give_reason(self, code: int, at: int) -> bool:
        """Give the reason that a digit stands for."""
        asked, protocol = self.asked_reason(at), self.state.protocol
        if asked is None or protocol is None:
            return False
        reason = next((each for each in protocol.reasons if each.code == code), None)
        if reason is None:
            return self._not_sent(self.tr("There is no reason {code}.", code=code), at)
        given = ReasonGiven(
            action=asked.action, verdict=asked.verdict, digit=code, text=reason.text
        )
        wording = same(self.tr("Reason: {text}").format(text=self.tr(reason.text)))
        return self.send(wording, REASON, given, at)

    def forget_reason(self) -> None:
        """Ask for no reason any more."""
        self._asked = None

    # --- the session

    def command(self, command: Any, at: int, wording: Wording | None = None, **more: Any) -> bool:
        """Send a command to the session (see `SessionCommand`). ``wording``: for the log, if it has
        no usual one.
        """
        act = SessionCommand(command=command, **more)
        return self.send(wording or command_wording(act, self.tr), COMMAND, act, at)

    def prompt_command(self, command: Literal["skip", "repeat"], at: int) -> bool:
        """Skip or repeat the prompt that is shown or about to appear; skip a question, or a rest
        that must be taken.
        """
        waiting, tr = self.state.waiting, self.tr
        if waiting and waiting.step and command == "skip":
            if waiting.step.step.required and not self.refusal():
                why = tr("Nobody else can answer that: the session waits for it.")
                return self._not_sent(why, at)
            step = Wording(tr("Skipped the step"), tr("Skipping the step"))
            wording = None if waiting.step.step.is_question else step
            return self.command(command, at, wording, reason="step", value=waiting.step.number)
        if waiting and waiting.stage == "rest" and command == "skip":
            return self.command(command, at, reason="rest")
        if waiting and waiting.stage != "trial" and not self.refusal():
            return self._not_sent(tr("No prompt is shown."), at)
        return self.command(command, at)

    def may_resume(self, at: int) -> bool:
        """Return True if the pause key takes effect: it must be pressed twice to end a
        participant's pause.

        A key that is held down or bounces counts once.
        """
        if not self.state.is_their_pause or self.refusal():
            return True
        since, self._resume_asked_at = at - self._resume_asked_at, at
        if TOO_SOON <= since <= CONFIRM_SECONDS * SECOND:
            self._resume_asked_at = 0
            return True
        return False

    def pause(self, at: int) -> bool:
        """Pause the session, or resume it."""
        if self.state.is_paused:
            return self.command("resume", at)
        return self.command("pause", at)

    def level(self, step: int, at: int) -> bool:
        """Raise or lower the level of the next attempt."""
        state = self.state
        sent = self.log.last_open(lambda act: getattr(act, "command", "") == "level")
        level = sent.message.value if sent else state.next_level or state.level
        if level is None:
            return self._not_sent(self.tr("The level is not known yet."), at)
        if not self._is_level(level + step, at):
            return False
        text = self.tr("Level {previous} → {level}", previous=level, level=level + step)
        return self.command("level", at, same(text), value=level + step)

    def set_level(self, level: int, at: int) -> bool:
        """Set the level of the next attempt."""
        if not self._is_level(level, at):
            return False
        return self.command("level", at, same(self.tr("Level {level}", level=level)), value=level)

    def _is_level(self, level: int, at: int) -> bool:
        """Return True if the session can have a level; else log the nearest one that it can
        have.
        """
        welcome = self.state.welcome
        parameters, levels = (welcome.parameters, welcome.levels) if welcome else ({}, 1)
        least, most = (
            int(parameters.get("min_level", 1)),
            min(levels, int(parameters.get("max_level", levels))),
        )
        if least <= level <= most:
            return True
        if level < least:
            return self._not_sent(self.tr("Level {level} is the lowest level.", level=least), at)
        return self._not_sent(self.tr("Level {level} is the highest level.", level=most), at)

    def hold(self, at: int) -> bool:
        """Let only the operator change the level, or restore the mode that was set before."""
        state = self.state
        mode = state.arbiter.modes.get("difficulty") if state.arbiter else None
        if mode != "manual":
            self._mode_before_hold = mode
            change = ModeChanged(kind="difficulty", mode="manual")
            return self.send(same(self.tr("Level held")), MODE, change, at)
        planned = state.welcome.parameters.get("operator_difficulty") if state.welcome else None
        usual: Mode = planned if planned in MODES and planned != "manual" else "autonomous"
        before = self._mode_before_hold or usual
        wording = same(self.tr("Level: {mode}", mode=self.tr(before)))
        return self.send(wording, MODE, ModeChanged(kind="difficulty", mode=before), at)

    # --- speech and notes

    def pick(self, item: Item, at: int) -> bool:
        """Send the act of a palette item."""
        if item.topic is None:
            self.log.report(at, self.tr("Not said: {why}.", why=item.why))
            return False
        if isinstance(item.message, SessionCommand) and item.message.command == "mark":
            return self._mark(item, item.message.reason, at)
        return self.send(item.wording, item.topic, item.message, at)

    def _mark(self, item: Item, name: str, at: int) -> bool:
        """Mark the trial. Another mark is replaced only if the key is pressed twice for the same
        trial.
        """
        now, tr = self.state.trial_mark, self.tr
        if now.present not in ("", name) and self._mark_asked != (now, name) and not self.refusal():
            self._mark_asked = now, name
            marks = self.state.welcome.marks if self.state.welcome else ()
            titles = {mark.name: mark.title for mark in marks}
            present = in_line(titles.get(now.present, now.present), tr)
            text = tr("Marked as {present} already. The same key again: {mark} instead.")
            self.log.report(at, text.format(present=present, mark=in_line(item.text, tr)))
            return False
        self._mark_asked = (TrialMark(), "")
        return self.send(item.wording, COMMAND, item.message, at)

    def say(self, text: str, seat: str, at: int) -> bool:
        """Have the agent say a typed text."""
        filled = self.fill(text, seat, at)
        if not filled:
            return False
        remark = Remark(text=addressed(self.state, seat, filled), source="free text", seat=seat)
        wording = said_wording(filled, addressee_code(self.state, seat), self.tr)
        return self.send(wording, REMARK, remark, at, text)

    def fill(self, text: str, seat: str, at: int) -> str:
        """Return a typed text with its slots filled; empty if a value is not known yet."""
        filled, missing = fill_slots(text, slot_values(self.state, seat))
        if missing:
            self._not_sent(f"{not_known(missing, self.tr)}.", at)
            return ""
        return filled

    def _when(self) -> Wait:
        """Return what a remark waits for."""
        if self.state.is_quiet:
            return "response"
        return "pause" if self.state.is_paused else ""

    def note(self, text: str, at: int) -> bool:
        """Add a note to the record."""
        note = NoteAdded(text=text)
        return self.send(note_wording(note, self.tr), NOTE_ADDED, note, at, text)

    def event(self, label: str, at: int) -> bool:
        """Add an event mark to the record."""
        event = NoteAdded(label=label)
        return self.send(note_wording(event, self.tr), NOTE_ADDED, event, at)

    # --- sending

    def send(
        self, wording: Wording, topic: Topic[Any], message: Any, at: int, typed: str = ""
    ) -> bool:
        """Send an act, or log why not. ``wording``: for the log; ``typed``: what the operator typed
        for it.
        """
        if reason := self.refusal(message):
            return self._not_sent(reason, at)
        if self.peer is None or self.state.welcome is None:
            return False
        id = secrets.token_hex(8)
        act = replace(message, actor=self.state.welcome.name, at=at, id=id)
        self.log.add(wording, topic, act, self._when() if topic is REMARK else "", typed)
        self.peer.send(topic, act)
        self._asked = (
            AskedReason(act.action, act.verdict, at)
            if topic is DECISION and act.verdict != "accept" and self.state.protocol
            else None
        )
        return True

    def _not_sent(self, why: str, at: int) -> Literal[False]:
        """Log why an act was not sent: a sentence."""
        self.log.report(at, f"{why} {self.tr('Nothing was sent.')}")
        return False


def takes_valence(approval: PendingApproval) -> bool:
    """Return True if a proposal has words, so that it can be sent with another valence."""
    return approval.level is None and bool(approval.proposal.text)


def editable(approval: PendingApproval, state: SessionState) -> str:
    """Return the part of a proposal that can be edited: its level, its text without the name, or
    its gesture.
    """
    if approval.level is not None:
        return str(approval.level)
    name = addressed(state, approval.proposal.seat, "")
    return approval.proposal.text.removeprefix(name) or approval.proposal.gesture.replace("_", " ")


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
