"""The onset of a prompt is the flush of its text, which control sequences do not contain."""

import pytest

from sar_tui.model.units import MS
from sar_tui.tui import timestamps
from sar_tui.tui.timestamps import OnsetWatch


@pytest.mark.parametrize(
    ("text", "written", "is_onset"),
    [
        ("Press: f", "\x1b[5;10HPress: f\x1b[0m", True),
        ("Press: f", "\x1b[5;10HPress: g\x1b[0m", False),
        ("5", "\x1b[5;10H \x1b[0m", False),
        ("5", "\x1b[5;10H5\x1b[0m", True),
        ("", "\x1b[?2026h", False),
        ("", "\x1b[5;10H   \x1b[0m", True),
    ],
)
def test_a_text_is_stamped_when_it_is_flushed(text: str, written: str, is_onset: bool) -> None:
    watch, stamps = OnsetWatch(), list[int]()
    watch.arm(text, stamps.append)
    watch.wrote(written)
    watch.wrote("\x1b[?2026l")
    watch.flushed()
    watch.flushed()
    assert len(stamps) == is_onset


def test_a_frame_that_is_drawn_early_is_flushed_when_it_is_due(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    slept: list[float] = []
    monkeypatch.setattr(timestamps, "host_now", lambda: 1000 * MS)
    monkeypatch.setattr("sar_tui.tui.timestamps.time.sleep", slept.append)
    watch = OnsetWatch()
    watch.arm("target", [].append, due=1005 * MS)
    watch.await_time()
    assert slept == [], "something else is flushed before"
    watch.wrote("target")
    watch.await_time()
    assert slept == [0.005]
    watch.arm("target", [].append, due=5000 * MS)
    watch.wrote("target")
    watch.await_time()
    assert slept[1:] == [0.02], "a wrong time does not block the terminal"
    watch.arm("target", [].append, due=990 * MS)
    watch.wrote("target")
    watch.await_time()
    assert len(slept) == 2
