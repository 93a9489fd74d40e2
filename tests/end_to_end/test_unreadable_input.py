"""Input that cannot be read, typed into real terminals: the programs go on, and tell about it in
the end.
"""

import json
from pathlib import Path

import pytest

from sar_tui.timing.pty import Terminal
from tests.end_to_end.operator_terminal import SessionTerminals, plain
from tests.end_to_end.participant_terminal import command, rows, see_the_summary
from tests.tui.unreadable import UNREADABLE

PROMPTS = 3
SETTINGS = {"attempts": 1, "prompts_per_attempt": PROMPTS, "outputs": "", "encouragement": "no"}
TOLD = b"The terminal sent input that cannot be read"
UNREAD = "SELECT message FROM events WHERE topic='input/unreadable'"
PASTED = "SELECT message FROM events WHERE topic='input/paste'"
HUGE = 9999


@pytest.mark.slow
def test_a_session_its_panel_and_the_agents_screen_survive_it(data: Path) -> None:
    with SessionTerminals(data) as terminals:
        participant, panel = terminals.both(**SETTINGS)
        agent = terminals.start_program(command("agent", "--data", str(data)))
        agent.wait_for("\x1b[?1049h")
        agent.settle()
        for number in range(PROMPTS):
            for terminal in (participant.terminal, panel.terminal, agent):
                for junk in list(UNREADABLE.values())[number::PROMPTS]:
                    terminal.write(junk)
            participant.answer(1)
        see_the_summary(participant.terminal)

        panel.terminal.press("f1")
        terminals.until(lambda: "Keys" in panel.sees(), "the panel still reads keys")
        for terminal in (agent, panel.terminal):
            terminal.press("ctrl+q")
            assert terminal.wait() == 0
        participant.terminal.confirm()
        assert participant.terminal.wait() == 0
        outputs = [bytes(each.output) for each in (participant.terminal, panel.terminal, agent)]
    for output in outputs:
        assert b"Traceback" not in output
        assert TOLD in output
    assert rows(data, "SELECT count(*) FROM trials WHERE response IS NOT NULL") == [(PROMPTS,)]
    dropped = "".join(json.loads(message)["what"] for (message,) in rows(data, UNREAD))
    for what in (r"\xf1", r"\xe2\x82", r"\x1b[1114112u", r"\x1b[55296u", r"\x1b[48;9999;9999;1;1t"):
        assert what in dropped


@pytest.mark.slow
@pytest.mark.parametrize(
    "unit",
    [b"\x1b[A", b"abcdefghij", b"\x1b[31mhello\x1b[0m"],
    ids=["arrows", "letters", "colours"],
)
def test_a_megabyte_that_nobody_types_is_dropped_and_help_answers_in_the_middle_of_it(
    data: Path, unit: bytes
) -> None:
    with SessionTerminals(data) as terminals:
        participant, panel = terminals.both(**SETTINGS)
        for terminal, helps in (
            (participant.terminal, "Press Enter to close this."),
            (panel.terminal, "Keys"),
        ):
            since = len(terminal.output)
            for part in range(100):
                terminal.write(unit * (10_000 // len(unit)))
                if part == 50:
                    terminal.press("f1")
                terminals.look(0)
            terminal.wait_for(helps, since=since)
            terminals.look(0.5)
            terminal.press("escape")
            terminal.press("ctrl+c")
            assert terminal.wait() == 130
            assert b"A paste was dropped: too long, or no text (99" in terminal.output
    pasted = [json.loads(message)["length"] for (message,) in rows(data, PASTED)]
    assert sum(pasted) > 990_000, "its length is in the record"
    assert rows(data, "SELECT count(*) FROM events WHERE topic='input/key'") < [(200,)]


@pytest.mark.slow
def test_a_window_of_an_impossible_size_is_drawn_in_part(data: Path) -> None:
    with Terminal(command("--data", str(data))) as terminal:
        terminal.wait_for("New participant")
        terminal.settle()
        terminal.resize(HUGE, HUGE)
        terminal.settle()
        terminal.resize(80, 24)
        since = len(terminal.output)
        terminal.press("f1")
        terminal.wait_for("Press Enter to close this.", since=since)
        terminal.press("ctrl+q")
        assert terminal.wait() == 0
        assert "Traceback" not in plain(terminal.output.decode(errors="replace"))
