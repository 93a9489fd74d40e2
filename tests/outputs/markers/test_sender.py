"""The thread that sends: the session never waits for it, and what is lost is counted."""

import threading

import pytest

from sar_tui.model.units import MS
from sar_tui.outputs.markers.marker import Marker, MarkerError
from sar_tui.outputs.markers.sender import Sender
from tests.outputs.markers.receivers import PATIENCE_S


class Box:
    """A destination that a test holds up, or makes fail."""

    address = "box"

    def __init__(self) -> None:
        self.may_send = threading.Event()
        self.may_send.set()
        self.has_opened = threading.Event()
        self.is_sending = threading.Event()
        self.fails = False
        self.received: list[str] = []

    def check(self) -> None: ...

    def open(self, session: str, task: str) -> str:
        if self.fails:
            raise MarkerError("It is unplugged.")
        self.has_opened.set()
        return ""

    def send(self, marker: Marker) -> bool:
        self.is_sending.set()
        self.may_send.wait(PATIENCE_S)
        if self.fails:
            raise MarkerError("It is unplugged.")
        self.received.append(marker.event)
        return True

    def close(self) -> str:
        return ""


def test_a_marker_is_handed_over_while_the_destination_hangs() -> None:
    box, changes = Box(), list[tuple[str, str]]()
    box.may_send.clear()
    sender = Sender(
        box, "s1", "keyboard", lambda state, why: changes.append((state, why)), now=lambda: 30 * MS
    )
    sender.put(Marker("prompt_onset", 10 * MS))
    assert box.is_sending.wait(PATIENCE_S)
    sender.put(Marker("response", 20 * MS))
    assert box.received == [], "put has returned, and nothing was sent yet"
    box.may_send.set()
    sender.finish()
    assert box.received == ["prompt_onset", "response"]
    assert (sender.sent, sender.lost, sender.late_ms) == (2, 0, (20.0, 20.0))
    assert changes == [("open", "")]


def test_markers_of_a_destination_that_fails_are_lost_and_counted_until_it_works_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("sar_tui.outputs.markers.sender.RETRY_SECONDS", 0.01)
    box, changes = Box(), list[tuple[str, str]]()
    failing, working = threading.Event(), threading.Event()

    def changed(state: str, why: str) -> None:
        changes.append((state, why))
        {"failing": failing, "working": working}.get(state, threading.Event()).set()

    sender = Sender(box, "s1", "keyboard", changed)
    assert box.has_opened.wait(PATIENCE_S)
    box.fails = True
    sender.put(Marker("cue", 1))
    assert failing.wait(PATIENCE_S)
    box.fails = False
    assert working.wait(PATIENCE_S)
    sender.put(Marker("response", 2))
    sender.finish()
    assert changes == [("open", ""), ("failing", "It is unplugged."), ("working", "")]
    assert (box.received, sender.sent, sender.lost) == (["response"], 1, 1)


def test_more_markers_than_can_wait_are_lost_and_counted() -> None:
    box = Box()
    box.may_send.clear()
    sender = Sender(box, "s1", "keyboard", lambda *_: None, longest_queue=2)
    sender.put(Marker("cue", 1))
    assert box.is_sending.wait(PATIENCE_S)
    for _ in range(5):
        sender.put(Marker("cue", 1))
    box.may_send.set()
    sender.finish()
    assert (sender.sent, sender.lost) == (3, 3)
