"""Presence of operators and times of modes, each run by its own clock."""

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.model import messages as m
from sar_tui.reports.presence import KINDS, MODES, mode_times, presence
from sar_tui.rules.parameters import TaskParameters
from tests.reports.session_script import ANNA, Script, has

STILL = m.Waiting(what="enter", stage="attempt")
"""Message that only shows that the session went on."""


def test_an_operator_is_absent_from_going_until_they_return_or_the_run_ends() -> None:
    has(presence(Script().log(60_000, STILL)), duration_s=60, operated_s=0, absences=())
    there = presence(Script().join(10_000).log(60_000, STILL))
    has(there, duration_s=60, operated_s=50, absences=())
    script = Script().join(10_000).join(10_000, state="baton").gone(20_000)
    there = presence(script.join(25_500).join(25_500, state="baton").log(60_000, STILL))
    assert there.operated_s == 44.5
    (absence,) = there.absences
    has(absence, at_s=20, duration_s=5.5, actor=ANNA, state="lost", came_back=True)
    (absence,) = presence(Script().join(10_000).gone(20_000, "left").log(60_000, STILL)).absences
    has(absence, duration_s=40, state="left", came_back=False)


def test_while_one_of_two_operators_stays_there_is_no_absence_and_an_observer_is_none() -> None:
    script = Script().join(0).join(5000, "operator.ben").join(8000, state="lost", operated=True)
    has(presence(script.log(10_000, STILL)), absences=(), operated_s=10)
    came = m.OperatorChanged(actor="observer.eve", role="observer", state="joined", operated=False)
    assert presence(Script().log(1000, came).log(5000, STILL)).operated_s == 0


def test_runs_are_added_each_by_its_own_clock_and_start_without_an_operator() -> None:
    script = Script().join(2000).log(10_000, STILL)
    script.begin(2, 900_000_000).log(900_003_000, STILL).join(900_004_000).log(900_010_000, STILL)
    has(presence(script), duration_s=20, operated_s=8 + 6, absences=())


def test_an_operator_who_joined_before_a_run_does_not_count_for_it() -> None:
    script = Script().log(10_000, STILL)
    script.run = 2
    script.join(900).begin(2, 1000).log(5000, STILL)
    assert presence(script).operated_s == 0
    assert {t.unattended_s for t in mode_times(script, TaskParameters())} == {14}


def test_modes_are_timed_by_kind_with_the_unattended_part() -> None:
    script = Script().join(1000).log(4000, m.ModeChanged(kind="feedback", mode="veto"))
    times = mode_times(
        script.gone(9000).log(10_000, STILL), TaskParameters(operator_feedback="approve")
    )
    found = {(t.kind, t.mode): (t.time_s, t.unattended_s) for t in times}
    assert found["feedback", "veto"] == (6, 1)
    assert found["feedback", "approve"] == (4, 1)
    assert found["gesture", "autonomous"] == (10, 2)


def test_a_mode_chosen_by_hand_still_holds_in_the_next_run() -> None:
    script = Script().log(4000, m.ModeChanged(kind="difficulty", mode="manual")).log(5000, STILL)
    times = mode_times(script.begin(2, 7000).log(8000, STILL), TaskParameters())
    found = {t.mode: t.time_s for t in times if t.kind == "difficulty"}
    assert found == {"autonomous": 4, "manual": 2}


_OPERATOR = [
    m.OperatorChanged(actor=ANNA, state=state, operated=state == "joined")
    for state in ("joined", "lost")
]


EVENTS = st.sampled_from(_OPERATOR) | st.builds(
    m.ModeChanged, kind=st.sampled_from(KINDS), mode=st.sampled_from(MODES)
)


@given(st.lists(st.tuples(st.integers(1, 10_000), EVENTS), max_size=12))
def test_mode_times_of_each_kind_add_up_to_the_session(events: list[tuple[int, m.Message]]) -> None:
    script, ms = Script(), 0
    for after, event in events:
        script.log(ms := ms + after, event)
    there = presence(script.log(ms + 1000, STILL))
    times = mode_times(script, TaskParameters())
    absent = round(there.duration_s - there.operated_s, 3)
    for kind in KINDS:
        assert round(sum(t.time_s for t in times if t.kind == kind), 3) == there.duration_s
        assert round(sum(t.unattended_s for t in times if t.kind == kind), 3) == absent
    assert round(sum(each.duration_s for each in there.absences), 3) <= absent
