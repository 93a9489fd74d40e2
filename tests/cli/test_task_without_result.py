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


def test_it_is_listed_without_a_metric(call: Call, rated: Path) -> None:
    listed = {row["name"]: row for row in call("tasks --json --tasks", rated).json["tasks"]}
    assert listed["pleasant"]["metric"] is None
    assert call("tasks show pleasant --json --tasks", rated).json["task"]["metric"] is None
    call("tasks --tasks", rated).shows("How pleasant?")


def test_a_session_is_shown_without_results_goals_and_plot(
    call: Call, rated: Path, session: str
) -> None:
    shown = call("show", session, "--tasks", rated)
    shown.shows("3 attempts, levels 1 to 1.")
    assert "reached" not in shown.out
    for row in call("show", session, "--json", "--tasks", rated).json["attempts"]:
        assert (row["metric"], row["goal"]) == (None, None)
        assert (row["outcome"], row["feedback"]) == ("none", "none")
        assert set(row["qualities"]) == {"mean_rating"}


@pytest.mark.usefixtures("session")
def test_progress_has_its_sessions_and_says_nothing_of_a_goal(call: Call, rated: Path) -> None:
    told = call("progress P01 --tasks", rated)
    told.shows("100%")
    assert "level at goal is not known" not in told.out
    (line,) = call("progress P01 --json --tasks", rated).json["lines"]
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


@pytest.mark.slow
def test_it_passes_its_check(call: Call, rated: Path) -> None:
    assert call("tasks check", rated / "pleasant").code == 0
