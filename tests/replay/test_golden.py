"""Golden sessions: recorded by the program of each version of the rules, they come out the same for
ever.

The sessions of ``golden/rules-N.db.gz`` were recorded by the last program with rules N.
"""

import gzip
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.plugins import Catalogue
from sar_tui.replay.replay import replay
from sar_tui.rules.version import RULES
from sar_tui.store import sessions
from sar_tui.store.database import connect

GOLDEN = {
    int(file.name.removesuffix(".db.gz").removeprefix("rules-")): file
    for file in (Path(__file__).parent / "golden").glob("rules-*.db.gz")
}


def test_each_version_of_the_rules_has_golden_sessions() -> None:
    assert sorted(GOLDEN) == list(range(1, RULES + 1)), (
        "run `python -m tests.replay.make_golden` when the rules change"
    )


@pytest.mark.parametrize("rules", sorted(GOLDEN))
def test_golden_sessions_are_identical(data: Path, catalogue: Catalogue, rules: int) -> None:
    data.mkdir(exist_ok=True)
    (data / "sar-tui.db").write_bytes(gzip.decompress(GOLDEN[rules].read_bytes()))
    with closing(connect(data)) as database:
        for (name,) in database.execute("SELECT id FROM sessions").fetchall():
            replayed = replay(database, data, catalogue, sessions.find(database, data, name))
            assert replayed.identical, (name, replayed.first_difference)
            assert {run.rules for run in replayed.recorded_with} == {rules}
