"""Contents of a participant's card: the verdict is that of the progress screen, however long the
history.
"""

from contextlib import closing
from datetime import date
from pathlib import Path

import pytest

from sar_tui.app.home import contents
from sar_tui.app.home.words import progress_words
from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.reports.progress import progress
from sar_tui.store.database import connect
from tests.progress.session_results import adapted, session


@pytest.mark.parametrize("last", [300.0, 450.0, 600.0])
def test_the_card_and_the_progress_screen_give_one_verdict_after_many_sessions(
    tmp_path: Path,
    catalogue: Catalogue,
    keyboard: type[Task],
    monkeypatch: pytest.MonkeyPatch,
    last: float,
) -> None:
    played = [
        session(number, adapted(number, base=450.0 + (last - 450.0) * number / 24))
        for number in range(25)
    ]
    other = session(30, adapted(3), {"threshold": 900.0}, on_day=0)
    simulated = session(31, adapted(3), mode="simulated", on_day=0)
    monkeypatch.setattr(
        contents.results, "sessions_of", lambda *_, **__: iter([other, *played, simulated])
    )
    with closing(connect(tmp_path)) as database:
        card = contents.read_card(database, tmp_path, catalogue, "P01", keyboard, date(2026, 4, 1))
    (line,) = progress("P01", played, {"keyboard": keyboard}.get).lines
    assert line.verdict == {300.0: "more", 450.0: "noise", 600.0: "less"}[last]
    assert card.progress == progress_words(line, 1)
    assert len(card.chart.bars) == 25
