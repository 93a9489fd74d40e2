"""Markers of messages: their stamps, what is never sent, and that a session is the same with and
without them.
"""

from pathlib import Path
from typing import Any

import msgspec
import pytest

from sar_tui.loop import topics as t
from sar_tui.loop.bus import Topic
from sar_tui.loop.clock import VirtualClock
from sar_tui.loop.task import Task
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.outputs.markers.destinations import make_destinations
from sar_tui.outputs.markers.marker import Marker
from sar_tui.outputs.markers.node import MarkerNode, Translation
from sar_tui.plugins import Catalogue
from sar_tui.store import sessions
from sar_tui.store.database import connect_to_read
from tests.loop_driver import LoopDriver
from tests.outputs.markers.receivers import udp_receiver
from tests.program import Call

AT = 5 * SECOND
REPORT = {"action": "u1", "output": "speech", "part": "say"}


TIMING = m.Timing("flush", None, 0.0, 0, 1, 0.0, ())
SHOWN = m.Shown(attempt=1, trial=2, presentation=1, at=10, source="flush")


def translated(
    *sent: tuple[Topic[Any], m.Message], seats: tuple[str, ...] = ("A",)
) -> list[Marker]:
    translation = Translation("s1", seats)
    return [marker for topic, message in sent for marker in translation.markers(topic, AT, message)]


def trial(onset: int, reaction_time_ms: float | None) -> m.TrialEnded:
    """A trial that was answered at 90 ns."""
    what: Any = {"stimulus": "f", "response": "f", "correct": True, "value": None, "details": {}}
    when: Any = {"onset": onset, "response_at": 90, "reaction_time_ms": reaction_time_ms}
    return m.TrialEnded(attempt=1, trial=2, timing=TIMING, **what, **when)


def test_an_utterance_has_a_start_and_an_end_without_its_words() -> None:
    how: Any = {"kind": "feedback", "decision": "accepted", "actor": "agent"}
    said = m.Action(id="u1", text="Well done, P01!", **how)
    markers = translated(
        (t.ACTION, said),
        (t.REPORT, m.OutputReport(**REPORT, state="queued", at=1)),
        (t.REPORT, m.OutputReport(**REPORT, state="started", at=2)),
        (t.REPORT, m.OutputReport(**REPORT, state="aborted", at=3, detail="Stopped at Well done")),
    )
    fields = {"action": "u1", "output": "speech", "kind": "feedback"}
    assert markers == [
        Marker("utterance_start", 2, fields),
        Marker("utterance_end", 3, fields | {"state": "aborted"}),
    ]


def test_a_part_that_never_began_has_no_marker() -> None:
    failed = m.OutputReport(**REPORT, state="failed", at=2, detail="no sound card")
    assert translated((t.REPORT, failed)) == []


def test_an_operators_act_has_the_stamp_of_the_key_and_neither_words_nor_names() -> None:
    by: Any = {"text": "private", "actor": "operator.anna"}
    markers = translated(
        (t.DECISION, m.Decision(action="u1", verdict="edit", at=7, **by)),
        (t.REMARK, m.Remark(source="free text", at=8, **by)),
        (t.NOTE_ADDED, m.NoteAdded(label="cough", at=9, **by)),
        (t.COMMAND, m.SessionCommand(command="pause", reason="pain")),
        (t.COMMAND, m.SessionCommand(command="mark", reason="help")),
    )
    assert markers == [
        Marker("decision", 7, {"action": "u1", "verdict": "edit"}),
        Marker("remark", 8, {"source": "free text"}),
        Marker("note", 9, {"label": "cough"}),
        Marker("command", AT, {"command": "pause"}),
    ]


def test_a_movement_has_a_start_and_an_end() -> None:
    markers = translated((t.SHOWN, SHOWN), (t.TRIAL, trial(40, None)))
    assert [(marker.event, marker.ns) for marker in markers] == [
        ("prompt_onset", 10),
        ("movement_start", 40),
        ("movement_end", 90),
    ]


def test_an_onset_that_the_writing_thread_has_sent_is_not_sent_again() -> None:
    translation = Translation("s1")
    assert len(translation.shown(SHOWN)) == 1
    assert translation.markers(t.SHOWN, AT, SHOWN) == ()


def test_each_frame_of_a_prompt_has_a_marker_and_a_key_after_it_is_a_response() -> None:
    translation = Translation("s1")
    frames = [msgspec.structs.replace(SHOWN, at=10 * frame, frame=frame) for frame in (0, 1)]
    assert [marker.event for one in frames for marker in translation.shown(one)] == [
        "prompt_onset",
        "frame_onset",
    ]
    assert translation.markers(t.SHOWN, AT, frames[1]) == ()
    assert [one.event for one in translation.markers(t.TRIAL, AT, trial(10, 80.0))] == ["response"]


def test_markers_name_the_seat_only_if_there_are_two() -> None:
    started = m.AttemptStarted(attempt=1, practice=False, level=2, trials=3, seat="B")
    assert "seat" not in translated((t.ATTEMPT_STARTED, started))[0].fields
    assert translated((t.ATTEMPT_STARTED, started), seats=("A", "B"))[0].fields["seat"] == "B"


def test_a_session_is_the_same_with_markers(keyboard: type[Task], calm: Theme) -> None:
    def session(*extra: MarkerNode) -> list[tuple[str, m.Message, int]]:
        loop = LoopDriver(keyboard, calm, extra=extra, attempts=2, prompts_per_attempt=3)
        loop.start()
        for _ in range(3):
            loop.answer()
        loop.wait(2000)
        loop.session.detach()
        loop.session.bus.drain()
        return [(r.topic.name, r.message, r.at) for r in loop.records if r.topic is not t.MARKERS]

    with udp_receiver() as receiver:
        to = make_destinations([receiver.address])
        node = MarkerNode(to, "s1", "keyboard", ("A",), VirtualClock())
        assert session(node) == session()
        assert receiver.until("attempt_end")


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
        record.message.at for record in history if record.topic is t.SHOWN
    )
    assert len(times.get("miss", [])) == len(trials) - len(answered)
    assert all(("seat" in each.fields) == (task == "pairs") for each in made if each.event == ended)
