"""A form in a real pseudo-terminal: filled in with keys, killed in between, and gone on with."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import ScreenReader, command, rows
from tests.end_to_end.test_plain import in_order, lines

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


def fill(data: Path, *more: str, form: str = "SUS") -> list[str]:
    new = [] if (data / "sar-tui.db").exists() else ["--new"]
    return command("record", "fill", form, "P01", "--data", str(data), *new, *more)


def answer(terminal: Terminal, keys: str) -> None:
    """Answer items, each with the key of its point."""
    for key in keys:
        terminal.settle()
        terminal.confirm(key)
        terminal.settle()
        terminal.confirm()


def content(data: Path) -> dict[str, object]:
    """Return the last version of the only form."""
    found = rows(data, "SELECT content FROM records ORDER BY version")
    return dict(json.loads(found[-1][0]))


@pytest.mark.slow
def test_a_form_that_is_killed_at_its_fourth_item_goes_on_there_and_is_scored(data: Path) -> None:
    with Terminal(fill(data)) as terminal:
        screen = ScreenReader(terminal)
        terminal.wait_for("Item 1 of 10")
        answer(terminal, "412")
        terminal.wait_for("Item 4 of 10")
        terminal.settle()
        assert "You said: 2. Backspace goes back." in screen.text()
        terminal.kill(signal.SIGKILL)
        terminal.wait()
    assert content(data)["status"] == "open"
    with Terminal(fill(data)) as terminal:
        screen = ScreenReader(terminal)
        terminal.wait_for("Item 4 of 10")
        terminal.settle()
        assert "You said: 2." in screen.text()
        assert "P01" not in screen.text(), "a participant sees the form only"
        answer(terminal, "1525153")
        terminal.wait_for("Thank you")
        terminal.settle()
        terminal.confirm()
        assert terminal.wait() == 0
        said = terminal.output.decode()
    assert "System Usability Scale of P01: Usability 82.5 (0 to 100)." in said
    found = content(data)
    assert [found[f"q{number}"] for number in range(1, 11)] == [4, 1, 2, 1, 5, 2, 5, 1, 5, 3]
    assert (found["status"], found["score"], found["score_missing"]) == ("complete", 82.5, 0)
    assert all(isinstance(found[f"q{number}_ms"], int) for number in range(1, 11))
    assert rows(data, "SELECT count(DISTINCT id), count(*) FROM records") == [(1, 10)]
    listed = subprocess.run(
        command("record", "list", "-p", "P01", "--data", str(data)),
        capture_output=True,
        text=True,
        check=True,
    )
    assert "Usability 82.5 (0 to 100)" in " ".join(listed.stdout.split())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("language", "question", "thanks"),
    [
        ("de", "Wie anstrengend war das für Sie?", "Vielen Dank"),
        ("es", "¿Cuánto esfuerzo ha sido?", "Muchas gracias"),
    ],
)
def test_a_form_is_filled_in_in_german_and_spanish(
    data: Path, language: str, question: str, thanks: str
) -> None:
    with Terminal(fill(data, "--language", language, form="effort")) as terminal:
        terminal.wait_for(question)
        answer(terminal, "6")
        terminal.wait_for(thanks)
        terminal.settle()
        terminal.confirm()
        assert terminal.wait() == 0
    assert (content(data)["language"], content(data)["score"]) == (language, 6.0)


@pytest.mark.slow
def test_a_form_is_filled_in_in_plain_lines(data: Path) -> None:
    with Terminal(fill(data, "--plain", form="NASA-TLX")) as terminal:
        for number, keys in enumerate(("40", "5", "100", "0", "35", "tab"), 1):
            terminal.wait_for(f"Item {number} of 6")
            terminal.settle(silence_ms=600)
            for key in [keys] if keys == "tab" else [*keys, "enter"]:
                terminal.confirm(key)
        terminal.wait_for("Thank you")
        terminal.settle(silence_ms=600)
        terminal.confirm()
        assert terminal.wait() == 0
        found = lines(terminal)
    assert in_order(
        found,
        "Item 1 of 6",
        "How mentally demanding was the task?",
        "0: Very low.",
        "100: Very high.",
        "Press Tab if you would rather not say.",
        "Press the number or an arrow key, then Enter.",
        "Chosen: 40.",
        "Item 2 of 6",
        "You said: 40.",
        "Thank you",
        "Workload of P01: Workload no score (0 to 100, 1 missing).",
    )


@pytest.mark.parametrize(
    ("form", "says"),
    [
        ("Godspeed", "The text of Godspeed is not here"),
        ("BBT", "BBT is no form."),
        ("nothing", "There is no kind of record nothing."),
    ],
)
def test_a_form_that_cannot_be_used_is_refused_in_a_sentence(
    data: Path, form: str, says: str
) -> None:
    with Terminal(fill(data, form=form)) as terminal:
        assert terminal.wait() == 2
        assert says in " ".join(terminal.output.decode().split())
