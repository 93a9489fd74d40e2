"""The page of progress: self-contained, with text alternatives, for no session, one, and a
thousand.
"""

import re
import sys
from statistics import fmean
from types import SimpleNamespace
from typing import Any

import pytest

from sar_tui.loop.task import Task
from sar_tui.plugins import Catalogue
from sar_tui.progress.lines import SessionResults
from sar_tui.reports import charts, progress_charts, progress_page, progress_words
from sar_tui.reports.progress import Progress, progress
from sar_tui.rules.wellbeing import SessionRatings
from tests.progress.session_results import adapted, at_one_level, session
from tests.reports.test_progress import SPANISH, fell, steady
from tests.untranslated import english_in


def figures(found: Progress, kind: type[Task], code: str = "en") -> str:
    return progress_page.page(found, {kind.name: kind}.get, code)


@pytest.fixture
def specs(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """Collect the charts instead of drawing them."""
    collected: list[dict[str, Any]] = []

    def draw(spec: dict[str, Any]) -> str:
        collected.append(spec)
        return '<svg class="marks"></svg>'

    monkeypatch.setitem(sys.modules, "vl_convert", SimpleNamespace(vegalite_to_svg=draw))
    return collected


def page(keyboard: type[Task], sessions: list[SessionResults], code: str = "en") -> str:
    return figures(progress("P01", sessions, {"keyboard": keyboard}.get), keyboard, code)


def test_a_session_has_its_charts_and_texts_are_escaped(
    keyboard: type[Task], specs: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    nobody = page(keyboard, [])
    assert "There are no finished attempts yet." in nobody
    assert "<svg" not in nobody
    made = page(keyboard, [session(1, adapted(1), {"levels": ["<b>", "&c"]})])
    assert "<b>" not in made
    assert "&lt;b&gt; &amp;c" in made
    specs.clear()
    made = page(keyboard, steady(1))
    # level at goal, minutes, result, attempts and repetitions of each day
    assert made.count("<svg") == made.count("<figcaption>") == len(specs) == 5
    specs.clear()
    one_level = [session(number, at_one_level(number, 950.0)) for number in range(4)]
    assert "Level at goal of each session" not in page(keyboard, one_level)
    assert len(specs) == 4
    specs.clear()
    played = [session(n, adapted(n), qualities={"sparc": -1.6 - n / 10}) for n in range(3)]
    assert "Mean of each session: smoothness (SPARC)." in page(keyboard, played)
    assert len(specs) == 6
    monkeypatch.setitem(sys.modules, "vl_convert", None)
    with pytest.raises(charts.ChartsMissing, match=r"pip install -e '\.\[report\]'"):
        page(keyboard, steady(1))


def test_each_chart_has_a_text_alternative_and_a_page_needs_nothing_from_elsewhere(
    keyboard: type[Task], specs: list[dict[str, Any]]
) -> None:
    made = page(keyboard, steady(5))
    labels = re.findall(r'<svg role="img" aria-label="([^"]+)"', made)
    assert len(labels) == 5
    first = r"2026-02-27: level 3\.\d \(.* keys, 95 % range .*\)\. 2026-03-03: level 3"
    assert re.search(first, labels[0])
    assert "2000 repetitions on 5 days." in labels[4]
    assert re.findall(r"https?:|src=|href=|@import|url\(|<script", made) == []
    (noise,) = specs[0]["layer"][0]["data"]["values"]
    values = [value["value"] for value in specs[0]["data"]["values"]]
    assert noise["low"] < min(values)
    assert 2 < noise["high"] < 60, (
        "the noise of the baseline in keys, as people read it, not in bits"
    )
    made = page(keyboard, steady(5), "es")
    assert '<html lang="es">' in made
    shown = re.sub(r"<style>.*?</style>|<[^>]+>", "\n", made, flags=re.DOTALL)
    assert english_in(re.sub(r"docs/\S+", "", shown).splitlines(), SPANISH) == []
    assert "aciertos" in made


def test_a_thousand_sessions_share_marks_by_a_stated_rule_and_the_newest_are_listed(
    keyboard: type[Task], specs: list[dict[str, Any]]
) -> None:
    sessions = steady(1000)
    made = page(keyboard, sessions)
    assert "In the charts a mark stands for up to 9 sessions, one after the other" in made
    assert "Attempts of each month. Line: planned." in made
    assert [len(spec["data"]["values"]) <= 120 for spec in specs] == [True] * 5
    first = specs[2]["data"]["values"][0]
    (line,) = progress("P01", sessions[:9], {"keyboard": keyboard}.get).lines
    mean = fmean(each.mean for each in line.sessions if each.mean)
    assert first["value"] == pytest.approx(mean / 1000)
    assert first["date"] == "2026-03-03", "the middle one of nine"
    assert sum(row["repetitions"] for row in specs[4]["data"]["values"]) == 400_000
    assert made.count("<tr>") == 61


def test_pain_and_tiredness_are_charted_on_the_time_axis_of_the_sessions(
    keyboard: type[Task], specs: list[dict[str, Any]]
) -> None:
    second = SessionRatings(pain_before=4, pain_after=5, fatigue_after=4)
    said = [SessionRatings(), second, SessionRatings(pain_after=3)]
    made = page(keyboard, [session(n, adapted(n), felt=felt) for n, felt in enumerate(said)])
    assert "pain 5 → 3, tiredness 4 → 4" in made
    felt = next(spec for spec in specs if len(spec["layer"]) == 2 and "data" in spec["layer"][0])
    for layer in (*specs[0]["layer"], *felt["layer"]):
        domain = layer["encoding"]["x"]["scale"]["domain"]
        assert domain == ["2026-02-27T10:00:00", "2026-03-01T10:02:00"]


def test_an_adverse_event_is_told_and_marked(
    keyboard: type[Task], specs: list[dict[str, Any]]
) -> None:
    events = [fell("2026-02-28", outcome="No injury")]
    found = progress("P01", steady(3), {"keyboard": keyboard}.get, records=events)
    made = figures(found, keyboard)
    assert "<strong>Adverse event 2026-02-28, mild: Fell. Outcome: No injury.</strong>" in made
    assert "!: pain above the limits, or an adverse event." in made
    signs = [[layer["mark"].get("text") for layer in spec["layer"]] for spec in specs]
    (marked,) = (spec for spec, texts in zip(specs, signs, strict=True) if "!" in texts)
    assert marked["data"]["values"][0]["date"] == "2026-02-28"


@pytest.mark.slow
def test_every_chart_can_be_drawn(keyboard: type[Task]) -> None:
    converter = pytest.importorskip("vl_convert", reason="the extra `report` is not installed")
    more: Any = {
        "felt": SessionRatings(pain_before=2, fatigue_after=4),
        "qualities": {"sparc": -1.6},
    }
    sessions = [session(n, adapted(n), **more) for n in range(5)]
    found = progress("P01", sessions, {"keyboard": keyboard}.get, records=[fell("2026-03-01")])
    tr = progress_words.words("es", keyboard)
    (line,) = found.lines
    charts = [
        progress_charts.level_picture(line, tr),
        progress_charts.minutes_picture(line, tr),
        progress_charts.result_picture(line, tr),
        *progress_charts.quality_pictures(line, tr).values(),
        progress_charts.felt_picture(line, tr),
        progress_charts.attempts_picture(found.days, tr),
        progress_charts.dose_picture(found.days, tr),
    ]
    namespaces = {f"http://www.w3.org/{name}" for name in ("2000/svg", "1999/xlink")}
    for chart in charts:
        drawn = converter.vegalite_to_svg(chart)
        assert drawn.startswith("<svg ")
        assert set(re.findall(r'https?://[^"\s]+', drawn)) <= namespaces


def test_goals_that_differ_between_levels_are_not_drawn_as_one_line(
    catalogue: Catalogue, specs: list[dict[str, Any]]
) -> None:
    reaching = catalogue.task("reaching")
    facts = {"task": "reaching", "task_version": reaching.version, "metric": reaching.metric}
    played = [session(1, adapted(1, base=900.0), **facts)]
    found = progress("P01", played, {"reaching": reaching}.get)
    made = figures(found, reaching)
    assert found.lines[0].goal is None
    assert "Dashed" not in made
    # -1.6 is not shown as -2
    assert all(spec["config"]["axisY"]["format"] == ".6~r" for spec in specs)
