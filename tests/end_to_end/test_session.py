"""The real program at a real pseudo-terminal, from the first Enter to the summary."""

import json
import re
import time
from itertools import accumulate
from pathlib import Path

import pytest

from sar_tui.model.units import MS
from sar_tui.timing.closed_loop import LEAVE_KEYS
from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import Press, ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import (
    ScreenReader,
    command,
    only_session,
    replays_identically,
    rows,
    run_command,
    see_the_agent_still,
    see_the_summary,
)


def _slowly(foreperiod_ms: int) -> dict[str, int]:
    """A wait long enough to look at the screen meanwhile."""
    return {"foreperiod_min_ms": foreperiod_ms, "foreperiod_max_ms": foreperiod_ms}


@pytest.fixture(scope="module")
def whole_session(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Press]]:
    """The data of a whole session, and what its participant pressed, in the last presentation of
    each prompt.

    A prompt is shown again if the machine was too busy to time its response.
    """
    data = tmp_path_factory.mktemp("played") / "data"
    with Terminal(run_command(data, prompts_per_attempt=6, attempts=2)) as terminal:
        participant = ScriptedParticipant(terminal, random_answers(3, 120, 220, error_rate=0.25))
        participant.run(12)
        while rows(data, "SELECT count(*) FROM trials") < [(12,)]:
            participant.run(until=time.monotonic_ns() + 100 * MS)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0
    timings = rows(data, "SELECT timing FROM trials ORDER BY attempt, trial")
    last = list(accumulate(json.loads(timing)["presentation"] for (timing,) in timings))
    return data, [participant.presses[number - 1] for number in last]


def test_every_press_is_stored_with_its_correctness(
    whole_session: tuple[Path, list[Press]],
) -> None:
    data, presses = whole_session
    recorded = rows(data, "SELECT stimulus, response, correct FROM trials ORDER BY attempt, trial")
    assert recorded == [
        (press.expected, press.key, press.key == press.expected) for press in presses
    ]
    assert {correct for _, _, correct in recorded} == {0, 1}, "the script planned both"
    assert rows(data, "SELECT status FROM sessions") == [("completed",)]
    assert rows(data, "SELECT count(*) FROM attempts") == [(2,)]


def test_it_is_replayed_identically(whole_session: tuple[Path, list[Press]]) -> None:
    data, _ = whole_session
    assert replays_identically(data)


def test_each_trial_stores_its_timing_quality(whole_session: tuple[Path, list[Press]]) -> None:
    data, _ = whole_session
    for (text,) in rows(data, "SELECT timing FROM trials"):
        timing = json.loads(text)
        assert timing["onset_source"] == "flush"
        assert timing["handler_delay_ms"] > 0
        assert timing["loop_lag_ms"] is not None


def test_no_byte_is_written_while_a_response_is_awaited(data: Path) -> None:
    with Terminal(run_command(data, prompts_per_attempt=2, attempts=1, **_slowly(700))) as t:
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


@pytest.mark.slow
def test_keys_without_a_prompt_are_stored_but_are_no_responses(data: Path) -> None:
    """A key in the wait, a paste, and a key held down before the prompt."""
    with Terminal(run_command(data, prompts_per_attempt=2, attempts=1, **_slowly(600))) as t:
        t.wait_for("Press Enter to go on.")
        t.confirm()
        t.wait_for("Press Enter to begin")
        t.settle()
        see_the_agent_still(t, data)
        t.confirm()
        t.settle()
        for _ in range(20):
            t.press("x")
        t.write(b"\x1b[200~pasted text\x1b[201~")
        shown = t.wait_for("Press: ")
        t.settle()
        key = chr(t.output[shown])
        t.press(key)
        shown = t.wait_for("Press: ", since=shown)
        t.settle()
        t.press(chr(t.output[shown]))
        see_the_summary(t)

    keys = rows(data, "SELECT message FROM events WHERE topic='input/key'")
    assert sum('"key":"x"' in message for (message,) in keys) == 20
    assert len(rows(data, "SELECT 1 FROM events WHERE topic='input/paste'")) == 1
    assert [response for (response,) in rows(data, "SELECT response FROM trials")] != ["x", "x"]
    (first,) = rows(data, "SELECT timing FROM trials WHERE trial=1")
    assert json.loads(first[0])["false_starts"] >= 1
    assert "paste" in json.loads(first[0])["flags"]


@pytest.mark.slow
def test_only_keys_of_the_task_are_recorded(data: Path) -> None:
    """Characters typed into a form are not stored as key presses."""
    with Terminal(command("--data", str(data))) as t:
        t.wait_for("New participant")
        t.settle()
        t.confirm()
        t.wait_for("Never a name")
        t.settle()
        for key in "secret7":
            t.press(key)
        t.settle()
        t.confirm()
        t.settle()
        for key in ("right", "right", "enter"):
            t.press(key)
            t.settle()
        t.wait_for("Press Enter to go on.")
        t.confirm()
        t.wait_for("Press Enter to begin")
        for key in LEAVE_KEYS:
            t.confirm(key)
        assert t.wait() == 0

    assert rows(data, "SELECT code FROM participants") == [("SECRET7",)]
    (events,) = rows(
        data, "SELECT group_concat(message) FROM events WHERE session=?", only_session(data)
    )
    keys = re.findall(r'"key":"(.*?)"', events[0])
    assert set(keys) == {"enter"}
