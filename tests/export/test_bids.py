"""Sessions leave as a BIDS data set in which the BIDS validator finds no error, and which holds
what was measured.
"""

import json
import re
import runpy
import shutil
from collections.abc import Callable
from contextlib import closing
from datetime import UTC, datetime
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from sar_tui.export import registry
from sar_tui.export.errors import ExportError
from sar_tui.export.export import Exported, export
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import imu
from sar_tui.store.database import connect, connect_to_read
from sar_tui.store.selection import Request
from sar_tui.study import ledger
from sar_tui.study.rehearsal import Habits, rehearse
from tests.export.bids_judge import ALLOWED, judge
from tests.export.exported import ALL, export_as
from tests.export.hard_study import EMPTY, INTERRUPTED, NOTE, store_study
from tests.played import catalogue, simulated
from tests.recorded import score, told
from tests.store.by_hand import sql, value
from tests.study.plans import WITH_FORMS, plan

DOCS = Path(__file__).parents[2] / "docs" / "archive-in-bids.md"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    data = tmp_path_factory.mktemp("study") / "data"
    store_study(data)
    return data


@pytest.fixture(scope="module")
def dataset(study: Path) -> Path:
    """An export of the whole study with notes."""
    export_bids(study, study.parent / "out", with_notes=True)
    return study.parent / "out"


def export_bids(data: Path, folder: Path, request: Request = ALL, **options: Any) -> Exported:
    return export_as("bids", data, folder, request, **options)


def read(path: Path) -> list[dict[str, str]]:
    text = path.read_text("utf-8").removesuffix("\n")
    head, *lines = (line.split("\t") for line in text.split("\n"))
    return [dict(zip(head, line, strict=True)) for line in lines]


def load(path: Path) -> Any:
    return json.loads(path.read_text())


def keyboard_events(dataset: Path, kind: str) -> list[dict[str, str]]:
    """Return the events of a kind of the session with questions."""
    paths = dataset.glob("sub-P01/ses-*/beh/*_task-keyboard_*_events.tsv")
    longest = max(paths, key=lambda path: path.stat().st_size)
    return [row for row in read(longest) if row["trial_type"] == kind]


def one(folder: Path, pattern: str) -> Path:
    (found,) = folder.glob(pattern)
    return found


def test_the_validator_finds_no_error_in_a_hard_study_and_only_the_warnings_of_the_docs(
    dataset: Path,
) -> None:
    found = judge(dataset)
    assert {issue.severity for issue in found} == {"warning"}
    assert {issue.what for issue in found} <= ALLOWED.keys()
    page = DOCS.read_text("utf-8")
    assert [what for what in ALLOWED if f"`{what.split()[-1]}`" not in page] == []


def test_the_script_of_the_docs_says_what_the_database_says(
    study: Path, dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "study").symlink_to(dataset)
    monkeypatch.chdir(tmp_path)
    script = DOCS.read_text("utf-8").partition("```python\n")[2].partition("```")[0]
    (tmp_path / "script.py").write_text(script)
    right = runpy.run_path(str(tmp_path / "script.py"))["right"]
    stored = sql(
        study,
        "SELECT level, avg(reaction_time_ms) FROM trials LEFT JOIN attempts USING (session, attempt, seat)"
        " JOIN seats USING (session, seat) WHERE trials.correct AND practice IS NOT 1 AND participant='P01'"
        " AND level IS NOT NULL GROUP BY level",
    )
    found = right[right.subject == "sub-P01"].groupby("level").response_time.mean()
    assert dict(found * 1000) == {level: pytest.approx(mean) for level, mean in stored}


@pytest.mark.parametrize("task", ["keyboard", "reaching", "pairs"])
def test_trials_are_rows_of_beh(study: Path, dataset: Path, task: str) -> None:
    paths = sorted(dataset.glob(f"sub-*/ses-*/beh/*_task-{task}_*_beh.tsv"))
    rows = [row for path in paths for row in read(path)]
    query = "SELECT onset_ns, reaction_time_ms, trials.correct FROM trials JOIN sessions ON sessions.id=session"
    expected = [
        (or_missing(onset), or_missing(time), ["false", "true"][right])
        for onset, time, right in sql(study, f"{query} WHERE task=?", task)
    ]
    found = [(row["onset_ns"], row["reaction_time_ms"], row["correct"]) for row in rows]
    assert sorted(found) == sorted(expected)
    for row in rows:
        ms = row["reaction_time_ms"]
        assert row["response_time"] == ("n/a" if ms == "n/a" else repr(float(ms) / 1000))
    described = load(dataset / f"task-{task}_beh.json")
    assert set(rows[0]) <= set(described)
    assert described["reaction_time_ms"]["Units"] == "ms"


def or_missing(value: object) -> str:
    return "n/a" if value is None else repr(value)


def unescaped(text: str) -> str:
    signs = {"t": "\t", "n": "\n", "r": "\r"}
    return re.sub(r"\\(.)", lambda found: signs.get(found[1], found[1]), text)


def test_events_of_behaviour_count_from_the_time_of_each_run_in_scans(
    study: Path, dataset: Path
) -> None:
    trials = keyboard_events(dataset, "trial")
    assert {row["practice"] for row in trials} == {"true", "false"}
    misses = [row for row in trials if row["response"] == "n/a"]
    assert misses
    for row in misses:
        found = (row["response_time"], row["duration"], row["correct"])
        assert found == ("n/a", "n/a", "false")
        assert float(row["onset"]) > 0
    runs = list(one(dataset, "sub-P01/ses-*/beh/*_run-2_events.tsv").parent.glob("*_events.tsv"))
    for rows in map(read, runs):
        assert {"trial", "action"} <= {row["trial_type"] for row in rows}
        assert all(0 <= float(row["onset"]) < 600 for row in rows if row["trial_type"] == "trial")
    assert len(runs) == len(read(one(runs[0].parents[1], "*_scans.tsv"))) == 2
    folder = dataset / "sub-P01" / f"ses-{INTERRUPTED}"
    (scan,) = read(one(folder, "*_scans.tsv"))
    utc = "SELECT json_extract(clock_anchor, '$.utc') FROM runs WHERE session=?"
    assert scan["acq_time"] == value(study, utc, INTERRUPTED)
    events = read(folder / scan["filename"].replace("_beh", "_events"))
    rows = [row for row in events if row["trial_type"] == "trial"]
    onsets = [f"{second}.000000000" for second in (1, 2, 4, 5, 6, 7)]
    assert [row["onset"] for row in rows] == [*onsets, "n/a"]
    assert [row["stimulus"] for row in rows] == ['\\"', "\\\\", "NA", "n", "true", "ñ", "never"]


def test_motion_holds_every_sample_and_an_empty_row_at_each_gap(study: Path, dataset: Path) -> None:
    (session,) = (path.parent for path in dataset.glob("sub-P01/ses-*/motion"))
    lines = one(session, "motion/*_motion.tsv").read_text().splitlines()
    rows = [line.split("\t") for line in lines]
    with closing(connect(study)) as database:
        samples = imu.samples(database, session.name.removeprefix("ses-"))
    measured = [row for row in rows if row[1] != "n/a"]
    zero = int(samples["at"][0])
    assert [Fraction(row[0]) * 10**9 + zero for row in measured] == samples["at"].tolist()
    for first, name in ((1, "acceleration"), (4, "rate")):
        found = [list(map(float, row[first : first + 3])) for row in measured]
        assert found == samples[name].tolist()
    about = load(one(session, "motion/*_motion.json"))
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
    data, out = tmp_path / "data", tmp_path / "out"
    shutil.copytree(study, data)
    sql(data, "UPDATE imu_chunks SET data=zeroblob(60) WHERE stream=1 AND seq=2")
    exported = export_bids(data, out, Request(participant="P01", mixed=True))
    about = (load(one(place, "sub-P01/ses-*/motion/*_motion.json")) for place in (dataset, out))
    before, after = (each["GapCount"] for each in about)
    assert after == before + 1
    (said,) = (sentence for sentence in exported.problems if "damaged" in sentence)
    assert said in (out / "README.md").read_text()


def test_every_session_is_there_and_one_of_two_is_one_of_each(dataset: Path) -> None:
    (mine,), (partners,) = (
        read(dataset / f"sub-{code}" / f"sub-{code}_sessions.tsv") for code in ("P02", "P3")
    )
    assert mine["session_id"] == partners["session_id"]
    assert (mine["seat"], mine["partner"]) == ("A", "sub-P3")
    assert (partners["seat"], partners["partner"]) == ("B", "sub-P02")
    people = read(dataset / "participants.tsv")
    codes = {row["participant_id"]: row["participant"] for row in people}
    assert codes == {"sub-P01": "P01", "sub-P02": "P02", "sub-P3": "P-3"}

    rows = {row["session_id"]: row for row in read(dataset / "sub-P01" / "sub-P01_sessions.tsv")}
    assert rows[f"ses-{EMPTY}"]["status"] == rows[f"ses-{INTERRUPTED}"]["status"] == "interrupted"
    assert read(one(dataset, f"sub-P01/ses-{EMPTY}/beh/*_beh.tsv")) == []
    assert {row["mode"] for row in rows.values()} == {"live", "simulated"}
    assert load(dataset / "dataset_description.json")["Name"].endswith("(some are simulated)")


def test_every_table_is_one_step_for_each_of_its_owners(study: Path, tmp_path: Path) -> None:
    steps: list[int] = []

    def start(number: int) -> Callable[[], None]:
        steps.append(number)
        return lambda: steps.append(-1)

    with closing(connect_to_read(study)) as database:
        export(database, study, catalogue(), ALL, registry.load("bids"), tmp_path / "out", start)
    assert sum(steps) == 0


def test_scores_and_answers_are_phenotypes(dataset: Path) -> None:
    def phenotype(name: str) -> dict[str, str]:
        (row,) = read(dataset / "phenotype" / f"{name}.tsv")
        return row

    row = phenotype("arat")
    assert (row["date_1"], row["score_1"]) == ("2026-01-10", "20.0")
    assert (row["date_2"], row["score_2"]) == ("2026-03-10", "31.5")
    sidecar = load(dataset / "phenotype" / "arat.json")
    assert sidecar["MeasurementToolMetadata"] == {"Description": "Action Research Arm Test (ARAT)"}
    assert set(sidecar) == {"MeasurementToolMetadata", *row} - {"participant_id"}
    pain, tired = phenotype("pain"), phenotype("tiredness")
    assert (pain["moment_1"], pain["rating_1"]) == ("before", "3.0")
    assert (pain["session_2"], pain["rating_2"]) == ("n/a", "8.0"), "of a session that never began"
    assert (tired["moment_1"], tired["answer_1"]) == ("after", "not said")


@pytest.fixture(scope="module")
def with_forms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An export of a study with forms, consent, deviations, and records of people."""
    folder = tmp_path_factory.mktemp("forms")
    site, _ = rehearse(
        plan(WITH_FORMS), WITH_FORMS, catalogue(), folder, folder / "rehearsal.key", people=4,
        seed=1, start=datetime(2026, 3, 2, tzinfo=UTC), habits=Habits(misses=0.2, late=0.4),
        persons=lambda number: PEOPLE["average"], effects={},
    )  # fmt: skip
    with closing(connect(site.folder)) as database:
        sql(database, "UPDATE sessions SET mode='live'")
        study = ledger.find(database, "praise").plan
        consent = {"version": "2", "answer": "yes", "witness": "W1"}
        ledger.note(database, ledger.CONSENT, study, "R01", consent, author="ana")
        for reason in ("A\tbus", "=1+1"):
            late = {"visit": "second", "what": "late", "reason": reason}
            ledger.note(database, ledger.DEVIATION, study, "R01", late, author="ana")
        score(database, "R01", "ARAT", "2026-01-10", 20, NOTE)
        told(database, "R02", "before", "pain", "not said")
    export_bids(site.folder, folder / "out", with_notes=True)
    return folder / "out"


def test_the_validator_finds_forms_and_records_of_a_study_described(with_forms: Path) -> None:
    assert {issue.what for issue in judge(with_forms)} <= ALLOWED.keys()
    files = sorted((with_forms / "phenotype").glob("*.tsv"))
    assert [path.stem for path in files] == [
        "arat", "consent", "deviation", "effort", "enrolment", "formfilled", "pain", "sus",
    ]  # fmt: skip
    people = {row["participant_id"] for row in read(with_forms / "participants.tsv")}
    for path in files:
        rows, sidecar = read(path), load(path.with_suffix(".json"))
        assert next(iter(rows[0])) == "participant_id"
        assert {row["participant_id"] for row in rows} <= people
        assert set(sidecar) == {"MeasurementToolMetadata", *rows[0]} - {"participant_id"}
        assert all(each["Description"] for each in sidecar.values())
        for row in rows:
            levels = {name: each["Levels"] for name, each in sidecar.items() if "Levels" in each}
            assert all(row[name] in {*known, "n/a"} for name, known in levels.items())
    (consent,) = read(with_forms / "phenotype" / "consent.tsv")
    assert (consent["study_1"], consent["answer_1"]) == ("praise", "yes")


def test_the_validator_looks_into_forms(with_forms: Path, tmp_path: Path) -> None:
    changed = shutil.copytree(with_forms, tmp_path / "changed") / "phenotype"
    sidecar = load(changed / "sus.json")
    del sidecar["q1_1"]
    (changed / "sus.json").write_text(json.dumps(sidecar))
    rows = [line.split("\t") for line in (changed / "effort.tsv").read_text().splitlines()]
    swapped = ["\t".join([row[1], row[0], *row[2:]]) for row in rows]
    (changed / "effort.tsv").write_text("\n".join(swapped) + "\n")
    found = {(issue.what, issue.where) for issue in judge(tmp_path / "changed")}
    assert found >= {
        ("TSV_ADDITIONAL_COLUMNS_UNDEFINED q1_1", "/phenotype/sus.tsv"),
        ("TSV_COLUMN_ORDER_INCORRECT participant_id", "/phenotype/effort.tsv"),
    }


def test_sessions_of_a_study_are_named_by_their_visit_and_block(with_forms: Path) -> None:
    for path in with_forms.glob("sub-*/sub-*_sessions.tsv"):
        for row in read(path):
            assert row["session_id"] == f"ses-{row['visit']}{row['block']}{row['session']}"
            assert (path.parent / row["session_id"] / "beh").is_dir()
            assert row["study"] == "praise"
            assert row["study_condition"] in ("praised", "unpraised", "slow", "fast")


def _answer(answer: object) -> str:
    """Return an answer as the events have it: a number has decimals."""
    if isinstance(answer, int):
        return str(float(answer))
    return "n/a" if answer is None else str(answer)


def test_questions_and_notes_are_events(study: Path, dataset: Path) -> None:
    query = "SELECT step, status, json_extract(answer, '$'), answered_ns - shown_ns FROM answers ORDER BY number"
    found = [
        (
            row["step"], row["status"], row["value"] if row["words"] == "n/a" else row["words"],
            Fraction(row["duration"]),
        )
        for row in keyboard_events(dataset, "step")
    ]  # fmt: skip
    assert found == [
        (step, status, _answer(answer), Fraction(lasted, 10**9))
        for step, status, answer, lasted in sql(study, query)
    ]
    rows = [row for path in dataset.glob("sub-*/ses-*/beh/*_events.tsv") for row in read(path)]
    assert {unescaped(row["text"]) for row in rows if row["label"] == "pausa"} == {NOTE}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("UPDATE seats SET participant='P-01'", "Participants P-01 and P01 would both be sub-P01"),
        ("UPDATE sessions SET task='Key_board'", "Tasks Key_board and keyboard would both be task-keyboard"),
    ],
)  # fmt: skip
def test_what_bids_cannot_tell_apart_is_refused(tmp_path: Path, change: str, said: str) -> None:
    data = tmp_path / "data"
    for _ in range(2):
        simulated(data, user="poor", attempts=1)
    sql(data, f"{change} WHERE rowid=1")
    with pytest.raises(ExportError, match=f"{said} in BIDS") as refused:
        export_bids(data, tmp_path / "out")
    assert refused.value.bad_input
    assert not (tmp_path / "out").exists()
