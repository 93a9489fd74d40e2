"""Markers of sessions of each task: onsets, responses and movements are those of the table of
trials.
"""

from pathlib import Path

import pytest

from sar_tui.loop.topics import SHOWN
from sar_tui.outputs.markers.marker import Marker
from sar_tui.outputs.markers.node import Translation
from sar_tui.plugins import Catalogue
from sar_tui.store import sessions
from sar_tui.store.database import connect_to_read
from tests.program import Call

SEATS = {"keyboard": ("A",), "reaching": ("A",), "pairs": ("A", "B")}
SHORT = ("--seed", 5, "--attempts", 2, "--json")


@pytest.mark.parametrize("task", SEATS)
def test_markers_have_the_times_of_the_trials(
    call: Call, catalogue: Catalogue, task: str, fewer_blocks: None, tmp_path: Path
) -> None:
    who = ("-p", "P01", "-p", "P02") if len(SEATS[task]) > 1 else ("-p", "P01")
    session = call("simulate", task, "--user", "average", *who, *SHORT).json["session"]
    with connect_to_read(tmp_path / "data") as database:
        history = list(sessions.history(database, session))
        trials = sessions.rows(database, "trials", session)
    translation = Translation(session, SEATS[task])
    made: list[Marker] = []
    for record in history:
        if record.topic in translation.topics:
            made += translation.markers(record.topic, record.at, record.message)
    times = {
        event: sorted(each.ns for each in made if each.event == event)
        for event in {each.event for each in made}
    }
    began, ended = (
        ("movement_start", "movement_end") if task == "reaching" else ("prompt_onset", "response")
    )
    answered = [trial for trial in trials if trial["response_ns"] is not None]
    assert answered
    assert times[ended] == sorted(trial["response_ns"] for trial in answered)
    assert {trial["onset_ns"] for trial in answered} <= set(times[began])
    assert times["prompt_onset"] == sorted(
        record.message.at for record in history if record.topic is SHOWN
    )
    assert len(times.get("miss", [])) == len(trials) - len(answered)
    assert all(("seat" in each.fields) == (task == "pairs") for each in made if each.event == ended)
