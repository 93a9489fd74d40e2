"""Markers of the real program in a pseudo-terminal: stamps, a flash and a tone, and a screen LSL
does not write on.
"""

import json
from pathlib import Path

import pytest

from sar_tui.model.units import SECOND
from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import (
    ScreenReader,
    only_session,
    replays_identically,
    rows,
    run_command,
    see_the_summary,
)
from tests.outputs.markers.receivers import PATIENCE_S, lsl_inlet, udp_receiver


@pytest.mark.slow
def test_markers_over_udp_and_lsl_have_the_stamps_that_are_stored(tmp_path: Path) -> None:
    pytest.importorskip("pylsl")
    data = tmp_path / "data"
    with udp_receiver() as receiver:
        command = [*run_command(data, prompts_per_attempt=3, attempts=1), "--sync-flash"]
        command += ["--speech", f"file:{tmp_path}", "--markers", f"lsl,{receiver.address}"]
        with Terminal(command) as terminal:
            screen = ScreenReader(terminal)
            terminal.wait_for("for the camera.")
            inlet = lsl_inlet(only_session(data))
            terminal.confirm()
            terminal.wait_for("Welcome")
            ScriptedParticipant(terminal, random_answers(3, 120, 220, error_rate=0.25)).run(3)
            see_the_summary(terminal)
            terminal.confirm()
            assert terminal.wait() == 0
        markers = receiver.until("session_end")
        stamps = []
        while len(stamps) < 3:
            (text,), stamp = inlet.pull_sample(PATIENCE_S)
            if '"event":"prompt_onset"' in text:
                stamps.append(stamp)
        inlet.close_stream()
    onsets = [ns for (ns,) in rows(data, "SELECT onset_ns FROM trials ORDER BY attempt, trial")]
    responses = [
        ns for (ns,) in rows(data, "SELECT response_ns FROM trials ORDER BY attempt, trial")
    ]
    assert [marker["ns"] for marker in markers if marker["event"] == "prompt_onset"] == onsets
    assert [marker["ns"] for marker in markers if marker["event"] == "response"] == responses
    signals = [
        json.loads(text)
        for (text,) in rows(data, "SELECT message FROM events WHERE topic='output/sync'")
    ]
    assert sorted((signal["what"], signal["source"]) for signal in signals) == [
        ("flash", "flush"),
        ("tone", "sound"),
    ]
    assert {marker["ns"] for marker in markers if marker["event"].startswith("sync_")} == {
        signal["at"] for signal in signals
    }
    assert stamps == pytest.approx([ns / SECOND for ns in onsets], rel=0, abs=1e-6)
    assert "common.cpp" not in screen.text(), "LSL must not write on the screen"
    assert b"api_config" not in terminal.output
    assert replays_identically(data)
