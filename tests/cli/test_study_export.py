"""A study leaves as tables and as BIDS, and each of its people gets their own rows."""

import csv
import os
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import msgspec
import pytest

from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import records
from sar_tui.store.database import connect
from sar_tui.study import ledger
from sar_tui.study.rehearsal import Habits, rehearse
from tests.export.bids_judge import complaints
from tests.played import catalogue
from tests.program import Call
from tests.store.by_hand import value
from tests.study.plans import WITH_FORMS, plan

BLIND = WITH_FORMS.replace("[outcome]", "[allocation]\nblind = true\n[outcome]", 1)


@pytest.fixture
def rehearsed(request: pytest.FixtureRequest, tmp_path: Path, call: Call) -> Path:
    """The data folder of ``call``: a rehearsal of a plan."""
    text = getattr(request, "param", WITH_FORMS)
    site, _ = rehearse(
        plan(text), text, catalogue(), tmp_path, tmp_path / "rehearsal.key", people=4, seed=1,
        start=datetime(2026, 3, 2, tzinfo=UTC), habits=Habits(),
        persons=lambda number: PEOPLE["average"], effects={},
    )  # fmt: skip
    data = site.folder.rename(tmp_path / "data")
    with closing(connect(data)) as database:
        study = ledger.find(database, "praise").plan
        given = {"version": "2", "answer": "yes"}
        ledger.note(database, ledger.CONSENT, study, "R01", given, author="ana")
        late = {"visit": "second", "what": "late", "reason": "Bus"}
        ledger.note(database, ledger.DEVIATION, study, "R01", late, author="ana")
    return data


def test_its_sessions_leave_as_bids(call: Call, rehearsed: Path, tmp_path: Path) -> None:
    call("simulate keyboard --user average -p R01").shows("")
    to = tmp_path / "tables"
    found = call("study export --bids --json --to", to).json
    assert found["files"][-1] == str(to / "bids")
    assert complaints(to / "bids") == []
    sessions = {path.name for path in (to / "bids").glob("sub-*/ses-*")}
    assert len(sessions) == value(rehearsed, "SELECT count(*) FROM sessions WHERE study NOTNULL")
    assert all(name.startswith(("ses-first", "ses-second")) for name in sessions)
    before = _analysed(call)
    call("participant withdraw R01 --exclude").shows("R01 has withdrawn")
    assert _analysed(call) == before - 1
    assert call("study export --bids --to", tmp_path / "without").code == 0
    for path in (tmp_path / "without").rglob("*.*sv"):
        assert "R01" not in path.read_text(), path


def test_nothing_of_another_study_leaves_with_it(
    call: Call, rehearsed: Path, tmp_path: Path
) -> None:
    with closing(connect(rehearsed)) as database:
        database.execute("UPDATE sessions SET mode='live'")
        database.execute("UPDATE studies SET mode='live'")
        study = ledger.find(database, "praise").plan
        other = msgspec.structs.replace(study, name="other")
        for name, given in (
            (ledger.CONSENT, {"version": "9", "answer": "no"}),
            (ledger.DEVIATION, {"what": "other", "reason": "of the other"}),
        ):
            ledger.note(database, name, other, "R01", given, author="ana")
        answers = {"score": 3}
        pain = records.add(database, records.kind_of("nrs"), "R01", "", answers)
        at = {"visit": "first", "block": "pain", "record": pain.id}
        ledger.note(database, ledger.FORM, other, "R01", at, author="ana")
    to = tmp_path / "tables"
    assert call("study export --study praise --bids --to", to).code == 0
    phenotype = to / "bids" / "phenotype"
    assert {path.stem for path in phenotype.glob("*.tsv")} == {
        "consent", "deviation", "effort", "enrolment", "formfilled", "sus",
    }  # fmt: skip
    (_, own) = csv.reader((phenotype / "consent.tsv").read_text().splitlines(), delimiter="\t")
    assert "yes" in own
    assert "no" not in own
    assert "of the other" not in (phenotype / "deviation.tsv").read_text()


def _analysed(call: Call) -> int:
    """Return the number of people whose outcome the report on the study has."""
    key = Path(os.environ["SAR_TUI_DATA"]).with_name("rehearsal.key")
    found = call("report study --json --key", key).json
    return sum(group["analysed"] for group in found["groups"])


@pytest.mark.parametrize("rehearsed", [BLIND], indirect=True)
def test_those_of_a_blind_study_do_not(call: Call, rehearsed: Path, tmp_path: Path) -> None:
    to = tmp_path / "tables"
    call("study export --bids --to", to).refused("The study praise is blind")
    assert not to.exists()
    report = call("participant report R01 --to", tmp_path / "mine")
    assert report.code == 0
    assert "of a study that is blind still" in report.err
    assert not (tmp_path / "mine" / "data").exists()
    for path in (tmp_path / "mine").iterdir():
        words = ("praised", "silent", "feedback_form", "threshold")
        assert not [word for word in words if word in path.read_text()], path


def test_a_person_gets_their_rows_of_a_study(call: Call, rehearsed: Path, tmp_path: Path) -> None:
    shown = call("participant report R01")
    shown.shows("Studies", "Enrolment in a study", "Consent to a study", "Bus")
    to = tmp_path / "mine"
    call("participant report R01 --to", to).shows("4 sessions of R01 in")
    with (to / "studies.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["study"] for row in rows} == {"praise"}
    whats = [row["what"] for row in rows]
    assert whats.count("Session, keyboard") == 4
    assert {
        "Enrolment in a study", "Consent to a study", "Deviation from the plan of a study",
        "A form of a study was filled in",
    } < set(whats)  # fmt: skip
    places = {(row["visit"], row["block"]) for row in rows if row["block"]}
    assert places == {
        ("first", "baseline"), ("first", "speeds"), ("first", "strain"), ("second", "training"),
        ("second", "usability"),
    }  # fmt: skip
    assert "<h2>Studies</h2>" in (to / "report.html").read_text()
