"""A task without a result in the commands: simulated, listed, shown, exported and reported, without
a traceback.
"""

from pathlib import Path

import pytest

from tests.program import Call
from tests.tasks.test_documented_tasks import documented


@pytest.fixture
def rated(tmp_path: Path) -> Path:
    """The folder of the documented task of ratings."""
    documented(tmp_path / "mytasks", "pleasant")
    return tmp_path / "mytasks"


@pytest.fixture
def session(call: Call, rated: Path) -> str:
    """A simulated session of it."""
    who = "--user average -p P01 --attempts 3 --seed 1 --json --tasks"
    return str(call(f"simulate pleasant {who}", rated).json["session"])


def test_it_is_listed_and_shown_without_a_metric_results_and_goals(
    call: Call, rated: Path, session: str
) -> None:
    where = ("--tasks", rated)
    listed = {row["name"]: row for row in call("tasks --json", *where).json["tasks"]}
    assert listed["pleasant"]["metric"] is None
    assert call("tasks show pleasant --json", *where).json["task"]["metric"] is None
    call("tasks", *where).shows("How pleasant?")
    shown = call("show", session, *where)
    shown.shows("3 attempts, levels 1 to 1.")
    assert "reached" not in shown.out
    for row in call("show", session, "--json", *where).json["attempts"]:
        assert (row["metric"], row["goal"]) == (None, None)
        assert (row["outcome"], row["feedback"]) == ("none", "none")
        assert set(row["qualities"]) == {"mean_rating"}
    told = call("progress P01", *where)
    told.shows("100%")
    assert "level at goal is not known" not in told.out
    (line,) = call("progress P01 --json", *where).json["lines"]
    (each,) = line["sessions"]
    assert (each["attempts"], each["reached"], each["mean"]) == (3, None, None)


@pytest.mark.usefixtures("session")
@pytest.mark.parametrize(
    "command",
    [
        "replay last",
        "replay last --what-if min_accuracy=0.5",
        "report intervention --all --simulated",
        "progress P01 --html {folder}/page.html",
        *(
            f"export last --simulated --to {{folder}}/out --format {kind}"
            for kind in ("csv", "bids", "psych-ds", "parquet", "mat", "elan")
        ),
    ],
)
def test_other_commands_take_it(call: Call, rated: Path, tmp_path: Path, command: str) -> None:
    called = call(command.format(folder=tmp_path), "--tasks", rated)
    assert (called.code, called.err) == (0, "")
    assert "0%" not in called.out.replace("100%", "")
