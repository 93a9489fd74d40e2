"""The scripts of docs/analyse-exports.md run on an export, and say what the database says."""

import re
import runpy
import sqlite3
import subprocess
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from tests.export.exported import export_as, export_csv, read_csv
from tests.needs_statistics import needs_octave, needs_r
from tests.program import Call

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "analyse-exports.md").read_text(encoding="utf-8")


def script(kind: str) -> str:
    """Return the first script of a kind on the page."""
    found = re.search(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)
    assert found
    return found[1]


Group = tuple[str, str, int]
Means = dict[str, dict[Group, Any]]
"""Mean times by their name, and by task, participant and level."""
REACTION, REACH = "reaction_time_ms", "details_reach_time_ms"


@pytest.fixture
def study(call: Call, simulated: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Means:
    """Exports in the folders ``study`` and ``study-mat`` here; the mean times, from the
    database.
    """
    call("simulate", "reaching", "--user", "average", "--attempts", 2, "--seed", 2, "-p", "P02")
    _add_odd_trials(tmp_path / "data")
    export_csv(tmp_path / "data", tmp_path / "study")
    export_as("mat", tmp_path / "data", tmp_path / "study-mat", with_notes=True)
    monkeypatch.chdir(tmp_path)
    with closing(sqlite3.connect(tmp_path / "data" / "sar-tui.db")) as database:
        rows = database.execute(
            "SELECT task, participant, level, avg(reaction_time_ms), avg(json_extract(details, "
            "'$.reach_time_ms')) FROM trials JOIN attempts USING (session, attempt, seat) JOIN "
            "seats USING (session, seat) JOIN sessions ON sessions.id=session WHERE "
            "trials.correct AND NOT practice GROUP BY 1, 2, 3"
        ).fetchall()
    means: Means = {
        name: {
            tuple(row[:3]): pytest.approx(row[index], rel=1e-12)
            for row in rows
            if row[index] is not None
        }
        for name, index in ((REACTION, 3), (REACH, 4))
    }
    assert len(means[REACTION]) > len(means[REACH]) > 0
    return means


def _add_odd_trials(data: Path) -> None:
    """Add a miss, trials of an attempt that was cut off, and a note; make the first attempts
    practice.
    """
    with closing(sqlite3.connect(data / "sar-tui.db")) as database, database:
        database.execute("UPDATE attempts SET practice=(attempt=1)")
        database.execute(
            "UPDATE trials SET response=NULL, reaction_time_ms=NULL WHERE trial=2 AND attempt=3"
        )
        columns = (
            "session, trial, seat, run, stimulus, response, correct, onset_ns, response_ns, "
            "reaction_time_ms, timing, details"
        )
        database.execute(
            f"INSERT INTO trials (attempt, {columns}) SELECT 99, {columns} FROM trials WHERE "
            "attempt=2"
        )
        database.execute(
            "INSERT INTO notes (session, at_ns, author, text) SELECT id, 1, 'operator', 'año' "
            "FROM sessions"
        )


def _means(lines: list[list[str]]) -> dict[Group, float]:
    return {
        (task, code, int(level)): float(mean) for task, code, level, mean in lines if mean != "NaN"
    }


def test_python(study: Means, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "script.py").write_text(script("python standard library"))
    runpy.run_path(str(tmp_path / "script.py"))
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert {
        name: _means([rest for first, *rest in lines if first == name]) for name in study
    } == study


def test_pandas(study: Means, tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(script("python"))
    right = runpy.run_path(str(tmp_path / "script.py"))["right"]
    means = right.groupby(["task", "participant", "level"])[list(study)].mean()
    assert {name: means[name].dropna().to_dict() for name in study} == study


@needs_r
def test_r(study: Means, tmp_path: Path) -> None:
    (tmp_path / "script.R").write_text(script("r"))
    done = subprocess.run(["Rscript", "script.R"], capture_output=True, text=True, check=True)
    found: dict[str, list[list[str]]] = {}
    for line in done.stdout.splitlines():
        *row, last = line.split()
        if last in study:
            found[last] = current = []
        else:
            current.append([*row[1:], last])
    assert {name: _means(lines) for name, lines in found.items()} == study


@needs_octave
def test_octave(study: Means, tmp_path: Path) -> None:
    lines = [line.split() for line in _octave(script("matlab"))]
    found = {
        name: _means([[*line[:3], line[index]] for line in lines])
        for name, index in ((REACTION, 3), (REACH, 4))
    }
    assert found == study


@needs_octave
def test_octave_reads_samples_and_texts(study: Means, tmp_path: Path) -> None:
    trials, samples = read_csv(tmp_path / "study", "trials"), read_csv(tmp_path / "study", "imu")
    example = re.sub(r"session_\w+", f"session_{samples[0]['session']}", script("matlab samples"))
    said = _octave("\n".join([example, script("matlab texts"), "disp(notes{1})"]))
    found = [float(line.split()[-2]) for line in said if line.startswith("attempt")]
    assert found == [
        pytest.approx(
            max(
                abs(each["rate_z"])
                for each in samples
                if trial["onset_ns"] <= each["at_ns"] <= trial["response_ns"]
            )
        )
        for trial in trials
        if trial["details_reach_time_ms"] is not None
    ]
    assert said[-1] == "año"


def _octave(source: str) -> list[str]:
    Path("script.m").write_text(source)
    done = subprocess.run(["octave-cli", "script.m"], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def test_the_pages_format_works(
    study: Means, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from sar_tui.export import registry

    page = (DOCS / "export-data.md").read_text(encoding="utf-8")
    source = page.partition("## Add a format")[2].partition("```python\n")[2].partition("```")[0]
    (tmp_path / "counts.py").write_text(source)
    made = runpy.run_path(str(tmp_path / "counts.py"))["Counts"]
    monkeypatch.setattr("tests.export.exported.load", lambda name: made())
    assert registry.names()[0] == "csv"
    export_csv(tmp_path / "data", tmp_path / "counted")
    assert '"sessions": 2' in (tmp_path / "counted" / "counts.json").read_text()
