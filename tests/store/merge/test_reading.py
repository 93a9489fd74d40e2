"""Readers of a merged database find the order of sessions, whose they are, and what goes on
here.
"""

from contextlib import closing
from datetime import date
from pathlib import Path

import pytest

from sar_tui.app.home.contents import can_resume, read_day, read_sessions
from sar_tui.model.language import Language
from sar_tui.plugins import Catalogue
from sar_tui.store import participants, results, sessions, sites
from sar_tui.store.database import FILE, RESCUE, connect
from sar_tui.store.rescue import bring_back
from tests.store.by_hand import sql
from tests.store.merge.sites import copy, holds, merge, play, site


@pytest.fixture
def zurich(tmp_path: Path) -> Path:
    """A database with three sessions of P01, the clock having been set back before the last, and
    four of Bern.
    """

    def of(day: int) -> dict[str, str]:
        status = "interrupted" if day == 20 else "completed"
        return {"began": f"2026-03-{day:02}T10:00:00+00:00", "status": status}

    folder, bern = site(tmp_path / "zurich", "ZURICH"), site(tmp_path / "bern", "BERN")
    for number, day in enumerate((1, 10, 5)):
        play(folder, f"a{number}", **of(day))
    for number, day in enumerate((20, 2, 11, 9)):
        play(bern, f"b{number}", f"P0{1 + number % 2}", **of(day))
    merge(folder, bern)
    return folder


def listed(folder: Path, **asked: str) -> list[str]:
    with closing(connect(folder)) as database:
        return [row["id"] for row in sessions.listing(database, folder, **asked)]


def test_sessions_are_in_order_of_time_and_this_sites_as_they_were_stored(zurich: Path) -> None:
    assert listed(zurich) == ["b0", "b2", "a2", "a1", "b3", "b1", "a0"]
    assert listed(zurich, participant="P01@BERN") == ["b0", "b2"]
    play(zurich, "a3", began="2026-03-12T10:00:00+00:00")
    with closing(connect(zurich)) as database:
        assert sessions.find(database, zurich, "last")["id"] == "a3"


def test_a_person_with_two_codes_has_all_sessions_in_order(zurich: Path) -> None:
    merge(zurich, None, same=("P01@BERN=P01",))
    assert listed(zurich, participant="P01") == ["b0", "b2", "a2", "a1", "a0"]
    with closing(connect(zurich)) as database:
        assert participants.codes(database) == ["P01"]
        assert list(results.sessions_of(database, "P01@BERN")) == []


def test_the_first_screen_lists_this_sites_participants(zurich: Path, catalogue: Catalogue) -> None:
    sql(zurich, "UPDATE sessions SET software='{}'")
    with closing(connect(zurich)) as database:
        shown = read_day(database, zurich, date(2026, 3, 30), Language()).entries
        assert [each.code for each in shown] == ["P01"]
        assert participants.last_used(database) == "P01"
        listed = read_sessions(database, zurich, catalogue, None, Language())
        assert [line.who for line in listed.lines][:2] == ["P01@BERN", "P01@BERN"]
        assert (listed.offered, [row["id"] for row in listed.rows if can_resume(row)]) == (None, [])
        assert sessions.latest_interrupted(database, zurich) is None


def test_what_was_merged_comes_back_from_a_rescue_file(zurich: Path, tmp_path: Path) -> None:
    merge(zurich, None, same=("P01@BERN=P01",))
    before = holds(zurich)
    removed = tmp_path / "removed"
    removed.mkdir()
    (copy(zurich, tmp_path / "copy") / FILE).rename(removed / f"{RESCUE}a0.db")
    bring_back(removed)
    assert holds(removed) == before
    with closing(connect(removed)) as database:
        assert sites.own(database) == "ZURICH"
