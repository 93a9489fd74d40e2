"""The participant's pauses: time, duration and reason."""

from typing import Any

from sar_tui.model import messages as m
from sar_tui.reports.deviations import Pause, pauses
from tests.reports.session_script import ANNA, Script

GOES_ON = m.Waiting(what="foreperiod", stage="trial")
PAUSED = m.Waiting(what="resume", stage="paused")


def act(command: Any, reason: str = "", actor: str = "participant") -> m.SessionCommand:
    return m.SessionCommand(command=command, reason=reason, actor=actor)


def found(script: Script) -> list[Pause]:
    return pauses(script, [ANNA])


def test_a_pause_has_its_reason_and_who_ended_it() -> None:
    script = Script().log(1000, GOES_ON).log(5000, act("pause"), PAUSED)
    script.log(7000, act("pause", "pain"), PAUSED).log(9000, act("resume", actor=ANNA), GOES_ON)
    assert found(script.log(60_000, GOES_ON)) == [Pause(1, 5, 4, "pain", ANNA)]


def test_an_operators_pause_is_not_the_participants_until_they_say_pain() -> None:
    script = Script().log(5000, act("pause", actor=ANNA), PAUSED)
    script.log(8000, act("resume", actor=ANNA), GOES_ON)
    assert found(script) == []
    script = Script().log(5000, act("pause", actor=ANNA), PAUSED)
    script.log(6000, act("pause", "pain"), PAUSED).log(8000, act("resume"), GOES_ON)
    assert found(script) == [Pause(1, 6, 2, "pain", "participant")]


def test_a_pause_that_did_not_take_effect_is_left_out() -> None:
    assert found(Script().log(5000, act("pause")).log(6000, GOES_ON)) == []


def test_a_pause_ends_with_its_run() -> None:
    script = Script().log(5000, act("pause", "tired"), PAUSED).log(8000, m.NoteAdded())
    script.begin(2, 0).log(1000, GOES_ON).log(4000, act("pause"), PAUSED)
    script.log(5000, act("resume"), GOES_ON)
    assert found(script) == [Pause(1, 5, 3, "tired", ""), Pause(2, 4, 1, "", "participant")]
