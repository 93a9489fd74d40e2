"""State of the session as the panel knows it, the texts about it, and the order of proposals."""

from datetime import datetime
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from rich.cells import cell_len

from sar_tui.link.peer import Connection, MotionTrace
from sar_tui.loop import topics as t
from sar_tui.loop.answers import answer_to
from sar_tui.loop.bus import Topic
from sar_tui.loop.marks import TrialMark
from sar_tui.model import messages as m
from sar_tui.model.units import SECOND
from sar_tui.operator import proposal_strip, status_view
from sar_tui.operator.act_log import Act
from sar_tui.operator.commands import by_urgency
from sar_tui.operator.event_text import Line
from sar_tui.operator.session_state import MAX_ATTEMPTS, MAX_TRIALS, SessionState
from sar_tui.operator.text_charts import cut, motion, responses, two_lines, wrap
from sar_tui.reports.charts import sparkline
from tests.operator import panel_driver as b


def after(*logged: tuple[Topic[object], m.Message]) -> SessionState:
    """Return the state after joining a session and receiving these messages."""
    state = SessionState().receive(Connection("connected")).receive(b.welcome())
    return state.receive(
        [b.frame(topic, message, seq=seq) for seq, (topic, message) in enumerate(logged, 1)]
    )


def lines(state: SessionState) -> list[str]:
    return [line.text for line in state.log]


def test_at_first_everything_is_unknown() -> None:
    state = SessionState()
    assert not state.is_connected
    assert status_view.activity(state, 60).plain == "Not known yet"
    assert status_view.session_line(state) == "Operator"


def test_a_prompt_is_shown_until_its_trial_ends() -> None:
    up = after((t.WAITING, b.waiting()), (t.PROMPT, b.prompt()))
    assert up.prompt is not None
    assert "Press: f" in status_view.activity(up, 60).plain
    over = up.receive([b.frame(t.TRIAL, b.trial(5, "f", 412))])
    assert over.prompt is None
    assert over.seat("A").trials[-1].reaction_time_ms == 412


def test_the_answer_to_a_trial_and_an_attempt_that_begins_by_itself_are_named() -> None:
    told = after((t.WAITING, b.waiting("result")))
    assert "The answer to a prompt is shown" in status_view.activity(told, 60).plain
    coming = after((t.WAITING, b.waiting("enter", "attempt", until=5)))
    assert "The next attempt begins by itself" in status_view.activity(coming, 60).plain


def test_an_attempt_that_began_again_is_counted_once() -> None:
    again = after((t.WAITING, b.waiting("enter", "attempt", attempt=5, restarts=2)))
    assert "attempt 3 of 20" in status_view.session_line(again)


def test_an_attempt_without_a_goal_has_neither_tick_nor_cross() -> None:
    free = after(
        (t.ATTEMPT_ENDED, b.attempt(goal=None, outcome="none")),
        (t.WAITING, b.waiting("enter", "attempt")),
    )
    shown = status_view.activity(free, 60).plain
    assert "Attempt 2 · 498, 95%" in shown
    assert not {"✓", "✗"} & set(shown)


def test_a_voided_prompt_is_not_shown() -> None:
    voided = m.PromptVoided(attempt=3, trial=5, presentation=1, reason="pause")
    assert after((t.PROMPT, b.prompt()), (t.VOIDED, voided)).prompt is None


def test_the_agents_text_is_shown_until_a_trial_begins_and_then_it_listens() -> None:
    said = after((t.ACTION, b.action("a1")))
    assert (said.agent.words, said.agent.face) == (b.proposal().text, "happy")
    begun = said.receive([b.frame(t.WAITING, b.waiting("quiet"))])
    assert (begun.agent.words, begun.agent.face) == ("", "listening")


def test_joined_text_is_shown_below_the_text_before() -> None:
    state = after(
        (t.ACTION, b.action("a1")),
        (t.ACTION, b.action("a2", text="And rest a little.", joins=True)),
    )
    assert (state.agent.words, state.agent.more) == (b.proposal().text, "And rest a little.")


def test_the_agent_thinks_while_feedback_is_awaited_and_then_listens() -> None:
    thinking = after((t.WAITING, b.waiting("answer", "answer")))
    assert thinking.agent.face == "thinking"
    assert (
        thinking.receive([b.frame(t.WAITING, b.waiting("enter", "attempt"))]).agent.face
        == "listening"
    )


def test_the_attempt_is_named_in_english_and_stays_the_same_during_feedback() -> None:
    done = b.frame(t.ATTEMPT_ENDED, b.attempt(attempt=2))
    state = SessionState().receive(b.welcome(attempts=22, parameters={"practice_attempts": 2}))
    spanish = {"attempt": 3, "attempt_name": "intento 1 de 20"}
    answered = state.receive([done, b.frame(t.WAITING, b.waiting("answer", "answer", **spanish))])
    assert "practice 2 of 2" in status_view.session_line(answered)
    begun = answered.receive([b.frame(t.WAITING, b.waiting("enter", "attempt", **spanish))])
    assert "attempt 1 of 20" in status_view.session_line(begun)


def test_the_next_level_is_shown_beside_the_current_one() -> None:
    changed = m.LevelChanged(previous=4, level=5, reason="operator")
    state = after((t.WAITING, b.waiting()), (t.LEVEL, changed))
    assert "level 4, then 5" in status_view.session_line(state)
    assert lines(state) == ["Level 4 → 5 (an operator)."]


def test_a_repeated_trial_counts_once_and_old_trials_are_dropped() -> None:
    twice = after(*[(t.TRIAL, b.trial(number, "f", 400)) for number in (1, 2, 2)])
    assert [trial.trial for trial in twice.seat("A").trials] == [1, 2]
    many = after(*[(t.TRIAL, b.trial(number, "f", 400)) for number in range(1, 90)])
    assert len(many.seat("A").trials) == MAX_TRIALS


def test_all_attempts_are_kept_and_one_that_is_scored_again_replaces_its_earlier_score() -> None:
    again = [b.attempt(attempt=1), b.attempt(attempt=2), b.attempt(attempt=2, metric=510.0)]
    state = after(*[(t.ATTEMPT_ENDED, ended) for ended in again])
    assert [(ended.attempt, ended.metric) for ended in state.seat("A").attempts] == [
        (1, 498.2),
        (2, 510.0),
    ]
    assert state.seat("A").attempt == again[-1]
    many = after(
        *[(t.ATTEMPT_ENDED, b.attempt(attempt=number)) for number in range(1, MAX_ATTEMPTS + 9)]
    )
    assert len(many.seat("A").attempts) == MAX_ATTEMPTS


def test_a_mark_changes_whether_a_trial_is_correct() -> None:
    marked = m.TrialMarked(attempt=3, trial=1, mark="missed", correct=False)
    state = after((t.TRIAL, b.trial(1, "f", 400)), (t.MARKED, marked))
    assert not state.seat("A").trials[0].correct


def test_a_panel_that_joins_knows_the_mark_of_an_earlier_run() -> None:
    state = SessionState().receive(
        b.welcome(trial_mark=TrialMark(done=(2, 1), marks={(2, 1): "missed"}))
    )
    assert (state.trial_mark.trial, state.trial_mark.present) == ((2, 1), "missed")
    begun = state.receive(
        [
            b.frame(
                t.ATTEMPT_STARTED, m.AttemptStarted(attempt=3, practice=False, level=1, trials=20)
            )
        ]
    )
    assert begun.trial_mark.present == ""


def test_after_an_aborted_trial_a_mark_is_put_on_the_last_one_again() -> None:
    state = after(
        (t.ATTEMPT_STARTED, m.AttemptStarted(attempt=3, practice=False, level=1, trials=20)),
        (t.TRIAL, b.trial(1, "f", 400)),
        (t.MARKED, m.TrialMarked(attempt=3, trial=1, mark="assisted", correct=False)),
        (t.WAITING, b.waiting("response", "trial", attempt=3, trial=2)),
        (t.MARKED, m.TrialMarked(attempt=3, trial=2, mark="missed", correct=False)),
    )
    assert (state.trial_mark.trial, state.trial_mark.present) == ((3, 2), "missed")
    aborted = state.receive(
        [
            b.frame(t.MARKED, m.TrialMarked(attempt=3, trial=2, mark="", correct=True)),
            b.frame(t.VOIDED, m.PromptVoided(attempt=3, trial=2, presentation=1, reason="pause")),
        ]
    )
    assert (aborted.trial_mark.trial, aborted.trial_mark.present) == ((3, 1), "assisted")


def test_the_session_says_who_has_control() -> None:
    mine = after((t.PRESENCE, b.presence()))
    assert (mine.holder, mine.has_control) == (b.ANNA, True)
    theirs = mine.receive(
        [b.frame(t.PRESENCE, b.presence("baton", "operator.ben", ben="operator"))]
    )
    assert (theirs.holder, theirs.has_control) == ("operator.ben", False)
    lost = m.OperatorChanged(
        actor="operator.ben", state="lost", operated=False, detail="The connection broke."
    )
    gone = theirs.receive([b.frame(t.PRESENCE, lost)])
    assert (gone.holder, gone.has_control) == ("", True)
    left = replace(lost, holder="", peers={b.ANNA: "operator"})
    alone = theirs.receive(Connection("connected")).receive([b.frame(t.PRESENCE, left)])
    assert status_view.link_status(alone).plain == "● nobody in control · b takes it"
    assert lines(gone) == [
        "You have control.",
        "ben has control.",
        "ben lost the connection: The connection broke.",
    ]


def test_an_operator_who_joins_late_knows_who_has_control() -> None:
    watcher = m.OperatorChanged(
        actor="observer.cara",
        role="observer",
        state="joined",
        operated=True,
        holder="operator.ben",
        peers={"operator.ben": "operator", "observer.cara": "observer"},
    )
    late = after((t.PRESENCE, watcher))
    assert not late.has_control
    assert "ben in control · b takes it · cara watches" in status_view.link_status(late).plain


def test_several_observers_are_counted() -> None:
    peers: dict[str, m.Role] = {"cara": "observer", "dan": "observer", "eve": "observer"}
    assert (
        status_view.link_status(after((t.PRESENCE, b.presence(**peers)))).plain
        == "● in control · 3 watch"
    )


def test_an_observer_never_has_control() -> None:
    assert (
        not SessionState()
        .receive(Connection("connected"))
        .receive(b.welcome("observer"))
        .has_control
    )


def test_a_second_welcome_resets_the_state() -> None:
    state = after((t.TRIAL, b.trial(1, "f", 400)), (t.PRESENCE, b.presence()))
    again = state.receive(b.welcome())
    assert again.seats == {}
    assert again.log == ()
    assert again.is_connected


def test_a_lost_link_keeps_the_last_state_and_says_what_the_session_does() -> None:
    state = after((t.TRIAL, b.trial(1, "f", 400))).receive(
        Connection("lost", "The connection broke.")
    )
    assert state.seat("A").trials
    assert not state.is_connected
    assert "goes on by itself (autonomous)" in status_view.link_loss(state)
    assert "The connection broke" in status_view.link_loss(state)


def test_refused_acts_and_dropped_proposals_are_logged() -> None:
    state = after(
        (
            t.REFUSED,
            m.PeerRequestRefused(
                actor="observer.cara", what="a command", why="An observer cannot act.", count=3
            ),
        ),
        (t.DROPPED, m.Dropped(id="p1", reason="expired")),
        (t.DROPPED, m.Dropped(id="p2", reason="vetoed", actor=b.ANNA)),
        (t.STORAGE, m.StorageChanged(working=False, reason="The disk is full.")),
    )
    assert lines(state) == [
        "Refused for cara: a command (3 times). An observer cannot act.",
        "The proposal expired: nobody decided in time.",
        "Cannot write to the disk: The disk is full.",
    ]


def test_a_failed_voice_is_shown_until_it_works_again() -> None:
    failed = m.OutputReport(
        action="a1", output="speech", part="say", state="failed", at=0, detail="no loudspeaker"
    )
    state = after((t.REPORT, failed))
    assert "No voice: no loudspeaker" in status_view.activity(state, 60).plain
    assert state.receive([b.frame(t.REPORT, replace(failed, state="started"))]).voice == ""


def test_two_participants_have_rows_of_their_own() -> None:
    state = (
        SessionState()
        .receive(Connection("connected"))
        .receive(b.welcome(participants={"A": "P01", "B": "P02"}))
    )
    state = state.receive(
        [
            b.frame(t.TRIAL, b.trial(1, "f", 400)),
            b.frame(t.TRIAL, b.trial(1, "k", 500, correct=False, seat="B")),
        ]
    )
    shown = status_view.activity(state, 36).plain
    assert "P01 ✓f" in shown
    assert "P02 ✗k" in shown
    assert "400 ms" in shown
    assert len(shown.splitlines()) <= 7


def test_two_participants_have_results_between_attempts_and_times_in_trials() -> None:
    state = (
        SessionState()
        .receive(Connection("connected"))
        .receive(b.welcome(participants={"A": "P01", "B": "P02"}))
    )
    state = state.receive(
        [b.frame(t.TRIAL, b.trial(1, "k", 430, seat="B")), b.frame(t.ATTEMPT_ENDED, b.attempt("B"))]
    )
    between = state.receive([b.frame(t.WAITING, b.waiting("enter", "attempt"))])
    assert "✓ 498 of 520 ms, 95%" in status_view.activity(between, 32).plain
    during = between.receive([b.frame(t.WAITING, b.waiting())])
    assert "430 ms" in status_view.activity(during, 32).plain


def test_a_filler_disappears_when_the_wait_is_over() -> None:
    filler = b.action("s1", kind="filler", text="Just a moment, please.")
    waiting = after((t.ACTION, filler), (t.WAITING, b.waiting("answer", "answer")))
    assert waiting.agent.words == "Just a moment, please."
    over = waiting.receive([b.frame(t.WAITING, b.waiting("enter", "attempt"))])
    assert (over.agent.words, over.agent.face) == ("", "listening")
    answered = waiting.receive(
        [b.frame(t.ACTION, b.action("a1")), b.frame(t.WAITING, b.waiting("enter", "attempt"))]
    )
    assert answered.agent.words == b.proposal().text


def test_a_cue_is_shown_until_the_response() -> None:
    cued = after(
        (t.WAITING, b.waiting("foreperiod")), (t.CUE, b.cue()), (t.WAITING, b.waiting("response"))
    )
    assert cued.agent.cue is not None
    assert cued.receive([b.frame(t.WAITING, b.waiting("quiet"))]).agent.cue is None


def test_an_action_done_without_approval_is_logged_but_not_one_without_veto() -> None:
    late = {"ground": "deadline", "actor": "agent"}
    state = after(
        (t.ACTION, b.action("a1", mode="approve", **late)),
        (t.ACTION, b.action("a2", mode="veto", **late)),
        (t.ACTION, b.action("a3", mode="approve", ground="operator", actor=b.ANNA)),
    )
    assert lines(state) == ["Nobody decided in time: the feedback was sent unchanged."]


def test_dropped_proposals_are_logged_by_kind_except_fillers() -> None:
    waits = b.arbiter_state(
        b.approval("p1", kind="encouragement"),
        b.approval("l1", level=5),
        replace(b.approval("l2", level=6), mode="veto"),
        queued=(b.action("s1", kind="filler"),),
    )
    decided = {"level": 5, "ground": "deadline", "at": 0, "actor": "agent"}
    state = after(
        (t.ARBITER_STATE, waits),
        (t.DROPPED, m.Dropped(id="p1", reason="late")),
        (t.DROPPED, m.Dropped(id="s1", reason="late")),
        (t.LEVEL_DECIDED, m.LevelDecided(id="l1", decision="accepted", **decided)),
        (t.LEVEL_DECIDED, m.LevelDecided(id="l2", decision="accepted", **decided)),
        (
            t.LEVEL_DECIDED,
            m.LevelDecided(id="l1", decision="accepted", **decided | {"ground": "operator"}),
        ),
        (
            t.LEVEL_DECIDED,
            m.LevelDecided(
                id="l1", decision="rejected", **decided | {"ground": "mode", "level": 0}
            ),
        ),
    )
    assert lines(state) == [
        "The encouragement came too late: the session had moved on.",
        "The next level is 5 (nobody decided in time).",
        "The level stays (nobody decided).",
    ]


def test_a_long_act_leaves_room_for_its_outcome_in_the_log() -> None:
    said = "Said “" + "on and " * 30 + "on”"
    remark = m.Remark(id="1", at=b.START)
    act = Act(said, t.REMARK.name, remark, answer=answer_to(remark, b.START + 5_000_000))
    assert act.line().text.endswith("… · link 5 ms")
    assert cell_len(act.line().text) < 70


# --- the header and the log


LEVEL_5 = m.LevelChanged(previous=4, level=5, reason="success")


@pytest.mark.parametrize("width", [20, 29, 40, 60, 120])
@pytest.mark.parametrize(
    "participants", [{"A": "P01"}, {"A": "LEFT-PERSON-01", "B": "RIGHT-PERSON-02"}]
)
def test_the_level_stays_in_the_header_however_little_room_there_is(
    width: int, participants: dict[str, str]
) -> None:
    state = SessionState().receive(b.welcome(participants=participants))
    state = state.receive([b.frame(t.WAITING, b.waiting()), b.frame(t.LEVEL, LEVEL_5)])
    line = status_view.session_line(state, width)
    assert cell_len(line) <= width
    assert "level 4, then 5" in line or line.startswith("level 4→5 · 3/20")


def test_each_line_of_the_log_has_its_time_of_day() -> None:
    wall = datetime(2026, 1, 5, 0, 0, 10)
    log = [Line(b.START - 20 * SECOND, "One"), Line(b.START, "Two", "good"), Line(0, "Three")]
    shown = status_view.log_lines(
        log, 40, 5, partial(status_view.time_of_day, now=b.START, wall=wall)
    )
    assert shown.plain.splitlines() == ["23:59:50 · One", "00:00:10 ✓ Two", "         · Three"]


# --- the order of proposals


def test_proposals_are_sorted_by_deadline_and_then_by_reading_time() -> None:
    level, feedback = b.approval("l1", 4000, level=5), b.approval("f1", 4001)
    gesture = b.approval("g1", 4002, kind="gesture", text="")
    soon, free = b.approval("e1", 2000, kind="encouragement"), b.approval("m1", None)
    order = by_urgency((free, level, gesture, feedback, soon))
    assert [approval.proposal.id for approval in order] == ["e1", "f1", "l1", "g1", "m1"]


def test_a_reported_change_stands_beside_its_mdc95_in_the_title() -> None:
    evidence = "reach time -0.421 s (MDC95 0.380 s)"
    approval = b.approval("f1", 4000, evidence=evidence)
    assert evidence in proposal_strip.title(approval, 1, 1, "")
    assert "MDC95" not in proposal_strip.proposal_text(approval.proposal, None)


@given(
    st.lists(
        st.tuples(
            st.none() | st.integers(0, 9000), st.sampled_from(["feedback", "gesture", "rest"])
        )
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


def test_only_some_seconds_of_motion_are_stored() -> None:
    state = SessionState()
    for _ in range(20):
        state = state.receive(MotionTrace("A", SECOND, 10.0, (0.5,) * 10))
    assert len(state.seat("A").rates) == 80


def test_correct_wrong_and_missed_responses_have_different_signs() -> None:
    trials = [b.trial(1, "f", 400), b.trial(2, "j", 400, correct=False), b.trial(3, "d", None)]
    assert "".join(text for text, _ in responses(trials, 40)) == "✓f ✗j –d "


def test_the_oldest_responses_are_left_out() -> None:
    trials = [b.trial(number, "f", 400) for number in range(1, 9)]
    assert "".join(text for text, _ in responses([b.trial(0, "a", 1.0), *trials], 24)) == "✓f " * 8


def test_a_sparkline_reaches_from_the_least_to_the_greatest_and_leaves_gaps() -> None:
    assert sparkline([100.0, None, 200.0], 10) == "▁·█"
    assert sparkline([None], 10) == "·"
    assert sparkline([300.0, 300.0], 10) == "▁▁"


def test_motion_is_drawn_within_its_width_and_noise_stays_low() -> None:
    assert len(motion([0.1] * 400, 30)) <= 30
    assert set(motion([0.05] * 30, 30)) == {"▁"}
    assert motion([], 30) == ""


@pytest.mark.parametrize(
    "text", ["", "short", "one two three four five six", "漢字 漢字 漢字 漢字 漢字", "x" * 50]
)
def test_text_fits_exactly_two_lines(text: str) -> None:
    lines = two_lines(text, 10).split("\n")
    assert len(lines) == 2
    assert all(cell_len(line) <= 10 for line in lines)
    assert cell_len(cut(text, 10)) <= 10
    assert "".join(lines).endswith("…") == (cell_len(text) > 20)


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("", []),
        ("short", ["short"]),
        ("one two three four", ["one two", "three four"]),
        ("one two three four five", ["one two", "three fou…"]),
        ("one\ntwo", ["one", "two"]),
        ("one\ntwo\nthree", ["one", "two…"]),
        ("x" * 25, ["x" * 10, "x" * 9 + "…"]),
    ],
)
def test_text_is_wrapped_and_cut_with_an_ellipsis(text: str, lines: list[str]) -> None:
    assert wrap(text, 10, 2) == lines


def test_repeated_events_share_one_line_of_the_log() -> None:
    state = SessionState().receive(Connection("connected")).receive(b.welcome())
    refused = m.PeerRequestRefused(
        actor="unknown", what="a connection", why="It has no certificate."
    )
    state = state.receive([b.frame(t.REFUSED, refused) for _ in range(40)])
    text = "40 times: Refused for unknown: a connection. It has no certificate."
    assert [line.text_with_count for line in state.log] == [text]
    state = state.receive([b.frame(t.REFUSED, replace(refused, why="It has expired."))])
    assert [line.times for line in state.log] == [40, 1]


def test_a_goal_that_the_therapist_sets_is_in_the_log() -> None:
    state = after((t.SETTING, m.SettingChanged(name="threshold", value=700.0)))
    assert lines(state) == ["The therapist set the goal to 700 from the next attempt on."]
