"""Progress over sessions: verdicts, doses, comparisons, and their words in both languages."""

import re
import tomllib
from datetime import date
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import pytest

from sar_tui.checks.task_translations import texts_in
from sar_tui.loop.task import Task
from sar_tui.model.trial_types import NO_METRIC, Metric
from sar_tui.progress.lines import SessionResults
from sar_tui.progress.task_level import AttemptResult
from sar_tui.records.kind import SHIPPED
from sar_tui.reports import dose_words, progress_words
from sar_tui.reports.charts import Columns
from sar_tui.reports.dose import days_of, recent
from sar_tui.reports.progress import Progress, compare, progress
from sar_tui.reports.progress_charts import result_picture
from sar_tui.reports.progress_glossary import GLOSSARY, explained
from sar_tui.reports.progress_parts import figures, listed, of_person, picture
from sar_tui.reports.progress_timeline import timeline
from sar_tui.rules.wellbeing import SessionRatings
from sar_tui.store.records import Record
from tests.progress.session_results import adapted, at_one_level, session
from tests.untranslated import english_in

SPANISH = tomllib.loads(
    (Path(progress_words.__file__).parent / "words.es.toml").read_text(encoding="utf-8")
)


def of(keyboard: type[Task], *sessions: SessionResults) -> Progress:
    return progress("P01", sessions, {"keyboard": keyboard}.get)


def steady(count: int, base: float = 450.0) -> list[SessionResults]:
    return [session(number, adapted(number, base=base)) for number in range(count)]


def said(found: Progress, language: str = "en", kind: type[Task] | None = None) -> str:
    tr = progress_words.words(language, kind)
    return " ".join(
        sentence for line in found.lines for sentence in progress_words.sentences(line, tr)
    )


def test_one_session_has_a_level_at_goal_and_no_verdict(keyboard: type[Task]) -> None:
    assert (of(keyboard).lines, of(keyboard).days) == ([], [])
    found = of(keyboard, *steady(1))
    (line,) = found.lines
    assert line.sessions[0].at_goal is not None
    assert (line.baseline, line.verdict, line.between_sd) == (None, "not yet known", None)
    assert "Level at goal in the last session: level 3." in said(found)
    assert "not yet known. It needs 4 sessions" in said(found)
    note = progress_words.note("P01", line, progress_words.words("en", keyboard))
    assert "goal 1.0 s: 1 session on 2026-02-27; 20 of 20 attempts done," in note


@pytest.mark.parametrize(
    ("base", "verdict", "says"),
    [
        (450.0, "noise", "no change can be shown"),
        (50.0, "more", "better than that: a change that noise and practice do not explain"),
        (750.0, "less", "worse"),
    ],
)
def test_a_person_who_gets_much_faster_or_slower_has_changed(
    keyboard: type[Task], base: float, verdict: str, says: str
) -> None:
    found = of(keyboard, *steady(5), session(9, adapted(9, base=base)))
    assert found.lines[0].verdict == verdict
    assert says in said(found)


@pytest.mark.parametrize(("first", "is_practice"), [(600.0, True), (450.0, False)])
def test_the_gain_after_the_first_session_is_called_practice(
    keyboard: type[Task], first: float, is_practice: bool
) -> None:
    found = of(keyboard, session(0, adapted(0, base=first)), *steady(6)[1:])
    assert ("Practice: from" in said(found)) is is_practice


def test_at_a_fixed_level_lower_times_are_better(keyboard: type[Task]) -> None:
    means = (990.0, 950.0, 955.0, 945.0, 700.0)
    found = of(keyboard, *(session(n, at_one_level(n, mean)) for n, mean in enumerate(means)))
    (line,) = found.lines
    assert (line.measure, line.verdict) == ("result", "more")
    low, high = re.search(r"Sessions from ([\d.]+) s to ([\d.]+) s", said(found)).groups()  # type: ignore[union-attr]
    assert float(low) < 0.945
    assert float(high) > 0.955


@pytest.mark.parametrize("better", ["lower", "higher"])
def test_results_below_zero_keep_their_sign_in_the_note_and_in_comparisons(
    keyboard: type[Task], better: Literal["lower", "higher"]
) -> None:
    metric, means = Metric("effect", unit="ms", better=better), (-12.0, -20.0, 1.0, -20.0, -300.0)
    results = ([AttemptResult(3, mean, 20)] * 12 for mean in means)
    found = of(keyboard, *(session(n, each, metric=metric) for n, each in enumerate(results)))
    note = progress_words.note("P01", found.lines[0], progress_words.words("en", keyboard))
    word = "better" if better == "lower" else "worse"
    assert "Baseline: -0.013 s. Sessions from -0." in note
    assert f"is {word} than that" in note
    low, high = map(float, re.search(r"Sessions from (\S+) s to (\S+) s", note).groups())  # type: ignore[union-attr]
    assert low < -0.013 < high
    compared = compared_in(found, 2, 4, "en", keyboard)
    assert compared.startswith("From 0.001 s to -0.300 s.")
    assert word in compared


def fast(number: int, level: int, mean: float) -> SessionResults:
    """Return a session all of whose results beat the goal of 1000 ms, at two levels."""
    results = [AttemptResult(level + n % 2, mean + 100 * (n % 2), 20) for n in range(12)]
    return session(number, results)


def compared_in(found: Progress, one: int, other: int, code: str, keyboard: type[Task]) -> str:
    comparison = compare(found, f"session{one:03}", f"session{other:03}")
    assert comparison is not None
    return progress_words.compared(found.lines[0], comparison, progress_words.words(code, keyboard))


def test_sessions_without_a_level_at_goal_are_marked_and_compared_at_the_levels_of_both(
    keyboard: type[Task],
) -> None:
    found = of(keyboard, fast(0, 1, 500.0), fast(1, 2, 400.0), fast(2, 4, 400.0))
    compared = compared_in(found, 0, 1, "en", keyboard)
    assert (
        "every result was better than the goal. Mean at level 2: 0.60 s, then 0.40 s;" in compared
    )
    assert "No level was played in both" in compared_in(found, 0, 2, "en", keyboard)
    spanish = compared_in(found, 0, 1, "es", keyboard)
    assert "0,60 s, luego 0,40 s" in spanish
    assert english_in([spanish], SPANISH) == []
    four = [AttemptResult(level, 400.0 + 10 * level, 20) for level in (1, 2, 3, 4)]
    found = of(keyboard, session(0, four), session(1, four))
    assert "Mean at levels 1 to 4, played in both: 0.4" in compared_in(found, 0, 1, "en", keyboard)
    hardest = keyboard(keyboard.Parameters()).levels
    found = of(keyboard, *(fast(n, hardest - 1, 400.0) for n in (1, 2)))
    assert "a harder goal" in compared_in(found, 1, 2, "en", keyboard)
    found = of(keyboard, *steady(2), session(9, at_one_level(9, 400.0)))
    easy = compared_in(found, 0, 9, "en", keyboard)
    assert easy.startswith("The level at goal of 2026-03-08 is not known: every result was better")
    assert "Mean at level 3:" in easy
    assert "harder levels can be tried" in said(found)
    drawn = drawn_of(found, keyboard, 120, 16)
    assert "^ all too easy" in drawn[0]
    assert "^" in drawn[1]


def test_two_sessions_are_compared_in_the_order_they_were_played(keyboard: type[Task]) -> None:
    found = of(keyboard, *steady(5), session(9, adapted(9, base=50.0)))
    comparison = compare(found, "session009", "session001")
    assert comparison is not None
    assert (comparison.earlier.session, comparison.later.session) == ("session001", "session009")
    assert comparison.verdict == "more"
    words = progress_words.compared(found.lines[0], comparison, progress_words.words("en", None))
    noise = r"from [\d.]+ keys to [\d.]+ keys would be no more than noise \(MDC95\)\.$"
    assert re.search(rf"That is better; {noise}", words)
    assert comparison.mdc95 == found.lines[0].baseline.mdc95  # type: ignore[union-attr]
    assert compare(found, "session001", "nothing") is None
    found = of(keyboard, *steady(2), session(9, adapted(9), {"threshold": 800.0}))
    comparison = compare(found, "session001", "session009")
    assert comparison is not None
    assert (comparison.comparable, comparison.difference) == (False, None)
    words = progress_words.compared(None, comparison, progress_words.words("en", None))
    assert "cannot be compared" in words


def test_a_day_is_the_sum_of_its_live_sessions_against_the_programme() -> None:
    second, simulated = adapted(1, attempts=5), session(2, adapted(2), on_day=0, mode="simulated")
    (day,) = days_of([session(0, adapted(0), on_day=0), session(1, second, on_day=0), simulated])
    assert (day.sessions, day.planned, day.done, day.repetitions) == (2, 40, 25, 500)
    assert day.time_on_task_s == 750.0
    plan = {"planned_attempts_a_day": 30}
    sessions = [
        session(0, adapted(0), plan, on_day=0),
        session(1, adapted(1, attempts=10), plan, on_day=0),
        session(2, adapted(2), plan, on_day=1),
        session(3, adapted(3, attempts=12), task="other", on_day=1),
    ]
    days = days_of(sessions)
    assert [(day.planned, day.done) for day in days] == [(30, 30), (50, 32)]
    assert [dose_words.mark(day) for day in days] == ["■", "◧"]
    days = days_of([session(n, adapted(n, attempts=done)) for n, done in enumerate((20, 12, 3))])
    months = [("2026-02", "·" * 26 + "■◧"), ("2026-03", "□" + "·" * 30), ("2026-04", "··")]
    assert dose_words.calendar(days, date(2026, 4, 2)) == months, "marked without colour"
    assert dose_words.calendar(days_of([]), date(2026, 4, 2)) == []


def test_the_dose_of_the_last_four_weeks_includes_today_and_not_the_day_before_them() -> None:
    days = days_of([session(number, adapted(number), on_day=number) for number in (0, 1, 28)])
    assert [day.date for day in days] == ["2026-02-27", "2026-02-28", "2026-03-27"]
    found = recent(days, date(2026, 3, 27))
    assert (found.first, found.days, found.as_planned, found.done) == ("2026-02-28", 2, 2, 40)
    said = dose_words.recent_text(found, progress_words.words("en", None))
    assert "sessions on 2 days, on 2 of them" in said
    assert "40 of 40 attempts, 800 repetitions" in said


def test_new_pain_and_adverse_events_are_told(keyboard: type[Task]) -> None:
    found = progress("P01", steady(2), {"keyboard": keyboard}.get, **NEW_PAIN)
    pain, event = progress_words.warnings(found, progress_words.words("en", None))
    assert pain.startswith("Pain is new: some in each of the last four sessions")
    assert event == "Adverse event 2026-03-01, mild: Cramp. Outcome not yet recorded."
    events = [fell("2026-03-01", outcome="No injury.")]
    found = progress("P01", steady(2), {"keyboard": keyboard}.get, records=events)
    (noted,) = progress_words.after_notes(found, progress_words.words("en", None))
    assert noted == "Adverse event 2026-03-01, mild: Fell. Outcome: No injury."


def fell(onset: str, session: str | None = None, **more: str) -> Record:
    content = {"what": "Fell", "severity": "mild"} | more
    given: Any = {"kind": "adverse-event", "participant": "P01", "content": content}
    return Record(id=onset, at=onset, session=session, **given)


NEW_PAIN: Any = {
    "ratings": [SessionRatings(pain_after=0), *[SessionRatings(pain_after=2)] * 4],
    "records": [fell("2026-03-01", what="Cramp")],
}


def test_an_adverse_event_stands_below_its_session_and_its_day(keyboard: type[Task]) -> None:
    days = ("2026-02-28 09:00", "2026-02-01", "2026-03-02")
    given: Any = {
        "records": [*map(fell, days), fell("2026-03-02", "session001")],
        "today": date(2026, 3, 2),
    }
    found = progress("P01", steady(4), {"keyboard": keyboard}.get, **given)
    (line,) = found.lines
    assert [each.events for each in line.sessions] == [
        ["2026-02-28 09:00"], ["2026-03-02"], [], ["2026-03-02"],
    ]  # fmt: skip
    tr = progress_words.words("en", keyboard)
    marks = drawn_of(found, keyboard, 80, 24)[-1]
    assert (marks.split("  ")[0], marks.count("!")) == ("look at", 3)
    calendar = "\n".join(dose_words.calendar_lines(found, 3, tr))
    february = f"Feb 2026  {'·' * 26}■■\n          !{' ' * 26}!\n"
    assert february in calendar
    assert "! adverse event" in calendar


def test_the_note_tells_of_pain_where_it_is_known(keyboard: type[Task]) -> None:
    tr = progress_words.words("en", keyboard)
    rated = [
        session(n, adapted(n), felt=SessionRatings(pain_after=pain))
        for n, pain in enumerate((0, 6, 1))
    ]
    (line,) = of(keyboard, *rated, *steady(4)[3:]).lines
    said = "Worst of each session, 0 to 10, from first to last: pain 0 → 1 (highest 6)."
    assert said in progress_words.note("P01", line, tr)
    (line,) = of(keyboard, *steady(1)).lines
    assert "Worst" not in progress_words.note("P01", line, tr)


def drawn_of(
    found: Progress, kind: type[Task], width: int, height: int, code: str = "en", **more: Any
) -> list[str]:
    """Return the rows of the timeline of the newest line."""
    tr = progress_words.words(code, kind)
    return [row.text for row in timeline(found.lines[-1], width, height, tr, **more)]


def rated(number: int, pain: int, tired: int = 2, **more: Any) -> SessionResults:
    felt = SessionRatings(pain_before=1, pain_after=pain, fatigue_after=tired)
    return session(number, adapted(number), felt=felt, **more)


@pytest.mark.parametrize("count", [1, 2, 12, 100])
@pytest.mark.parametrize("size", [(78, 14), (58, 24), (74, 40)])
def test_a_picture_fits_and_has_dose_and_pain_below_their_session(
    keyboard: type[Task], count: int, size: tuple[int, int]
) -> None:
    found = of(keyboard, *(rated(n, 3) for n in range(count)))
    (line,) = found.lines
    drawn = picture(line, size, "verdict", count - 1, progress_words.words("en", keyboard))
    assert len(drawn) <= size[1]
    assert max(len(row.text) for row in drawn) <= size[0]
    (foot, *_) = (row.text for row in drawn if "└" in row.text)
    at = foot.index("▲")
    (bars,) = (row.text for row in drawn if row.figure == "dose" and row.name)
    (pain,) = (row.text for row in drawn if row.figure == "pain")
    assert (bars[at], pain[at]) == ("█" if count == 100 else "1", "3"), "all are as long"
    assert {row.figure for row in drawn if "┤" in row.text} == {"level"}


def test_results_are_charted_where_they_or_their_measures_are_chosen(keyboard: type[Task]) -> None:
    (line,) = of(keyboard, *steady(6)).lines
    tr = progress_words.words("en", keyboard)
    for figure, charted in (("level", "level"), ("result", "result"), ("correct", "result")):
        drawn = picture(line, (78, 20), figure, 5, tr, "session001")
        assert {row.figure for row in drawn if "┤" in row.text} == {charted}
        (foot,) = (row.text for row in drawn if "└" in row.text)
        assert 0 < foot.index("◆") < foot.index("▲")


def test_what_needs_a_look_is_marked_and_told(keyboard: type[Task]) -> None:
    sessions = [rated(0, 2), rated(1, 6), rated(2, 2), rated(3, 1)]
    records = [fell("2026-03-01 12:00", "session002")]
    found = progress("P01", sessions, {"keyboard": keyboard}.get, records)
    tr = progress_words.words("en", keyboard)
    rows = {row.figure: row for row in timeline(found.lines[0], 78, 20, tr)}
    looks = rows["look"]
    assert [looks.text[first] for first, _ in looks.looks] == ["!", "!"]
    ((first, _),) = rows["pain"].looks
    assert rows["pain"].text[first] == "6", "above the limit of 5"
    assert looks.text[first] == "!"
    said = of_person("look", found, found.lines[0], 0, tr)
    assert [text[:10] for text in said] == ["2026-02-28", "2026-03-01"]
    assert "a reason to stop" in said[0]
    assert "Adverse event 2026-03-01 12:00, mild: Fell." in said[1]


def test_figures_are_those_that_a_line_has(keyboard: type[Task]) -> None:
    (line,) = (found := of(keyboard, rated(0, 2))).lines
    tr = progress_words.words("en", keyboard)
    names = figures(found, line)
    assert names == [
        "verdict", "level", "result", "correct", "dose", "pain", "tired", "sessions", "days",
        "records",
    ]  # fmt: skip
    assert figures(of(keyboard), None) == ["records"]
    unrated = of(keyboard, session(0, at_one_level(0, 950.0), qualities={"sparc": -1.5}))
    assert {"level", "pain"}.isdisjoint(figures(unrated, unrated.lines[0]))
    assert "quality" in figures(unrated, unrated.lines[0])
    for name in ("sessions", "days", "records"):
        rows = listed(name, found, line, (38, 12), tr)
        assert (rows[0].text, rows[0].figure) == (GLOSSARY[name].title, name)
        assert len(rows) <= 12
        assert max(len(row.text) for row in rows) <= 38 or name == "days"


def test_a_task_without_a_result_has_its_dose_on_the_dates(keyboard: type[Task]) -> None:
    empty = [AttemptResult(1, None, 20)]
    found = of(keyboard, *(session(n, empty, metric=NO_METRIC, reached=None) for n in range(3)))
    assert figures(found, found.lines[0])[:2] == ["verdict", "dose"]
    drawn = drawn_of(found, keyboard, 78, 20, chosen=2)
    assert (drawn[0].strip()[0], drawn[2].split()[0]) == ("└", "minutes")
    assert of_person("verdict", found, found.lines[0], 0, progress_words.words("en", None)) == []


DOCS = Path(__file__).parents[2]


@pytest.mark.parametrize("name", GLOSSARY)
def test_each_figure_is_explained_in_both_languages_with_a_source_that_is_there(name: str) -> None:
    what, how, source = explained(name, progress_words.words("en", None))
    assert how.startswith("How it is computed: ")
    for page in re.findall(r"docs/\S+?\.md(?:#[\w-]+)?", source):
        file, _, anchor = page.partition("#")
        heads = re.findall(r"^#+ (.+)$", (DOCS / file).read_text(encoding="utf-8"), re.MULTILINE)
        known = [re.sub(r"[^\w -]", "", head).lower().replace(" ", "-") for head in heads]
        assert not anchor or anchor in known
    assert re.search(r"docs/|doi:10\.|PMID", source)
    spanish = explained(name, progress_words.words("es", None))
    assert what != spanish[0]
    entry = GLOSSARY[name]
    assert {entry.title, entry.what, entry.how} <= set(SPANISH)


def test_every_text_of_charts_parts_and_dose_has_a_translation_and_none_is_left() -> None:
    folder = Path(progress_words.__file__).parent
    names = (
        "progress_parts",
        "progress_words",
        "progress_headline",
        "progress_timeline",
        "progress_glossary",
        "progress_page",
        "progress_charts",
        "dose_words",
    )
    sources = [(folder / f"{name}.py").read_text(encoding="utf-8") for name in names]
    texts = set().union(*map(texts_in, sources))
    assert {text for text in texts if re.search("[a-z]", text)} - set(SPANISH) == set()
    package = folder.parent
    records = (package / "records/kind.py", package / "store/records.py")
    others = (package / "cli/progress.py", *records, *SHIPPED.glob("*.toml"))
    files = [path.read_text(encoding="utf-8") for path in (*folder.glob("*.py"), *others)]
    inserted = {"simulated", "demonstration", "no session"}
    source = re.sub(r'"\n\s*f?"', "", "".join(files)).replace("'", '"')
    assert [text for text in SPANISH if f'"{text}"' not in source and text not in inserted] == []


def test_every_sentence_is_in_spanish(keyboard: type[Task]) -> None:
    tr = progress_words.words("es", keyboard)
    pain = SessionRatings(pain_after=4)
    for sessions in (
        steady(1),
        [session(0, adapted(0, base=600.0)), *steady(6)[1:]],
        [*steady(5), session(9, adapted(9, base=50.0))],
        [*steady(5), session(9, adapted(9, base=750.0))],
        [session(1, at_one_level(1, 400.0), felt=pain)],
        [session(1, at_one_level(1, 1900.0))],
        [session(number, at_one_level(number, 950.0)) for number in range(5)],
        [session(1, adapted(1), mode="simulated", seat="B")],
    ):
        found = progress("P01", sessions, {"keyboard": keyboard}.get, **NEW_PAIN)
        shown = progress_words.note("P01", found.lines[0], tr)
        dose = dose_words.recent_text(recent(found.days, date(2026, 3, 1)), tr)
        others = [dose, dose_words.legend(tr), *progress_words.warnings(found, tr)]
        assert english_in([shown, *others], SPANISH) == []
        assert "ms" not in shown or not re.search(r"\d\.\d", shown)


def test_the_chart_of_levels_has_minutes_pain_and_tiredness_on_its_axis(
    keyboard: type[Task],
) -> None:
    felt = SessionRatings(pain_before=2, pain_after=4, fatigue_after=10)
    half = session(1, adapted(1, attempts=10))
    found = of(keyboard, session(0, adapted(0), felt=felt), half)
    drawn = drawn_of(found, keyboard, 78, 17, chosen=1)
    assert len(drawn) <= 17
    assert drawn[0].startswith("level at goal")
    assert any(re.match(r" *\d┤", row) for row in drawn)
    below = [row.split() for row in drawn[-4:]]
    assert below == [
        ["minutes", "10", "5"], ["pain", "4", "·"], ["tired", "10", "·"], ["look", "at", "!"],
    ]  # fmt: skip
    assert drawn[-6].index("▲") == drawn[-3].index("·") == drawn[-4].index("5")


def test_levels_have_labels_at_equal_distances_and_the_baseline_is_marked(
    keyboard: type[Task],
) -> None:
    found = of(keyboard, *steady(8))
    for height in range(14, 30):
        drawn = drawn_of(found, keyboard, 78, height, chosen=7)
        labels = [(row, int(text.split("┤")[0])) for row, text in enumerate(drawn) if "┤" in text]
        steps = {(later - row, level - after) for (row, level), (later, after) in pairwise(labels)}
        assert len(steps) == 1
        (mean,) = (row for row in drawn if "baseline" in row)
        assert re.search(r"━ baseline \d\.\d( |$)", mean)
        assert sum("noise and practice" in row for row in drawn) == 1


def test_the_chart_of_results_has_accuracy_and_quality_in_figures(keyboard: type[Task]) -> None:
    played = (session(n, adapted(n), qualities={"sparc": -1.5 - n}) for n in (0, 1))
    found = of(keyboard, *played)
    drawn = drawn_of(found, keyboard, 78, 16, shown="result")
    assert drawn[-3].split() == ["correct", "95%", "95%"]
    assert drawn[-2].split() == ["smoothness", "(SPARC)", "-1.5", "-2.5"]
    spanish = "\n".join(drawn_of(found, keyboard, 80, 20, "es", shown="result"))
    assert "-1,5" in spanish
    assert "-1.5" not in spanish
    assert spanish.startswith("tiempo de reacción (s)")
    assert "aciertos " in spanish, "the task's words do not change those of the charts"


@pytest.mark.parametrize("better", ["lower", "higher"])
def test_a_better_result_is_higher_up_whichever_way_is_better(
    keyboard: type[Task], better: Literal["lower", "higher"]
) -> None:
    metric = Metric("reaction_time", unit="ms", better=better)
    results = ([AttemptResult(3, mean, 20)] * 6 for mean in (1200.0, 900.0))
    played = [session(n, each, metric=metric) for n, each in enumerate(results)]
    (line,) = (found := of(keyboard, *played)).lines
    tr = progress_words.words("en", keyboard)
    drawn = drawn_of(found, keyboard, 80, 16)
    first, second = sorted(
        (found.start(), n) for n, row in enumerate(drawn) for found in re.finditer("[▄▀]", row)
    )
    assert (second[1] < first[1]) == (better == "lower"), "rows count from above"
    ticks = [float(row.split("┤")[0]) for row in drawn if "┤" in row]
    assert ticks == sorted(ticks, reverse=better == "higher")
    spec = result_picture(line, tr)
    assert spec is not None
    assert spec["layer"][0]["encoding"]["y"]["scale"]["reverse"] == (better == "lower")
    assert ("better is up" in drawn[0]) == (better == "lower")


def test_the_dose_is_in_figures_where_there_is_room_and_its_bars_begin_at_zero() -> None:
    shown = Columns(4, 40).numbers([0, 5, 10, 20], "{:.0f}")
    assert shown == "     0         5         10        20"
    assert Columns(4, 4).numbers([0, 5, 10, 20], "{:.0f}") == ""
    assert Columns(4, 4).heights([0, 5, 10, 20]) == "·▂▄█"
    assert Columns(2, 2).heights([0, 0]) == "··"


def test_values_that_differ_by_rounding_have_equal_bars() -> None:
    assert Columns(3, 3).bars([0.95, 0.95 + 1e-15, 0.95]) == "▄▄▄"


def test_the_change_of_a_quality_stands_beside_its_mdc95(keyboard: type[Task]) -> None:
    def played(count: int) -> str:
        values = enumerate((-1.60, -1.55, -1.50, -1.52, -1.40)[:count])
        sessions = [session(n, adapted(n), qualities={"sparc": value}) for n, value in values]
        (line,) = (found := of(keyboard, *sessions)).lines
        return " ".join(of_person("result", found, line, 0, progress_words.words("en", None)))

    assert "smoothness (SPARC) -1.6 → -1.4 (MDC95 0.153)" in played(5)
    assert "smoothness (SPARC) -1.6 → -1.5." in played(3)
    assert "How much of these changes is noise is not yet known" in played(3)


def test_marks_are_within_half_a_row_of_their_value_on_the_axis(keyboard: type[Task]) -> None:
    results = [session(n, adapted(n, base=450.0 - 13 * n)) for n in range(12)]
    (line,) = of(keyboard, *results).lines
    tr = progress_words.words("en", keyboard)
    for height in range(14, 40):
        for shown, is_shaded in (("level", False), ("level", True), ("result", True)):
            drawn = timeline(line, 120, height, tr, shown=shown, is_shaded=is_shaded)
            ticks = [
                (row, float(each.text.split("┤")[0]))
                for row, each in enumerate(drawn)
                if "┤" in each.text
            ]
            (above, high), (below, low) = ticks[0], ticks[-1]
            a_row = (high - low) / (below - above)
            marks = sorted(
                (run.first, row + (0.25 if each.text[run.first] == "▄" else -0.25))
                for row, each in enumerate(drawn)
                for run in each.runs
                if run.shown == "point"
            )
            values = [
                each.at_goal.level if shown == "level" and each.at_goal else (each.mean or 0) / 1000
                for each in line.sessions
            ]
            for value, (_, row) in zip(values, marks, strict=True):
                assert abs(high - (row - above) * a_row - value) <= abs(a_row) / 2 + 1e-6
