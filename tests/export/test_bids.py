"""Sessions leave as a BIDS data set in which the BIDS validator finds no error, and which holds
what was measured.
"""

import json
import re
import runpy
import shutil
from collections.abc import Callable
from contextlib import closing
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from sar_tui.export.export import Exported, Options, export
from sar_tui.export.registry import load
from sar_tui.plugins import Catalogue
from sar_tui.store import imu
from sar_tui.store.database import connect, connect_to_read
from sar_tui.store.selection import Request
from tests.examples import first_rows
from tests.export.bids_judge import ALLOWED, complaints, judge
from tests.export.exported import ALL, no_bar
from tests.export.hard_study import EMPTY, INTERRUPTED, NOTE, store_study
from tests.program import Call

DOCS = Path(__file__).parents[2] / "docs" / "archive-in-bids.md"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data = tmp_path_factory.mktemp("study") / "data"
    store_study(data, Catalogue())
    return data


@pytest.fixture(scope="module")
def dataset(study: Path) -> Path:
    """An export of the whole study with notes."""
    export_bids(study, study.parent / "out", with_notes=True)
    return study.parent / "out"


def export_bids(data: Path, folder: Path, request: Request = ALL, **options: Any) -> Exported:
    with closing(connect_to_read(data)) as database:
        return export(
            database, data, Catalogue(), request, load("bids"), folder, no_bar, Options(**options)
        )


def read(path: Path) -> list[dict[str, str]]:
    head, *lines = (
        line.split("\t") for line in path.read_text("utf-8").removesuffix("\n").split("\n")
    )
    return [dict(zip(head, line, strict=True)) for line in lines]


def one(folder: Path, pattern: str) -> Path:
    (found,) = folder.glob(pattern)
    return found


def test_the_validator_finds_no_error_in_a_hard_study(dataset: Path) -> None:
    assert complaints(dataset) == []


@pytest.mark.parametrize(
    ("request_", "options"),
    first_rows(
        1,
        [
            (ALL, {"recode": True}),
            (ALL, {"with_events": True}),
            (Request(everything=True), {}),
            (Request(everything=True, simulated=True), {"with_notes": True}),
        ],
    ),
)
def test_the_validator_finds_no_error_whatever_leaves(
    study: Path, tmp_path: Path, request_: Request, options: dict[str, Any]
) -> None:
    recode = tmp_path / "map.csv" if "recode" in options else None
    export_bids(study, tmp_path / "out", request_, **{**options, "recode": recode})
    assert complaints(tmp_path / "out") == []


def test_the_judge_finds_a_planted_error(dataset: Path, tmp_path: Path) -> None:
    planted = tmp_path / "planted"
    shutil.copytree(dataset, planted)
    events = one(planted, "sub-P3/ses-*/beh/*_events.tsv")
    events.write_text(events.read_text().replace("onset\t", "began\t", 1))
    (planted / "participants.tsv").write_text("participant_id\nsub-P01\n")
    errors = {issue.what for issue in judge(planted) if issue.severity == "error"}
    assert errors == {"TSV_COLUMN_MISSING onset", "PARTICIPANT_ID_MISMATCH"}


def test_the_allowed_warnings_are_in_the_docs() -> None:
    page = DOCS.read_text("utf-8")
    assert [what for what in ALLOWED if f"`{what.split()[-1]}`" not in page] == []


def test_the_script_of_the_docs_says_what_the_database_says(
    study: Path, dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "study").symlink_to(dataset)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "script.py").write_text(
        DOCS.read_text("utf-8").partition("```python\n")[2].partition("```")[0]
    )
    right = runpy.run_path(str(tmp_path / "script.py"))["right"]
    with closing(connect(study)) as database:
        stored = database.execute(
            "SELECT level, avg(reaction_time_ms) FROM trials LEFT JOIN attempts USING (session, "
            "attempt, seat)"
            " JOIN seats USING (session, seat) WHERE trials.correct AND practice IS NOT 1 AND "
            "participant='P01'"
            " AND level IS NOT NULL GROUP BY level"
        ).fetchall()
    found = right[right.subject == "sub-P01"].groupby("level").response_time.mean()
    assert dict(found * 1000) == {level: pytest.approx(mean) for level, mean in stored}


def test_trials_are_rows_of_beh(study: Path, dataset: Path) -> None:
    for task in ("keyboard", "reaching", "pairs"):
        rows = [
            row
            for path in sorted(dataset.glob(f"sub-*/ses-*/beh/*_task-{task}_*_beh.tsv"))
            for row in read(path)
        ]
        with closing(connect(study)) as database:
            stored = database.execute(
                "SELECT onset_ns, reaction_time_ms, trials.correct FROM trials JOIN sessions ON "
                "sessions.id=session"
                " WHERE task=?",
                (task,),
            ).fetchall()
        expected = sorted(
            (or_missing(onset), or_missing(time), ["false", "true"][right])
            for onset, time, right in stored
        )
        assert (
            sorted((row["onset_ns"], row["reaction_time_ms"], row["correct"]) for row in rows)
            == expected
        )
        for row in rows:
            missing = row["reaction_time_ms"] == "n/a"
            assert row["response_time"] == (
                "n/a" if missing else repr(float(row["reaction_time_ms"]) / 1000)
            )
        described = json.loads((dataset / f"task-{task}_beh.json").read_text())
        assert set(rows[0]) <= set(described)
        assert described["reaction_time_ms"]["Units"] == "ms"


def or_missing(value: object) -> str:
    return "n/a" if value is None else repr(value)


def unescaped(text: str) -> str:
    return re.sub(
        r"\\(.)", lambda found: {"t": "\t", "n": "\n", "r": "\r"}.get(found[1], found[1]), text
    )


def test_a_miss_has_no_response_time_and_practice_is_marked(dataset: Path) -> None:
    path = max(
        dataset.glob("sub-P01/ses-*/beh/*_task-keyboard_*_events.tsv"),
        key=lambda path: path.stat().st_size,
    )
    trials = [row for row in read(path) if row["trial_type"] == "trial"]
    misses = [row for row in trials if row["response"] == "n/a"]
    assert misses
    assert {(row["response_time"], row["duration"], row["correct"]) for row in misses} == {
        ("n/a", "n/a", "false")
    }
    assert all(float(row["onset"]) > 0 for row in misses)
    assert {row["practice"] for row in trials} == {"true", "false"}


def test_each_run_of_a_resumed_session_has_files_and_a_zero_of_its_own(dataset: Path) -> None:
    first, second = one(dataset, "sub-P01/ses-*/beh/*_run-2_events.tsv").parent.glob("*_events.tsv")
    for path in (first, second):
        rows = read(path)
        assert {"trial", "action"} <= {row["trial_type"] for row in rows}
        assert all(0 <= float(row["onset"]) < 600 for row in rows if row["trial_type"] == "trial")
    assert len(read(one(first.parents[1], "*_scans.tsv"))) == 2


def test_events_of_behaviour_count_from_the_time_of_day_in_scans(
    study: Path, dataset: Path
) -> None:
    folder = dataset / "sub-P01" / f"ses-{INTERRUPTED}"
    (scan,) = read(one(folder, "*_scans.tsv"))
    with closing(connect(study)) as database:
        (utc,) = database.execute(
            "SELECT json_extract(clock_anchor, '$.utc') FROM runs WHERE session=?", (INTERRUPTED,)
        ).fetchone()
    rows = [
        row
        for row in read(folder / scan["filename"].replace("_beh", "_events"))
        if row["trial_type"] == "trial"
    ]
    assert scan["acq_time"] == utc
    assert [row["onset"] for row in rows] == [
        *(f"{second}.000000000" for second in (1, 2, 4, 5, 6, 7)),
        "n/a",
    ]
    assert [row["stimulus"] for row in rows] == ['\\"', "\\\\", "NA", "n", "true", "ñ", "never"]


def test_motion_holds_every_sample_and_a_row_of_missing_values_at_each_gap(
    study: Path, dataset: Path
) -> None:
    (session,) = (path.parent for path in dataset.glob("sub-P01/ses-*/motion"))
    rows = [
        line.split("\t") for line in one(session, "motion/*_motion.tsv").read_text().splitlines()
    ]
    with closing(connect(study)) as database:
        samples = imu.samples(database, session.name.removeprefix("ses-"))
    measured = [row for row in rows if row[1] != "n/a"]
    zero = int(samples["at"][0])
    assert [Fraction(row[0]) * 10**9 + zero for row in measured] == samples["at"].tolist()
    for first, name in ((1, "acceleration"), (4, "rate")):
        assert [[float(value) for value in row[first : first + 3]] for row in measured] == samples[
            name
        ].tolist()
    about = json.loads(one(session, "motion/*_motion.json").read_text())
    gaps = [row for row in read(one(session, "motion/*_events.tsv")) if row["state"] == "gap"]
    assert len(rows) - len(measured) == about["GapCount"] == len(gaps) > 0
    assert (about["TaskName"], about["SamplingFrequency"]) == ("reaching", 250.0)
    channels = read(one(session, "motion/*_channels.tsv"))
    assert list(channels[0])[:5] == ["name", "component", "type", "tracked_point", "units"]
    assert [row["type"] for row in channels][:2] == ["LATENCY", "ACCEL"]
    assert len(channels) == len(rows[0]) == about["MotionChannelCount"]
    latencies = [float(row[0]) for row in rows]
    assert latencies == sorted(latencies)


def test_a_damaged_block_is_named_and_marked(study: Path, dataset: Path, tmp_path: Path) -> None:
    shutil.copytree(study, tmp_path / "data")
    with closing(connect(tmp_path / "data")) as database:
        database.execute("UPDATE imu_chunks SET data=zeroblob(60) WHERE stream=1 AND seq=2")
    exported = export_bids(
        tmp_path / "data", tmp_path / "out", Request(participant="P01", mixed=True)
    )
    before, after = (
        json.loads(one(place, "sub-P01/ses-*/motion/*_motion.json").read_text())["GapCount"]
        for place in (dataset, tmp_path / "out")
    )
    assert after == before + 1
    (said,) = (sentence for sentence in exported.problems if "damaged" in sentence)
    assert said in (tmp_path / "out" / "README.md").read_text()
    assert complaints(tmp_path / "out") == []


def test_a_session_of_two_is_one_of_each(dataset: Path) -> None:
    (mine,), (partners,) = (
        read(dataset / f"sub-{code}" / f"sub-{code}_sessions.tsv") for code in ("P02", "P3")
    )
    assert mine["session_id"] == partners["session_id"]
    assert (mine["seat"], mine["partner"], partners["seat"], partners["partner"]) == (
        "A",
        "sub-P3",
        "B",
        "sub-P02",
    )
    codes = {
        row["participant_id"]: row["participant"] for row in read(dataset / "participants.tsv")
    }
    assert codes == {"sub-P01": "P01", "sub-P02": "P02", "sub-P3": "P-3"}


def test_every_session_is_there_with_its_status_and_its_mode(dataset: Path) -> None:
    rows = {row["session_id"]: row for row in read(dataset / "sub-P01" / "sub-P01_sessions.tsv")}
    assert rows[f"ses-{EMPTY}"]["status"] == rows[f"ses-{INTERRUPTED}"]["status"] == "interrupted"
    assert read(one(dataset, f"sub-P01/ses-{EMPTY}/beh/*_beh.tsv")) == []
    assert {row["mode"] for row in rows.values()} == {"live", "simulated"}
    assert json.loads((dataset / "dataset_description.json").read_text())["Name"].endswith(
        "(some are simulated)"
    )


def test_every_table_is_one_step_of_the_progress_for_each_of_its_owners(
    study: Path, tmp_path: Path
) -> None:
    steps: list[int] = []
    with closing(connect_to_read(study)) as database:

        def start(number: int) -> Callable[[], None]:
            steps.append(number)
            return lambda: steps.append(-1)

        export(database, study, Catalogue(), ALL, load("bids"), tmp_path / "out", start)
    assert sum(steps) == 0


def test_scores_and_answers_are_phenotypes(dataset: Path) -> None:
    (row,) = read(dataset / "phenotype" / "arat.tsv")
    assert (row["date_1"], row["score_1"]) == ("2026-01-10", "20.0")
    assert (row["date_2"], row["score_2"]) == ("2026-03-10", "31.5")
    sidecar = json.loads((dataset / "phenotype" / "arat.json").read_text())
    assert sidecar["MeasurementToolMetadata"] == {"Description": "Action Research Arm Test (ARAT)"}
    assert set(sidecar) == {"MeasurementToolMetadata", *row} - {"participant_id"}
    (pain,) = read(dataset / "phenotype" / "pain.tsv")
    assert (pain["moment_1"], pain["rating_1"]) == ("before", "3.0")
    assert (pain["session_2"], pain["rating_2"]) == ("n/a", "8.0"), "of a session that never began"
    (tired,) = read(dataset / "phenotype" / "tiredness.tsv")
    assert (tired["moment_1"], tired["answer_1"]) == ("after", "not said")


def test_questions_are_events_from_when_they_were_shown(
    study: Path, dataset: Path, tmp_path: Path
) -> None:
    with closing(connect(study)) as database:
        asked = database.execute(
            "SELECT step, status, json_extract(answer, '$'), shown_ns, answered_ns FROM answers "
            "ORDER BY number"
        ).fetchall()
    path = max(
        dataset.glob("sub-P01/ses-*/beh/*_task-keyboard_*_events.tsv"),
        key=lambda path: path.stat().st_size,
    )
    rows = [row for row in read(path) if row["trial_type"] == "step"]
    assert [(row["step"], row["status"]) for row in rows] == [
        (step, status) for step, status, *_ in asked
    ]
    assert [row["value"] if row["words"] == "n/a" else row["words"] for row in rows] == [
        "n/a" if answer is None else str(answer) for _, _, answer, *_ in asked
    ]
    lasted = [Fraction(ended - shown, 10**9) for *_, shown, ended in asked]
    assert [Fraction(row["duration"]) for row in rows] == lasted
    export_bids(study, tmp_path / "out")
    assert all(
        "words" not in row
        for path in (tmp_path / "out").rglob("*_events.tsv")
        for row in read(path)
    )


def test_notes_leave_only_if_asked_for_and_keep_quotes_and_line_ends(
    study: Path, dataset: Path, tmp_path: Path
) -> None:
    rows = [row for path in dataset.glob("sub-*/ses-*/beh/*_events.tsv") for row in read(path)]
    assert {unescaped(row["text"]) for row in rows if row["label"] == "pausa"} == {NOTE}
    export_bids(study, tmp_path / "out")
    assert not any(
        "duele" in path.read_text() for path in (tmp_path / "out").rglob("*") if path.is_file()
    )


def test_an_export_is_replaced_by_the_next(call: Call, simulated: str, tmp_path: Path) -> None:
    for _ in range(2):
        called = call(
            "export", simulated, "--simulated", "--format", "bids", "--to", tmp_path / "out"
        )
        assert (called.code, called.err) == (0, "")


@pytest.mark.parametrize("codes", [("P-01", "P01"), ("A-1", "A_1")])
def test_participants_that_bids_cannot_tell_apart_are_refused(
    call: Call, tmp_path: Path, codes: tuple[str, str]
) -> None:
    for code in codes:
        call("simulate", "keyboard", "--user", "poor", "--attempts", 1, "-p", code)
    called = call("export", "--all", "--simulated", "--format", "bids", "--to", tmp_path / "out")
    label = codes[1].replace("_", "")
    assert called.code == 2
    assert f"Participants {codes[0]} and {codes[1]} would both be sub-{label} in BIDS" in called.err
    assert "--recode" in called.err
    assert not (tmp_path / "out").exists()


def test_tasks_that_bids_cannot_tell_apart_are_refused(
    call: Call, simulated: str, tmp_path: Path
) -> None:
    call("simulate", "keyboard", "--user", "poor", "--attempts", 1)
    with closing(connect(tmp_path / "data")) as database:
        database.execute("UPDATE sessions SET task='Key_board' WHERE id=?", (simulated,))
    called = call("export", "--all", "--simulated", "--format", "bids", "--to", tmp_path / "out")
    assert (called.code, (tmp_path / "out").exists()) == (2, False)
    assert "Tasks Key_board and keyboard would both be task-keyboard in BIDS" in called.err
