"""A simulated operator, who reads proposals and decides on them according to a profile. Seeded."""

from collections.abc import Callable
from functools import partial

import msgspec

from sar_tui.loop.clock import Handle
from sar_tui.loop.node import Node, on
from sar_tui.loop.topics import (
    ACTION,
    ATTEMPT_ENDED,
    COMMAND,
    DECIDED,
    DECISION,
    DROPPED,
    LEVEL_DECIDED,
    NOTE_ADDED,
    PENDING_APPROVAL,
    PRESENCE,
    PROPOSAL_SEEN,
    REMARK,
    SESSION,
    SESSION_ENDED,
    THEME,
)
from sar_tui.model import messages as m
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.simulation.participant_model import ex_gaussian

NAME = "operator.simulated"
PAINTING = 30 * MS
"""Time until a pending proposal is on the operator's screen."""
TOO_LATE_TO_STOP = 200 * MS
"""A key press due within this time happens even if the proposal is gone: about the stop-signal
reaction time of healthy adults (Logan & Cowan 1984).
"""


class OperatorProfile(msgspec.Struct, frozen=True):
    """Model of someone who decides on proposals.

    A decision takes the time to read (``ms_per_word``) and then to choose, which is ex-Gaussian
    like other choice times (Luce 1986; see `simulation.participant_model`). Reading every word
    takes 252 ms a word on average (238 words a minute, Brysbaert 2019); an operator knows the texts
    and only recognises them. The values are assumptions: we know of no study of operators.

    Args:
        name: ``careful``, ``hasty`` or ``absent``.
        ms_per_word: reading time.
        mean_ms: mean of the choice time.
        sigma_ms: standard deviation of its normal part.
        tau_ms: mean of its exponential tail, part of the mean.
        vetoes: share of proposals meant to be vetoed.
        edits: share meant to be edited.
        slips: share of decisions made with the wrong key.
        misses: share of proposals without a decision.
        remarks: share of attempts followed by a remark.
        notes: share followed by a note.
        levels: share followed by a level set by hand.
        leaves: share followed by an absence.
        away_s: mean duration of an absence.
    """

    name: str
    ms_per_word: float
    mean_ms: float
    sigma_ms: float
    tau_ms: float
    vetoes: float
    edits: float
    slips: float
    misses: float
    remarks: float = 0.1
    notes: float = 0.1
    levels: float = 0.03
    leaves: float = 0.0
    away_s: float = 0.0

    def reaction_ms(self, text: str, streams: RandomStreams) -> float:
        """Return the time from seeing a proposal to the key; at least 150 ms."""
        generator = streams.generator("reaction", self.name)
        choice_ms = ex_gaussian(generator, self.mean_ms, self.sigma_ms, self.tau_ms)
        return max(150.0, self.ms_per_word * len(text.split()) + choice_ms)

    def verdict(self, streams: RandomStreams) -> str:
        """Return the decision on a proposal: ``accept``, ``veto``, ``edit`` or ``miss``."""
        if streams.uniform("miss", self.name) < self.misses:
            return "miss"
        drawn = streams.uniform("verdict", self.name)
        meant = (
            "veto"
            if drawn < self.vetoes
            else "edit"
            if drawn < self.vetoes + self.edits
            else "accept"
        )
        if streams.uniform("slip", self.name) < self.slips:
            return streams.choice(
                [verdict for verdict in ("accept", "veto", "edit") if verdict != meant], "slipped"
            )
        return meant


PROFILES = {
    profile.name: profile
    for profile in (
        OperatorProfile(
            "careful",
            90,
            700,
            120,
            250,
            vetoes=0.08,
            edits=0.12,
            slips=0.01,
            misses=0.01,
            notes=0.2,
        ),
        OperatorProfile(
            "hasty", 25, 380, 80, 120, vetoes=0.1, edits=0.02, slips=0.08, misses=0.04, notes=0.02
        ),
        OperatorProfile(
            "absent",
            90,
            900,
            200,
            500,
            vetoes=0.05,
            edits=0.08,
            slips=0.02,
            misses=0.2,
            leaves=0.25,
            away_s=40.0,
        ),
    )
}
"""``careful`` reads everything and errs little, ``hasty`` decides before reading, ``absent`` comes
and goes.
"""


class SimulatedOperator(Node):
    """Operator who joins at the session's start and decides on one proposal after the other.

    Its acts are drawn from the seed and the proposal's id or the attempt: the same seed gives the
    same session.
    """

    name = "operator"
    emits = (DECISION, NOTE_ADDED, COMMAND, PRESENCE, REMARK, PROPOSAL_SEEN)

    def __init__(self, profile: OperatorProfile, seed: int) -> None:
        super().__init__()
        self._profile = profile
        self._seed = seed
        self._theme: Theme
        self._is_here = False
        self._has_ended = False
        self._busy_until = 0
        self._pending: dict[str, tuple[int, Handle]] = {}

    @property
    def _time(self) -> int:
        """Time of the clock, also between cascades."""
        return self.bus.clock.now()

    @on(THEME)
    def theme_applied(self, applied: m.ThemeApplied) -> None:
        """Keep the theme, whose phrases its remarks use."""
        self._theme = applied.theme

    @on(SESSION)
    def session_started(self, _: m.SessionStarted) -> None:
        self._join()

    @on(SESSION_ENDED)
    def session_ended(self, _: m.SessionEnded) -> None:
        """Stop acting after attempts: only the goodbye is left."""
        self._has_ended = True

    @on(PENDING_APPROVAL)
    def approval_pending(self, approval: m.PendingApproval) -> None:
        """Read the proposal as soon as there is time, and decide."""
        if self._is_here:
            self._schedule_decision(approval)

    @on(ACTION)
    def action_done(self, action: m.Action) -> None:
        self._drop(action.id)

    @on(DECIDED)
    def decided(self, action: m.Action) -> None:
        self._drop(action.id)

    @on(DROPPED)
    def dropped(self, dropped: m.Dropped) -> None:
        self._drop(dropped.id)

    @on(LEVEL_DECIDED)
    def level_decided(self, decided: m.LevelDecided) -> None:
        self._drop(decided.id)

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: m.AttemptEnded) -> None:
        """Sometimes make a remark, write a note, set the level or leave."""
        if not self._is_here or self._has_ended:
            return
        streams = RandomStreams(self._seed, "operator", ended.attempt, ended.seat)
        profile = self._profile
        for name, share, act in (
            ("remark", profile.remarks, lambda at: self._remark(streams, ended.seat, at)),
            ("note", profile.notes, lambda at: self._note(ended, at)),
            ("level", profile.levels, lambda at: self._set_level(ended, at)),
            ("leave", profile.leaves, lambda at: self._leave(streams)),
        ):
            if streams.uniform(name, profile.name) < share:
                self._at(self._time + round((1 + 2 * streams.uniform(name, "when")) * SECOND), act)

    # --- proposals

    def _schedule_decision(self, approval: m.PendingApproval) -> None:
        """Schedule the decision after those on earlier proposals: an operator reads one at a
        time.
        """
        id = approval.proposal.id
        if earlier := self._pending.pop(id, None):
            earlier[1].cancel()
        streams = RandomStreams(self._seed, "operator", id)
        seen = self._time + PAINTING
        self._at(
            seen, lambda at: self.emit(PROPOSAL_SEEN, m.ProposalSeen(action=id, actor=NAME, at=at))
        )
        verdict = self._profile.verdict(streams)
        if verdict == "miss":
            return
        reaction = self._profile.reaction_ms(approval.proposal.text, streams)
        due = self._busy_until = max(seen, self._busy_until) + round(reaction * MS)
        decision = self._decision(approval, verdict, streams)
        handle = self.bus.clock.call_at(
            due, lambda: self._decide(msgspec.structs.replace(decision, at=due))
        )
        self._pending[id] = due, handle

    def _decide(self, decision: m.Decision) -> None:
        self._pending.pop(decision.action, None)
        self.emit(DECISION, decision)

    def _decision(
        self, approval: m.PendingApproval, verdict: str, streams: RandomStreams
    ) -> m.Decision:
        """Return the decision. An edit adds encouragement and makes blame neutral, or lowers the
        level by one.
        """
        proposal = approval.proposal
        decide = partial(m.Decision, seat=proposal.seat, action=proposal.id, actor=NAME)
        if verdict != "edit" or (proposal.kind == "gesture" and approval.level is None):
            return decide(verdict="accept" if verdict == "accept" else "veto")
        if approval.level is not None:
            return decide(verdict="edit", level=max(1, approval.level - 1))
        addition = streams.choice(self._theme.phrases["encouragement"], "words")
        text = f"{proposal.text} {addition}".strip()
        if proposal.valence == "negative":
            return decide(verdict="edit", text=text, valence="neutral")
        return decide(verdict="edit", text=text)

    def _drop(self, id: str) -> None:
        """Cancel the decision on a proposal that no longer waits, unless it is too late to stop the
        key press.
        """
        due, handle = self._pending.get(id, (0, None))
        if handle and due - self._time > TOO_LATE_TO_STOP:
            handle.cancel()
            del self._pending[id]

    # --- own initiative

    def _remark(self, streams: RandomStreams, seat: str, at: int) -> None:
        text = streams.choice(self._theme.phrases["encouragement"], "remark", "words")
        self.emit(REMARK, m.Remark(seat=seat, text=text, valence="positive", actor=NAME, at=at))

    def _note(self, ended: m.AttemptEnded, at: int) -> None:
        text = f"Attempt {ended.attempt}: {ended.outcome}."
        self.emit(NOTE_ADDED, m.NoteAdded(seat=ended.seat, text=text, actor=NAME, at=at))

    def _set_level(self, ended: m.AttemptEnded, at: int) -> None:
        """Lower the level after a failure, raise it after a success."""
        level = ended.level + 1 if ended.outcome == "success" else max(1, ended.level - 1)
        self.emit(
            COMMAND,
            m.SessionCommand(seat=ended.seat, command="level", value=level, actor=NAME, at=at),
        )

    # --- presence

    def _join(self) -> None:
        self._is_here = True
        self._busy_until = self._time
        for state in ("joined", "baton"):  # "baton": takes control
            changed = m.OperatorChanged(
                actor=NAME, state=state, operated=True, peers={NAME: "operator"}
            )
            self.emit(PRESENCE, changed)

    def _leave(self, streams: RandomStreams) -> None:
        """Lose the connection for a while."""
        if self._has_ended or not self._is_here:
            return
        self._is_here = False
        for _, handle in self._pending.values():
            handle.cancel()
        self._pending.clear()
        why = "Nothing has been heard from the operator's program."
        self.emit(PRESENCE, m.OperatorChanged(actor=NAME, state="lost", operated=False, detail=why))
        away = streams.generator("away").expovariate(1 / self._profile.away_s)
        self.bus.clock.call_at(self._time + round(away * SECOND), self._join)

    def _at(self, when: int, act: Callable[[int], None]) -> None:
        """Act at a time, unless the operator is away by then."""

        def do() -> None:
            if self._is_here:
                act(when)

        self.bus.clock.call_at(when, do)
