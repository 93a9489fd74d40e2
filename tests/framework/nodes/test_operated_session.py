"""Given an operator who decides, when an attempt ends, then the session waits for them, no longer than it is set to."""

from typing import Any

import msgspec
import pytest

from sar_tui.framework import messages as m
from sar_tui.framework.task import Result, Task, Trial
from sar_tui.framework.theme import Theme
from sar_tui.framework.topics import (
    ACTING,
    ACTION,
    ATTEMPT_ENDED,
    DECISION,
    DROPPED,
    LEVEL,
    LEVEL_RULED,
    MODE,
    OFFERED,
    OPERATOR,
    PRESENCE,
    REMARK,
    SESSION_ENDED,
    STANDING,
    WAITING,
)
from sar_tui.outputs.node import OutputNode
from sar_tui.plugins import Catalogue
from tests.desk import Desk
from tests.lifting import Bench, Lift
from tests.outputs.fakes import Speaker


def operated(theme: Theme, **settings: Any) -> Desk:
    """A session with an operator, at the end of its first attempt."""
    desk = Desk(
        Catalogue().task("keyboard"),
        theme,
        attempts=3,
        prompts_per_attempt=2,
        filler="never",
        encouragement=False,
        **settings,
    )
    desk.session.bus.publish(PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True))
    desk.enter()
    desk.attempt()
    return desk


def decide(desk: Desk, action: str, verdict: Any, **how: Any) -> None:
    told = m.Decision(action=action, verdict=verdict, actor="operator.ana", at=desk.clock.now(), **how)
    desk.session.bus.publish(DECISION, told)


def feedback(desk: Desk) -> list[m.Action]:
    return [action for action in desk.all(ACTION) if action.kind == "feedback"]


def offered(desk: Desk) -> str:
    """The id of the feedback that waits."""
    return [offer.proposal.id for offer in desk.all(OFFERED) if offer.proposal.kind == "feedback"][-1]


def test_the_next_attempt_cannot_begin_while_an_answer_is_decided_on(calm: Theme) -> None:
    desk = operated(calm, operator_feedback="approve", operator_time_ms=20_000)
    assert (desk.waiting.what, desk.waiting.stage) == ("answer", "answer")
    desk.press("enter")
    assert desk.waiting.stage == "answer"
    decide(desk, offered(desk), "accept")
    assert (desk.waiting.what, desk.waiting.stage, desk.waiting.attempt) == ("enter", "attempt", 2)
    assert len(feedback(desk)) == 1


def test_nobody_waits_longer_than_the_operators_time(calm: Theme) -> None:
    desk = operated(calm, operator_feedback="approve", operator_time_ms=5000)
    desk.wait(4000)
    assert (desk.waiting.what, desk.waiting.stage) == ("enter", "attempt")
    assert [action.ground for action in feedback(desk)] == ["deadline"]


def test_a_manual_answer_is_not_waited_for(calm: Theme) -> None:
    desk = operated(calm, operator_feedback="manual")
    assert desk.waiting.stage == "attempt"
    desk.press("enter")
    assert [(dropped.reason, dropped.actor) for dropped in desk.all(DROPPED)] == [("manual", "agent")]
    desk.to_prompt()
    assert feedback(desk) == []


def test_words_of_the_operator_before_an_answer_falls_due_change_nothing_of_the_wait(calm: Theme) -> None:
    desk = operated(calm, extra=[OutputNode(Speaker(1000), "speech", calm)], feedback_delay_ms=5000)
    known = len(desk.all(WAITING))
    desk.session.bus.publish(REMARK, m.Remark(text="Take your time.", actor="operator.ana"))
    desk.wait(3000)
    assert [(agent.acting, agent.owing) for agent in desk.all(ACTING)[-2:]] == [(True, False), (False, False)]
    assert len(desk.all(WAITING)) == known
    desk.wait(10_000)
    assert [waiting.stage for waiting in desk.all(WAITING)[known:]] == ["attempt"]


def test_a_pause_while_an_operator_decides_comes_back_to_the_wait(calm: Theme) -> None:
    desk = operated(calm, operator_feedback="approve", operator_time_ms=60_000)
    desk.operate("pause")
    desk.operate("resume")
    assert desk.waiting.stage == "answer"


def test_a_decision_taken_in_a_pause_is_said_after_it(calm: Theme) -> None:
    desk = operated(calm, operator_feedback="approve", operator_time_ms=60_000)
    desk.operate("pause")
    decide(desk, offered(desk), "accept")
    assert feedback(desk) == []
    desk.operate("resume")
    assert desk.waiting.stage == "attempt"
    assert len(feedback(desk)) == 1


def test_the_last_answer_is_decided_before_the_review(calm: Theme) -> None:
    desk = operated(calm, operator_feedback="approve", operator_time_ms=60_000)
    for _ in range(2):
        decide(desk, offered(desk), "veto")
        desk.attempt()
    desk.press("enter")
    assert desk.waiting.stage == "answer"
    decide(desk, offered(desk), "accept")
    assert desk.waiting.stage == "review"


def test_an_operator_of_an_earlier_run_decides_nothing_in_the_next(calm: Theme) -> None:
    settings = {"attempts": 3, "prompts_per_attempt": 2, "filler": "never", "encouragement": False}
    killed = operated(calm, operator_feedback="approve")
    decide(killed, offered(killed), "veto")
    desk = Desk(Catalogue().task("keyboard"), calm, history=killed.records, operator_feedback="approve", **settings)
    desk.enter()
    desk.attempt()
    assert [(action.actor, action.ground) for action in feedback(desk)] == [("agent", "no operator")]


# --- the level ------------------------------------------------------------------------------------------------------


def test_the_level_rises_when_the_operator_lets_it(calm: Theme) -> None:
    desk = operated(calm, operator_difficulty="approve", operator_time_ms=60_000)
    assert desk.waiting.stage == "answer"
    assert desk.all(LEVEL) == []
    decide(desk, "l1", "accept")
    assert [(change.previous, change.level, change.reason) for change in desk.all(LEVEL)] == [(1, 2, "success")]
    assert (desk.waiting.stage, desk.waiting.level) == ("attempt", 2)


@pytest.mark.parametrize(("how", "level"), [({"verdict": "veto"}, 1), ({"verdict": "edit", "level": 3}, 3)])
def test_the_level_is_what_the_operator_says(calm: Theme, how: dict[str, Any], level: int) -> None:
    desk = operated(calm, operator_difficulty="approve", operator_time_ms=60_000)
    decide(desk, "l1", **how)
    assert desk.waiting.level == level
    assert [change.reason for change in desk.all(LEVEL)] == ["operator"] * (level != 1)
    desk.press("enter")
    assert desk.to_prompt().level == level


@pytest.mark.parametrize(("asked", "level"), [(99, 5), (0, 2)])
def test_a_level_that_the_operator_puts_in_its_place_stays_within_its_bounds(
    calm: Theme, asked: int, level: int
) -> None:
    settings = {"start_level": 3, "min_level": 2, "max_level": 5}
    desk = operated(calm, operator_difficulty="approve", operator_time_ms=60_000, **settings)
    decide(desk, "l1", "edit", level=asked)
    assert desk.waiting.level == level


def test_after_the_last_attempt_nobody_is_asked_for_the_level(calm: Theme) -> None:
    desk = lifted(calm, attempts=1, operator_difficulty="approve", operator_time_ms=60_000)
    assert desk.waiting.stage == "review"
    assert offers(desk) == []
    assert desk.all(LEVEL) == []


def test_a_level_that_was_refused_can_be_proposed_again(calm: Theme) -> None:
    desk = operated(calm, operator_difficulty="approve", operator_time_ms=60_000)
    decide(desk, "l1", "veto")
    desk.attempt()
    decide(desk, "l2", "accept")
    assert desk.waiting.level == 2


def test_a_level_that_is_taken_up_while_nobody_waits_for_it_is_that_of_the_next_attempt(calm: Theme) -> None:
    desk = operated(calm, operator_difficulty="manual")
    decide(desk, "l1", "accept")
    assert (desk.waiting.stage, desk.waiting.level) == ("attempt", 2)


def test_no_level_changes_once_the_session_is_being_ended(calm: Theme) -> None:
    desk = Desk(Catalogue().task("keyboard"), calm, attempts=3, prompts_per_attempt=2, operator_difficulty="approve")
    desk.session.bus.publish(PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True))
    desk.start()
    desk.answer()
    desk.to_prompt()
    desk.screen.stores = False
    desk.answer()
    desk.operate("end")
    assert (desk.waiting.what, desk.waiting.stage) == ("storage", "ended")
    decide(desk, "l1", "accept")
    assert [ruled.decision for ruled in desk.all(LEVEL_RULED)] == ["accepted"]
    assert desk.all(LEVEL) == []


def test_a_level_held_by_hand_stays(calm: Theme) -> None:
    desk = operated(calm, operator_difficulty="manual")
    assert (desk.waiting.stage, desk.waiting.level) == ("attempt", 1)
    desk.attempt()
    assert desk.waiting.level == 1


def test_a_level_set_by_hand_while_one_is_asked_for_is_the_one_that_holds(calm: Theme) -> None:
    desk = operated(calm, operator_difficulty="veto", operator_time_ms=5000)
    desk.session.bus.publish(OPERATOR, m.Operator(command="level", value=4, actor="operator.ana"))
    desk.wait(10_000)
    assert desk.waiting.level == 4


def test_a_level_that_a_marked_trial_no_longer_calls_for_is_asked_for_no_longer(calm: Theme) -> None:
    desk = Bench(Lift, calm, operator_difficulty="approve", operator_time_ms=60_000)
    desk.session.bus.publish(PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True))
    desk.begin_lifts()
    desk.lift()
    desk.lift()
    assert [offer.proposal.id for offer in desk.last(STANDING).offers] == ["l1"]
    desk.operate("mark", reason="caught")
    assert desk.last(STANDING).offers == ()
    decide(desk, "l1", "accept")
    assert (desk.waiting.stage, desk.waiting.level) == ("attempt", 1)
    desk.operate("mark", reason="caught")
    assert [offer.proposal.id for offer in desk.last(STANDING).offers] == ["l2"], "the mark was taken back"
    decide(desk, "l2", "accept")
    assert desk.waiting.level == 2


@pytest.mark.parametrize(("lost", "level"), [("autonomous", 2), ("silent", 1)])
def test_a_level_that_waits_when_the_program_is_killed_is_decided_as_without_an_operator(
    calm: Theme, lost: str, level: int
) -> None:
    settings = {"operator_difficulty": "approve", "operator_time_ms": 60_000, "operator_lost": lost}
    killed = operated(calm, **settings)
    assert (killed.waiting.stage, killed.waiting.level) == ("answer", 1)
    desk = Desk(
        Catalogue().task("keyboard"),
        calm,
        history=killed.records,
        attempts=3,
        prompts_per_attempt=2,
        filler="never",
        encouragement=False,
        **settings,
    )
    desk.press("enter")
    assert (desk.waiting.stage, desk.waiting.level) == ("attempt", level)
    assert [(ruled.id, ruled.actor, ruled.ground) for ruled in desk.all(LEVEL_RULED)] == [
        ("l1", "agent", "no operator")
    ]


def lifted(calm: Theme, task: type[Task] = Lift, **settings: Any) -> Bench:
    """A session with an operator and a therapist, at the end of its first attempt."""
    desk = Bench(task, calm, **{"attempts": 3, "filler": "never", "encouragement": False, **settings})
    desk.session.bus.publish(PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True))
    desk.begin_lifts()
    desk.lift()
    desk.lift()
    return desk


def offers(desk: Desk) -> list[str]:
    return [offer.proposal.id for offer in desk.last(STANDING).offers]


@pytest.mark.parametrize("attempts", [2, 3])
def test_the_level_that_a_mark_calls_for_is_asked_about_before_the_last_attempt_too(calm: Theme, attempts: int) -> None:
    desk = lifted(calm, attempts=attempts, operator_difficulty="approve", operator_time_ms=60_000)
    decide(desk, "l1", "veto")
    desk.operate("mark", reason="caught")
    desk.operate("mark", reason="caught")
    assert desk.all(LEVEL) == []
    assert offers(desk) == ["l2"]


@pytest.mark.parametrize(
    ("how", "level"), [({"verdict": "veto"}, 1), ({"verdict": "accept"}, 2), ({"verdict": "edit", "level": 4}, 4)]
)
def test_a_mark_that_changes_no_outcome_leaves_the_level_as_the_operator_ruled(
    calm: Theme, how: dict[str, Any], level: int
) -> None:
    desk = lifted(calm, operator_difficulty="approve", operator_time_ms=60_000)
    decide(desk, "l1", **how)
    desk.operate("mark", reason="leaned")
    assert (desk.waiting.stage, desk.waiting.level, offers(desk)) == ("attempt", level, [])
    desk.press("enter")
    desk.wait(300)
    assert desk.waiting.level == level
    desk.lift()
    desk.lift()
    assert [offer.level for offer in desk.last(STANDING).offers] == [level + 1], "the next step is from there"


def test_a_mark_that_changes_no_outcome_leaves_the_level_waiting(calm: Theme) -> None:
    desk = lifted(calm, operator_difficulty="approve", operator_time_ms=60_000)
    desk.operate("mark", reason="leaned")
    assert offers(desk) == ["l1"]


def test_a_level_that_a_mark_no_longer_calls_for_falls_away_whatever_became_of_the_attempt_before(calm: Theme) -> None:
    desk = Bench(Lift, calm, attempts=3, filler="never", operator_difficulty="approve", operator_time_ms=60_000)
    desk.session.bus.publish(PRESENCE, m.OperatorChanged(actor="operator.ana", state="joined", operated=True))
    desk.begin_lifts()
    desk.lift(3000)
    desk.lift(3000)
    desk.press("enter")
    desk.wait(300)
    desk.lift()
    desk.lift()
    assert [one.outcome for one in desk.all(ATTEMPT_ENDED)] == ["failure", "success"]
    assert offers(desk) == ["l1"]
    desk.operate("mark", reason="caught")
    assert offers(desk) == []


def test_an_answer_that_waits_for_the_operator_is_another_once_the_attempt_is_scored_anew(calm: Theme) -> None:
    desk = lifted(calm, operator_feedback="approve", operator_time_ms=60_000)
    desk.operate("mark", reason="caught")
    assert desk.waiting.stage == "answer"
    decide(desk, offered(desk), "accept")
    assert [action.valence for action in feedback(desk)] == ["negative"]
    assert desk.last(ATTEMPT_ENDED).feedback == "negative"


def test_an_answer_that_was_given_is_not_given_again_while_the_level_waits(calm: Theme) -> None:
    desk = lifted(calm, operator_difficulty="approve", operator_time_ms=60_000)
    desk.operate("mark", reason="caught")
    decide(desk, "l1", "accept")
    assert [action.valence for action in feedback(desk)] == ["positive"]


class Couple(Lift):
    """A lifts for two: B's time is told apart, as if it were their own."""

    seats = ("A", "B")
    b_ms = 400.0

    def seat_of(self, key: str) -> str:
        return "A"

    def perceived(self, trial: Trial, percept: Any) -> Any:
        result = super().perceived(trial, percept)
        if not isinstance(result, Result):
            return result
        return {"A": result, "B": msgspec.structs.replace(result, value=self.b_ms)}


class UnevenCouple(Couple):
    """B never reaches the goal."""

    b_ms = 5000.0


def test_of_two_the_later_answer_is_waited_for_where_the_other_has_none(calm: Theme) -> None:
    bandwidth = {"feedback_schedule": "bandwidth", "feedback_tolerance": 70.0}
    desk = lifted(calm, UnevenCouple, feedback_delay_ms=5000, **bandwidth)
    assert [one.feedback for one in desk.all(ATTEMPT_ENDED)] == ["none", "negative"]
    assert desk.waiting.stage == "answer"
    desk.wait(5000)
    assert desk.waiting.stage == "attempt"
    assert [(action.seat, action.joins, action.policy) for action in feedback(desk)] == [("B", False, "interrupt")]


def test_of_two_the_second_is_answered_after_the_first_and_each_is_looked_at(calm: Theme) -> None:
    desk = lifted(calm, Couple)
    assert [(action.seat, action.joins, action.policy, action.gaze) for action in feedback(desk)] == [
        ("A", False, "interrupt", "left"),
        ("B", True, "queue", "right"),
    ]
    assert [action.gaze for action in desk.all(ACTION) if action.kind == "greeting"] == ["ahead"]


def test_of_two_a_level_is_asked_for_still_where_a_mark_changes_the_outcome_of_one_and_not_of_both(calm: Theme) -> None:
    desk = lifted(calm, UnevenCouple, start_level=3, operator_difficulty="approve", operator_time_ms=60_000)
    desk.operate("mark", reason="caught")
    assert {one.outcome for one in desk.all(ATTEMPT_ENDED)[-2:]} == {"failure"}
    assert offers(desk) == ["l1"]
    decide(desk, "l1", "accept")
    assert desk.waiting.level == 2


def test_of_two_a_mark_that_changes_the_outcome_of_both_asks_once_for_what_it_calls_for(calm: Theme) -> None:
    desk = lifted(calm, Couple, start_level=3, operator_difficulty="approve", operator_time_ms=60_000)
    levels = []
    for _ in range(3):
        (offer,) = desk.last(STANDING).offers
        levels.append((offer.proposal.id, offer.level))
        desk.operate("mark", reason="caught")
    assert levels == [("l1", 4), ("l2", 2), ("l3", 4)]


def test_of_two_only_who_was_not_answered_yet_is_answered_anew(calm: Theme) -> None:
    desk = lifted(calm, Couple, operator_feedback="approve", operator_time_ms=60_000)
    decide(desk, offers(desk)[0], "accept")
    desk.operate("mark", reason="caught")
    assert [(offer.seat, offer.proposal.valence) for offer in desk.last(STANDING).offers] == [("B", "negative")]
    assert {one.seat: one.feedback for one in desk.all(ATTEMPT_ENDED)} == {"A": "positive", "B": "negative"}
    decide(desk, offers(desk)[0], "accept")
    assert [(action.seat, action.valence) for action in feedback(desk)] == [("A", "positive"), ("B", "negative")]


def test_an_answer_that_begins_to_be_owed_in_a_pause_is_waited_for_after_it(calm: Theme) -> None:
    desk = operated(calm, operator_feedback="manual")
    desk.operate("pause")
    desk.session.bus.publish(MODE, m.ModeChosen(kind="feedback", mode="approve", actor="operator.ana"))
    desk.operate("resume")
    assert desk.waiting.stage == "answer"
    decide(desk, offered(desk), "accept")
    assert desk.waiting.stage == "attempt"
    assert len(feedback(desk)) == 1


# --- with and without -------------------------------------------------------------------------------------------------


def test_an_operator_who_lets_all_pass_changes_nothing_the_participant_sees(calm: Theme) -> None:
    """But the time: and not even that, with a fixed delay."""
    sessions = []
    for mode in ("autonomous", "veto", "approve"):
        settings = dict.fromkeys((f"operator_{kind}" for kind in ("feedback", "encouragement", "difficulty")), mode)
        desk = operated(calm, feedback_delay_ms=2000, operator_time_ms=2000, **settings)
        desk.wait(5000)
        desk.attempt()
        desk.wait(5000)
        heard = [
            (record.at, msgspec.structs.replace(record.message, decided=0, mode="manual", ground="mode", actor=""))
            for record in desk.records
            if record.topic is ACTION
        ]
        seen = [(record.at, record.message) for record in desk.records if record.topic is WAITING]
        sessions.append((heard, seen[-1]))
    assert sessions[0] == sessions[1] == sessions[2]


@pytest.mark.parametrize("pauses", [False, True])
def test_who_ends_a_session_in_which_all_is_done_completes_it(calm: Theme, pauses: bool) -> None:
    desk = operated(calm)
    for _ in range(2):
        desk.attempt()
    if pauses:
        desk.operate("pause")
    desk.operate("end")
    assert desk.last(SESSION_ENDED).status == "completed"
    early = operated(calm)
    early.operate("end")
    assert early.last(SESSION_ENDED).status == "aborted"
