"""Terminals with 16 colours, and ``NO_COLOR``: no other colours are sent, and what colour tells is
told by form, too.
"""

import os
import re
from pathlib import Path

import pytest

from sar_tui.timing.pty import Terminal
from tests.end_to_end.participant_terminal import QUICK, ScreenReader, command
from tests.end_to_end.test_held_keys import exercise

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name != "posix", reason="there are no pseudo-terminals"),
]

_SGR = re.compile(rb"\x1b\[([\d;:]*)m")
_FORMS = {1, 2, 3, 4, 7}
"""Bold, dim, italic, underlined, reversed."""
KEYS = (
    ("Press Enter to start.", "enter"),
    ("How much pain do you have now?", "4"),
    ("Press Enter to go on.", "enter"),
    ("Where does it hurt?", "down"),
)
TERMINALS = {
    "16 colours": {"TERM": "xterm-16color", "COLORTERM": ""},
    "console": {"TERM": "linux", "COLORTERM": ""},
    "no colour": {"NO_COLOR": "1", "COLORTERM": "truecolor"},
}


def seen(data: Path, environment: dict[str, str]) -> tuple[list[str], list[list[int]]]:
    """Answer the first questions; return the screens, and the parameters of every SGR sequence."""
    exercise(data, **QUICK, ask_wellbeing=True)
    screens = []
    words = command("--patient", "p01", "--data", str(data))
    with Terminal(words, environment=environment) as terminal:
        reader = ScreenReader(terminal)
        for awaited, key in KEYS:
            terminal.wait_for(awaited)
            terminal.confirm(key)
            terminal.settle()
            screens.append(reader.text())
        sent = _SGR.findall(bytes(terminal.output))
    return screens, [[int(each or 0) for each in re.split(b"[;:]", one)] for one in sent]


def told_by_form(screens: list[str]) -> None:
    """Expect a heavy box around the number that is chosen, and a mark before the place."""
    assert re.search(r"┃\s+4\s+┃", screens[1])
    assert re.search(r"[▸▶]\s1\s", screens[3])


@pytest.mark.parametrize("name", ["16 colours", "console"])
def test_a_terminal_of_16_colours_gets_no_others(data: Path, name: str) -> None:
    screens, sent = seen(data, TERMINALS[name])
    assert not [each for each in sent if {38, 48} & set(each)]
    assert [each for each in sent if any(30 <= one <= 37 or 90 <= one <= 97 for one in each)]
    told_by_form(screens)


def test_without_colour_form_tells_what_is_chosen(data: Path) -> None:
    screens, sent = seen(data, TERMINALS["no colour"])
    assert {one for each in sent for one in each} <= {0, *_FORMS}
    assert 1 in {one for each in sent for one in each}, "sentences are bold"
    told_by_form(screens)


def test_without_colour_start_and_the_chosen_group_of_settings_are_reversed(data: Path) -> None:
    exercise(data)
    words = command("--data", str(data))
    with Terminal(words, environment=TERMINALS["no colour"]) as terminal:
        reader = ScreenReader(terminal)
        terminal.wait_for("Press")
        terminal.settle()
        assert "START" in reader.reversed()
        terminal.confirm("enter")
        terminal.wait_for("▸ START")
        terminal.settle()
        assert "▸ START · Enter" in reader.reversed()
        terminal.confirm("f2")
        terminal.wait_for("Difficulty")
        terminal.settle()
        terminal.write(b"\x1b[Z")  # shift+tab
        terminal.settle()
        assert "▌Difficulty" in reader.reversed()
