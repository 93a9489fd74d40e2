"""What an operator's keys mean: each is an act for the session, or a sentence on why there is none. No screen."""

from typing import Any, Literal

from msgspec.structs import replace

from sar_tui.framework.bus import Topic
from sar_tui.framework.clock import MS, SECOND
from sar_tui.framework.messages import (
    ActRefused,
    Decision,
    Mode,
    ModeChanged,
    NoteAdded,
    Operator,
    PendingApproval,
    ProposalSeen,
    Remark,
    Valence,
)
from sar_tui.framework.topics import DECISION, MODE, NOTE_ADDED, OPERATOR, PROPOSAL_SEEN, REMARK
from sar_tui.link.peer import Peer, PeerEvent, Welcome
from sar_tui.operator import proposal_view
from sar_tui.operator.event_log import SLOW, ActLog, short
from sar_tui.operator.palette import MODES, Item
from sar_tui.operator.phrases import addressed, addressee, fill_slots, slot_values
from sar_tui.operator.session_state import SessionState

TOO_SOON = 150 * MS
"""Nobody reads and answers a proposal faster: a key that comes sooner was meant for the one before."""

CONFIRM_SECONDS = 3
"""So soon a pause that the participant made has to be ended by a second key."""


class Commands:
    """One operator, at work: knows the state, sends acts by the peer, keeps the log.

    ``control_key``: with which the baton is taken, as it is called.
    ``painted``: the proposals that have stood on the screen. ``stands``: the one that keys are about, by its id, and
    since when (ns) it stands there.
    Each method takes ``at``, the stamp of the key (ns, on the session's clock), and says whether something was sent.
    """

    def __init__(self) -> None:
        self.state = SessionState()
        self.peer: Peer | None = None
        self.log = ActLog()
        self.painted: set[str] = set()
        self.shown: tuple[str, int] = ("", 0)
        self._sent_decisions: dict[str, tuple[str, int]] = {}
        self._held_from: Mode | None = None
        self._resume_asked_at = 0
        self.control_key = ""

    def receive(self, event: PeerEvent) -> None:
        """What came over the link."""
        self.state = self.state.receive(event)
        if isinstance(event, Welcome):
            self._sent_decisions = {}
        if isinstance(event, list) and self.state.welcome:
            for frame in event:
                self.log.receive(frame, self.state.welcome.name)
                if isinstance(frame.message, ActRefused) and frame.message.actor == self.state.welcome.name:
                    self._sent_decisions = {}

    @property
    def pending(self) -> tuple[PendingApproval, ...]:
        """What waits for an operator, as far as is known, what presses first; nothing while the link is down."""
        state = self.state
        return proposal_view.by_urgency(state.arbiter.pending) if state.arbiter and state.is_connected else ()

    def refusal(self) -> str:
        """Why an act would not be heeded; empty where it would."""
        state = self.state
        if not state.is_connected:
            return "There is no connection."
        if state.welcome and state.welcome.role == "observer":
            return "You watch: only operators act."
        return "" if state.has_control else f"{short(state.holder)} has the baton; {self.control_key} takes it."

    def sent_decision(self, id: str) -> str:
        """What was sent about a proposal that still waits; empty where nothing was, or it seems not to have arrived."""
        words, at = self._sent_decisions.get(id, ("", 0))
        return words if words and self.peer and self.peer.now() - at < SLOW else ""

    # --- proposals -------------------------------------------------------------------------------------------

    def report_seen(self, approval: PendingApproval, at: int) -> None:
        """A proposal has been painted as the one that keys are about. Told once, by whoever may decide on it."""
        self.shown = (approval.proposal.id, at)
        if approval.proposal.id not in self.painted:
            waiting = {each.proposal.id for each in self.pending}
            self.painted = (self.painted & waiting) | {approval.proposal.id}
            self._sent_decisions = {id: ruled for id, ruled in self._sent_decisions.items() if id in waiting}
            if self.peer and not self.refusal():
                seen = ProposalSeen(action=approval.proposal.id, seat=approval.proposal.seat, at=at)
                self.peer.send(PROPOSAL_SEEN, seen)

    def decide(self, approval: PendingApproval, verdict: Literal["accept", "veto"], at: int) -> bool:
        """Approve or veto."""
        words = "Approved" if verdict == "accept" else "Vetoed"
        return self._send_decision(words, approval, Decision(action=approval.proposal.id, verdict=verdict), at)

    def change_valence(self, approval: PendingApproval, valence: Valence, at: int) -> bool:
        """Send it with another valence: the face, gesture and tone are that one's."""
        return self._send_decision(
            f"With a {valence} face, words as they were:",
            approval,
            Decision(action=approval.proposal.id, verdict="edit", valence=valence),
            at,
        )

    def edit(self, approval: PendingApproval, text: str, at: int) -> bool:
        """Send it in other words, with another gesture, or at another level. Unchanged, it is approved."""
        text = text.strip()
        if text == editable(approval, self.state):
            return self.decide(approval, "accept", at)
        decision = Decision(action=approval.proposal.id, verdict="edit")
        if approval.level is not None:
            if not text.isdecimal():
                self.log.report(at, f"A level is a number, not {text!r}. Nothing was sent.")
                return False
            decision = replace(decision, level=int(text))
        elif approval.proposal.text:
            said = self._in_full(text, approval.proposal.seat, at)
            if not said:
                return False
            named = approval.proposal.text != editable(approval, self.state)
            decision = replace(decision, text=addressed(self.state, approval.proposal.seat, said) if named else said)
        elif self.state.theme and text.replace(" ", "_") not in self.state.theme.gestures:
            self.log.report(at, f"The theme has no gesture {text!r}. Nothing was sent.")
            return False
        else:
            decision = replace(decision, gesture=text.replace(" ", "_"))
        return self._send_decision("Edited", approval, decision, at)

    def _send_decision(self, words: str, approval: PendingApproval, decision: Decision, at: int) -> bool:
        if self.sent_decision(decision.action):
            return False
        stands, since = self.shown
        if stands != decision.action or at - since < TOO_SOON:
            self.log.report(at, "Too soon: that proposal had only just come. Nothing was sent.")
            return False
        words = f"{words} {approval.proposal.kind}"
        sent = self.send(words, DECISION, replace(decision, seat=approval.proposal.seat), at)
        if sent:
            self._sent_decisions[decision.action] = (words, at)
        return sent

    # --- the session -------------------------------------------------------------------------------------------

    def command(self, words: str, command: Any, at: int, **more: Any) -> bool:
        """An act that steers the session (see `Operator`)."""
        return self.send(words, OPERATOR, Operator(command=command, **more), at)

    def prompt_command(self, words: str, command: Literal["skip", "repeat"], at: int) -> bool:
        """An act on the prompt that is up, or about to come."""
        waiting = self.state.waiting
        if waiting and waiting.stage != "trial" and not self.refusal():
            self.log.report(at, "No prompt is up. Nothing was sent.")
            return False
        return self.command(words, command, at)

    def may_resume(self, at: int) -> bool:
        """Whether the key for a pause is heeded: a pause that is the participant's is only ended by two of them.

        A key that is held down, or bounces, is one.
        """
        if not self.state.is_their_pause or self.refusal():
            return True
        since, self._resume_asked_at = at - self._resume_asked_at, at
        if TOO_SOON <= since <= CONFIRM_SECONDS * SECOND:
            self._resume_asked_at = 0
            return True
        return False

    def pause(self, at: int) -> bool:
        """Pause; or go on, if it is paused."""
        if self.state.is_paused:
            return self.command("Went on", "resume", at)
        return self.command("Paused", "pause", at)

    def level(self, step: int, at: int) -> bool:
        """So many levels up or down, from the next attempt on."""
        state = self.state
        level = self._level_sent() or state.next_level or state.level
        if level is None:
            self.log.report(at, "The level is not known yet. Nothing was sent.")
            return False
        parameters, levels = (state.welcome.parameters, state.welcome.levels) if state.welcome else ({}, 1)
        least, most = int(parameters.get("min_level", 1)), min(levels, int(parameters.get("max_level", levels)))
        if not least <= level + step <= most:
            self.log.report(at, f"Level {level} is the {'highest' if step > 0 else 'lowest'} there is.")
            return False
        return self.command(f"Level {level} → {level + step}", "level", at, value=level + step)

    def _level_sent(self) -> int | None:
        """The level that was sent last and is on its way."""
        on_its_way = [act for act in self.log.acts if act.topic == OPERATOR.name and act.is_pending]
        return next((act.message.value for act in reversed(on_its_way) if act.message.command == "level"), None)

    def hold(self, at: int) -> bool:
        """Nobody but the operator changes the level from here on; or, again, as it was before."""
        state = self.state
        mode = state.arbiter.modes.get("difficulty") if state.arbiter else None
        if mode != "manual":
            self._held_from = mode
            return self.send("Level held", MODE, ModeChanged(kind="difficulty", mode="manual"), at)
        usual = state.welcome.parameters.get("operator_difficulty") if state.welcome else None
        before: Mode = self._held_from or (usual if usual in MODES and usual != "manual" else "autonomous")
        return self.send(f"Level: {before}", MODE, ModeChanged(kind="difficulty", mode=before), at)

    # --- words ---------------------------------------------------------------------------------------------------

    def pick(self, item: Item, at: int) -> bool:
        """What a number of the palette stands for."""
        if item.topic is None:
            self.log.report(at, f"Not said: {item.why}.")
            return False
        return self.send(self._when(item.words) if item.topic is REMARK else item.words, item.topic, item.message, at)

    def say(self, text: str, seat: str, at: int) -> bool:
        """Free text."""
        said = self._in_full(text, seat, at)
        if not said:
            return False
        remark = Remark(text=addressed(self.state, seat, said), source="free text", seat=seat)
        return self.send(self._when(f"Said{addressee(self.state, seat)} “{said}”"), REMARK, remark, at)

    def _in_full(self, text: str, seat: str, at: int) -> str:
        """What was typed, with its slots filled; empty where there is nothing yet to fill one with."""
        filled, missing = fill_slots(text, slot_values(self.state, seat))
        if missing:
            self.log.report(at, f"{{{missing}}} is not known yet. Nothing was sent.")
            return ""
        return filled

    def _when(self, words: str) -> str:
        """What the log calls words or a gesture: they wait while a response is awaited, and in a pause."""
        if self.state.is_quiet:
            return f"After the response: {words[0].lower()}{words[1:]}"
        if self.state.is_paused:
            return f"After the pause: {words[0].lower()}{words[1:]}"
        return words

    def note(self, text: str, at: int) -> bool:
        """A note, for the record."""
        return self.send(f"Noted “{text}”", NOTE_ADDED, NoteAdded(text=text), at)

    def event(self, label: str, at: int) -> bool:
        """An event mark, for the record."""
        return self.send(f"Event: {label}", NOTE_ADDED, NoteAdded(label=label), at)

    # --- sending ---------------------------------------------------------------------------------------------------

    def send(self, words: str, topic: Topic[Any], message: Any, at: int) -> bool:
        """Send an act, or say why not."""
        if refusal := self.refusal():
            self.log.report(at, f"{refusal} Nothing was sent.")
            return False
        if self.peer is None or self.state.welcome is None:
            return False
        act = replace(message, actor=self.state.welcome.name, at=at)
        self.log.add(words, topic, act)
        self.peer.send(topic, act)
        return True


def takes_valence(approval: PendingApproval) -> bool:
    """Whether it can be sent as a positive, neutral or negative one: words can, a level or a gesture cannot."""
    return approval.level is None and bool(approval.proposal.text)


def editable(approval: PendingApproval, state: SessionState) -> str:
    """What of a proposal can be typed anew: its level, its words but for whom they call, or its gesture."""
    if approval.level is not None:
        return str(approval.level)
    called = addressed(state, approval.proposal.seat, "")
    return approval.proposal.text.removeprefix(called) or approval.proposal.gesture.replace("_", " ")
