"""``sar-tui validate``: figures and claims, for people and programs."""

import csv
import re
import sys
from pathlib import Path

import pytest

from sar_tui.validation import table_4_1
from sar_tui.validation.registry import VALIDATIONS
from sar_tui.validation.report import Conditions, Report
from tests.program import Call

pytestmark = pytest.mark.usefixtures("simulated_once")


def test_table_4_1_is_printed_beside_the_results(call: Call) -> None:
    printed = call("validate --only table-4.1 --json").json
    assert set(printed) == {"table-4.1"}
    rows = printed["table-4.1"]
    assert [row["type"] for row in rows] == [
        f"{how} {where}" for where in ("near", "far") for how in ("slow",) * 2 + ("fast",) * 2
    ]
    assert (rows[0]["table_reach_time_s"], rows[7]["table_peak_return_rad_s"]) == (1.3385, -4.4508)
    for row in rows:
        assert abs(row["single_axis_difference_ms"]) <= 40
        assert abs(row["fixed_threshold_difference_ms"]) <= 130
        for detector in ("single_axis", "fixed_threshold"):
            assert row[f"{detector}_reach_time_s"] == pytest.approx(
                row["table_reach_time_s"] + row[f"{detector}_difference_ms"] / 1000
            )
            assert abs(row[f"{detector}_peak_extension_difference_percent"]) <= 3
            assert abs(row[f"{detector}_peak_return_difference_percent"]) <= 3


@pytest.mark.slow
def test_several_validations_whose_claims_hold_can_be_named_in_any_order(call: Call) -> None:
    names = "reach,modularity,table-4.1"
    called = call("validate --full --reaches 20 --json --only", names)
    assert called.code == 0
    assert list(called.json) == ["table-4.1", "reach", "modularity"]
    rows = {row["scenario"]: row for row in called.json["reach"]}
    for row in rows.values():
        assert row["reaches"] == 20
        assert row["orientation_exactly_one_percent"] >= 95.0
        assert row["orientation_endless_percent"] == 0.0
    assert rows["clean"]["fixed_threshold_exactly_one_percent"] == 100.0
    assert rows["all combined"]["fixed_threshold_exactly_one_percent"] == 0.0
    shared = {row["task"]: row["strict_shared"] for row in called.json["modularity"]}
    assert shared["reaching"] < shared["keyboard"], "a sensor and movement science"


def test_a_failed_claim_is_reported_and_exits_with_1(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(table_4_1.TIME_MS, "fixed-threshold", 100.0)
    claim = "✗ The fixed-threshold detector's reach times are within 100 ms of the table's."
    call("validate --only table-4.1").shows(f"{claim} But reach 1: -110.5 ms,", code=1)
    as_json = call("validate --only table-4.1 --json")
    assert (as_json.code, len(as_json.json["table-4.1"])) == (1, 8)
    assert as_json.err.startswith(claim)
    monkeypatch.setattr(table_4_1, "detect", lambda recording, name: ())
    claim = "✗ The single-axis detector finds eight reaches. But it finds 0."
    call("validate --only table-4.1").shows(claim, "reach 8: none", code=1)


def test_figures_tables_and_one_page_are_written_and_existing_files_are_not_overwritten(
    call: Call, tmp_path: Path
) -> None:
    folder = tmp_path / "new" / "results"
    called = call("validate --only figure-4.15,table-4.1 --to", folder)
    called.shows("slow near", "✓ The fixed-threshold detector finds eight reaches.")
    assert "✗" not in called.out
    figure = {f"figure-4.15.{kind}" for kind in ("csv", "txt", "svg")}
    written = {"table-4.1.csv", "table-4.1.txt", "validation.html"} | figure
    assert {path.name for path in folder.iterdir()} == written
    drawing = (folder / "figure-4.15.svg").read_text(encoding="utf-8")
    states = (drawing.count(">added</text>"), drawing.count(">the same</text>") > 5)
    assert states == (4, True), "not told by colour alone"
    with (folder / "table-4.1.csv").open(encoding="utf-8", newline="") as file:
        assert len(list(csv.DictReader(file))) == 8
    text = (folder / "table-4.1.txt").read_text(encoding="utf-8")
    assert "✓ The fixed-threshold detector finds eight reaches." in text
    page = (folder / "validation.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 1
    wide = page.count('<div class="wide"><table')
    assert page.count("<table") == wide > 0, "wide tables scroll by themselves"
    assert not re.search("<script|src=|href=", page)
    (folder / "validation.html").unlink()
    (folder / "table-4.1.csv").write_text("mine")
    again = call("validate --only table-4.1 --to", folder)
    again.refused("already holds a table-4.1.csv", "not overwritten")
    assert (folder / "table-4.1.csv").read_text() == "mine"
    within = call("validate --only table-4.1 --to", folder / "table-4.1.csv" / "results")
    within.refused("cannot be used: Not a directory.", code=1)


def test_every_validation_is_named_in_the_help(call: Call) -> None:
    help_text = call("validate --help").out
    assert [name for name in VALIDATIONS if name not in help_text] == []


def test_without_the_package_for_figures_all_else_is_written_and_the_page_draws_with_characters(
    call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "vl_convert", None)
    called = call("validate --only figure-4.8 --to", tmp_path / "report")
    assert (called.code, called.err.count("pip install -e '.[report]'")) == (0, 1)
    names = {path.name for path in (tmp_path / "report").iterdir()}
    assert names == {"figure-4.8.csv", "figure-4.8.txt", "validation.html"}
    page = (tmp_path / "report" / "validation.html").read_text(encoding="utf-8")
    assert "rad/s about z over s" in page


def test_a_recorded_session_has_the_figures_that_its_data_allow(call: Call, tmp_path: Path) -> None:
    call("simulate reaching --user poor --attempts 2 --seed 1")
    found = call("validate --session last --json").json
    assert set(found) == {"figure-4.4", "figure-4.8", "figure-4.11", "figure-4.13", "table-4.1"}
    assert len(found["figure-4.4"]) == 2
    assert {"reach_time_ms", "goal_ms"} < set(found["figure-4.4"][0]), "named as the task's metric"
    assert "reaction" not in call("validate --session last").out
    assert {row["reach_time_s"] > 0 for row in found["table-4.1"]} == {True}
    call("simulate keyboard --user poor --attempts 1 --seed 1")
    called = call("validate --session last --to", tmp_path / "mine")
    assert called.code == 0
    assert "figure-4.8: it has no samples of a motion sensor." in called.out
    named = set(re.findall(r"(?:figure|table)-[\d.]+\d", called.out))
    drawn = {path.stem for path in (tmp_path / "mine").glob("*.csv")}
    assert {name for name in VALIDATIONS if name.startswith(("figure", "table"))} <= named | drawn
    assert (tmp_path / "mine" / "figure-4.4.svg").exists()
    refused = call("validate --session last --full")
    assert (refused.code, "leave out" in refused.err) == (2, True)


def test_the_quick_form_is_the_default_and_the_full_one_is_asked_for(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[bool, int, int]] = []

    def run(conditions: Conditions) -> Report:
        asked.append((conditions.is_quick, conditions.reaches, len(conditions.seeds)))
        return Report([], [], [])

    monkeypatch.setitem(VALIDATIONS, "reach", VALIDATIONS["reach"]._replace(run=run))
    for option in ("", "--full", "--reaches 7"):
        assert call(f"validate --only reach {option}").code == 0
    assert asked == [(True, 20, 3), (False, 200, 10), (True, 7, 3)]


def test_the_time_left_is_told_where_output_is_piped(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.cli.progress_line._PIPED_S", 0.0)
    called = call("validate --only figure-4.8,table-4.1 --json")
    assert called.json.keys() == {"figure-4.8", "table-4.1"}
    assert re.search(r"table-4.1 … 50 %, about \d+ s left\n", called.err)
