"""Markers of messages: their stamps, what is never sent, and that a session is the same with and
without them.
"""

from typing import Any

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
from tests.loop_driver import LoopDriver
from tests.outputs.markers.receivers import udp_receiver

AT = 5 * SECOND
REPORT = {"action": "u1", "output": "speech", "part": "say"}


def translated(
    *sent: tuple[Topic[Any], m.Message], seats: tuple[str, ...] = ("A",)
) -> list[Marker]:
    translation = Translation("s1", seats)
    return [marker for topic, message in sent for marker in translation.markers(topic, AT, message)]


def test_an_utterance_has_a_start_and_an_end_without_its_words() -> None:
    said = m.Action(
        id="u1", kind="feedback", text="Well done, P01!", decision="accepted", actor="agent"
    )
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
    assert (
        translated(
            (t.REPORT, m.OutputReport(**REPORT, state="failed", at=2, detail="no sound card"))
        )
        == []
    )


def test_an_operators_act_has_the_stamp_of_the_key_and_neither_words_nor_names() -> None:
    markers = translated(
        (
            t.DECISION,
            m.Decision(action="u1", verdict="edit", text="private", actor="operator.anna", at=7),
        ),
        (t.REMARK, m.Remark(text="private", actor="operator.anna", source="free text", at=8)),
        (t.NOTE_ADDED, m.NoteAdded(text="private", label="cough", actor="operator.anna", at=9)),
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
    trial = m.TrialEnded(
        attempt=1,
        trial=2,
        stimulus="reach",
        response="reach",
        correct=True,
        onset=40,
        response_at=90,
        reaction_time_ms=None,
        value=None,
        timing=m.Timing("flush", None, 0.0, 0, 1, 0.0, ()),
        details={},
    )
    shown = m.Shown(attempt=1, trial=2, presentation=1, at=10, source="flush")
    markers = translated((t.SHOWN, shown), (t.TRIAL, trial))
    assert [(marker.event, marker.ns) for marker in markers] == [
        ("prompt_onset", 10),
        ("movement_start", 40),
        ("movement_end", 90),
    ]


def test_an_onset_that_the_writing_thread_has_sent_is_not_sent_again() -> None:
    translation = Translation("s1")
    shown = m.Shown(attempt=1, trial=2, presentation=1, at=10, source="flush")
    assert len(translation.shown(shown)) == 1
    assert translation.markers(t.SHOWN, AT, shown) == ()


def test_each_frame_of_a_prompt_has_a_marker_and_a_key_after_it_is_a_response() -> None:
    translation = Translation("s1")
    shown = [
        m.Shown(attempt=1, trial=2, presentation=1, at=at, source="flush", frame=at // 10)
        for at in (0, 10)
    ]
    assert [marker.event for one in shown for marker in translation.shown(one)] == [
        "prompt_onset",
        "frame_onset",
    ]
    assert translation.markers(t.SHOWN, AT, shown[1]) == ()
    trial = m.TrialEnded(
        attempt=1,
        trial=2,
        stimulus="s",
        response="f",
        correct=True,
        onset=10,
        response_at=90,
        reaction_time_ms=80.0,
        value=None,
        timing=m.Timing("flush", None, 0.0, 0, 1, 0.0, ()),
        details={},
    )
    assert [marker.event for marker in translation.markers(t.TRIAL, AT, trial)] == ["response"]


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
        node = MarkerNode(
            make_destinations([receiver.address]), "s1", "keyboard", ("A",), VirtualClock()
        )
        assert session(node) == session()
        assert receiver.until("attempt_end")
