"""State of the session as the panel knows it, and the texts about it."""

from datetime import datetime
from functools import partial
from typing import Any

import pytest
from msgspec.structs import replace
from rich.cells import cell_len

from sar_tui.link.peer import Connection, MotionTrace
from sar_tui.loop import topics as t
from sar_tui.loop.bus import Topic
from sar_tui.loop.marks import TrialMark
from sar_tui.model import messages as m
from sar_tui.model.step import Entry, Step
from sar_tui.model.units import SECOND
from sar_tui.operator import status_view
from sar_tui.operator.event_text import Line
from sar_tui.operator.session_state import MAX_ATTEMPTS, MAX_TRIALS, SessionState
from tests.operator import panel_driver as b

BETWEEN = b.waiting("enter", "attempt")


def joined(**welcome: Any) -> SessionState:
    """Return the state after joining a session."""
    return SessionState().receive(Connection("connected")).receive(b.welcome(**welcome))


def after(*logged: tuple[Topic[Any], m.Message], state: SessionState | None = None) -> SessionState:
    """Return the state after these messages; ``state``: the one before, else a session is
    joined.
    """
    return (state or joined()).receive(
        [b.frame(topic, message, seq=seq) for seq, (topic, message) in enumerate(logged, 1)]
    )


def activity(state: SessionState, width: int = 60) -> str:
    return status_view.activity(state, width).plain


# --- what the participant does


def test_a_prompt_is_shown_until_its_trial_ends_or_is_voided() -> None:
    up = after((t.WAITING, b.waiting()), (t.PROMPT, b.prompt()))
    assert up.prompt is not None
    assert "Press: f" in activity(up)
    over = after((t.TRIAL, b.trial(5, "f", 412)), state=up)
    assert over.prompt is None
    assert over.seat("A").trials[-1].reaction_time_ms == 412
    voided = m.PromptVoided(attempt=3, trial=5, presentation=1, reason="pause")
    assert after((t.VOIDED, voided), state=up).prompt is None


ANSWERED = m.AskedStep(
    number=1,
    step=Step(name="word", text="Anything else?", kind="text"),
    entry=Entry(typed="my secret"),
)
READ = m.AskedStep(number=1, step=Step(name="read", text="Now the other hand."))


@pytest.mark.parametrize(
    ("waiting", "text"),
    [
        (b.waiting("result"), "The answer to a prompt is shown · 5 of 20"),
        (b.waiting("enter", "attempt", until=5), "The next attempt begins by itself"),
        (b.waiting("enter", "instructions"), "Waits for Enter · instructions"),
        (b.waiting("resume", "paused", reason="storage"), "Paused: the disk"),
        (b.waiting("step", "step", step=ANSWERED), "Waits for an answer: Anything else?"),
        (b.waiting("step", "step", step=READ), "Now the other hand."),
    ],
)
def test_what_the_session_waits_for_is_named_without_what_is_typed(
    waiting: m.Waiting, text: str
) -> None:
    assert status_view.waiting_text(after((t.WAITING, waiting))) == text


def test_two_participants_have_rows_of_their_own_with_results_between_attempts_and_times_in_trials() -> (
    None
):
    free = after((t.ATTEMPT_ENDED, b.attempt(goal=None, outcome="none")), (t.WAITING, BETWEEN))
    assert not {"✓", "✗"} & set(activity(free)), "there is no goal"
    state = after(
        (t.TRIAL, b.trial(1, "f", 400)),
        (t.TRIAL, b.trial(1, "k", 430, correct=False, seat="B")),
        (t.ATTEMPT_ENDED, b.attempt("B")),
        (t.WAITING, BETWEEN),
        state=joined(participants={"A": "P01", "B": "P02"}),
    )
    shown = activity(state, 36)
    assert "P01 ✓f" in shown
    assert "P02 ✗k" in shown
    assert "400 ms" in shown
    assert "✓ 498 of 520 ms, 95%" in shown
    assert len(shown.splitlines()) <= 7
    assert "430 ms" in activity(after((t.WAITING, b.waiting()), state=state), 32)


# --- results


def test_a_repeated_trial_or_attempt_counts_once_and_old_ones_are_dropped() -> None:
    twice = after(
        *[(t.TRIAL, b.trial(number, "f", 400)) for number in (1, 2, 2)],
        *[(t.ATTEMPT_ENDED, b.attempt(attempt=number)) for number in (1, 2)],
        (t.ATTEMPT_ENDED, b.attempt(attempt=2, metric=510.0)),
    )
    seat = twice.seat("A")
    assert [trial.trial for trial in seat.trials] == [1, 2]
    assert [(ended.attempt, ended.metric) for ended in seat.attempts] == [(1, 498.2), (2, 510.0)]
    assert seat.attempt == seat.attempts[-1]
    many = after(
        *[(t.TRIAL, b.trial(number, "f", 400)) for number in range(1, MAX_TRIALS + 9)],
        *[(t.ATTEMPT_ENDED, b.attempt(attempt=number)) for number in range(1, MAX_ATTEMPTS + 9)],
    ).seat("A")
    assert (len(many.trials), len(many.attempts)) == (MAX_TRIALS, MAX_ATTEMPTS)
    assert many.trials[-1].trial == MAX_TRIALS + 8
    state = SessionState()
    for _ in range(20):
        state = state.receive(MotionTrace("A", SECOND, 10.0, (0.5,) * 10))
    assert len(state.seat("A").rates) == 80, "only some seconds of motion are stored"


def test_a_mark_changes_its_trial_and_after_an_aborted_one_is_put_on_the_last_again() -> None:
    earlier = joined(trial_mark=TrialMark(done=(2, 1), marks={(2, 1): "missed"}))
    assert (earlier.trial_mark.trial, earlier.trial_mark.present) == ((2, 1), "missed")
    begun = m.AttemptStarted(attempt=3, practice=False, level=1, trials=20)
    state = after((t.ATTEMPT_STARTED, begun), state=earlier)
    assert state.trial_mark.present == ""
    state = after(
        (t.TRIAL, b.trial(1, "f", 400)),
        (t.MARKED, m.TrialMarked(attempt=3, trial=1, mark="assisted", correct=False)),
        (t.WAITING, b.waiting("response", "trial", attempt=3, trial=2)),
        (t.MARKED, m.TrialMarked(attempt=3, trial=2, mark="missed", correct=False)),
        state=state,
    )
    assert not state.seat("A").trials[0].correct
    assert (state.trial_mark.trial, state.trial_mark.present) == ((3, 2), "missed")
    aborted = after(
        (t.MARKED, m.TrialMarked(attempt=3, trial=2, mark="", correct=True)),
        (t.VOIDED, m.PromptVoided(attempt=3, trial=2, presentation=1, reason="pause")),
        state=state,
    )
    assert (aborted.trial_mark.trial, aborted.trial_mark.present) == ((3, 1), "assisted")


# --- control and the link


BEN = b.presence("baton", "operator.ben", ben="operator")
CARA: Any = {"cara": "observer"}
NOBODY = m.OperatorChanged(
    actor="operator.ben", state="left", operated=False, peers={b.ANNA: "operator"}
)


@pytest.mark.parametrize(
    ("presence", "has_control", "status"),
    [
        (b.presence(), True, "● in control"),
        (BEN, False, "● ben in control · b takes it"),
        (replace(BEN, holder="", operated=False), True, "● nobody in control · b takes it · ben"),
        (NOBODY, True, "● nobody in control · b takes it"),
        (b.presence(**CARA), True, "● in control · cara watches"),
        (b.presence(**CARA, dan="observer", eve="observer"), True, "● in control · 3 watch"),
    ],
)
def test_the_session_says_who_has_control_and_who_watches(
    presence: m.OperatorChanged, has_control: bool, status: str
) -> None:
    state = after((t.PRESENCE, presence))
    assert state.holder == presence.holder
    assert state.has_control is has_control
    assert status_view.link_status(state).plain == status
    assert not after((t.PRESENCE, presence), state=joined(role="observer")).has_control


def test_a_lost_link_keeps_the_last_state_until_another_welcome() -> None:
    state = after((t.TRIAL, b.trial(1, "f", 400)), (t.PRESENCE, b.presence()))
    lost = state.receive(Connection("lost", "The connection broke."))
    assert lost.seat("A").trials
    assert not lost.is_connected
    assert "goes on by itself (autonomous)" in status_view.link_loss(lost)
    assert "The connection broke" in status_view.link_loss(lost)
    again = state.receive(b.welcome())
    assert (again.seats, again.log, again.is_connected) == ({}, (), True)


def test_a_failed_voice_is_shown_until_it_works_again() -> None:
    failed = m.OutputReport(
        action="a1", output="speech", part="say", state="failed", at=0, detail="no loudspeaker"
    )
    assert after((t.REPORT, replace(failed, part="gesture"))).voice == ""
    state = after((t.REPORT, failed))
    assert "No voice: no loudspeaker" in activity(state)
    assert after((t.REPORT, replace(failed, state="started")), state=state).voice == ""


def test_what_the_agent_does_is_shown_and_no_stop_from_before_this_panel_joined() -> None:
    for current, text in (
        (b.action("a1"), "▶ The agent speaks"),
        (b.action("a1", spoken=""), "▶ The agent moves"),
        (None, "The agent is idle"),
    ):
        state = after(
            (t.ARBITER_STATE, b.arbiter_state(current=current)),
            (t.HALT, m.Halt(reason="stopped", asked=0)),
            (t.ACTING, m.AgentActing(acting=current is not None)),
        )
        assert activity(state).endswith(text)
        assert state.stops == ()


# --- the header and the log


LEVEL_5 = m.LevelChanged(previous=4, level=5, reason="success")


@pytest.mark.parametrize("width", [20, 29, 40, 60, 120])
@pytest.mark.parametrize(
    "participants", [{"A": "P01"}, {"A": "LEFT-PERSON-01", "B": "RIGHT-PERSON-02"}]
)
def test_the_level_and_the_next_one_stay_in_the_header_however_little_room_there_is(
    width: int, participants: dict[str, str]
) -> None:
    state = joined(participants=participants)
    state = after((t.WAITING, b.waiting()), (t.LEVEL, LEVEL_5), state=state)
    line = status_view.session_line(state, width)
    assert cell_len(line) <= width
    assert "level 4, then 5" in line or line.startswith("level 4→5 · 3/20")


def test_the_attempt_is_named_in_english_and_counts_once_and_stays_the_same_during_feedback() -> (
    None
):
    state = joined(attempts=22, parameters={"practice_attempts": 2})
    state = after((t.ATTEMPT_ENDED, b.attempt(attempt=2)), state=state)
    spanish: Any = {"attempt": 3, "attempt_name": "intento 1 de 20"}
    again: Any = {"attempt": 5, "restarts": 2}
    for waiting, name in (
        (b.waiting("answer", "answer", **spanish), "practice 2 of 2"),
        (b.waiting("enter", "attempt", **spanish), "attempt 1 of 20"),
        (b.waiting("enter", "attempt", **again), "attempt 1 of 20"),
    ):
        assert name in status_view.session_line(after((t.WAITING, waiting), state=state))


def test_each_line_of_the_log_has_its_time_of_day() -> None:
    wall = datetime(2026, 1, 5, 0, 0, 10)
    log = [Line(b.START - 20 * SECOND, "One"), Line(b.START, "Two", "good"), Line(0, "Three")]
    shown = status_view.log_lines(
        log, 40, 5, partial(status_view.time_of_day, now=b.START, wall=wall)
    )
    assert shown.plain.splitlines() == ["23:59:50 · One", "00:00:10 ✓ Two", "         · Three"]


def test_repeated_events_share_one_line_of_the_log() -> None:
    refused = m.PeerRequestRefused(
        actor="unknown", what="a connection", why="It has no certificate."
    )
    state = after(*[(t.REFUSED, refused)] * 40)
    text = "40 times: Refused for unknown: a connection. It has no certificate."
    assert [line.text_with_count for line in state.log] == [text]
    state = after((t.REFUSED, replace(refused, why="It has expired.")), state=state)
    assert [line.times for line in state.log] == [40, 1]
