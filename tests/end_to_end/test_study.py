"""A block of a study, from the app's screen of the study in a real terminal."""

import json
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.store.database import connect
from sar_tui.study import enrolment, ledger
from sar_tui.study.secret import key_file
from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import (
    QUICK,
    ScreenReader,
    command,
    replays_identically,
    rows,
    see_the_summary,
)
from tests.study.plans import plan

_SETTINGS = ", ".join(f"{name} = {value}" for name, value in QUICK.items())
ONE_VISIT = f"""
name = "praise"
hypothesis = "People are faster with praise."
[conditions.praise]
task = "keyboard"
settings = {{ prompts_per_attempt = 3, {_SETTINGS} }}
[conditions.silence]
task = "keyboard"
settings = {{ prompts_per_attempt = 3, feedback_schedule = "none", {_SETTINGS} }}
[outcome]
visit = "only"
block = "training"
compared = "within"
[[visits]]
name = "only"
[[visits.blocks]]
name = "training"
conditions = ["praise", "silence"]
order = "williams"
attempts = 1
"""


@pytest.mark.slow
def test_a_block_runs_from_the_screen_of_its_study_which_then_offers_the_next(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "configuration"))
    key = key_file("praise")
    with closing(connect(data)) as db:
        text, catalogue = ONE_VISIT, Catalogue(())
        enrolment.freeze(db, catalogue, text, plan(text), key, mode="live", author="me")
        enrolment.enrol(db, ledger.find(db), "P01", key)
    with Terminal(command("--data", str(data))) as terminal:
        screen = ScreenReader(terminal)
        terminal.wait_for("F7")
        terminal.settle()
        terminal.write(b"\x1b[18~")  # F7
        terminal.wait_for("1 person is due today.")
        terminal.settle()
        assert "to start visit 1, block 1" in screen.text()
        terminal.confirm()
        ScriptedParticipant(terminal, random_answers(5, 120, 180)).run(3)
        see_the_summary(terminal)
        terminal.confirm()
        terminal.wait_for("1 of 2 done")
        terminal.settle()
        assert "to start visit 1, block 2" in screen.text()
        terminal.press("ctrl+q")
        assert terminal.wait() == 0
    ((place, status),) = rows(data, "SELECT study, status FROM sessions")
    assert (json.loads(place)["block"], status) == ("training", "completed")
    assert replays_identically(data)
