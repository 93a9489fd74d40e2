"""``sar-tui wellbeing`` and ``adverse``: pain, tiredness and adverse events, for people and
programs.
"""

from contextlib import closing
from datetime import datetime, timedelta
from pathlib import Path

import pytest

from sar_tui.store import participants, wellbeing
from sar_tui.store.database import connect
from tests.program import Call

FALL = ("--what", "Fell from the chair", "--onset", "2026-03-01T14:30", "--severity", "moderate")


@pytest.fixture
def data(tmp_path: Path, simulated: str) -> Path:
    """The data folder of ``call``, with a session of P01 and what was said in it."""
    folder = tmp_path / "data"
    with closing(connect(folder)) as database:
        participants.add(database, "P01")
        for moment, question, answer in (
            ("before", "pain", "2"),
            ("before", "fatigue", wellbeing.NOT_SAID),
            ("after", "pain", "5"),
            ("after", "place", "left shoulder"),
            ("after", "fatigue", "10"),
        ):
            wellbeing.save(database, "P01", moment, question, answer, session=simulated)  # type: ignore[arg-type]
        with database:
            database.execute(wellbeing.PAUSES, (simulated, "A", "pain", wellbeing.now()))
    return folder


def test_show_says_what_the_participant_said(call: Call, data: Path, simulated: str) -> None:
    shown = call("show", simulated)
    assert shown.code == 0
    assert 'Pain: 2 before, 5 after (left shoulder), "in pain" in a pause.' in shown.out
    assert "Tiredness: would rather not say before, 10 after." in shown.out
    assert "That was a reason to stop and to tell the therapist." in shown.out
    rows = call("show", simulated, "--json").json["wellbeing"]
    assert [row["answer"] for row in rows] == ["2", "not said", "5", "left shoulder", "10", "yes"]


def test_a_number_given_in_a_pause_is_shown(call: Call, data: Path, simulated: str) -> None:
    with closing(connect(data)) as database:
        wellbeing.save(database, "P01", "pause", "pain", "9", session=simulated)
    assert '"in pain" in a pause (9).' in call("show", simulated).out
    assert "pain 9" in call("sessions").out


def test_a_list_of_sessions_marks_pain_and_tiredness(
    call: Call, data: Path, simulated: str
) -> None:
    assert "completed, simulated, pain 5, tired 10" in call("sessions").out
    (row,) = call("sessions --json").json["sessions"]
    assert {each["question"] for each in row["wellbeing"]} == {"pain", "place", "fatigue"}


def test_the_answers_of_a_participant_are_listed(call: Call, data: Path, simulated: str) -> None:
    said = " ".join(call("wellbeing p01").out.split())
    assert (
        'Pain: 2 before, 5 after (left shoulder), "in pain" in a pause. Tiredness: would rather '
        "not say" in said
    )
    assert [
        word for word in ("fatigue", "moment", "answer", wellbeing.NOT_SAID) if word in said
    ] == []
    found = call("wellbeing P01 --json").json
    assert (found["participant"], len(found["wellbeing"]), found["tell_therapist"]) == (
        "P01",
        6,
        [],
    )
    assert call("wellbeing P1") == (2, "", "There is no participant P1. Is it P01?\n")
    assert call("wellbeing", "Jane Doe").code == 2


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
            wellbeing.save(database, "P01", "after", "pain", pain, session=str(number))
    assert (
        "! Pain is new: some in each of the last four sessions, and none before."
        in call("wellbeing P01").out
    )
    assert call("wellbeing P01 --json").json["tell_therapist"] == ["new pain"]


# --- adverse events


def test_an_adverse_event_is_recorded_and_amended(call: Call, data: Path, simulated: str) -> None:
    added = call("adverse add p01", *FALL, "--session", simulated, "--json").json["adverse_event"]
    assert (added["version"], added["onset"], added["session"]) == (
        1,
        "2026-03-01 14:30",
        simulated,
    )
    amended = call("adverse amend", added["event"], "--action", "Rested", "--outcome", "No injury")
    assert amended.code == 0
    (now,) = call("adverse list -p P01 --json").json["adverse_events"]
    assert (now["version"], now["what"], now["action"], now["outcome"]) == (
        2, "Fell from the chair", "Rested", "No injury",
    )  # fmt: skip
    versions = call("adverse show", added["event"], "--json").json["versions"]
    assert [(one["version"], one["outcome"]) for one in versions] == [(1, ""), (2, "No injury")]
    assert (
        "! Adverse event 2026-03-01 14:30, moderate: Fell from the chair."
        in call("wellbeing P01").out
    )
    shown = call("show", simulated).out
    assert (
        f"! Adverse event {added['event']}, moderate: Fell from the chair. Action: Rested. "
        "Outcome: No injury." in shown
    )
    assert call("show", simulated, "--json").json["adverse_events"] == [now]


def test_people_are_told_what_is_still_missing(call: Call, data: Path) -> None:
    with closing(connect(data)) as database:
        participants.add(database, "P02")
    said = call("adverse add P01", *FALL, "--action", "Rested").out
    assert said.endswith("--outcome …`.\n")
    assert "--action" not in said
    assert "Fell from the chair" in call("adverse list").out
    assert call("adverse list -p P02").out == "There are no adverse events of P02.\n"


def test_the_advice_not_to_train_and_what_came_of_it_are_told(call: Call, tmp_path: Path) -> None:
    with closing(connect(tmp_path / "data")) as database:
        for question, answer in (("pain", "9"), ("advice", "shown"), ("advice", "stopped")):
            wellbeing.save(database, "P01", "before", question, answer)  # type: ignore[arg-type]
    said = " ".join(call("wellbeing P01").out.split())
    assert "! Pain was above the limit when it was last told. Tell the therapist." in said
    assert "Advised before the session not to train. They stopped." in said
    assert call("wellbeing P01 --json").json["tell_therapist"] == ["stop", "stopped"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("P99", *FALL), "There is no participant P99: add --new for a new participant."),
        (("P01", *FALL, "--severity", "awful"), "The severity must be mild, moderate or severe."),
        (("P01", *FALL, "--onset", "yesterday"), "The onset must be a date, such as 2026-03-01"),
        (("P01", *FALL, "--onset", "2026-02-30"), "The onset must be a date, such as 2026-03-01"),
        (
            ("P01", *FALL, "--onset", f"{datetime.now() + timedelta(days=2):%Y-%m-%d}"),
            "is in the future.",
        ),
        (("P01", *FALL, "--what", "  "), "Say what happened, in a few words."),
        (("P01", *FALL, "--session", "nowhere"), "There is no session nowhere."),
    ],
)
def test_bad_input_is_refused_in_a_sentence(
    call: Call, data: Path, arguments: tuple[str, ...], says: str
) -> None:
    called = call("adverse add", *arguments)
    assert called.code == 2
    assert says in called.err
    assert call("adverse list --json").json == {"adverse_events": []}


def test_an_amendment_must_change_something_that_exists(call: Call, data: Path) -> None:
    event = call("adverse add P01", *FALL, "--json").json["adverse_event"]["event"]
    for arguments in ((event,), (event, "--severity", "moderate"), ("ffffff", "--outcome", "well")):
        assert call("adverse amend", *arguments).code == 2
    assert len(call("adverse show", event, "--json").json["versions"]) == 1
    assert call("adverse show ffffff").code == 2


def test_the_session_of_an_event_must_be_the_participants(
    call: Call, data: Path, simulated: str
) -> None:
    with closing(connect(data)) as database:
        participants.add(database, "P02")
    called = call("adverse add P02", *FALL, "--session", simulated)
    assert (called.code, f"The session {simulated} is not one of P02." in called.err) == (2, True)
