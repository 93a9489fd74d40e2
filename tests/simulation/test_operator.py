"""Simulated operators decide according to their profile, reproducibly."""

from collections import Counter
from collections.abc import Callable
from itertools import pairwise
from statistics import fmean, median
from typing import Any

import msgspec
import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.session import Session
from sar_tui.loop.task import Task
from sar_tui.loop.topics import MODE, STORED
from sar_tui.model import messages as m
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.theme import Theme
from sar_tui.rules.parameters import build
from sar_tui.simulation.operator import (
    NAME,
    PROFILES,
    TOO_LATE_TO_STOP,
    OperatorProfile,
    SimulatedOperator,
)
from sar_tui.simulation.participant import SimulatedParticipant
from sar_tui.simulation.participant_model import PEOPLE

PLAIN = OperatorProfile(
    "plain",
    0,
    500,
    0.001,
    0.001,
    vetoes=0,
    edits=0,
    slips=0,
    misses=0,
    remarks=0,
    notes=0,
    levels=0,
)
"""Accepts everything 500 ms after it is on the screen, and does nothing else."""

Record = tuple[int, m.Message]
Play = Callable[..., list[Record]]


@pytest.fixture
def play(keyboard: type[Task], calm: Theme) -> Play:
    """Play a whole session with an operator (None: nobody) and return its messages with times.

    ``colleague``: sets a mode in reply to a message.
    """

    def whole(
        profile: OperatorProfile | None,
        seed: int = 1,
        colleague: Callable[[m.Message], m.ModeChanged | None] = lambda _: None,
        **parameters: object,
    ) -> list[Record]:
        short = {
            "attempts": 6,
            "prompts_per_attempt": 3,
            "operator_feedback": "approve",
            **parameters,
        }
        task = keyboard(build(keyboard.Parameters, short))
        clock = VirtualClock()
        operator = [SimulatedOperator(profile, seed)] if profile else []
        session = Session(
            task,
            calm,
            clock,
            seed,
            [SimulatedParticipant(PEOPLE["average"], task, seed), *operator],
        )
        messages: list[Record] = []
        session.bus.tap(
            lambda cascade: messages.extend((record.at, record.message) for record in cascade)
        )
        session.begin()
        while not session.ended and session.broken is None:
            before = len(messages)
            assert clock.step()
            for _, message in messages[before:]:
                if chosen := colleague(message):
                    session.bus.publish(MODE, chosen)
                if isinstance(message, m.TrialEnded):  # is committed at once
                    stored = m.Stored(attempt=message.attempt, trial=message.trial)
                    session.bus.publish(STORED, stored)
        assert session.faults == []
        return messages

    return whole


def of(kind: type[Any], messages: list[Record]) -> list[Any]:
    return [message for _, message in messages if isinstance(message, kind)]


def like(profile: str, **changes: Any) -> OperatorProfile:
    return msgspec.structs.replace(PROFILES[profile], **changes)


def test_the_same_seed_gives_the_same_session_and_another_a_different_one(play: Play) -> None:
    profile = PROFILES["careful"]
    assert play(profile, 5) == play(profile, 5)
    decisions = [
        [(d.action, d.verdict, d.at) for d in of(m.Decision, play(profile, seed))]
        for seed in (5, 6)
    ]
    assert decisions[0] != decisions[1]


def test_it_takes_control_at_the_start_sees_pending_proposals_and_then_decides(
    play: Play,
) -> None:
    messages = play(PLAIN)
    came = [(at, message) for at, message in messages if isinstance(message, m.OperatorChanged)]
    assert [(at, message.state, message.operated, message.actor) for at, message in came] == [
        (0, "joined", True, NAME),
        (0, "baton", True, NAME),
    ]
    pending = {
        message.proposal.id: at
        for at, message in messages
        if isinstance(message, m.PendingApproval)
    }
    seen = {message.action: message.at for message in of(m.ProposalSeen, messages)}
    decided = {message.action: message.at for message in of(m.Decision, messages)}
    assert pending.keys() == seen.keys() == decided.keys()
    assert len(pending) == 6
    for id, at in pending.items():
        assert seen[id] - at == 30_000_000
        assert decided[id] - seen[id] == pytest.approx(500_000_000, abs=2_000_000)
    said = [message for message in of(m.Action, messages) if message.kind == "feedback"]
    assert {message.ground for message in said} == {"operator"}


def test_proposals_are_decided_one_after_the_other(play: Play) -> None:
    messages = play(PLAIN, operator_difficulty="approve", operator_gesture="approve")
    times = sorted(message.at for message in of(m.Decision, messages))
    assert len(times) > 12
    assert min(later - earlier for earlier, later in pairwise(times)) > 490_000_000


@pytest.mark.parametrize(
    ("share", "verdicts"),
    [("vetoes", {"veto"}), ("edits", {"edit"}), ("misses", set()), ("slips", {"veto", "edit"})],
)
def test_a_share_of_one_means_always(share: str, verdicts: set[str], play: Play) -> None:
    messages = play(msgspec.structs.replace(PLAIN, **{share: 1.0}), operator_difficulty="approve")
    assert {message.verdict for message in of(m.Decision, messages)} == verdicts


def test_an_edit_adds_encouragement_and_softens_blame(play: Play, calm: Theme) -> None:
    messages = play(like("careful", edits=1.0, vetoes=0, slips=0, misses=0), threshold=300)
    proposed = {message.id: message for message in of(m.Proposal, messages)}
    edits = of(m.Decision, messages)
    assert {proposed[edit.action].valence for edit in edits} == {"negative"}
    for edit in edits:
        before = proposed[edit.action].text
        assert edit.text.removeprefix(f"{before} ") in calm.phrases["encouragement"]
        assert edit.valence == "neutral"


def test_a_key_due_soon_after_the_deadline_is_pressed_too_late(play: Play) -> None:
    """The deadline is at 1000 ms: a key due at 1130 ms is still pressed, one due at 2000 ms is
    not.
    """
    slightly_late = msgspec.structs.replace(PLAIN, mean_ms=1100)
    messages = play(slightly_late, operator_time_ms=1000, operator_ms_per_word=0)
    assert len(of(m.LateDecision, messages)) == len(of(m.PendingApproval, messages)) == 6
    assert 100_000_000 < TOO_LATE_TO_STOP < 970_000_000
    messages = play(
        msgspec.structs.replace(PLAIN, mean_ms=2000), operator_time_ms=1000, operator_ms_per_word=0
    )
    assert of(m.LateDecision, messages) == of(m.Decision, messages) == []


def test_an_absent_operator_decides_nothing(play: Play) -> None:
    messages = play(like("absent", leaves=1.0, away_s=15.0, misses=0), attempts=10)
    states = [message.state for message in of(m.OperatorChanged, messages)]
    assert states.count("lost") >= 3
    assert states.count("joined") >= 3
    is_here = False
    for _, message in messages:
        if isinstance(message, m.OperatorChanged):
            is_here = message.operated
        assert is_here or not isinstance(
            message, m.Decision | m.Remark | m.NoteAdded | m.ProposalSeen
        )


def test_a_proposal_that_becomes_pending_again_is_decided_once(play: Play) -> None:
    """A pending proposal becomes pending again when its mode is set again."""

    def colleague(message: m.Message) -> m.ModeChanged | None:
        waits = isinstance(message, m.PendingApproval) and message.mode == "approve"
        return m.ModeChanged(kind="feedback", mode="veto") if waits else None

    messages = play(PLAIN, colleague=colleague)
    pending = Counter(message.proposal.id for message in of(m.PendingApproval, messages))
    decisions = Counter(message.action for message in of(m.Decision, messages))
    assert sorted(pending.values()) == [1] * 5 + [2]
    assert decisions == Counter(pending.keys())
    assert of(m.LateDecision, messages) == []


def test_acts_on_its_own_initiative(play: Play) -> None:
    messages = play(msgspec.structs.replace(PLAIN, remarks=1.0, notes=1.0, levels=1.0), attempts=8)
    remarks, notes = of(m.Remark, messages), of(m.NoteAdded, messages)
    commands = of(m.SessionCommand, messages)
    assert len(remarks) >= 7
    assert len(notes) >= 7
    assert {message.command for message in commands} == {"level"}
    assert all(message.actor == NAME and message.at for message in (*remarks, *notes, *commands))


def test_the_participant_is_as_fast_with_an_operator_as_without(play: Play) -> None:
    with_one, without = play(PROFILES["careful"], 2), play(None, 2)
    assert of(m.Decision, with_one)
    times = [
        {(t.attempt, t.trial): t.reaction_time_ms for t in of(m.TrialEnded, messages)}
        for messages in (with_one, without)
    ]
    assert times[0] == times[1]


# --- profiles

MANY = [RandomStreams(1, "operator", f"a{n}") for n in range(2000)]


@pytest.mark.parametrize("name", PROFILES)
def test_shares_match_the_profile(name: str) -> None:
    profile = PROFILES[name]
    verdicts = Counter(profile.verdict(streams) for streams in MANY)
    assert verdicts["miss"] / 2000 == pytest.approx(profile.misses, abs=0.025)
    slipped = profile.slips / 2
    for verdict, share in (("veto", profile.vetoes), ("edit", profile.edits)):
        meant = share * (1 - profile.slips) + (1 - share) * slipped
        assert verdicts[verdict] / 2000 == pytest.approx((1 - profile.misses) * meant, abs=0.025)


@pytest.mark.parametrize("name", PROFILES)
def test_times_match_the_profile(name: str) -> None:
    profile = PROFILES[name]
    text = "one two three four five"
    times = [profile.reaction_ms(text, streams) for streams in MANY]
    assert fmean(times) == pytest.approx(5 * profile.ms_per_word + profile.mean_ms, rel=0.03)
    assert median(times) < fmean(times), "the tail is on the slow side"
    assert min(times) >= 150
