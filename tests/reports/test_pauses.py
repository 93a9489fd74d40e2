"""The participant's own pauses: when, for how long, and how they said they were."""

from typing import Any

from sar_tui.framework import messages as m
from sar_tui.reports.pauses import Pause, pauses
from tests.reports.session_script import WHO, Script

GOES_ON = m.Waiting(what="foreperiod", stage="trial")
PAUSED = m.Waiting(what="resume", stage="paused")


def act(command: Any, reason: str = "", actor: str = "participant") -> m.Operator:
    return m.Operator(command=command, reason=reason, actor=actor)


def found(script: Script) -> list[Pause]:
    return pauses(script, [WHO])


def test_a_pause_is_told_with_its_reason_and_who_ended_it() -> None:
    script = Script().say(1000, GOES_ON).say(5000, act("pause"), PAUSED).say(7000, act("pause", "pain"), PAUSED)
    script.say(9000, act("resume", actor=WHO), GOES_ON).say(60_000, GOES_ON)
    assert found(script) == [Pause(1, 5, 4, "pain", WHO)]


def test_who_is_in_pain_in_a_pause_of_the_operators_is_told_from_then_on() -> None:
    script = Script().say(5000, act("pause", actor=WHO), PAUSED).say(6000, act("pause", "pain"), PAUSED)
    assert found(script.say(8000, act("resume"), GOES_ON)) == [Pause(1, 6, 2, "pain", "participant")]


def test_a_pause_of_the_operators_is_none_of_the_participants() -> None:
    script = Script().say(5000, act("pause", actor=WHO), PAUSED).say(8000, act("resume", actor=WHO), GOES_ON)
    assert found(script) == []


def test_what_could_not_be_a_pause_just_then_is_none() -> None:
    assert found(Script().say(5000, act("pause")).say(6000, GOES_ON)) == []


def test_a_pause_in_which_the_run_ends_lasts_until_then_and_the_next_run_begins_without_one() -> None:
    script = Script().say(5000, act("pause", "tired"), PAUSED).say(8000, m.NoteAdded())
    script.begin(2, 0).say(1000, GOES_ON).say(4000, act("pause"), PAUSED).say(5000, act("resume"), GOES_ON)
    assert found(script) == [Pause(1, 5, 3, "tired", ""), Pause(2, 4, 1, "", "participant")]
