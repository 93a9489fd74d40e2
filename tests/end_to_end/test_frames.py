"""A documented task whose prompts change, in a real terminal: killed, resumed, and replayed."""

import json
import time
from pathlib import Path

import pytest

from sar_tui.model.units import MS
from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.documented import write_documented
from tests.end_to_end.participant_terminal import (
    QUICK,
    command,
    only_session,
    replays_identically,
    rows,
    see_the_summary,
)

PROMPTS = 8


@pytest.mark.slow
def test_a_stop_signal_task_is_killed_between_frames_resumed_and_replayed(
    data: Path, tmp_path: Path
) -> None:
    write_documented(tmp_path / "mytasks", "stopping")
    settings = [f"--set={name}={value}" for name, value in (QUICK | {"attempts": 1}).items()]
    where = ("--data", str(data), "--tasks", str(tmp_path / "mytasks"))
    with Terminal(
        command("run", "stopping", "-p", "P01", "--seed", "3", *where, *settings)
    ) as terminal:
        participant = ScriptedParticipant(terminal, random_answers(1, 330, 360))
        while b"Do not press." not in terminal.output:
            participant.run(until=time.monotonic_ns() + 20 * MS)
        terminal.kill()
        terminal.wait()
    done = rows(data, "SELECT count(*) FROM trials")[0][0]
    with Terminal(command("resume", only_session(data), *where)) as terminal:
        ScriptedParticipant(terminal, random_answers(2, 330, 360)).run(PROMPTS - done)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0
    trials = rows(data, "SELECT stimulus, timing, details, onset_ns FROM trials ORDER BY trial")
    assert len(trials) == PROMPTS
    for stimulus, timing, details, onset in trials:
        onsets = json.loads(timing).get("frame_onsets_ns", [])
        if stimulus.startswith("stop"):
            assert onset == onsets[0]
            if len(onsets) > 1:
                assert json.loads(details)["stop_delay_ms"] == (onsets[1] - onsets[0]) / 1e6
        else:
            assert onsets == []
    assert any(stimulus.startswith("stop") for stimulus, *_ in trials)
    assert replays_identically(data, "--tasks", str(tmp_path / "mytasks"))
