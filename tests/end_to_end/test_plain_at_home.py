"""A person trains at home in plain lines: messages, a form, and what the clinic has seen."""

import sys
from contextlib import closing

import pytest

from sar_tui.letterbox import correspondents, status
from sar_tui.store import records
from sar_tui.store.database import connect, transaction
from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import command
from tests.end_to_end.test_plain import do_attempt, in_order, lines
from tests.home_and_clinic import RIGHT, Pair, _joined, exchanged, pair

__all__ = ["_joined", "pair"]
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


@pytest.mark.slow
def test_messages_a_form_and_a_session_go_to_the_clinic_and_back(pair: Pair) -> None:
    pair.set_programme(attempts=1, prompts_per_attempt=1)
    pair.write("The first.", "The second.")
    pair.ask("effort")
    with Terminal(command("--data", str(pair.home), "--plain")) as terminal:

        def answer(wanted: str, *keys: str) -> None:
            terminal.wait_for(wanted)
            terminal.settle(silence_ms=600)
            for key in keys:
                terminal.confirm(key)

        answer("The first.", "enter")
        answer("The second.", "enter")
        answer("Press Esc to answer later.", "enter")
        answer("Press the number or an arrow key, then Enter.", "6", "enter")
        answer("Thank you", "enter")
        answer("Press Enter to start.", "enter")
        answer("Press Enter to go on.", "enter")
        answer("Press Enter to begin", "enter")
        do_attempt(terminal, 1)
        terminal.settle(silence_ms=600)
        terminal.confirm()
        answer("Press Enter to finish.", "enter")
        answer("You can rest now.", "f12")
        answer("Please enter the passphrase.", *RIGHT, "enter")
        assert terminal.wait() == 0
        found = lines(terminal)
    assert in_order(
        found,
        "1 of 2",
        "A message from your therapist",
        "The first.",
        "Press Enter when you have read it.",
        "2 of 2",
        "The second.",
        "Your therapist would like to know how you are.",
        "Press Enter to start.",
    )
    exchanged(pair.clinic)
    with closing(connect(pair.clinic)) as database:
        message = status.last_message(database, "P01")
        assert message
        assert message.read_at
        assert records.listing(database, participant="P01", kinds=["effort"])
        assert database.execute("SELECT status FROM sessions").fetchall() == [("completed",)]
        with transaction(database):
            correspondents.mark_seen(database, "P01")
    exchanged(pair.clinic)
    with Terminal(command("--data", str(pair.home), "--plain")) as terminal:
        terminal.wait_for("Your therapist has seen today's training.")
        terminal.kill()
