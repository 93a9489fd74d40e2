"""Tests for the welcome that a session sends to its peers."""

from sar_tui.link.peer import session_welcome
from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build


def made(name: str, **parameters: object) -> Task:
    kind = Catalogue().task(name)
    return kind(build(kind.Parameters, parameters))


def test_welcome_has_format_and_length() -> None:
    welcome = session_welcome(
        made("keyboard", attempts=5, practice_attempts=2, prompts_per_attempt=7),
        "s1",
        "l1",
        {"A": "P01"},
    )
    assert (
        welcome.unit,
        welcome.decimals,
        welcome.attempts,
        welcome.trials,
        welcome.spoken_names,
    ) == ("ms", 0, 7, 7, {})
    assert welcome.parameters["prompts_per_attempt"] == 7


def test_welcome_of_two_has_their_spoken_names() -> None:
    people = {"A": "P01", "B": "P02"}
    assert session_welcome(made("pairs"), "s1", "l1", people).spoken_names == {
        "A": "Left",
        "B": "Right",
    }
    assert session_welcome(made("pairs", address="code"), "s1", "l1", people).spoken_names == people
    assert session_welcome(made("pairs", language="es"), "s1", "l1", people).spoken_names == {
        "A": "Izquierda",
        "B": "Derecha",
    }
