"""A session that is resumed shows its progress if the replay of what was done takes longer than a
moment.
"""

from pathlib import Path

import pytest
from textual.widget import Widget

from sar_tui.app import session_start
from tests.app.app_driver import OpenApp
from tests.runs.test_resume import interrupted


@pytest.mark.parametrize("seconds", [0.0, 60.0])
async def test_the_progress_of_a_long_replay_is_painted(
    opened: OpenApp, seconds: float, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    painted: list[str] = []
    paint = session_start.paint_now

    def watched(widget: Widget, *, in_place: bool) -> None:
        painted.append(str(widget.render()))
        paint(widget, in_place=in_place)

    monkeypatch.setattr(session_start, "paint_now", watched)
    monkeypatch.setattr(session_start, "_SHOWN_AFTER_S", seconds)
    monkeypatch.setattr(session_start, "_PAINTED_EVERY_S", 0.0)
    async with opened(interrupted(data, "long", 400)) as driver:
        assert driver.screen_name == "SessionScreen"
    if seconds:
        assert painted == []
    else:
        assert painted[0].startswith("The session goes on where it stopped: ")
        shares = [int(text.split()[-2]) for text in painted]
        assert len(set(shares)) > 5
        assert shares == sorted(shares)
