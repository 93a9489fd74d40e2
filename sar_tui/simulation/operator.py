"""A simulated operator: reads what the agent proposes, and decides on it as its character would. Seeded."""

from collections.abc import Callable

import msgspec

from sar_tui.framework import messages as m
from sar_tui.framework.clock import MS, SECOND, Handle
from sar_tui.framework.node import Node, on
from sar_tui.framework.random_streams import RandomStreams
from sar_tui.framework.theme import Theme
from sar_tui.framework.topics import (
    ACTION,
    ATTEMPT_ENDED,
    DECIDED,
    DECISION,
    DROPPED,
    LEVEL_DECIDED,
    NOTE_ADDED,
    OPERATOR,
    PENDING_APPROVAL,
    PRESENCE,
    PROPOSAL_SEEN,
    REMARK,
    SESSION,
    SESSION_ENDED,
    THEME,
)
from sar_tui.simulation.ex_gaussian import ex_gaussian

NAME = "operator.simulated"
PAINTING = 30 * MS
"""From a proposal's being offered to its standing on the operator's screen."""
TOO_LATE_TO_STOP = 200 * MS
"""A key this near is pressed although the proposal has gone: about the stop-signal reaction time of healthy adults
(Logan & Cowan 1984)."""


class OperatorProfile(msgspec.Struct, frozen=True):
    """A model of someone who decides on proposals.

    A decision takes reading (``ms_per_word``), and after it a choice, whose time is ex-Gaussian like that of other
    choices (Luce 1986; see `simulation.person`). Who reads every word takes 252 ms a word on average (238 words a
    minute, Brysbaert 2019); an operator, who knows the wordings, only looks which it is. We know of no study that
    gives figures for operators: these are chosen.

    Args:
        name: what it is called: ``careful``, ``hasty``, ``absent``.
        ms_per_word: reading.
        mean_ms: mean of the choice after reading.
        sigma_ms: standard deviation of the normal part of it.
        tau_ms: mean of its exponential tail, part of the mean.
        vetoes: the share of proposals that they mean to stop.
        edits: the share that they mean to change.
        slips: the share of decisions that come out as another than was meant: the wrong key.
        misses: the share of proposals on which they do not decide.
        remarks: the share of attempts after which they say something of their own.
        notes: the share after which they write something down.
        levels: the share after which they set the level by hand.
        leaves: the share after which they are gone.
        away_s: for how long, on average.
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
        """From a proposal's being seen to the key; never below 150 ms."""
        generator = streams.generator("reaction", self.name)
        choice_ms = ex_gaussian(generator, self.mean_ms, self.sigma_ms, self.tau_ms)
        return max(150.0, self.ms_per_word * len(text.split()) + choice_ms)

    def verdict(self, streams: RandomStreams) -> str:
        """What becomes of a proposal: ``accept``, ``veto``, ``edit``, or ``miss``."""
        if streams.uniform("miss", self.name) < self.misses:
            return "miss"
        drawn = streams.uniform("verdict", self.name)
        meant = "veto" if drawn < self.vetoes else "edit" if drawn < self.vetoes + self.edits else "accept"
        if streams.uniform("slip", self.name) < self.slips:
            return streams.choice([verdict for verdict in ("accept", "veto", "edit") if verdict != meant], "slipped")
        return meant


CHARACTERS = {
    character.name: character
    for character in (
        OperatorProfile("careful", 90, 700, 120, 250, vetoes=0.08, edits=0.12, slips=0.01, misses=0.01, notes=0.2),
        OperatorProfile("hasty", 25, 380, 80, 120, vetoes=0.1, edits=0.02, slips=0.08, misses=0.04, notes=0.02),
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
"""Reads all and errs little; decides before having read; comes and goes."""


class SimulatedOperator(Node):
    """Is there from the session's beginning, and decides on one proposal after the other.

    What it does is drawn from the seed and the proposal's id, or the attempt: the same seed is the same session.

    Args:
        character, seed: who decides, and how it comes out.
    """

    name = "operator"
    emits = (DECISION, NOTE_ADDED, OPERATOR, PRESENCE, REMARK, PROPOSAL_SEEN)

    def __init__(self, character: OperatorProfile, seed: int) -> None:
        super().__init__()
        self._character = character
        self._seed = seed
        self._theme: Theme
        self._is_here = False
        self._has_ended = False
        self._busy_until = 0
        self._pending: dict[str, tuple[int, Handle]] = {}

    @property
    def _time(self) -> int:
        """The clock's, also between cascades."""
        return self.bus.clock.now()

    @on(THEME)
    def wear(self, worn: m.ThemeApplied) -> None:
        """What it says of its own are the theme's words."""
        self._theme = worn.theme

    @on(SESSION)
    def session_started(self, _: m.SessionStarted) -> None:
        self._come()

    @on(SESSION_ENDED)
    def session_ended(self, _: m.SessionEnded) -> None:
        """What is left is the goodbye."""
        self._has_ended = True

    @on(PENDING_APPROVAL)
    def offered(self, offer: m.PendingApproval) -> None:
        """Read it when there is time for it, and decide."""
        if self._is_here:
            self._take_up(offer)

    @on(ACTION)
    def acted(self, action: m.Action) -> None:
        self._let_go(action.id)

    @on(DECIDED)
    def decided(self, action: m.Action) -> None:
        self._let_go(action.id)

    @on(DROPPED)
    def dropped(self, dropped: m.Dropped) -> None:
        self._let_go(dropped.id)

    @on(LEVEL_DECIDED)
    def level_ruled(self, ruled: m.LevelDecided) -> None:
        self._let_go(ruled.id)

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, ended: m.AttemptEnded) -> None:
        """Now and then there is something to say, to write down, to set; or a reason to go."""
        if not self._is_here or self._has_ended:
            return
        streams = RandomStreams(self._seed, "operator", ended.attempt, ended.seat)
        character = self._character
        for name, share, act in (
            ("remark", character.remarks, lambda at: self._remark(streams, ended.seat, at)),
            ("note", character.notes, lambda at: self._note(ended, at)),
            ("level", character.levels, lambda at: self._set_level(ended, at)),
            ("leave", character.leaves, lambda at: self._leave(streams)),
        ):
            if streams.uniform(name, character.name) < share:
                self._at(self._time + round((1 + 2 * streams.uniform(name, "when")) * SECOND), act)

    # --- proposals --------------------------------------------------------------------------------------------

    def _take_up(self, offer: m.PendingApproval) -> None:
        """One at a time: who reads one thing has not seen the next."""
        id = offer.proposal.id
        if earlier := self._pending.pop(id, None):
            earlier[1].cancel()
        streams = RandomStreams(self._seed, "operator", id)
        seen = self._time + PAINTING
        self._at(seen, lambda at: self.emit(PROPOSAL_SEEN, m.ProposalSeen(action=id, actor=NAME, at=at)))
        verdict = self._character.verdict(streams)
        if verdict == "miss":
            return
        reaction = self._character.reaction_ms(offer.proposal.text, streams)
        due = self._busy_until = max(seen, self._busy_until) + round(reaction * MS)
        decision = self._decision(offer, verdict, streams)
        handle = self.bus.clock.call_at(due, lambda: self._decide(msgspec.structs.replace(decision, at=due)))
        self._pending[id] = due, handle

    def _decide(self, decision: m.Decision) -> None:
        self._pending.pop(decision.action, None)
        self.emit(DECISION, decision)

    def _decision(self, offer: m.PendingApproval, verdict: str, streams: RandomStreams) -> m.Decision:
        """An edit adds a kind word, and makes blame milder; a level that is changed stays where it was."""
        proposal = offer.proposal
        about = {"seat": proposal.seat, "action": proposal.id, "actor": NAME}
        if verdict != "edit" or (proposal.kind == "gesture" and offer.level is None):
            return m.Decision(**about, verdict="accept" if verdict == "accept" else "veto")  # type: ignore[arg-type]
        if offer.level is not None:
            return m.Decision(**about, verdict="edit", level=max(1, offer.level - 1))  # type: ignore[arg-type]
        milder = {"valence": "neutral"} if proposal.valence == "negative" else {}
        kind = streams.choice(self._theme.phrases["encouragement"], "words")
        return m.Decision(**about, **milder, verdict="edit", text=f"{proposal.text} {kind}".strip())  # type: ignore[arg-type]

    def _let_go(self, id: str) -> None:
        """What is decided needs no decision any more; but a finger on its way presses its key."""
        due, handle = self._pending.get(id, (0, None))
        if handle and due - self._time > TOO_LATE_TO_STOP:
            handle.cancel()
            del self._pending[id]

    # --- of their own -------------------------------------------------------------------------------------------

    def _remark(self, streams: RandomStreams, seat: str, at: int) -> None:
        words = streams.choice(self._theme.phrases["encouragement"], "remark", "words")
        self.emit(REMARK, m.Remark(seat=seat, text=words, valence="positive", actor=NAME, at=at))

    def _note(self, ended: m.AttemptEnded, at: int) -> None:
        text = f"Attempt {ended.attempt}: {ended.outcome}."
        self.emit(NOTE_ADDED, m.NoteAdded(seat=ended.seat, text=text, actor=NAME, at=at))

    def _set_level(self, ended: m.AttemptEnded, at: int) -> None:
        """Easier for who has failed, harder for who has not."""
        level = ended.level + 1 if ended.outcome == "success" else max(1, ended.level - 1)
        self.emit(OPERATOR, m.Operator(seat=ended.seat, command="level", value=level, actor=NAME, at=at))

    # --- coming and going -----------------------------------------------------------------------------------------

    def _come(self) -> None:
        self._is_here = True
        self._busy_until = self._time
        for state in ("joined", "baton"):
            changed = m.OperatorChanged(actor=NAME, state=state, operated=True, peers={NAME: "operator"})
            self.emit(PRESENCE, changed)

    def _leave(self, streams: RandomStreams) -> None:
        """Nothing is heard of them any more, until they are back."""
        if self._has_ended or not self._is_here:
            return
        self._is_here = False
        for _, handle in self._pending.values():
            handle.cancel()
        self._pending.clear()
        why = "Nothing has been heard from the operator's program."
        self.emit(PRESENCE, m.OperatorChanged(actor=NAME, state="lost", operated=False, detail=why))
        away = streams.generator("away").expovariate(1 / self._character.away_s)
        self.bus.clock.call_at(self._time + round(away * SECOND), self._come)

    def _at(self, when: int, act: Callable[[int], None]) -> None:
        """Do something at a time, unless they are gone by then."""

        def do() -> None:
            if self._is_here:
                act(when)

        self.bus.clock.call_at(when, do)
