"""Input that cannot be read, typed into real terminals: the programs go on, and tell about it in
the end.
"""

import json
from pathlib import Path

import pytest

from tests.end_to_end.operator_terminal import SessionTerminals
from tests.end_to_end.participant_terminal import command, rows, see_the_summary
from tests.tui.unreadable import UNREADABLE

PROMPTS = 3
SETTINGS = {"attempts": 1, "prompts_per_attempt": PROMPTS, "outputs": "", "encouragement": "no"}
TOLD = b"The terminal sent input that cannot be read"
UNREAD = "SELECT message FROM events WHERE topic='input/unreadable'"


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
