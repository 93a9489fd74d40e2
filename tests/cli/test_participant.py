"""People's rights by the command line, in a process of its own where files matter."""

import os
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.loop.clock import VirtualClock
from sar_tui.runs.plan import make_plan
from sar_tui.runs.run import start
from sar_tui.store import participants
from sar_tui.store.database import StoreError, connect
from tests.played import catalogue
from tests.program import Call
from tests.store.by_hand import sql, value
from tests.store.persons import copies, fill, holding, played

FEW = {"attempts": 1, "prompts_per_attempt": 3}


def program(data: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "sar_tui", *words],
        env=os.environ | {"SAR_TUI_DATA": str(data), "COLUMNS": "160"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """The data folder of ``call``, with a session of P07, and P08."""
    folder = tmp_path / "data"
    with closing(connect(folder)) as database:
        for code in ("P07", "P08"):
            participants.add(database, code)
    played(folder, "keyboard", "P07", **FEW)
    return folder


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("withdraw P99", "There is no participant P99."),
        ("withdraw P07 --keep --exclude", "Give one of --keep, --exclude and --undo."),
        ("withdraw P07 --undo", "Say why the withdrawal is taken back"),
        ("withdraw P07 --undo --reason x", "P07 has not withdrawn."),
        ("withdraw P07 --on 2999-01-01", "The day 2999-01-01 is in the future."),
        ("withdraw P07 --on yesterday", "A day is given as 2026-03-01, not 'yesterday'."),
        ("withdraw P07@BERN", "P07@BERN is a participant of BERN"),
        ("move last P08", "Say why the session is moved: --reason TEXT."),
        ("move nothing P08 --reason x", "There is no session nothing."),
        ("move last P09 --reason x", "There is no participant P09"),
        ("move last P07 --reason x", "P07 is in the session"),
        ("move last P08 --seat B --reason x", "has no seat B: it was for one person."),
        ("move last P08 --seat C --reason x", "A seat is A or B, not 'C'."),
        ("erase P99 P99 --yes", "There is no participant P99."),
        ("erase P07", "Nobody can be asked here. Give the code twice: P07 P07 --yes."),
        ("erase P07 --yes", "With --yes the code is given twice"),
        ("erase P07 P08 --yes", "The codes are not the same. Nothing was done."),
        ("erase P07@BERN P07@BERN --yes", "P07@BERN is a participant of BERN"),
        ("de-identify P99 P99 --yes", "There is no participant P99."),
        ("de-identify P07", "Nobody can be asked here."),
        ("report P99", "There is no participant P99."),
    ],
)
def test_bad_input_is_refused_in_a_sentence(
    call: Call, data: Path, command: str, said: str
) -> None:
    call(f"participant {command}").refused(said)
    assert value(data, "SELECT count(*) FROM people_events") == 0
    assert value(data, "SELECT participant FROM seats") == "P07"


def test_nothing_is_recorded_of_somebody_who_withdrew(call: Call, data: Path) -> None:
    said = call("participant withdraw p07 --reason moved-away --on 2026-03-01")
    said.shows("P07 has withdrawn: nothing more")
    call("participant withdrawals").shows("moved-away", "keep", "2026-03-01")
    words = "P07 has withdrawn on 2026-03-01"
    call("record add FMA-UE P07 score=30").refused(words)
    plan = make_plan(catalogue(), "keyboard", ["P07"], FEW, seed=1)
    with pytest.raises(StoreError, match=words):
        start(plan, data, catalogue(), VirtualClock(), lambda *_: [])
    call("participant withdraw P07").refused("P07 has withdrawn on")
    call("export --all --to", data / "kept").shows("1 session")
    call("participant withdraw P07 --undo --reason came-back").shows("is taken back")
    call("record add FMA-UE P07 score=30 --on 2026-03-01").shows("is recorded")
    known = call("participant withdrawals --json").json["events"]
    assert [each["event"] for each in known] == ["withdrawn", "resumed"]


def test_excluded_data_is_in_no_export_report_or_progress(call: Call, data: Path) -> None:
    other = played(data, "keyboard", "P08", **FEW)
    call("participant withdraw P07 --exclude").shows("left out of exports, reports and progress")
    called = call("export --all --to", data / "all", "--json")
    assert called.json["sessions"] == [other]
    assert "P07 has withdrawn" in called.json["notices"][0]
    assert "P07" not in (data / "all" / "sar-tui-export.json").read_text()
    for command in ("export -p P07", "progress P07", "report intervention -p P07"):
        call(command).refused("P07 has withdrawn on", "their data is excluded")
    assert call("sessions -p P07 --json").json["sessions"]
    call("participant report P07").shows("withdrawn", "exclude")


def test_a_session_is_moved_and_its_log_tells_it(call: Call, data: Path) -> None:
    session = value(data, "SELECT id FROM sessions")
    call("record add adverse-event P07 what=Dizzy severity=mild --session last").shows("recorded")
    call("participant move last P09 --new --reason", "a typing error").shows("is one of P09")
    call(f"show {session}").shows("It was recorded for P07, and moved to P09: a typing error")
    assert call("record list -p P09 --json").json["records"]
    assert call("sessions -p P07 --json").json["sessions"] == []
    call("check").shows("is whole")
    assert call(f"replay {session} --json").json["identical"]
    call(f"participant move {session} P07 --reason", "it was right").shows("is one of P07")
    call("check").shows("is whole")


def test_both_seats_of_a_session_for_two_are_moved(call: Call, data: Path) -> None:
    session = played(data, "pairs", "P07", "P08", attempts=1, prompts_per_attempt=4)
    call(f"participant move {session} P09 --new --seat B --reason x").shows("is one of P09")
    call(f"participant move {session} P09 --reason x").refused("P09 is in the session")
    call(f"participant move {session} P08 --reason x").shows("is one of P08")
    seats = sql(data, "SELECT seat, participant FROM seats WHERE session=?", session)
    assert sorted(seats) == [("A", "P08"), ("B", "P09")]
    call("check").shows("is whole")


@pytest.mark.slow
def test_a_person_is_erased_by_the_program(tmp_path: Path) -> None:
    data = tmp_path / "data"
    fill(data)
    made = copies(data)
    assert program(data, "export", "--all", "--for", "Statistics", "--with-notes").returncode == 0
    done = program(data, "participant", "erase", "p07", "P07", "--yes", "--reason", "asked")
    assert done.returncode == 0, done.stderr
    assert "P07 is erased (2 sessions)." in done.stdout
    for path in made:
        assert f"Rewritten without them: {path}" in done.stdout
    assert "for Statistics (csv" in done.stdout
    assert "This export has them, and is not changed:" in done.stdout
    assert {name.partition("/")[0] for name in holding(data)} == {"exports"}
    (data / "sar-tui-rescue-abc.db").unlink()  # a copy, of which nothing is to be brought back
    assert program(data, "check").returncode == 0
    again = program(data, "run", "keyboard", "-p", "P07", "--new")
    assert again.returncode == 2
    call = program(data, "record", "add", "FMA-UE", "P07", "score=3", "--new")
    assert (call.returncode, call.stdout) == (2, "")
    assert "The data of P07 was erased on" in call.stderr
    assert len(call.stderr.splitlines()) == 1


def test_what_a_partner_did_is_shown_and_exported_after_an_erasure(call: Call, data: Path) -> None:
    session = played(data, "pairs", "P07", "P08", word="WORD", attempts=2, prompts_per_attempt=4)
    said = call("participant erase P07 P07 --yes")
    said.shows("P07 is erased (2 sessions). Of 1 session for two, the part of the partner stays.")
    call("check").shows("is whole")
    call(f"show {session}").shows("ERASED-")
    call("progress P08").shows("P08")
    call("export --all --with-events --with-notes --to", data / "all").shows("1 session in")
    assert "WORD" not in "".join(path.read_text() for path in (data / "all").glob("*.csv"))
    call("report intervention --all").shows("")
    call(f"replay {session}").refused("was erased: what is left cannot be run again.")


def test_the_report_has_all_of_one_person(call: Call, tmp_path: Path) -> None:
    data = tmp_path / "data"
    fill(data, word="WORD")
    said = call("participant report P07")
    for word in ("WORD-NOTE", "WORD-LABEL", "WORD-WHAT", "WORD-WHY", "WORD-REASON", "FMA-UE"):
        assert word in said.out, word
    to = tmp_path / "of-p07"
    call("participant report P07 --to", to).shows("2 sessions of P07 in")
    assert {"report.html", "report.json", "data"} == {path.name for path in to.iterdir()}
    assert "WORD-NOTE" in (to / "data" / "notes.csv").read_text()
    assert "WORD-WHAT" in (to / "data" / "records.csv").read_text()
    call("participant report P07 --to", to).refused("exists already, and is not overwritten")
    page = tmp_path / "page.html"
    call("participant report P07 --html", page).shows("is written")
    assert "<h2>Programmes</h2>" in page.read_text()
