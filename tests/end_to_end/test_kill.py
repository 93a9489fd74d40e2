"""kill -9 at random moments: nothing acknowledged is lost, and the session goes on as it would
have.
"""

import json
from pathlib import Path

import pytest

from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Situation
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.timing.pty import Terminal
from sar_tui.timing.scripted_participant import ScriptedParticipant, random_answers
from tests.end_to_end.participant_terminal import (
    command,
    only_session,
    replays_identically,
    rows,
    run_command,
    see_the_summary,
)


@pytest.mark.slow
def test_kills_lose_no_acknowledged_trial_and_change_no_prompt(
    data: Path, catalogue: Catalogue
) -> None:
    kills, attempts, prompts = 20, 8, 8
    pressed = 0
    start = run_command(data, prompts_per_attempt=prompts, attempts=attempts)
    for kill in range(kills):
        with Terminal(
            start if kill == 0 else command("resume", only_session(data), "--data", str(data))
        ) as terminal:
            terminal.wait_for("Enter")
            moment = terminal.read_at + round(
                RandomStreams("kill", kill).uniform("moment") * 2000 * MS
            )
            participant = ScriptedParticipant(terminal, random_answers(kill, 60, 160))
            presses = participant.run(until=moment)
            terminal.kill()
            terminal.wait()
        assert rows(data, "PRAGMA integrity_check") == [("ok",)]
        (stored,) = rows(data, "SELECT count(*) FROM trials")
        assert pressed + len(presses) - 1 <= stored[0] <= pressed + len(presses), (
            "at most the last press is lost"
        )
        pressed = stored[0]

    with Terminal(command("resume", only_session(data), "--data", str(data))) as terminal:
        ScriptedParticipant(terminal, random_answers(99, 60, 120)).run(prompts * attempts - pressed)
        see_the_summary(terminal)
        terminal.confirm()
        assert terminal.wait() == 0

    assert rows(data, "SELECT status FROM sessions") == [("completed",)]
    levels = [level for (level,) in rows(data, "SELECT level FROM attempts ORDER BY attempt")]
    assert levels == list(range(1, attempts + 1)), "all answers are right and fast"
    trials = rows(data, "SELECT attempt, trial, stimulus FROM trials ORDER BY attempt, trial")
    assert [(a, t) for a, t, _ in trials] == [
        (a, t) for a in range(1, attempts + 1) for t in range(1, prompts + 1)
    ]
    assert trials == _prompts_it_would_have_had(data, catalogue, prompts)
    assert replays_identically(data)


def _prompts_it_would_have_had(
    data: Path, catalogue: Catalogue, prompts: int
) -> list[tuple[int, int, str]]:
    """Return the prompts of a session that nobody killed: from its seed, its parameters and the levels it
    reached.
    """
    ((seed, parameters),) = rows(data, "SELECT seed, parameters FROM sessions")
    kind = catalogue.task("keyboard")
    task = kind(build(kind.Parameters, json.loads(parameters)))
    return [
        (
            attempt,
            trial,
            task.stimulus(
                Situation(
                    attempt, trial, level, RandomStreams(seed, attempt, trial), RandomStreams(seed)
                )
            ).name,
        )
        for attempt, level in rows(data, "SELECT attempt, level FROM attempts ORDER BY attempt")
        for trial in range(1, prompts + 1)
    ]
