"""``sar-tui report wizard`` on simulated sessions, printed and as JSON."""

import re
import sqlite3
from collections.abc import Collection
from pathlib import Path

import msgspec
import pytest

from sar_tui.drivers.files import write_private
from sar_tui.reports.intervention import InterventionReport
from sar_tui.reports.wizard import WizardReport
from sar_tui.reports.wizard_study import WizardStudy
from tests.program import Call
from tests.store.by_hand import add_message

PAGE = (Path(__file__).parents[2] / "docs" / "data-dictionary.md").read_text(encoding="utf-8")
SHORT = "simulate keyboard --user average --set prompts_per_attempt=3 --seed 1 --json"
DOCUMENTED = set(
    re.findall(r"`([^`\n]+)`", PAGE.partition("`report wizard`: ")[2].partition("\n## ")[0])
)
BUSY = "--set operator_difficulty=approve --set operator_encouragement=veto --set threshold=700"


def keys(value: object, data: Collection[str] = ()) -> set[str]:
    """Return all names in a JSON value, at any depth, but those in fields that hold data."""
    match value:
        case dict():
            parts = (keys(part, data) for name, part in value.items() if name not in data)
            return set(value).union(*parts)
        case list():
            return set().union(*(keys(part, data) for part in value))
        case _:
            return set()


def played(call: Call, options: str) -> str:
    return str(call(f"{SHORT} {options}").json["session"])


def test_the_printed_report_has_operators_latencies_and_agreement(call: Call) -> None:
    session = played(call, f"--operator careful --attempts 20 {BUSY}")
    made = call("report wizard", session, "--json").json
    decided, accepted = made["agreement"]["decided"], made["agreement"]["accepted"]
    call("report wizard", session).shows(
        f"Session {session}: keyboard, SIM, simulated.",
        "Operators: operator.simulated. There was an operator for",
        f"Operators decided on {decided} proposals: {accepted} as proposed",
        f"{made['decision_ms']['median']:.1f}",
        "█",
        "Plan: operator_feedback approve, operator_encouragement veto, operator_difficulty approve",
        "operator_time_ms 4000, operator_ms_per_word 250, operator_timeout act",
    )
    session = played(call, "--operator absent --attempts 20")
    made = call("report wizard", session, "--json").json
    begins, lasts = (made["absences"][0][name] for name in ("at_s", "duration_s"))
    absent = f"No operator from {begins:.1f} s of run 1 on, for {lasts:.1f} s"
    call("report wizard", session).shows(absent, f"lost {made['counts']['lost']}")


def test_notes_marks_and_pauses_are_printed_with_their_times(call: Call, tmp_path: Path) -> None:
    session = played(call, "--operator careful --attempts 2")
    who = "operator.simulated"
    with sqlite3.connect(tmp_path / "data" / "sar-tui.db") as connection:
        began, last = connection.execute("SELECT min(at_ns), max(at_ns) FROM events").fetchone()
        for topic, message in (
            ("operator/note", {"text": "Tired today.", "actor": who, "at": began + 27_000_000_000}),
            ("operator/note", {"label": "yawn", "actor": who, "at": began + 28_500_000_000}),
            ("operator/act", {"command": "pause", "reason": "pain"}),
        ):
            (seq,) = connection.execute("SELECT max(seq) + 1 FROM events").fetchone()
            add_message(connection, session, seq, last, topic, message)
    out = call("report wizard", session).out
    assert "1 note, 1 event mark." in out
    assert re.search(rf"27\.0 +{who} +Tired today\.", out)
    assert re.search(rf"28\.5 +{who} +yawn", out)
    paused = (
        f"The participant paused at {(last - began) / 1e9:.1f} s of run 1 (pain), for 0.0 s; "
        "until the run ended."
    )
    assert paused in out


def test_sessions_with_and_without_an_operator_are_told_apart(call: Call) -> None:
    alone, session = played(call, "--attempts 1"), played(call, "--operator careful --attempts 1")
    assert f"`sar-tui report wizard {session}`" in call("show", session).out
    assert "report wizard" not in call("show", alone).out
    lines = {line.split()[0]: line for line in call("sessions").out.splitlines()}
    assert (", operator" in lines[session], ", operator" in lines[alone]) == (True, False)
    listed = {row["id"]: row["operators"] for row in call("sessions --json").json["sessions"]}
    assert listed == {session: ["operator.simulated"], alone: []}
    out = call("report wizard", alone).out
    assert out.startswith(f"No operator took part in session {alone}")
    assert out.count("\n") == 1
    printed = call("report wizard", alone, "--json").json
    assert (printed["operated"], printed["operators"], printed["decision_ms"]) == (False, [], None)
    veto = played(call, "--attempts 1 --operator careful --set operator_feedback=veto")
    for each, mode in ((alone, "autonomous"), (session, "approve"), (veto, "veto")):
        parameters = call("show", each, "--json").json["session"]["parameters"]
        assert parameters["operator_feedback"] == mode


@pytest.fixture
def two_operated(call: Call) -> tuple[str, str]:
    """Two sessions with an operator, and a third without one."""
    first = played(call, f"--operator careful --attempts 3 {BUSY}")
    second = played(call, "--operator hasty --attempts 3 --set operator_feedback=approve")
    played(call, "--attempts 1")
    return first, second


OF_A_SESSION = "initiated answers therapist counts valence_table agreement_by_kind"
OF_SEVERAL = (
    "counts agreement_by_kind valence_table settings statuses modes feedback outputs deviations "
    "pauses events"
)
"""Fields whose names inside are data."""


@pytest.mark.parametrize(
    ("words", "report", "data"),
    [
        ("wizard last", WizardReport, OF_A_SESSION),
        ("wizard --all --simulated", WizardStudy, OF_SEVERAL),
        ("intervention --all --simulated", InterventionReport, OF_SEVERAL),
    ],
)
@pytest.mark.usefixtures("two_operated")
def test_json_has_every_field_and_the_data_dictionary_describes_each(
    call: Call, words: str, report: type[msgspec.Struct], data: str
) -> None:
    played(call, f"--operator absent --attempts 20 {BUSY}")
    printed = call(f"report {words} --json").json
    assert list(printed) == list(report.__struct_fields__)
    assert keys(printed, data.split()) - DOCUMENTED == set()
    assert {"deviations", "absences", "agreement"} <= DOCUMENTED


def test_a_page_of_a_report_is_self_contained_and_not_overwritten(
    call: Call, two_operated: tuple[str, str], tmp_path: Path
) -> None:
    every = "--all --simulated"
    for what in (f"wizard {two_operated[0]}", f"wizard {every}", f"intervention {every}"):
        page = tmp_path / f"{what.replace(' ', '')}.html"
        assert call(f"report {what} --html", page).code == 0
        text = page.read_text(encoding="utf-8")
        assert "<table>" in text
        assert not re.search("<script|src=|href=|url\\(", text)
        assert page.stat().st_mode & 0o777 == 0o600
        call(f"report {what} --html", page).refused("not overwritten")


def test_a_page_that_could_not_be_written_whole_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(UnicodeEncodeError):
        write_private(tmp_path / "page.html", "half \ud800")
    assert list(tmp_path.iterdir()) == []
    write_private(tmp_path / "page.html", "whole")
    assert (tmp_path / "page.html").read_text() == "whole"


def test_a_session_is_excluded_with_its_reason(call: Call, two_operated: tuple[str, str]) -> None:
    first, second = two_operated
    ask = ("report", "wizard", "--all", "--simulated", "--exclude")
    printed = call(*ask, f"{first}=Fire alarm.", "--json").json
    assert [each["session"] for each in printed["sessions"]] == [second]
    assert {"session": first, "why": "Fire alarm."} in printed["excluded"]
    call(*ask, f"{first}=").refused("Say why")
    call(*ask, "nope=x").refused("None of these sessions")
