"""Presence of operators and times of modes, each run by its own clock."""

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model import messages as m
from sar_tui.reports.presence import KINDS, MODES, mode_times, presence
from sar_tui.rules.parameters import TaskParameters
from tests.reports.session_script import ANNA, Script

STILL = m.Waiting(what="enter", stage="attempt")
"""Message that only shows that the session went on."""


def test_a_session_without_an_operator_was_not_operated() -> None:
    there = presence(Script().log(60_000, STILL))
    assert (there.duration_s, there.operated_s, there.absences) == (60, 0, ())


def test_the_time_before_the_first_operator_is_no_absence() -> None:
    there = presence(Script().join(10_000).log(60_000, STILL))
    assert (there.duration_s, there.operated_s, there.absences) == (60, 50, ())


def test_a_lost_operator_is_absent_until_they_return() -> None:
    script = Script().join(10_000).join(10_000, state="baton")
    script.join(20_000, state="lost", operated=False).join(25_500).join(25_500, state="baton").log(
        60_000, STILL
    )
    there = presence(script)
    assert there.operated_s == 44.5
    (absence,) = there.absences
    assert (absence.at_s, absence.duration_s, absence.actor, absence.state, absence.came_back) == (
        20,
        5.5,
        ANNA,
        "lost",
        True,
    )


def test_an_operator_who_does_not_come_back_is_absent_until_the_run_ends() -> None:
    script = Script().join(10_000).join(20_000, state="left", operated=False).log(60_000, STILL)
    (absence,) = presence(script).absences
    assert (absence.duration_s, absence.state, absence.came_back) == (40, "left", False)


def test_while_one_of_two_operators_stays_there_is_no_absence() -> None:
    script = (
        Script()
        .join(0)
        .join(5000, "operator.ben")
        .join(8000, state="lost", operated=True)
        .log(10_000, STILL)
    )
    assert presence(script).absences == ()
    assert presence(script).operated_s == 10


def test_an_observer_is_no_operator() -> None:
    came = m.OperatorChanged(actor="observer.eve", role="observer", state="joined", operated=False)
    assert presence(Script().log(1000, came).log(5000, STILL)).operated_s == 0


def test_runs_are_added_each_by_its_own_clock_and_start_without_an_operator() -> None:
    script = Script().join(2000).log(10_000, STILL)
    script.begin(2, 900_000_000).log(900_003_000, STILL).join(900_004_000).log(900_010_000, STILL)
    there = presence(script)
    assert (there.duration_s, there.operated_s) == (20, 8 + 6)
    assert there.absences == ()


def test_an_operator_who_joined_before_a_run_does_not_count_for_it() -> None:
    script = Script().log(10_000, STILL)
    script.run = 2
    script.join(900).begin(2, 1000).log(5000, STILL)
    assert presence(script).operated_s == 0
    assert {t.unattended_s for t in mode_times(script, TaskParameters())} == {14}


def test_modes_are_timed_by_kind_with_the_unattended_part() -> None:
    script = Script().join(1000).log(4000, m.ModeChanged(kind="feedback", mode="veto"))
    script.join(9000, state="lost", operated=False).log(10_000, STILL)
    times = mode_times(script, TaskParameters(operator_feedback="approve"))
    assert [(t.mode, t.time_s, t.unattended_s) for t in times if t.kind == "feedback"] == [
        ("veto", 6, 1),
        ("approve", 4, 1),
    ]
    assert [(t.mode, t.time_s, t.unattended_s) for t in times if t.kind == "gesture"] == [
        ("autonomous", 10, 2)
    ]


def test_a_mode_chosen_by_hand_still_holds_in_the_next_run() -> None:
    script = Script().log(4000, m.ModeChanged(kind="difficulty", mode="manual")).log(5000, STILL)
    script.begin(2, 7000).log(8000, STILL)
    times = {
        t.mode: t.time_s for t in mode_times(script, TaskParameters()) if t.kind == "difficulty"
    }
    assert times == {"autonomous": 4, "manual": 2}


EVENTS = st.one_of(
    st.builds(m.ModeChanged, kind=st.sampled_from(KINDS), mode=st.sampled_from(MODES)),
    st.builds(
        m.OperatorChanged, actor=st.just(ANNA), state=st.just("joined"), operated=st.just(True)
    ),
    st.builds(
        m.OperatorChanged, actor=st.just(ANNA), state=st.just("lost"), operated=st.just(False)
    ),
)


@given(st.lists(st.tuples(st.integers(1, 10_000), EVENTS), max_size=12))
def test_mode_times_of_each_kind_add_up_to_the_session(
    events: list[tuple[int, m.Message]],
) -> None:
    script, ms = Script(), 0
    for after, event in events:
        script.log(ms := ms + after, event)
    script.log(ms + 1000, STILL)
    there = presence(script)
    times = mode_times(script, TaskParameters())
    for kind in KINDS:
        assert round(sum(t.time_s for t in times if t.kind == kind), 3) == there.duration_s
        unattended = round(sum(t.unattended_s for t in times if t.kind == kind), 3)
        assert unattended == round(there.duration_s - there.operated_s, 3)
    assert (
        round(sum(absence.duration_s for absence in there.absences), 3)
        <= there.duration_s - there.operated_s + 1e-9
    )
