"""Deviations from the plan, each once, with actor and time; and the participant's pauses."""

from typing import Any

import pytest

from sar_tui.model import messages as m
from sar_tui.reports.deviations import Deviation, Pause, deviations, pauses
from tests.reports.session_script import ANNA, Script, has

GOES_ON = m.Waiting(what="foreperiod", stage="trial")
PAUSED = m.Waiting(what="resume", stage="paused")


def act(command: Any, **parts: Any) -> m.SessionCommand:
    return m.SessionCommand(command=command, actor=ANNA, **parts)


def found(script: Script) -> list[Deviation]:
    return deviations(script, [ANNA, "operator.ben"])


def test_a_session_that_went_as_planned_has_none() -> None:
    script = Script().join(10).join(10, state="baton")
    assert found(script.log(1000, m.Remark(text="Good.", actor=ANNA), GOES_ON)) == []


def changed(state: Any, *, operated: bool = False, detail: str = "") -> m.OperatorChanged:
    return m.OperatorChanged(actor=ANNA, state=state, operated=operated, detail=detail)


@pytest.mark.parametrize(
    ("message", "what", "detail"),
    [
        (m.ModeChanged(kind="feedback", mode="veto", actor=ANNA), "mode", "feedback: veto"),
        (act("level", value=3), "level", "3"),
        (act("skip"), "skip", ""),
        (act("skip", reason="step", value=2), "skip", "step 2"),
        (act("repeat"), "repeat", ""),
        (act("end", reason="tired"), "end", "tired"),
        (act("stop"), "stop", ""),
        (act("mark", reason="assisted"), "mark", "assisted"),
        (m.LateDecision(actor=ANNA, what="veto a3", why="Over."), "missed", "veto a3: Over."),
        (changed("lost", detail="silent"), "lost", "silent"),
        (changed("left"), "left", ""),
        (changed("unproven", operated=True, detail="tmux"), "unproven", "tmux"),
    ],
)
def test_each_deviation_has_its_time_and_actor(message: m.Message, what: str, detail: str) -> None:
    script = Script().join(10).log(61_500, message)
    assert found(script) == [Deviation(run=1, at_s=61.5, what=what, actor=ANNA, detail=detail)]


def test_an_observers_stop_and_refused_acts_count_and_other_acts_of_participants_do_not() -> None:
    eve = m.OperatorChanged(actor="observer.eve", role="observer", state="joined", operated=False)
    stop = m.SessionCommand(command="stop", actor="observer.eve")
    refused = m.PeerRequestRefused(actor="observer.eve", what="operator/act", why="No.", count=12)
    both = found(Script().log(5, eve).log(1000, stop).log(2000, refused))
    acts = [(each.what, each.actor, each.count) for each in both]
    assert acts == [("stop", "observer.eve", 1), ("refused", "observer.eve", 12)]
    gone = m.OperatorChanged(actor="observer.eve", role="observer", state="left", operated=True)
    acts = [m.SessionCommand(command="pause"), m.SessionCommand(command="stop"), gone]
    assert found(Script().join(10).log(1000, *acts)) == []


def test_a_pause_lasts_until_the_session_continues_or_the_run_ends() -> None:
    script = Script().join(10).log(5000, act("pause", reason="tired"), PAUSED).log(7000, PAUSED)
    script.log(12_250, m.SessionCommand(command="resume"), GOES_ON).log(90_000, GOES_ON)
    has(*found(script), what="pause", detail="tired", duration_s=7.25)
    script = Script().join(10).log(5000, act("pause"), PAUSED).log(8000, PAUSED)
    has(*found(script.begin(2, 0).log(50, GOES_ON)), run=1, duration_s=3)


def test_each_later_change_of_control_is_a_deviation() -> None:
    script = Script().join(10, state="baton").join(20, state="baton")
    script.join(5000, "operator.ben", "baton").join(9000, state="baton")
    assert [(each.what, each.actor, each.at_s) for each in found(script)] == [
        ("baton", "operator.ben", 5), ("baton", ANNA, 9),
    ]  # fmt: skip


def test_times_count_from_the_start_of_each_run() -> None:
    script = Script().join(10).log(3000, act("skip")).begin(2, 700_000).log(702_000, act("repeat"))
    first, second = found(script)
    has(first, run=1, at_s=3, what="skip")
    has(second, run=2, at_s=2, what="repeat")


# --- the participant's pauses


def ask(command: Any, reason: str = "", actor: str = "participant") -> m.SessionCommand:
    return m.SessionCommand(command=command, reason=reason, actor=actor)


def taken(script: Script) -> list[Pause]:
    return pauses(script, [ANNA])


def test_a_pause_has_its_reason_and_who_ended_it() -> None:
    script = Script().log(1000, GOES_ON).log(5000, ask("pause"), PAUSED)
    script.log(7000, ask("pause", "pain"), PAUSED).log(9000, ask("resume", actor=ANNA), GOES_ON)
    assert taken(script.log(60_000, GOES_ON)) == [Pause(1, 5, 4, "pain", ANNA)]


def test_an_operators_pause_is_not_the_participants_until_they_say_pain() -> None:
    script = Script().log(5000, ask("pause", actor=ANNA), PAUSED)
    script.log(8000, ask("resume", actor=ANNA), GOES_ON)
    assert taken(script) == []
    script = Script().log(5000, ask("pause", actor=ANNA), PAUSED)
    script.log(6000, ask("pause", "pain"), PAUSED).log(8000, ask("resume"), GOES_ON)
    assert taken(script) == [Pause(1, 6, 2, "pain", "participant")]


def test_a_pause_ends_with_its_run_and_one_that_did_not_take_effect_is_left_out() -> None:
    assert taken(Script().log(5000, ask("pause")).log(6000, GOES_ON)) == []
    script = Script().log(5000, ask("pause", "tired"), PAUSED).log(8000, m.NoteAdded())
    script.begin(2, 0).log(1000, GOES_ON).log(4000, ask("pause"), PAUSED)
    script.log(5000, ask("resume"), GOES_ON)
    assert taken(script) == [Pause(1, 5, 3, "tired", ""), Pause(2, 4, 1, "", "participant")]
