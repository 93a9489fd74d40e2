"""Tests for the welcome that a session sends to its peers."""

from sar_tui.framework.parameters import build
from sar_tui.framework.task import Task
from sar_tui.link.peer import session_welcome
from sar_tui.plugins import Catalogue


def made(name: str, **parameters: object) -> Task:
    kind = Catalogue().task(name)
    return kind(build(kind.Parameters, parameters))


def test_it_tells_how_values_are_shown_and_how_long_it_is() -> None:
    told = session_welcome(
        made("keyboard", attempts=5, practice_attempts=2, prompts_per_attempt=7), "s1", "l1", {"A": "P01"}
    )
    assert (told.unit, told.decimals, told.attempts, told.trials, told.spoken_names) == ("ms", 0, 7, 7, {})
    assert told.parameters["prompts_per_attempt"] == 7


def test_of_two_it_tells_what_the_agent_calls_each() -> None:
    people = {"A": "P01", "B": "P02"}
    assert session_welcome(made("pairs"), "s1", "l1", people).spoken_names == {"A": "Left", "B": "Right"}
    assert session_welcome(made("pairs", address="code"), "s1", "l1", people).spoken_names == people
    assert session_welcome(made("pairs", language="es"), "s1", "l1", people).spoken_names == {
        "A": "Izquierda",
        "B": "Derecha",
    }
