"""A task without a result in the commands: simulated, listed, shown, exported and reported, without
a traceback.
"""

from pathlib import Path

import pytest

from tests.program import Call
from tests.tasks.test_documented_tasks import documented


@pytest.fixture
def rated(call: Call, tmp_path: Path) -> tuple[Path, str]:
    """The folder of the documented task of ratings, and a simulated session of it."""
    documented(tmp_path / "mytasks", "pleasant")
    tasks = tmp_path / "mytasks"
    who = ("--user", "average", "-p", "P01", "--attempts", 3, "--seed", 1)
    done = call("simulate pleasant", *who, "--tasks", tasks, "--json")
    return tasks, str(done.json["session"])


def test_it_is_listed_without_a_metric(call: Call, rated: tuple[Path, str]) -> None:
    tasks, _ = rated
    (listed,) = [
        row
        for row in call("tasks --json --tasks", tasks).json["tasks"]
        if row["name"] == "pleasant"
    ]
    assert listed["metric"] is None
    assert call("tasks show pleasant --json --tasks", tasks).json["task"]["metric"] is None
    assert "How pleasant?" in call("tasks --tasks", tasks).out


def test_a_session_is_shown_without_results_goals_and_plot(
    call: Call, rated: tuple[Path, str]
) -> None:
    tasks, session = rated
    shown = call("show", session, "--tasks", tasks)
    assert shown.code == 0
    assert "3 attempts, levels 1 to 1." in shown.out
    assert "reached" not in shown.out
    rows = call("show", session, "--json", "--tasks", tasks).json["attempts"]
    assert {(row["metric"], row["goal"], row["outcome"], row["feedback"]) for row in rows} == {
        (None, None, "none", "none")
    }
    assert all(set(row["qualities"]) == {"mean_rating"} for row in rows)


def test_progress_has_its_sessions_and_says_nothing_of_a_goal(
    call: Call, rated: tuple[Path, str]
) -> None:
    tasks, _ = rated
    told = call("progress P01 --tasks", tasks)
    assert (told.code, "100%" in told.out, "level at goal is not known" in told.out) == (
        0,
        True,
        False,
    )
    (line,) = call("progress P01 --json --tasks", tasks).json["lines"]
    assert [(each["attempts"], each["reached"], each["mean"]) for each in line["sessions"]] == [
        (3, None, None)
    ]


@pytest.mark.parametrize(
    "command",
    [
        "replay {session}",
        "replay {session} --what-if min_accuracy=0.5",
        "report intervention --all --simulated",
        "progress P01 --html {folder}/page.html",
    ],
)
def test_other_commands_take_it(
    call: Call, rated: tuple[Path, str], tmp_path: Path, command: str
) -> None:
    tasks, session = rated
    called = call(*command.format(session=session, folder=tmp_path).split(), "--tasks", tasks)
    assert (called.code, called.err) == (0, "")
    assert "0%" not in called.out.replace("100%", "")


@pytest.mark.parametrize("kind", ["csv", "bids", "psych-ds", "parquet", "mat", "elan"])
def test_it_is_exported(call: Call, rated: tuple[Path, str], tmp_path: Path, kind: str) -> None:
    tasks, session = rated
    called = call(
        "export",
        session,
        "--simulated",
        "--format",
        kind,
        "--to",
        tmp_path / "out",
        "--tasks",
        tasks,
    )
    assert (called.code, called.err) == (0, "")


@pytest.mark.slow
def test_it_passes_its_check(call: Call, rated: tuple[Path, str]) -> None:
    tasks, _ = rated
    assert call("tasks check", tasks / "pleasant").code == 0
