"""An operator's commands: what they send to the session, or why they send nothing."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from sar_tui.link.peer import Connection
from sar_tui.loop import topics as t
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.model.units import MS, SECOND
from sar_tui.operator import proposal_strip
from sar_tui.operator.act_log import Wording
from sar_tui.operator.commands import TOO_SOON, by_urgency
from sar_tui.operator.palette import Item
from tests.operator import panel_driver as b
from tests.operator.panel_driver import ANNA
from tests.operator.test_acts import NOW, PROPOSAL, Panel

WORDS = b.approval("p1", text="Well done")
LEVEL = b.approval("p1", level=5)
NOD = b.approval("p1", kind="gesture", text="", spoken="", gesture="nod")


@pytest.fixture
def panel(calm: Theme) -> Panel:
    panel = Panel()
    panel.receive(t.THEME, m.ThemeApplied(theme=calm))
    return panel


# --- proposals


@pytest.mark.parametrize(
    ("approval", "typed", "decision"),
    [
        (WORDS, "Well done! ", {"verdict": "edit", "text": "Well done!"}),
        (WORDS, "Well done", {"verdict": "accept"}),
        (WORDS, "{participant}, well done", {"verdict": "edit", "text": "P01, well done"}),
        (LEVEL, "3", {"verdict": "edit", "level": 3}),
        (LEVEL, "1", {"verdict": "edit", "level": 1}),
        (LEVEL, "10", {"verdict": "edit", "level": 10}),
        (LEVEL, "5", {"verdict": "accept"}),
        (NOD, "lean in", {"verdict": "edit", "gesture": "lean_in"}),
        (NOD, "nod", {"verdict": "accept"}),
    ],
)
def test_a_proposal_is_edited_in_its_text_level_or_gesture_and_unchanged_it_is_approved(
    panel: Panel, approval: m.PendingApproval, typed: str, decision: dict[str, Any]
) -> None:
    assert panel.commands.edit(approval, typed, NOW)
    assert panel.peer.of(t.DECISION) == [m.Decision(action="p1", actor=ANNA, **decision)]


@pytest.mark.parametrize(
    ("approval", "typed", "why"),
    [
        (WORDS, "Yours: {result}", "{result} is not known yet"),
        (LEVEL, "x", "A level is a number, not 'x'"),
        (LEVEL, "0", "Level 1 is the lowest level"),
        (LEVEL, "11", "Level 10 is the highest level"),
        (LEVEL, "9" * 30, "Level 10 is the highest level"),
        (NOD, "bow", "The theme has no gesture 'bow'"),
    ],
)
def test_an_edit_that_cannot_be_is_not_sent(
    panel: Panel, approval: m.PendingApproval, typed: str, why: str
) -> None:
    assert not panel.commands.edit(approval, typed, NOW)
    assert panel.peer.sent == []
    assert panel.lines == [(f"{why}. Nothing was sent.", "bad")]


def test_a_proposal_is_decided_once_unless_the_session_refuses(panel: Panel) -> None:
    assert panel.commands.decide(PROPOSAL, "accept", NOW)
    assert not panel.commands.decide(PROPOSAL, "veto", NOW)
    panel.answer("refused", "It did not arrive.")
    assert panel.commands.change_valence(PROPOSAL, "negative", NOW)
    assert [(each.verdict, each.valence) for each in panel.peer.of(t.DECISION)] == [
        ("accept", None),
        ("edit", "negative"),
    ]


def test_a_key_right_after_a_proposal_has_appeared_was_not_meant_for_it(panel: Panel) -> None:
    panel.commands.report_seen(PROPOSAL, NOW)
    panel.commands.report_seen(WORDS, NOW + 100 * MS)  # painted twice: there since the first time
    assert panel.commands.shown == ("p1", NOW - SECOND)
    panel.commands.shown = ("p1", NOW)
    assert not panel.commands.decide(PROPOSAL, "accept", NOW + TOO_SOON - 1)
    assert panel.lines[-1][0].startswith("Too soon")
    assert panel.commands.decide(PROPOSAL, "accept", NOW + TOO_SOON)


def test_a_proposal_is_reported_as_seen_once_and_only_by_who_may_decide(panel: Panel) -> None:
    other = b.approval("p2")
    panel.receive(t.PRESENCE, b.presence("baton", "operator.ben", ben="operator"))
    for at, seen in ((NOW, PROPOSAL), (NOW + 1, other)):
        panel.receive(t.ARBITER_STATE, b.arbiter_state(seen))
        panel.commands.report_seen(seen, at)
    assert panel.peer.sent == []
    for _ in range(2):
        panel.receive(t.PRESENCE, b.presence("baton", ANNA, ben="operator"))
    assert [(name, act.action, act.at) for name, act in panel.peer.sent] == [
        (t.PROPOSAL_SEEN.name, "p2", NOW + 1)
    ]
    panel.commands.report_seen(other, NOW + 2)
    assert len(panel.peer.sent) == 1


def test_proposals_are_sorted_by_deadline_and_then_by_reading_time() -> None:
    level, feedback = b.approval("l1", 4000, level=5), b.approval("f1", 4001)
    gesture = b.approval("g1", 4002, kind="gesture", text="")
    soon, free = b.approval("e1", 2000, kind="encouragement"), b.approval("m1", None)
    order = by_urgency((free, level, gesture, feedback, soon))
    assert [approval.proposal.id for approval in order] == ["e1", "f1", "l1", "g1", "m1"]


@given(
    st.lists(
        st.tuples(
            st.none() | st.integers(0, 9000), st.sampled_from(["feedback", "gesture", "rest"])
        ),
        max_size=8,
    )
)
def test_sorting_loses_none_and_puts_those_without_deadline_last(
    waiting: list[tuple[int | None, str]],
) -> None:
    given_ = tuple(b.approval(f"p{n}", ms, kind=kind) for n, (ms, kind) in enumerate(waiting))
    order = by_urgency(given_)
    assert sorted(order, key=given_.index) == list(given_)
    is_free = [approval.deadline is None for approval in order]
    assert is_free == sorted(is_free)


@pytest.mark.parametrize(
    ("left_ms", "otherwise", "text"),
    [
        (0, "act", "time is up"),
        (1000, "act", "acts by itself in 1.0 s"),
        (1000, "drop", "is dropped in 1.0 s"),
        (None, "act", "waits for you until the next attempt begins"),
    ],
)
def test_the_time_left_is_told_with_what_happens_then(
    left_ms: int | None, otherwise: Any, text: str
) -> None:
    approval = replace(b.approval("p1", left_ms), otherwise=otherwise)
    assert proposal_strip.time_left(approval, NOW) == text


def test_a_reported_change_stands_beside_its_mdc95_in_the_title() -> None:
    evidence = "reach time -0.421 s (MDC95 0.380 s)"
    approval = b.approval("f1", 4000, evidence=evidence)
    assert evidence in proposal_strip.title(approval, 1, 1, "")
    assert "MDC95" not in proposal_strip.proposal_text(approval.proposal, None)


# --- the session


def test_levels_count_from_the_one_on_its_way_and_stop_at_the_highest(panel: Panel) -> None:
    for step in (1, 1, -1):
        assert panel.commands.level(step, NOW)
    assert [act.value for act in panel.peer.of(t.COMMAND)] == [5, 6, 5]
    for number in range(3):
        panel.answer(number=number)
    panel.receive(t.LEVEL, m.LevelChanged(previous=5, level=10, reason="success"))
    assert not panel.commands.level(1, NOW)
    assert panel.lines[-1] == ("Level 10 is the highest level. Nothing was sent.", "bad")
    assert len(panel.peer.sent) == 3


@pytest.mark.parametrize(
    ("modes", "sent"),
    [(["approve", "manual"], ["manual", "approve"]), (["manual"], ["veto"])],
    ids=["held here", "held elsewhere, planned as veto"],
)
def test_a_level_is_held_and_released_to_its_mode_before_or_the_planned_one(
    panel: Panel, modes: list[m.Mode], sent: list[m.Mode]
) -> None:
    for mode in modes:
        panel.receive(t.ARBITER_STATE, b.arbiter_state(modes={**b.MODES, "difficulty": mode}))
        panel.commands.hold(NOW)
    assert panel.peer.of(t.MODE) == [
        m.ModeChanged(kind="difficulty", mode=mode, actor=ANNA) for mode in sent
    ]


@pytest.mark.parametrize("reason", ["", "pain", "tired", "finished"])
def test_a_participants_pause_is_ended_only_by_a_second_key_that_is_no_bounce(
    panel: Panel, reason: str
) -> None:
    panel.receive(t.COMMAND, m.SessionCommand(command="pause", reason=reason))
    panel.receive(t.WAITING, b.waiting("resume", "paused", reason=reason))
    for keys in ([0, 149, 4000, 7001, 10_001], [20_000, 20_150]):
        *early, last = [panel.commands.may_resume(NOW + ms * MS) for ms in keys]
        assert not any(early)
        assert last
    assert panel.commands.pause(NOW)
    assert [act.command for act in panel.peer.of(t.COMMAND)] == ["resume"]


def test_an_operators_own_pause_is_ended_by_one_key_but_not_one_for_pain(panel: Panel) -> None:
    panel.receive(t.COMMAND, m.SessionCommand(command="pause", actor="operator.ben"))
    panel.receive(t.WAITING, b.waiting("resume", "paused"))
    assert panel.commands.may_resume(NOW)
    panel.receive(t.WAITING, b.waiting("resume", "paused", reason="pain"))
    assert not panel.commands.may_resume(NOW)


def test_only_a_prompt_is_repeated_and_a_rest_can_be_skipped_too(panel: Panel) -> None:
    panel.receive(t.WAITING, b.waiting("enter", "attempt"))
    for command in ("skip", "repeat"):
        assert not panel.commands.prompt_command(command, NOW)  # type: ignore[arg-type]
    assert panel.lines == [("No prompt is shown. Nothing was sent.", "bad")] * 2
    panel.receive(t.WAITING, b.waiting("rest", "rest"))
    assert panel.commands.prompt_command("skip", NOW)
    assert [(act.command, act.reason) for act in panel.peer.of(t.COMMAND)] == [("skip", "rest")]


def mark(name: str) -> Item:
    return Item(
        name.capitalize(), Wording("", ""), t.COMMAND, m.SessionCommand(command="mark", reason=name)
    )


def test_a_mark_replaces_another_only_if_its_key_is_pressed_twice_for_the_same_trial(
    panel: Panel,
) -> None:
    def marked(trial: int) -> None:
        panel.receive(t.TRIAL, b.trial(trial, "f", 400))
        message = m.TrialMarked(attempt=3, trial=trial, mark="missed", correct=False)
        panel.receive(t.MARKED, message)

    marked(4)
    assert panel.commands.pick(mark("missed"), NOW), "the present one is removed at once"
    assert not panel.commands.pick(mark("assisted"), NOW)
    again = "Marked as marker missed already. The same key again: assisted instead."
    assert panel.lines[-1] == (again, "bad")
    marked(5)
    assert not panel.commands.pick(mark("assisted"), NOW)
    assert panel.commands.pick(mark("assisted"), NOW)
    panel.receive(t.TRIAL, b.trial(6, "f", 400))
    assert panel.commands.pick(mark("assisted"), NOW), "a trial without a mark"
    reasons = [act.reason for act in panel.peer.of(t.COMMAND)]
    assert reasons == ["missed", "assisted", "assisted"]


# --- speech


def test_typed_slots_are_filled_and_other_braces_stay(panel: Panel) -> None:
    assert panel.commands.say("{participant} :{", "A", NOW)
    assert not panel.commands.say("{result}", "A", NOW)
    panel.receive(t.ATTEMPT_ENDED, b.attempt())
    assert panel.commands.say("{result}", "A", NOW)
    assert [remark.text for remark in panel.peer.of(t.REMARK)] == ["P01 :{", "0.50 seconds"]


def test_of_two_participants_the_agent_names_the_one_it_speaks_to(panel: Panel) -> None:
    people = {"A": "P01", "B": "P02"}
    names = {"A": "Left", "B": "Right"}
    panel.commands.receive(b.welcome(participants=people, spoken_names=names))
    assert panel.commands.say("Hi", "B", NOW)
    assert panel.lines[-1][0] == "Saying to P02 “Hi” …"
    panel.receive(t.REMARK, m.Remark(id="9", text="Ho", seat="B", actor="operator.ben"))
    assert panel.lines[-1][0] == "ben: Saying to P02 “Ho” …"
    assert panel.commands.edit(b.approval("p1", seat="B", text="Right: Good"), "Good!", NOW)
    panel.answer("refused")
    assert panel.commands.edit(b.approval("p1", seat="B", text="Good"), "Good!", NOW)
    (remark,) = panel.peer.of(t.REMARK)
    assert (remark.seat, remark.text) == ("B", "Right: Hi")
    decisions = panel.peer.of(t.DECISION)
    assert [(each.seat, each.text) for each in decisions] == [("B", "Right: Good!"), ("B", "Good!")]


# --- control


@pytest.mark.parametrize(
    ("role", "connection", "may_stop", "why"),
    [
        ("operator", "connected", True, "ben has control; b takes it."),
        ("observer", "connected", True, "You are an observer: you can only stop the agent."),
        ("operator", "lost", False, "There is no connection."),
    ],
)
def test_without_control_or_connection_nothing_is_sent_but_a_stop(
    role: m.Role, connection: Any, may_stop: bool, why: str
) -> None:
    panel = Panel(role)
    panel.commands.control_key = "b"
    panel.receive(t.PRESENCE, b.presence("baton", "operator.ben", ben="operator"))
    panel.commands.receive(Connection(connection))
    assert not panel.commands.note("coughs", NOW)
    assert not panel.commands.decide(PROPOSAL, "accept", NOW)
    assert panel.lines == [(f"{why} Nothing was sent.", "bad")] * 2
    assert panel.commands.command("stop", NOW) is may_stop
    assert [name for name, _ in panel.peer.sent] == [t.COMMAND.name] * may_stop
