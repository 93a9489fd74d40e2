"""Declared measures of attempts, wherever a session's results are shown."""

from pathlib import Path
from statistics import fmean

import pytest

from sar_tui.app.guarded_view import GuardedView
from sar_tui.model.language import Language
from sar_tui.model.measure import Measure
from sar_tui.plugins import Catalogue
from sar_tui.rules.parameters import build
from sar_tui.store.sessions import attempt_ended
from tests.documented import write_documented
from tests.edit import edit
from tests.program import Call


@pytest.fixture
def steady(tmp_path: Path) -> Path:
    """The folder of the documented task with a declared measure."""
    return write_documented(tmp_path / "mytasks", "steady")


def test_a_measure_has_its_title_unit_and_decimals_in_show_the_summary_and_progress(
    call: Call, steady: Path
) -> None:
    where = ("--tasks", steady.parent)
    simulated = call("simulate steady --user average --attempts 3 --seed 1 -p P01", *where)
    assert simulated.code == 0
    assert "variability" in simulated.out

    found = call("show last --json", *where).json
    values = [attempt["qualities"]["variability_ms"] for attempt in found["attempts"]]
    shown = call("show last", *where).out
    assert all(f" {value:.0f} ms" in shown for value in values)
    mean = f"Variability: {fmean(values):.0f} ms."
    assert mean in shown
    assert mean in simulated.out

    (line,) = call("progress P01 --json", *where).json["lines"]
    assert line["measured"] == [
        {"name": "variability_ms", "title": "variability", "unit": "ms", "decimals": 0}
    ]
    told = call("progress P01", *where).out
    assert "variability (ms)" in told
    assert f" {fmean(values):.0f}\n" in told

    assert "variability_ms" in call("tasks show steady", *where).out
    kind = Catalogue(tasks=(steady.parent,)).task("steady")
    ended = [attempt_ended(attempt) for attempt in found["attempts"]]
    assert GuardedView(kind(build(kind.Parameters, {}))).facts(ended) == [mean]


def test_an_undeclared_measure_is_stored_and_has_its_name_in_progress(
    call: Call, steady: Path
) -> None:
    edit(steady / "task.py", '"variability", unit="ms", decimals=0', '"variability"')
    edit(steady / "task.py", '"variability_ms", ', '"other", ')
    where = ("--tasks", steady.parent)
    simulate = ("simulate", "steady", "--user", "average", "--attempts", 2, "-p", "P01", *where)
    assert [call(*simulate, "--seed", seed).code for seed in (1, 2)] == [0, 0]
    assert "ariability" not in call("show last", *where).out
    assert "variability ms" in call("progress P01", *where).out


def test_a_value_has_the_readers_decimal_sign() -> None:
    measure = Measure("rate", "rate", unit="/s", decimals=1)
    assert measure.show(2.345, Language("es")) == "2,3 /s"
