"""``sar-tui record``: adverse events, scores, pain and tiredness, for people and programs."""

from contextlib import closing
from datetime import datetime, timedelta
from pathlib import Path

import pytest

from sar_tui.records.kind import kinds
from sar_tui.store import participants, records
from sar_tui.store.database import connect
from sar_tui.store.wellbeing import NOT_SAID
from tests.program import Call
from tests.recorded import told

FALL = ("what=Fell from the chair", "severity=moderate", "--on", "2026-03-01T14:30")
EVENT = ("record", "add", "adverse-event")


@pytest.fixture
def data(tmp_path: Path, simulated: str) -> Path:
    """The data folder of ``call``, with a session of P01 and what was said in it."""
    folder = tmp_path / "data"
    with closing(connect(folder)) as database:
        for code in ("P01", "P02"):
            participants.add(database, code)
        for moment, question, answer in (
            ("before", "pain", "2"),
            ("before", "tiredness", NOT_SAID),
            ("after", "pain", "5"),
            ("after", "place", "left shoulder"),
            ("after", "tiredness", "10"),
        ):
            told(database, "P01", moment, question, answer, session=simulated)
        with database:
            pause = ("x-1", simulated, "A", "pain", records.now())
            database.execute(records.PAUSES, pause)
    return folder


def test_a_session_shows_what_the_participant_said(call: Call, data: Path, simulated: str) -> None:
    shown = call("show", simulated)
    assert shown.code == 0
    assert 'Pain: 2 before, 5 after (left shoulder), "in pain" in a pause.' in shown.out
    assert "Tiredness: would rather not say before, 10 after." in shown.out
    assert "That was a reason to stop and to tell the therapist." in shown.out
    known = call("show", simulated, "--json").json["records"]
    assert sorted(row["kind"] for row in known) == [*["pain"] * 3, *["tiredness"] * 2]
    assert "completed, simulated, pain 5, tired 10" in call("sessions").out


def test_a_number_given_in_a_pause_is_shown(call: Call, data: Path, simulated: str) -> None:
    with closing(connect(data)) as database:
        told(database, "P01", "pause", "pain", "9", session=simulated)
    assert '"in pain" in a pause (9).' in call("show", simulated).out
    assert "pain 9" in call("sessions").out


def test_the_records_of_a_participant_are_listed(call: Call, data: Path) -> None:
    listed = call("record", "list", "-p", "p01").out
    assert "left shoulder" in listed
    found = call("record", "list", "pain", "-p", "P01", "--json").json
    assert [len(found["records"]), found["tell_therapist"]] == [3, []]
    assert call("record", "list", "-p", "P02").out == "There are no records of P02.\n"
    assert call("record", "list", "-p", "P1").err == "There is no participant P1. Is it P01?\n"


def test_the_therapist_is_told_of_pain_that_is_new_over_four_sessions(
    call: Call, data: Path
) -> None:
    with closing(connect(data)) as database:
        for number, pain in enumerate(("0", "2", "1", "3", "2")):
            database.execute(
                "INSERT INTO sessions (id, task, status, mode) VALUES (?, 'keyboard', "
                "'completed', 'live')",
                (number,),
            )
            database.execute("INSERT INTO seats VALUES (?, 'A', 'P01')", (number,))
            told(database, "P01", "after", "pain", pain, session=str(number))
    assert call("record", "list", "-p", "P01").out.startswith("! Pain is new")
    found = call("record", "list", "-p", "P01", "--json").json
    assert found["tell_therapist"] == ["new pain"]


def test_an_adverse_event_is_recorded_and_corrected(call: Call, data: Path, simulated: str) -> None:
    added = call(*EVENT, "p01", *FALL, "--session", simulated, "--json").json["record"]
    assert (added["at"], added["session"]) == ("2026-03-01 14:30", simulated)
    said = call("record", "correct", added["id"], "action=Rested", "outcome=No injury")
    assert said.code == 0
    (now,) = call("record", "list", "adverse-event", "--json").json["records"]
    assert (now["version"], now["content"]["outcome"]) == (2, "No injury")
    versions = call("record", "show", added["id"], "--json").json["versions"]
    assert [one["version"] for one in versions] == [1, 2]
    shown = call("show", simulated).out
    assert f"! Adverse event {added['id']}, moderate: Fell from the chair." in shown
    assert call("record", "correct", added["id"], "--remove").code == 0
    assert call("record", "list", "adverse-event").out.startswith("There are no records")


def test_people_are_told_what_is_still_missing(call: Call, data: Path) -> None:
    said = call(*EVENT, "P01", *FALL, "action=Rested").out
    assert "outcome=…" in said
    assert "action=…" not in said


def test_the_advice_not_to_train_and_what_came_of_it_are_told(call: Call, tmp_path: Path) -> None:
    with closing(connect(tmp_path / "data")) as database:
        for question, answer in (("pain", "9"), ("advice", "shown"), ("advice", "stopped")):
            told(database, "P01", "before", question, answer)
    found = call("record", "list", "-p", "P01", "--json").json
    assert found["tell_therapist"] == ["stop", "stopped"]
    (pain,) = found["records"]
    assert (pain["version"], pain["content"]["advice"]) == (3, "stopped")


def test_scores_appear_in_progress_with_their_sources(call: Call) -> None:
    for score, day, new in ((34, "2026-03-01", ["--new"]), (45, "2026-05-01", [])):
        added = call("record", "add", "fma-ue", "p01", f"score={score}", "--on", day, *new)
        assert (added.code, added.out.split()[-2:]) == (0, ["is", "recorded."])
    shown = " ".join(call("progress", "P01").out.split())
    assert "34 on 2026-03-01, 45 on 2026-05-01; change +11. Reaches MDC 6.8 points" in shown
    spanish = " ".join(call("progress", "P01", "--note", "--language", "es").out.split())
    assert "cambio +11. Alcanza MDC 6,8 puntos, 1 a 6 semanas" in spanish
    assert "doi:10.1177/15459683231186985" in spanish
    (found,) = call("progress", "P01", "--json").json["instruments"]
    assert (found["instrument"]["name"], found["change"]) == ("FMA-UE", 11.0)
    assert [each["reached"] for each in found["reached"]] == [True] * 5


def test_the_kinds_are_listed_with_their_fields(call: Call) -> None:
    listed = call("record", "kinds").out
    assert [name for name in kinds() if name not in listed] == []
    assert [each["name"] for each in call("record", "kinds", "--json").json["kinds"]] == list(
        kinds()
    )


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("P99", *FALL), "There is no participant P99: add --new for a new participant."),
        (("P01", *FALL, "severity=awful"), "Severity is mild, moderate or severe"),
        (("P01", *FALL, "--on", "yesterday"), "Onset is a date, such as 2026-03-01"),
        (("P01", *FALL, "--on", f"{datetime.now() + timedelta(days=2):%Y-%m-%d}"), "in the future"),
        (("P01", *FALL, "what= "), "Say what happened, in a few words."),
        (("P01", *FALL, "colour=red"), "adverse-event has no field colour."),
        (("P01", *FALL, "mild"), "A value is given as FIELD=VALUE"),
        (("P01", *FALL, "--session", "nowhere"), "There is no session nowhere."),
        (("P02", *FALL, "--session", "last"), "is not one of P02."),
    ],
)
def test_bad_input_is_refused_in_a_sentence(
    call: Call, data: Path, arguments: tuple[str, ...], says: str
) -> None:
    called = call(*EVENT, *arguments)
    assert called.code == 2
    assert says in called.err
    assert call("record", "list", "adverse-event", "--json").json["records"] == []


def test_kinds_and_records_that_do_not_exist_are_told(call: Call, data: Path) -> None:
    assert "There is no kind of record fim." in call("record", "add", "fim", "P01").err
    assert call("record", "show", "ffffff").code == 2
    assert call("record", "correct", "ffffff", "outcome=well").code == 2
