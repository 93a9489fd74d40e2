"""The state: what an operator knows, from what the link brings."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from rich.cells import cell_len

from sar_tui.framework import messages as m
from sar_tui.framework import topics as t
from sar_tui.framework.bus import Topic
from sar_tui.framework.clock import SECOND
from sar_tui.link.peer import Connection, MotionTrace
from sar_tui.operator import proposal_view, status_view
from sar_tui.operator.event_log import Act
from sar_tui.operator.session_state import MAX_TRIALS, SessionState
from sar_tui.operator.text_charts import cut, motion, responses, sparkline, two_lines, wrap
from tests.operator import panel_driver as b


def after(*told: tuple[Topic[object], m.Message]) -> SessionState:
    """What is known of a session that was joined, when all this has happened."""
    state = SessionState().receive(Connection("connected")).receive(b.welcome())
    return state.receive([b.frame(topic, message, seq=seq) for seq, (topic, message) in enumerate(told, 1)])


def lines(state: SessionState) -> list[str]:
    return [line.text for line in state.log]


def test_before_anything_is_heard_nothing_is_claimed() -> None:
    state = SessionState()
    assert not state.is_connected
    assert status_view.activity(state, 60).plain == "Not known yet"
    assert status_view.session_line(state) == "Operator"


def test_a_prompt_is_up_until_its_trial_ends() -> None:
    up = after((t.WAITING, b.waiting()), (t.PROMPT, b.prompt()))
    assert up.prompt is not None
    assert "Press: f" in status_view.activity(up, 60).plain
    over = up.receive([b.frame(t.TRIAL, b.trial(5, "f", 412))])
    assert over.prompt is None
    assert over.seat("A").trials[-1].reaction_time_ms == 412


def test_a_prompt_that_was_broken_off_is_not_up() -> None:
    voided = m.PromptVoided(attempt=3, trial=5, presentation=1, reason="pause")
    assert after((t.PROMPT, b.prompt()), (t.VOIDED, voided)).prompt is None


def test_words_stand_until_a_trial_begins_and_the_face_then_listens() -> None:
    said = after((t.ACTION, b.action("a1")))
    assert (said.agent.words, said.agent.face) == (b.proposal().text, "happy")
    begun = said.receive([b.frame(t.WAITING, b.waiting("quiet"))])
    assert (begun.agent.words, begun.agent.face) == ("", "listening")


def test_words_that_join_stand_below_those_that_are_there() -> None:
    state = after((t.ACTION, b.action("a1")), (t.ACTION, b.action("a2", text="And rest a little.", joins=True)))
    assert (state.agent.words, state.agent.more) == (b.proposal().text, "And rest a little.")


def test_an_answer_that_is_awaited_makes_the_agent_think_and_then_listen() -> None:
    thinking = after((t.WAITING, b.waiting("answer", "answer")))
    assert thinking.agent.face == "thinking"
    assert thinking.receive([b.frame(t.WAITING, b.waiting("enter", "attempt"))]).agent.face == "listening"


def test_the_attempt_is_counted_in_the_operators_words_and_is_the_one_that_is_answered_until_the_next_begins() -> None:
    done = b.frame(t.ATTEMPT_ENDED, b.attempt(attempt=2))
    state = SessionState().receive(b.welcome(attempts=22, parameters={"practice_attempts": 2}))
    spanish = {"attempt": 3, "attempt_name": "intento 1 de 20"}
    answered = state.receive([done, b.frame(t.WAITING, b.waiting("answer", "answer", **spanish))])
    assert "practice 2 of 2" in status_view.session_line(answered)
    begun = answered.receive([b.frame(t.WAITING, b.waiting("enter", "attempt", **spanish))])
    assert "attempt 1 of 20" in status_view.session_line(begun)


def test_the_level_of_the_next_attempt_is_told_apart_from_that_of_this_one() -> None:
    changed = m.LevelChanged(previous=4, level=5, reason="operator")
    state = after((t.WAITING, b.waiting()), (t.LEVEL, changed))
    assert "level 4, then 5" in status_view.session_line(state)
    assert lines(state) == ["Level 4 → 5 (an operator)."]


def test_a_trial_that_is_told_twice_counts_once_and_old_ones_are_forgotten() -> None:
    twice = after(*[(t.TRIAL, b.trial(number, "f", 400)) for number in (1, 2, 2)])
    assert [trial.trial for trial in twice.seat("A").trials] == [1, 2]
    many = after(*[(t.TRIAL, b.trial(number, "f", 400)) for number in range(1, 90)])
    assert len(many.seat("A").trials) == MAX_TRIALS


def test_a_mark_changes_whether_the_trial_was_right() -> None:
    marked = m.TrialMarked(attempt=3, trial=1, mark="missed", correct=False)
    state = after((t.TRIAL, b.trial(1, "f", 400)), (t.MARKED, marked))
    assert not state.seat("A").trials[0].correct


def test_the_baton_is_with_whom_the_session_says_that_it_is() -> None:
    mine = after((t.PRESENCE, b.presence()))
    assert (mine.holder, mine.has_control) == (b.ANNA, True)
    theirs = mine.receive([b.frame(t.PRESENCE, b.presence("baton", "operator.ben", ben="operator"))])
    assert (theirs.holder, theirs.has_control) == ("operator.ben", False)
    lost = m.OperatorChanged(actor="operator.ben", state="lost", operated=False, detail="The connection broke.")
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


def test_one_who_comes_late_knows_who_has_the_baton_from_what_was_told_last() -> None:
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


def test_of_many_who_watch_their_number_is_told() -> None:
    peers: dict[str, m.Role] = {"cara": "observer", "dan": "observer", "eve": "observer"}
    assert status_view.link_status(after((t.PRESENCE, b.presence(**peers)))).plain == "● in control · 3 watch"


def test_an_observer_never_steers() -> None:
    assert not SessionState().receive(Connection("connected")).receive(b.welcome("observer")).has_control


def test_a_welcome_that_comes_again_begins_anew_so_that_nothing_is_told_twice() -> None:
    state = after((t.TRIAL, b.trial(1, "f", 400)), (t.PRESENCE, b.presence()))
    again = state.receive(b.welcome())
    assert again.seats == {}
    assert again.log == ()
    assert again.is_connected


def test_when_the_link_is_lost_what_is_shown_stays_and_what_goes_on_is_told() -> None:
    state = after((t.TRIAL, b.trial(1, "f", 400))).receive(Connection("lost", "The connection broke."))
    assert state.seat("A").trials
    assert not state.is_connected
    assert "goes on by itself (autonomous)" in status_view.link_loss(state)
    assert "The connection broke" in status_view.link_loss(state)


def test_what_was_refused_or_missed_or_fell_away_is_told_in_a_line() -> None:
    state = after(
        (t.REFUSED, m.ActRefused(actor="observer.cara", what="a command", why="An observer cannot act.", count=3)),
        (t.MISSED, m.ActMissed(actor=b.ANNA, what="veto p1", why="Its time was over.")),
        (t.DROPPED, m.Dropped(id="p1", reason="expired")),
        (t.DROPPED, m.Dropped(id="p2", reason="vetoed", actor=b.ANNA)),
        (t.STORAGE, m.StorageChanged(working=False, reason="The disk is full.")),
    )
    assert lines(state) == [
        "Refused for cara: a command (3 times). An observer cannot act.",
        "Too late: veto p1. Its time was over.",
        "The proposal expired: nobody decided in time.",
        "Cannot write to the disk: The disk is full.",
    ]


def test_a_voice_that_fails_is_told_until_it_sounds_again() -> None:
    failed = m.OutputReport(action="a1", output="speech", part="say", state="failed", at=0, detail="no loudspeaker")
    state = after((t.REPORT, failed))
    assert "No voice: no loudspeaker" in status_view.activity(state, 60).plain
    assert state.receive([b.frame(t.REPORT, replace(failed, state="started"))]).voice == ""


def test_two_participants_are_shown_each_with_their_own_responses() -> None:
    state = SessionState().receive(Connection("connected")).receive(b.welcome(participants={"A": "P01", "B": "P02"}))
    state = state.receive(
        [b.frame(t.TRIAL, b.trial(1, "f", 400)), b.frame(t.TRIAL, b.trial(1, "k", 500, correct=False, seat="B"))]
    )
    shown = status_view.activity(state, 36).plain
    assert "P01 ✓f" in shown
    assert "P02 ✗k" in shown
    assert "400 ms" in shown
    assert len(shown.splitlines()) <= 7


def test_of_two_participants_the_last_results_stand_between_attempts_and_the_times_in_trials() -> None:
    state = SessionState().receive(Connection("connected")).receive(b.welcome(participants={"A": "P01", "B": "P02"}))
    state = state.receive([b.frame(t.TRIAL, b.trial(1, "k", 430, seat="B")), b.frame(t.ATTEMPT_ENDED, b.attempt("B"))])
    between = state.receive([b.frame(t.WAITING, b.waiting("enter", "attempt"))])
    assert "✓ 498 of 520 ms, 95%" in status_view.activity(between, 32).plain
    during = between.receive([b.frame(t.WAITING, b.waiting())])
    assert "430 ms" in status_view.activity(during, 32).plain


def test_a_filler_is_gone_when_the_wait_that_it_covered_is_over() -> None:
    filler = b.action("s1", kind="filler", text="Just a moment, please.")
    stalling = after((t.ACTION, filler), (t.WAITING, b.waiting("answer", "answer")))
    assert stalling.agent.words == "Just a moment, please."
    over = stalling.receive([b.frame(t.WAITING, b.waiting("enter", "attempt"))])
    assert (over.agent.words, over.agent.face) == ("", "listening")
    answered = stalling.receive([b.frame(t.ACTION, b.action("a1")), b.frame(t.WAITING, b.waiting("enter", "attempt"))])
    assert answered.agent.words == b.proposal().text


def test_a_cue_stands_until_the_response_is_there() -> None:
    cued = after((t.WAITING, b.waiting("foreperiod")), (t.CUE, b.cue()), (t.WAITING, b.waiting("response")))
    assert cued.agent.cue is not None
    assert cued.receive([b.frame(t.WAITING, b.waiting("quiet"))]).agent.cue is None


def test_what_went_out_because_nobody_approved_it_in_time_is_told_but_no_veto_that_was_not_made() -> None:
    late = {"ground": "deadline", "actor": "agent"}
    state = after(
        (t.ACTION, b.action("a1", mode="approve", **late)),
        (t.ACTION, b.action("a2", mode="veto", **late)),
        (t.ACTION, b.action("a3", mode="approve", ground="operator", actor=b.ANNA)),
    )
    assert lines(state) == ["Nobody decided in time: the feedback was sent unchanged."]


def test_what_fell_away_is_called_by_its_kind_and_a_filler_is_nobodys_news() -> None:
    waits = b.arbiter_state(
        b.approval("p1", kind="encouragement"),
        b.approval("l1", level=5),
        replace(b.approval("l2", level=6), mode="veto"),
        queued=(b.action("s1", kind="filler"),),
    )
    ruled = {"level": 5, "ground": "deadline", "at": 0, "actor": "agent"}
    state = after(
        (t.ARBITER_STATE, waits),
        (t.DROPPED, m.Dropped(id="p1", reason="late")),
        (t.DROPPED, m.Dropped(id="s1", reason="late")),
        (t.LEVEL_DECIDED, m.LevelDecided(id="l1", decision="accepted", **ruled)),
        (t.LEVEL_DECIDED, m.LevelDecided(id="l2", decision="accepted", **ruled)),
        (t.LEVEL_DECIDED, m.LevelDecided(id="l1", decision="accepted", **ruled | {"ground": "operator"})),
        (t.LEVEL_DECIDED, m.LevelDecided(id="l1", decision="rejected", **ruled | {"ground": "mode", "level": 0})),
    )
    assert lines(state) == [
        "The encouragement came too late: the session had moved on.",
        "The next level is 5 (nobody decided in time).",
        "The level stays (nobody decided).",
    ]


def test_of_long_words_that_were_sent_the_log_keeps_room_for_what_became_of_them() -> None:
    act = Act("Said “" + "on and " * 30 + "on”", "topic", m.Remark(at=b.START), latency=5_000_000)
    assert act.line(b.START).text.endswith("… · link 5 ms")
    assert cell_len(act.line(b.START).text) < 70


# --- the order of proposals ----------------------------------------------------------------------------------------


def test_what_is_due_first_comes_first_and_of_what_was_made_together_what_has_to_be_read() -> None:
    level, feedback = b.approval("l1", 4000, level=5), b.approval("f1", 4001)
    gesture = b.approval("g1", 4002, kind="gesture", text="")
    soon, free = b.approval("e1", 2000, kind="encouragement"), b.approval("m1", None)
    order = proposal_view.by_urgency((free, level, gesture, feedback, soon))
    assert [approval.proposal.id for approval in order] == ["e1", "f1", "l1", "g1", "m1"]


@given(st.lists(st.tuples(st.none() | st.integers(0, 9000), st.sampled_from(["feedback", "gesture", "rest"]))))
def test_none_is_lost_in_the_order_and_what_needs_nobody_soon_is_last(waiting: list[tuple[int | None, str]]) -> None:
    given_ = tuple(b.approval(f"p{n}", ms, kind=kind) for n, (ms, kind) in enumerate(waiting))
    order = proposal_view.by_urgency(given_)
    assert sorted(order, key=given_.index) == list(given_)
    is_free = [approval.deadline is None for approval in order]
    assert is_free == sorted(is_free)


def test_a_hands_motion_is_kept_for_some_seconds_only() -> None:
    state = SessionState()
    for _ in range(20):
        state = state.receive(MotionTrace("A", SECOND, 10.0, (0.5,) * 10))
    assert len(state.seat("A").rates) == 80


def test_right_and_wrong_are_told_by_signs_and_a_miss_by_another() -> None:
    trials = [b.trial(1, "f", 400), b.trial(2, "j", 400, correct=False), b.trial(3, "d", None)]
    assert "".join(text for text, _ in responses(trials, 40)) == "✓f ✗j –d "


def test_what_does_not_fit_is_the_oldest() -> None:
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


@pytest.mark.parametrize("text", ["", "short", "one two three four five six", "漢字 漢字 漢字 漢字 漢字", "x" * 50])
def test_words_stand_on_two_lines_whatever_they_are(text: str) -> None:
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
def test_words_are_folded_and_where_some_have_no_room_that_is_told(text: str, lines: list[str]) -> None:
    assert wrap(text, 10, 2) == lines


def test_what_is_told_again_and_again_keeps_one_line_of_the_journal() -> None:
    state = SessionState().receive(Connection("connected")).receive(b.welcome())
    knock = m.ActRefused(actor="unknown", what="a connection", why="It has no certificate.")
    state = state.receive([b.frame(t.REFUSED, knock) for _ in range(40)])
    told = "40 times: Refused for unknown: a connection. It has no certificate."
    assert [line.text_with_count for line in state.log] == [told]
    state = state.receive([b.frame(t.REFUSED, replace(knock, why="It has expired."))])
    assert [line.times for line in state.log] == [40, 1]
