"""Golden sessions: those of every release come out the same for ever."""

from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.replay.replay import replay
from sar_tui.store import sessions
from sar_tui.store.database import connect
from tests.store.make_golden import RELEASES, unpack


@pytest.mark.parametrize("release", RELEASES)
def test_golden_sessions_are_identical(data: Path, catalogue: Catalogue, release: str) -> None:
    with closing(connect(unpack(release, data))) as database:
        for (name,) in database.execute("SELECT id FROM sessions").fetchall():
            replayed = replay(database, data, catalogue, sessions.find(database, data, name))
            assert replayed.identical, (name, replayed.first_difference)
