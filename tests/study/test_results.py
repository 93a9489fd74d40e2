"""A whole study at two sites: in the right conditions, the same merged in either direction, and
analysed with what was simulated as the result.
"""

import shutil
from collections import Counter
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from sqlite3 import Connection
from typing import NamedTuple

import frictionless
import pandas
import pytest

from sar_tui.export.export import Options
from sar_tui.export.export import export as write
from sar_tui.export.registry import load
from sar_tui.plugins import Catalogue
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store.database import StoreError, connect
from sar_tui.store.merge.merge import merge
from sar_tui.store.selection import Request
from sar_tui.study import enrolment, ledger, results, secret
from sar_tui.study.envelopes import page, sheets
from sar_tui.study.next_block import person
from sar_tui.study.rehearsal import Habits, Rehearsed, rehearse
from sar_tui.study.report import make_report
from sar_tui.study.status import as_of, grid
from tests.study.plans import TWO_GROUPS, WITH_FORMS, plan

START = datetime(2026, 3, 2, tzinfo=UTC)
LATER = datetime(2026, 6, 1, tzinfo=UTC)


def blind(text: str) -> str:
    return text.replace("[outcome]", "[allocation]\nblind = true\n[outcome]", 1)


BLIND = blind(TWO_GROUPS)
EFFECT_MS = 300.0


class Played(NamedTuple):
    """A rehearsal, and the file of its key."""

    sites: list[Rehearsed]
    key: Path


def play(folder: Path, text: str = TWO_GROUPS, *, people: int = 24, habits: Habits) -> Played:
    key = folder / "rehearsal.key"
    sites = rehearse(
        plan(text),
        text,
        Catalogue(()),
        folder,
        key,
        people=people,
        seed=1,
        start=START,
        habits=habits,
        persons=lambda number: PEOPLE["average"],
        effects={"unpraised": EFFECT_MS},
    )
    return Played(sites, key)


@pytest.fixture(scope="module")
def played(tmp_path_factory: pytest.TempPathFactory) -> Played:
    habits = Habits(misses=0.15, late=0.15)
    return play(tmp_path_factory.mktemp("study"), WITH_FORMS, habits=habits)


def long_rows(folder: Path) -> list[results.Row]:
    with closing(connect(folder)) as db:
        frozen = ledger.find(db)
        return results.long_rows(db, frozen, ledger.people(db, frozen))


@pytest.mark.slow
def test_each_site_has_both_groups_and_both_orders(played: Played) -> None:
    for site in played.sites:
        with closing(connect(site.folder)) as db:
            people = ledger.enrolments(db, "praise")
        assert len(people) == 12
        assert abs(Counter(one.group for one in people)["praise"] - 6) <= 2
        for group in ("praise", "silent"):
            orders = Counter(one.orders for one in people if one.group == group)
            assert abs(orders[0,] - orders[1,]) <= 1


def test_each_form_that_was_filled_in_has_its_score(played: Played) -> None:
    for site in played.sites:
        rows = long_rows(site.folder)
        for block, most in (("strain", 10), ("usability", 100)):
            scores = [row["score"] for row in rows if row["block"] == block]
            visits = {row["participant"] for row in rows if row["block"] in ("speeds", "training")}
            assert 0 < len(scores) <= len(visits)
            assert all(0 <= score <= most for score in scores)
            assert len(set(scores)) > 3


def test_practice_is_not_among_the_attempts_of_a_block(tmp_path: Path) -> None:
    text = TWO_GROUPS.replace("attempts = 3\nlevel = 3", "attempts = 3\npractice = 2\nlevel = 3")
    found = play(tmp_path, text, people=1, habits=Habits())
    first, *_ = long_rows(found.sites[0].folder)
    assert (first["block"], first["attempts"]) == ("baseline", 3)


def test_missed_and_late_visits_are_listed(played: Played) -> None:
    for site in played.sites:
        with closing(connect(site.folder)) as db:
            frozen = ledger.find(db)
            rows = grid(frozen, ledger.people(db, frozen), played.key, LATER)
            noted = ledger.of_study(db, ledger.DEVIATION, "praise")
        late = {each.participant for each in noted if each.content["what"] == "late"}
        trained = [row for row in long_rows(site.folder) if row["visit"] == "second"]
        assert late == {row["participant"] for row in trained if row["deviations"]}
        for row in rows:
            cell = row.visits["second"]
            is_noted = any(each.participant == row.participant for each in noted)
            assert cell.deviated == is_noted
            assert (cell.state == "done") or (cell.done, cell.state) == (0, "missed")
    assert any(row.visits["second"].state == "missed" for row in rows)


def test_a_rehearsal_is_shown_as_of_its_own_end(tmp_path: Path) -> None:
    habits = {"stay": Habits(misses=1.0), "leave": Habits(misses=1.0, leaves=1.0)}
    for name, how in habits.items():
        found = play(tmp_path / name, people=2, habits=how)
        with closing(connect(found.sites[0].folder)) as db:
            frozen = ledger.find(db)
            people = ledger.people(db, frozen)
            (row,) = grid(frozen, people, found.key, as_of(frozen, people, START))
            report = make_report(db, frozen, found.key, START)
        shown = "visit missed" if name == "stay" else ""
        assert [cell.words for cell in row.visits.values()] == ["done", shown]
        assert row.ended == ("" if name == "stay" else "lost")
        assert report.missing == {"second/training": 1}


def test_a_merge_in_either_direction_gives_the_same_table(played: Played, tmp_path: Path) -> None:
    first, second = (site.folder for site in played.sites)

    def merged(into: Path, other: Path) -> list[results.Row]:
        copy = tmp_path / into.name
        shutil.copytree(into, copy)
        merge(copy, other, start=lambda _: lambda done, of: None)
        rows = long_rows(copy)
        for row in rows:  # each site calls its own people by their codes alone
            row["participant"] = row["participant"].partition("@")[0]
            row["session"] = row["session"].partition("@")[0]
        return sorted(rows, key=lambda row: row["session"])

    both = merged(first, second)
    assert len(both) == len(long_rows(first)) + len(long_rows(second))
    assert both == merged(second, first)


def test_ten_lines_of_pandas_give_the_outcome_that_was_simulated(
    played: Played, tmp_path: Path
) -> None:
    for site in played.sites:
        with closing(connect(site.folder)) as db:
            results.export(db, ledger.find(db), tmp_path / site.site, played.key)
    read = (pandas.read_csv(tmp_path / site / "wide.csv") for site in ("BERN", "GENF"))
    wide = pandas.concat(read, ignore_index=True)
    change = wide.second_training_metric - wide.first_baseline_metric
    by_group = change.groupby(wide.group).agg(["mean", "sem", "count"])
    praise, silent = by_group.loc["praise"], by_group.loc["silent"]
    difference = silent["mean"] - praise["mean"]
    error = (silent["sem"] ** 2 + praise["sem"] ** 2) ** 0.5
    assert abs(difference - EFFECT_MS) < 3 * error
    assert difference > 2 * error


def test_the_tables_are_as_they_are_described(played: Played, tmp_path: Path) -> None:
    with closing(connect(played.sites[0].folder)) as db:
        results.export(db, ledger.find(db), tmp_path / "out", played.key)
    report = frictionless.validate(str(tmp_path / "out" / "datapackage.json"))
    assert report.valid, report.to_summary()


def test_the_columns_follow_from_the_plan_before_anybody_has_begun(tmp_path: Path) -> None:
    (tmp_path / "k.key").write_text("5a" * 32)
    for name, text in (("open", WITH_FORMS), ("blind", blind(WITH_FORMS))):
        with closing(connect(tmp_path / name)) as db:
            enrolment.freeze(
                db, Catalogue(()), text, plan(text), tmp_path / "k.key", mode="live", author="me"
            )
            frozen = ledger.find(db)
            enrolment.enrol(db, frozen, "P01", tmp_path / "k.key")
            results.export(db, frozen, tmp_path / f"{name}-out", tmp_path / "k.key")
    wide = pandas.read_csv(tmp_path / "open-out" / "wide.csv")
    assert list(wide.columns[6:]) == [
        f"{block}_{measure}"
        for block in (
            "first_baseline", "first_speeds_slow", "first_speeds_fast", "first_strain",
            "second_training", "second_usability",
        )
        for measure in (
            ["score"]
            if block in ("first_strain", "second_usability")
            else ["metric", "accuracy", "success_rate", "level"]
        )
    ]  # fmt: skip
    package = (tmp_path / "open-out" / "datapackage.json").read_text()
    assert package.count("1: slow, fast; 2: fast, slow.") == 2
    assert "slow" not in (tmp_path / "blind-out" / "datapackage.json").read_text()
    coded = pandas.read_csv(tmp_path / "blind-out" / "wide.csv").columns
    assert len(coded) == len(wide.columns)


def test_a_blind_study_tells_no_condition_in_what_it_exports(tmp_path: Path) -> None:
    found = play(tmp_path, BLIND, people=4, habits=Habits())
    names = [b"prais", b"silen", b"slow", b"fast"]
    for site in found.sites:
        with closing(connect(site.folder)) as db:
            frozen = ledger.find(db)
            out = tmp_path / f"out-{site.site}"
            for path in results.export(db, frozen, out, found.key):
                content = path.read_bytes().replace(b"praise,1,", b"").replace(b"study-praise", b"")
                content = content.replace(b"Praise and reaction time", b"")
                assert not [name for name in names if name in content.lower()], path
            rows = grid(frozen, ledger.people(db, frozen), found.key, LATER)
            assert {row.group for row in rows} <= {"G1", "G2"}
            for table in ("sessions", "records"):
                column = "study" if table == "sessions" else "content"
                for (text,) in db.execute(f"SELECT {column} FROM {table}").fetchall():
                    said = text.replace('"study":"praise"', "")
                    assert not any(name in said.encode() for name in names)


def test_sessions_of_a_blind_study_are_exported_once_it_is_blind_no_longer(tmp_path: Path) -> None:
    found = play(tmp_path, BLIND, people=2, habits=Habits())
    folder = found.sites[0].folder

    def export(to: Path) -> None:
        write(connect(folder), folder, Catalogue(()), Request(everything=True, simulated=True),
              load("csv"), to, lambda steps: lambda: None, Options())  # fmt: skip

    with pytest.raises(StoreError, match="is of the blind study praise"):
        export(tmp_path / "blind")
    opened = BLIND.replace("blind = true", "").replace('"praise"\n', '"praise"\nversion = 2\n', 1)
    with closing(connect(folder)) as db:
        enrolment.freeze(
            db, Catalogue(()), opened, plan(opened), found.key, mode="simulated", author="me",
            reason="the last person has finished",
        )  # fmt: skip
        frozen = ledger.find(db)
        who = ledger.enrolments(db, "praise")[0].participant
        one = person(db, frozen, who, found.key)
        assert one.names.group(one.enrolled.group) in ("praise", "silent")
    export(tmp_path / "open")
    rows = pandas.read_csv(tmp_path / "open" / "sessions.csv")
    assert set(rows.study) == {"praise"}
    assert set(rows.study_condition) <= {"C1", "C2", "C3", "C4"}
    assert set(rows.order_position) == {1, 2}


def test_sheets_have_the_groups_that_people_are_drawn_into(played: Played) -> None:
    draws = secret.read(played.key)
    for site in played.sites:
        found = {number: group for _, number, group in sheets(plan(), draws, site.site, 12)}
        with closing(connect(site.folder)) as db:
            for one in ledger.enrolments(db, "praise"):
                assert found[one.number] == one.group
    printed = page(plan(), list(sheets(plan(), draws, "BERN", 3)))
    assert printed.count('class="sheet"') == 3


def test_conditions_and_blocks_that_look_alike_have_columns_of_their_own() -> None:
    alike = TWO_GROUPS.replace('"speeds"', '"a-b"').replace('"second"', '"first-a"')
    study = plan(alike.replace('block = "training"', 'block = "b"').replace('"training"', '"b"'))
    person = {"site": None, "group": "praise", "stratum": None, "order": "1", "consent": None}
    places = (("first", "a-b", "slow", 1.0), ("first-a", "b", "praised", 2.0))
    rows: list[results.Row] = [
        {"participant": "P01", "visit": visit, "block": block, "condition": condition,
         "position": 1, "metric": metric, **person}
        for visit, block, condition, metric in places
    ]  # fmt: skip
    people = [{"participant": who, **person} for who in ("P01", "P02")]
    shown = {name: name for name in study.conditions}
    columns, found = results.wide(study, rows, people, shown)
    names = [column.name for column in columns[6:] if column.name.endswith("metric")]
    assert names == [
        "first_baseline_metric", "first_a.b_slow_metric", "first_a.b_fast_metric",
        "first.a_b_metric",
    ]  # fmt: skip
    assert found[0]["first_a.b_slow_metric"] == 1.0
    assert found[1] == {"participant": "P02", **person}


def test_the_report_counts_who_began_and_what_they_did_in_a_visit(tmp_path: Path) -> None:
    found = play(tmp_path, people=4, habits=Habits())
    site = found.sites[0]
    with closing(connect(site.folder)) as db:
        frozen = ledger.find(db)
        enrolment.enrol(db, frozen, "P99", found.key)
        report = make_report(db, frozen, found.key, LATER)
    flows = report.groups
    assert sum(flow.allocated for flow in flows) == 3
    assert sum(flow.began for flow in flows) == sum(flow.as_intended for flow in flows) == 2
    dose = report.dose[0]
    seconds = sum(each.seconds for each in site.times if each.visit == dose.visit)
    assert (dose.people, dose.sessions) == (2, 3)
    assert dose.minutes == pytest.approx(seconds / 60 / 2)


def test_who_lacks_a_compared_condition_is_not_analysed(tmp_path: Path) -> None:
    three = TWO_GROUPS.replace(
        'conditions = ["slow", "fast"]', 'conditions = ["slow", "fast", "praised"]'
    ).replace('order = "latin square"', "")
    outcome = (
        '[outcome]\nvisit = "first"\nblock = "speeds"\ncompared = "within"\n'
        'conditions = ["slow", "fast"]\n'
    )
    head, _, rest = three.partition("[outcome]")
    text = head + outcome + rest[rest.index("[[visits]]") :]
    found = play(tmp_path, text, people=2, habits=Habits())
    for site in found.sites:
        with closing(connect(site.folder)) as db:
            frozen = ledger.find(db)

            def analysed(db: Connection = db, frozen: ledger.Frozen = frozen) -> int:
                report = make_report(db, frozen, found.key, LATER)
                return sum(flow.analysed or 0 for flow in report.groups)

            assert analysed() == 1
            db.execute("DELETE FROM attempts WHERE session IN (SELECT id FROM sessions WHERE"
                       " json_extract(study, '$.condition')='fast')")  # fmt: skip
            assert analysed() == 0
