"""The real program at a real pseudo-terminal, from the first Enter to the summary."""

import json
import re
import time
from itertools import accumulate
from pathlib import Path

import pytest

from sar_tui.model.units import MS
from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import (
    ScreenReader,
    replays_identically,
    rows,
    run_command,
    see_the_summary,
)


def test_each_press_is_stored_with_its_correctness_and_timing_and_replayed(data: Path) -> None:
    with Terminal(run_command(data, prompts_per_attempt=4, attempts=1)) as terminal:
        participant = ScriptedParticipant(terminal, random_answers(3, 120, 220, error_rate=0.5))
        participant.run(4)
        # a prompt is shown again if the machine was too busy to time its response
        while rows(data, "SELECT count(*) FROM trials") < [(4,)]:
            participant.run(until=time.monotonic_ns() + 100 * MS)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0

    timings = [
        json.loads(text) for (text,) in rows(data, "SELECT timing FROM trials ORDER BY trial")
    ]
    last = accumulate(timing["presentation"] for timing in timings)
    presses = [participant.presses[number - 1] for number in last]
    recorded = rows(data, "SELECT stimulus, response, correct FROM trials ORDER BY trial")
    assert recorded == [
        (press.expected, press.key, press.key == press.expected) for press in presses
    ]
    assert {correct for _, _, correct in recorded} == {0, 1}, "the script planned both"
    for timing in timings:
        assert timing["onset_source"] == "flush"
        assert timing["handler_delay_ms"] > 0
        assert timing["loop_lag_ms"] is not None
    assert rows(data, "SELECT status FROM sessions") == [("completed",)]
    assert rows(data, "SELECT count(*) FROM attempts") == [(1,)]
    assert replays_identically(data)


@pytest.mark.slow
def test_no_byte_is_written_while_a_response_is_awaited(data: Path) -> None:
    wait = {"foreperiod_min_ms": 700, "foreperiod_max_ms": 700}  # long enough to look meanwhile
    with Terminal(run_command(data, prompts_per_attempt=2, attempts=1, **wait)) as t:
        reader = ScreenReader(t)
        t.wait_for("Press Enter to go on.")
        t.settle()
        assert "Enter" in reader.text()
        t.confirm()
        t.wait_for("Press Enter to begin")
        t.settle()
        assert "Press Enter to begin attempt 1 of 1." in reader.text()
        t.confirm()
        seen = len(t.output)
        for _ in range(2):
            t.settle(silence_ms=300)
            # on a busy machine the prompt may be there already
            if b"Press: " not in t.output[seen:]:
                assert "Press:" not in reader.text()
            seen = t.wait_for("Press: ", since=seen)
            t.settle()
            line = re.search(r"Press: (\S)\s*$", reader.text(), re.MULTILINE)
            assert line, reader.text()
            drawn = len(t.output)
            t.read(time.monotonic_ns() + 700 * MS)
            assert t.output[drawn:] == b""
            seen = len(t.output)
            t.press(line[1])
        see_the_summary(t)
