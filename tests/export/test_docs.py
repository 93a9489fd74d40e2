"""The scripts of docs/analyse-exports.md run on an export, and say what the database says."""

import re
import runpy
import sqlite3
import subprocess
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from tests.export.exported import export_csv
from tests.needs_statistics import needs_r
from tests.program import Call

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "analyse-exports.md").read_text(encoding="utf-8")


def script(kind: str) -> str:
    """Return the first script of a kind on the page."""
    found = re.search(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)
    assert found
    return found[1]


@pytest.fixture
def study(call: Call, simulated: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[int, float]:
    """An export in the folder ``study`` here; the mean reaction times of its levels, from the database."""
    export_csv(tmp_path / "data", tmp_path / "study")
    monkeypatch.chdir(tmp_path)
    with closing(sqlite3.connect(tmp_path / "data" / "sar-tui.db")) as database:
        rows = database.execute(
            "SELECT level, avg(reaction_time_ms) FROM trials JOIN attempts USING (session, attempt, seat)"
            " WHERE trials.correct AND NOT practice GROUP BY level ORDER BY level"
        )
        return {level: pytest.approx(mean, rel=1e-6) for level, mean in rows}


def test_python(study: dict[int, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "script.py").write_text(script("python standard library"))
    runpy.run_path(str(tmp_path / "script.py"))
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert {int(level): float(mean) for _, level, mean in lines} == study


def test_pandas(study: dict[int, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "script.py").write_text(script("python"))
    found = runpy.run_path(str(tmp_path / "script.py"))["right"]
    assert dict(found.groupby("level").reaction_time_ms.mean()) == study


@needs_r
def test_r(study: dict[int, Any], tmp_path: Path) -> None:
    (tmp_path / "script.R").write_text(script("r"))
    done = subprocess.run(["Rscript", "script.R"], capture_output=True, text=True, check=True)
    lines = [line.split() for line in done.stdout.splitlines()[1:]]
    assert {int(level): float(mean) for _, _, level, mean in lines} == study


def test_the_format_of_the_page_works(study: dict[int, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from sar_tui.export import registry

    page = (DOCS / "export-data.md").read_text(encoding="utf-8")
    source = page.partition("## Add a format")[2].partition("```python\n")[2].partition("```")[0]
    (tmp_path / "counts.py").write_text(source)
    made = runpy.run_path(str(tmp_path / "counts.py"))["Counts"]
    monkeypatch.setattr("tests.export.exported.load", lambda name: made())
    assert registry.names()[0] == "csv"
    export_csv(tmp_path / "data", tmp_path / "counted")
    assert '"sessions": 1' in (tmp_path / "counted" / "counts.json").read_text()
