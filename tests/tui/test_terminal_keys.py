"""Each key that does something arrives from the terminals that people use, by what their
documentation says they send.

Sources:

- xterm: "XTerm Control Sequences", PC-Style Function Keys and VT220-Style Function Keys,
  https://invisible-island.net/xterm/ctlseqs/ctlseqs.html
- Windows Terminal and the Windows console: "Console Virtual Terminal Sequences", Input Sequences,
  https://learn.microsoft.com/windows/console/console-virtual-terminal-sequences; Ctrl-Backspace:
  https://github.com/microsoft/terminal/pull/13894
- macOS Terminal: terminfo entry ``nsterm``, reported for Terminal 2.5.3 in
  https://lists.nongnu.org/archive/html/bug-ncurses/2015-04/msg00018.html. Its keyboard settings
  list Home, End and the page keys with Shift; without, they scroll the window.
- GNU screen and tmux: terminfo entries ``screen`` and ``tmux``; ``xterm-keys``: tmux(1).
- Linux console: console_codes(4) and the terminfo entry ``linux``.
- rxvt: terminfo entry ``rxvt``.
- kitty's protocol, which Textual asks for: https://sw.kovidgoyal.net/kitty/keyboard-protocol/
"""

import importlib
import pkgutil
from collections.abc import Iterator

import pytest
from textual import events
from textual.binding import Binding
from textual.dom import DOMNode

import sar_tui.app
import sar_tui.operator
import sar_tui.tui
import sar_tui.widgets
from sar_tui.tui.terminal_input import _SIGNALS, TolerantParser

CSI, SS3 = "\x1b[", "\x1bO"

EVERYWHERE = {
    "enter": ["\r"],
    "tab": ["\t"],
    "escape": ["\x1b"],
    "space": [" "],
    "ctrl+c": ["\x03"],
    "ctrl+p": ["\x10"],
    "ctrl+q": ["\x11"],
    "ctrl+r": ["\x12"],
    "ctrl+s": ["\x13"],
    "ctrl+z": ["\x1a"],
}
F5_TO_F12 = {
    f"f{5 + at}": [f"{CSI}{code}~"] for at, code in enumerate((15, 17, 18, 19, 20, 21, 23, 24))
}
VT_F1_TO_F4 = {f"f{1 + at}": [f"{SS3}{letter}"] for at, letter in enumerate("PQRS")}
ARROWS = {"up": "A", "down": "B", "right": "C", "left": "D"}
CURSOR = {name: [CSI + letter, SS3 + letter] for name, letter in ARROWS.items()}
PAGES = {"delete": [f"{CSI}3~"], "pageup": [f"{CSI}5~"], "pagedown": [f"{CSI}6~"]}
BACK = {"backspace": ["\x7f"], "shift+tab": [f"{CSI}Z"]}
VT = EVERYWHERE | VT_F1_TO_F4 | F5_TO_F12 | CURSOR | PAGES | BACK
XTERM_ENDS = {"home": [f"{CSI}H", f"{SS3}H"], "end": [f"{CSI}F", f"{SS3}F"]}
VT220_ENDS = {"home": [f"{CSI}1~"], "end": [f"{CSI}4~"]}
VT220_F1_TO_F4 = {f"f{1 + at}": [f"{CSI}{11 + at}~"] for at in range(4)}
CONSOLE_F1_TO_F5 = {f"f{1 + at}": [f"{CSI}[{letter}"] for at, letter in enumerate("ABCDE")}
KITTY_F1_TO_F4 = {"f1": [f"{CSI}P"], "f2": [f"{CSI}Q"], "f3": [f"{CSI}13~"], "f4": [f"{CSI}S"]}
KITTY_LETTERS = {f"ctrl+{letter}": [f"{CSI}{ord(letter)};5u"] for letter in "cpqrsz"}

TERMINALS: dict[str, dict[str, list[str]]] = {
    "xterm": VT | XTERM_ENDS,
    "xterm, VT220 keys": VT | VT220_ENDS | VT220_F1_TO_F4,
    "xterm, backspace is ^H": VT | XTERM_ENDS | {"backspace": ["\x08"]},
    "Windows Terminal": VT | XTERM_ENDS | {"backspace": ["\x7f", "\x08"]},
    "macOS Terminal": VT | XTERM_ENDS,
    "GNU screen": VT | VT220_ENDS,
    "tmux": VT | VT220_ENDS,
    "tmux, xterm-keys": VT | XTERM_ENDS,
    "Linux console": VT | VT220_ENDS | CONSOLE_F1_TO_F5 | {"shift+tab": ["\x1b\t", f"{CSI}Z"]},
    "rxvt": VT | VT220_F1_TO_F4 | {"home": [f"{CSI}7~"], "end": [f"{CSI}8~"]},
    "kitty's protocol": VT
    | XTERM_ENDS
    | KITTY_F1_TO_F4
    | KITTY_LETTERS
    | {"escape": [f"{CSI}27u"], "shift+tab": [f"{CSI}9;2u"]},
}
TAKEN = {"f1", "f10", "f11", "ctrl+a", "ctrl+b", "ctrl+v", "ctrl+d"}
"""Keys that do not arrive everywhere: GNOME Terminal shows its own help and menu by F1 and F10;
F11 is the full screen; Ctrl-A and Ctrl-B are the prefixes of GNU screen and tmux, Ctrl-V pastes in
Windows Terminal.
"""
SENT = [
    (terminal, key, sent)
    for terminal, keys in TERMINALS.items()
    for key, ways in keys.items()
    for sent in ways
]
"""Terminal, key, and what it sends."""


def read(*parts: str) -> list[str]:
    """Return the keys of what a terminal sends, followed by a pause."""
    parser = TolerantParser()
    messages = [message for part in (*parts, "") for message in parser.feed(part)]
    return [message.key for message in messages if isinstance(message, events.Key)]


def bindings() -> Iterator[tuple[str, str, str]]:
    """Yield the class, action and keys of each binding of the apps, their screens and widgets."""
    for package in (sar_tui.app, sar_tui.operator, sar_tui.tui, sar_tui.widgets):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            importlib.import_module(module.name)
    found = [DOMNode]
    while found:
        kind = found.pop()
        found += kind.__subclasses__()
        if kind.__module__.startswith("sar_tui."):
            for each in vars(kind).get("BINDINGS", ()):
                assert isinstance(each, Binding)
                yield kind.__name__, each.action, each.key


def keys_by_command() -> dict[tuple[str, str], set[str]]:
    """Return all keys of each command."""
    commands: dict[tuple[str, str], set[str]] = {}
    for kind, action, keys in bindings():
        commands.setdefault((kind, action), set()).update(keys.split(","))
    return commands


@pytest.mark.parametrize(
    ("key", "sent"), [each[1:] for each in SENT], ids=[f"{each[0]}: {each[1]}" for each in SENT]
)
def test_a_key_arrives_by_its_name(key: str, sent: str) -> None:
    assert read(sent) == [key]
    assert read(*sent) == [key], "over a slow line it arrives byte by byte"
    assert read(f"{sent}j") == [key, "j"] or key == "escape", "the next key counts"


@pytest.mark.parametrize("terminal", TERMINALS)
def test_every_key_that_does_something_is_among_them(terminal: str) -> None:
    bound = {key for keys in keys_by_command().values() for key in keys}
    characters = {key for key in bound if len(key) == 1} | {
        "plus", "minus", "equals_sign", "question_mark", "slash", "comma", "full_stop",
        "left_square_bracket", "right_square_bracket", "left_curly_bracket", "right_curly_bracket",
    }  # fmt: skip
    assert bound - characters <= TERMINALS[terminal].keys()


def test_every_command_has_a_key_that_no_terminal_takes_for_itself() -> None:
    alone = {command for command, keys in keys_by_command().items() if keys <= TAKEN}
    assert alone == set()


def test_help_and_stop_are_known_however_they_are_sent() -> None:
    ways = {key: {sent for _, known, sent in SENT if known == key} for key in _SIGNALS}
    assert ways == {key: set(known) for key, known in _SIGNALS.items()}
