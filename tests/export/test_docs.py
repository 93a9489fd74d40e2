"""The scripts of docs/analyse-exports.md run on an export, and say what the database says."""

import re
import runpy
import subprocess
from pathlib import Path
from typing import Any

import pytest

from sar_tui.store.tables import TRIALS
from tests.export.exported import export_as, export_csv, read_csv
from tests.needs_statistics import needs_octave, needs_r
from tests.played import simulated as simulate
from tests.store.by_hand import insert, sql

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


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with data, and their exports in the folders ``study`` and ``study-mat``."""
    place = tmp_path_factory.mktemp("exported")
    simulate(place / "data", user="poor")
    simulate(place / "data", "reaching", "P02", seed=2, attempts=2)
    _add_odd_trials(place / "data")
    export_csv(place / "data", place / "study")
    export_as("mat", place / "data", place / "study-mat", with_notes=True)
    return place


@pytest.fixture
def study(exported: Path, monkeypatch: pytest.MonkeyPatch) -> Means:
    """Go to the exports, and return the mean times from the database."""
    monkeypatch.chdir(exported)
    rows = sql(
        exported / "data",
        "SELECT task, participant, level, avg(reaction_time_ms), avg(json_extract(details, '$.reach_time_ms'))"
        " FROM trials JOIN attempts USING (session, attempt, seat) JOIN seats USING (session, seat)"
        " JOIN sessions ON sessions.id=session WHERE trials.correct AND NOT practice GROUP BY 1, 2, 3",
    )
    means: Means = {REACTION: {}, REACH: {}}
    for *group, reaction, reach in rows:
        for name, mean in ((REACTION, reaction), (REACH, reach)):
            if mean is not None:
                means[name][tuple(group)] = pytest.approx(mean, rel=1e-12)  # type: ignore[index]
    assert len(means[REACTION]) > len(means[REACH]) > 0
    return means


def _add_odd_trials(data: Path) -> None:
    """Add a miss, trials of an attempt that was cut off, and a note; make the first attempts
    practice.
    """
    sql(data, "UPDATE attempts SET practice=(attempt=1)")
    missed = "response=NULL, reaction_time_ms=NULL"
    sql(data, f"UPDATE trials SET {missed} WHERE trial=2 AND attempt=3")
    columns = ", ".join(name for name in TRIALS.names if name != "attempt")
    cut_off = f"SELECT 99, {columns} FROM trials WHERE attempt=2"
    sql(data, f"INSERT INTO trials (attempt, {columns}) {cut_off}")
    for (id,) in sql(data, "SELECT id FROM sessions"):
        insert(data, "notes", session=id, at_ns=1, author="operator", text="año")


def _means(lines: list[list[str]]) -> dict[Group, float]:
    known = [line for line in lines if line[3] != "NaN"]
    return {(task, code, int(level)): float(mean) for task, code, level, mean in known}


def test_python(study: Means, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "script.py").write_text(script("python standard library"))
    runpy.run_path(str(tmp_path / "script.py"))
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    for name, means in study.items():
        assert _means([rest for first, *rest in lines if first == name]) == means


def test_pandas(study: Means, tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(script("python"))
    right = runpy.run_path(str(tmp_path / "script.py"))["right"]
    means = right.groupby(["task", "participant", "level"])[list(study)].mean()
    assert {name: means[name].dropna().to_dict() for name in study} == study


@needs_r
def test_r(study: Means, tmp_path: Path) -> None:
    (tmp_path / "script.R").write_text(script("r"))
    done = subprocess.run(
        ["Rscript", tmp_path / "script.R"], capture_output=True, text=True, check=True
    )
    found: dict[str, list[list[str]]] = {}
    for line in done.stdout.splitlines():
        *row, last = line.split()
        if last in study:
            found[last] = current = []
        else:
            current.append([*row[1:], last])
    assert {name: _means(lines) for name, lines in found.items()} == study


@needs_octave
def test_octave(study: Means) -> None:
    lines = [line.split() for line in _octave(script("matlab"))]
    for index, name in enumerate((REACTION, REACH), 3):
        assert _means([[*line[:3], line[index]] for line in lines]) == study[name]


@needs_octave
def test_octave_reads_samples_and_texts(study: Means) -> None:
    trials, samples = read_csv(Path("study"), "trials"), read_csv(Path("study"), "imu")
    example = re.sub(r"session_\w+", f"session_{samples[0]['session']}", script("matlab samples"))
    said = _octave("\n".join([example, script("matlab texts"), "disp(notes{1})"]))
    found = [float(line.split()[-2]) for line in said if line.startswith("attempt")]

    def largest(trial: dict[str, Any]) -> float:
        begin, end = trial["onset_ns"], trial["response_ns"]
        return max(abs(each["rate_z"]) for each in samples if begin <= each["at_ns"] <= end)

    reaches = [trial for trial in trials if trial["details_reach_time_ms"] is not None]
    assert found == [pytest.approx(largest(trial)) for trial in reaches]
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
    export_csv(Path("data"), tmp_path / "counted")
    assert '"sessions": 2' in (tmp_path / "counted" / "counts.json").read_text()
