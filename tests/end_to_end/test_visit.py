"""A therapist visits a session at home through a router, each in a terminal."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from sar_tui.link.invitation import write
from sar_tui.link.visits import keep_home
from sar_tui.timing.pty import Terminal
from tests.end_to_end.operator_terminal import SessionTerminals
from tests.end_to_end.participant_terminal import command, replays_identically, run_command
from tests.link.test_visits import ANNA, Clinic

SETTINGS = {"attempts": 1, "prompts_per_attempt": 2, "filler": "never"}
PRESENCE = [(ANNA, "joined"), (ANNA, "baton")]


@pytest.fixture
def clinic(data: Path, tmp_path: Path) -> Iterator[Clinic]:
    """A clinic whose home P01 dials out with the data folder of the test."""
    clinic = Clinic(tmp_path / "clinic")
    write(clinic.p01, tmp_path / "p01.sar-link")
    keep_home(data, tmp_path / "p01.sar-link")
    write(clinic.anna, tmp_path / "anna.sar-link")
    clinic.start_router()
    yield clinic
    clinic.end_router()


def visit(terminals: SessionTerminals, tmp_path: Path) -> Terminal:
    """Open a panel, and choose the home in its list."""
    words = command("wizard", "--link", str(tmp_path / "anna.sar-link"))
    panel = terminals.start_program([*words, "--data", str(tmp_path / "panel")], 100, 30)
    panel.wait_for("p01")
    panel.settle()
    panel.press("enter")
    return panel


def answer(terminal: Terminal, key: str) -> None:
    terminal.wait_for("not today")
    terminal.settle(silence_ms=600)
    terminal.confirm(key)


@pytest.mark.slow
def test_a_therapist_watches_and_speaks_after_a_yes_until_the_participant_ends_it(
    data: Path, tmp_path: Path, clinic: Clinic
) -> None:
    with SessionTerminals(data) as terminals:
        session = terminals.start_program(run_command(data, **SETTINGS))
        session.wait_for("Press Enter to go on.")
        panel = visit(terminals, tmp_path)
        session.wait_for("not today")
        assert b"Keyboard" not in panel.output
        answer(session, "enter")
        session.wait_for("Your therapist is watching")
        panel.wait_for("You have control")
        panel.press("t")
        panel.wait_for("Say:")
        for letter in "Hello from here":
            panel.press(letter)
        panel.wait_for("here")
        panel.press("enter")
        session.wait_for("Hello from here")
        session.confirm("escape")
        session.wait_for("End the visit")
        session.settle()
        for key in ("down", "down", "down", "enter"):
            session.confirm(key)
        panel.wait_for("They have ended the visit")
        is_over = [*PRESENCE, (ANNA, "left")]
        terminals.until(lambda: terminals.presence() == is_over, "the visit is over")
        for key in ("ctrl+q", "down", "enter"):
            session.confirm(key)
        session.wait()
    assert replays_identically(data)


@pytest.mark.slow
@pytest.mark.parametrize("key", ["enter", "escape"])
def test_the_question_in_plain_lines(data: Path, tmp_path: Path, clinic: Clinic, key: str) -> None:
    with SessionTerminals(data) as terminals:
        session = terminals.start_program([*run_command(data, **SETTINGS), "--plain"])
        session.wait_for("Press Enter to go on.")
        panel = visit(terminals, tmp_path)
        answer(session, key)
        if key == "escape":
            panel.wait_for("They would rather not be watched today")
            assert terminals.presence() == []
            return
        session.wait_for("Your therapist is watching.")
        session.settle()
        session.confirm("escape")
        session.wait_for("End the visit.")
        session.settle()
        for pressed in ("4", "enter"):
            session.confirm(pressed)
        session.wait_for("Your therapist is not watching any longer.")
        is_over = [*PRESENCE, (ANNA, "left")]
        terminals.until(lambda: terminals.presence() == is_over, "the visit is over")
