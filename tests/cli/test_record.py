"""``sar-tui record``: adverse events, scores, pain and tiredness, for people and programs."""

import csv
from contextlib import closing
from datetime import datetime, timedelta
from pathlib import Path

import pytest

from sar_tui.records.kind import NOT_SAID, kinds
from sar_tui.store import participants, records
from sar_tui.store.database import connect
from sar_tui.store.forms import FormAnswers, Occasion
from sar_tui.store.training_days import utc
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
            pause = ("x-1", simulated, "A", "pain", utc())
            database.execute(records.PAUSES, pause)
    return folder


def test_a_session_shows_what_the_participant_said(call: Call, data: Path, simulated: str) -> None:
    call("show", simulated).shows(
        'Pain: 2 before, 5 after (left shoulder), "in pain" in a pause.',
        "Tiredness: would rather not say before, 10 after.",
        "That was a reason to stop and to tell the therapist.",
    )
    known = call("show", simulated, "--json").json["records"]
    assert sorted(row["kind"] for row in known) == [*["pain"] * 3, *["tiredness"] * 2]
    call("sessions").shows("completed, simulated, pain 5/10, tired 10/10")
    with closing(connect(data)) as database:
        told(database, "P01", "pause", "pain", "9", session=simulated)
    call("show", simulated).shows('"in pain" in a pause (9).')
    call("sessions").shows("pain 9/10")


@pytest.mark.usefixtures("data")
def test_the_records_of_a_participant_are_listed(call: Call) -> None:
    call("record list -p p01").shows("left shoulder")
    found = call("record list pain -p P01 --json").json
    assert [len(found["records"]), found["tell_therapist"]] == [3, []]
    call("record list -p P02").shows("There are no records of P02.\n")
    call("record kinds").shows(*kinds())
    listed = call("record kinds --json").json["kinds"]
    assert [each["name"] for each in listed] == list(kinds())


def test_the_therapist_is_told_of_pain_that_is_new_over_four_sessions_and_of_advice(
    call: Call, data: Path
) -> None:
    with closing(connect(data)) as database:
        for number, pain in enumerate(("0", "2", "1", "3", "2")):
            row = "INSERT INTO sessions (id, task, status, mode) VALUES (?, ?, ?, 'live')"
            database.execute(row, (number, "keyboard", "completed"))
            database.execute("INSERT INTO seats VALUES (?, 'A', 'P01')", (number,))
            told(database, "P01", "after", "pain", pain, session=str(number))
    assert call("record list -p P01").out.startswith("! Pain is new")
    assert call("record list -p P01 --json").json["tell_therapist"] == ["new pain"]
    with closing(connect(data)) as database:
        for question, answer in (("pain", "9"), ("advice", "shown"), ("advice", "stopped")):
            told(database, "P02", "before", question, answer)
    found = call("record list -p P02 --json").json
    assert found["tell_therapist"] == ["stop", "stopped"]
    (pain,) = found["records"]
    assert (pain["version"], pain["content"]["advice"]) == (3, "stopped")


@pytest.mark.usefixtures("data")
def test_an_adverse_event_is_recorded_and_corrected(call: Call, simulated: str) -> None:
    added = call(*EVENT, "p01", *FALL, "--session", simulated, "--json").json["record"]
    assert (added["at"], added["session"]) == ("2026-03-01 14:30", simulated)
    said = call("record", "correct", added["id"], "action=Rested", "outcome=No injury")
    assert said.code == 0
    (now,) = call("record list adverse-event --json").json["records"]
    assert (now["version"], now["content"]["outcome"]) == (2, "No injury")
    versions = call("record", "show", added["id"], "--json").json["versions"]
    assert [one["version"] for one in versions] == [1, 2]
    call("show", simulated).shows(f"! Adverse event {added['id']}, moderate: Fell from the chair.")
    assert call("record", "correct", added["id"], "--remove").code == 0
    call("record list adverse-event").shows("There are no records")
    said = call(*EVENT, "P01", *FALL, "action=Rested").out
    assert ("outcome=…" in said, "action=…" in said) == (True, False), "what is still missing"


def test_scores_appear_in_progress_with_their_sources(call: Call) -> None:
    for score in ("score=34 --on 2026-03-01 --new", "score=45 --on 2026-05-01"):
        call(f"record add fma-ue p01 {score}").shows("is recorded.")
    shown = " ".join(call("progress P01").out.split())
    assert "34 on 2026-03-01, 45 on 2026-05-01; change +11. Reaches MDC95 6.82 points" in shown
    assert "limit of agreement; interval: 2 weeks (van der Lee 2001" in shown
    added = call("record add BBT P09 score=30 --new --json").json["record"]
    today = datetime.strptime(added["at"], "%Y-%m-%d")
    assert timedelta(0) <= datetime.now() - today < timedelta(days=2), (
        "today, unless said otherwise"
    )
    without = call("progress P09 --json").json
    assert (without["lines"], without["days"], len(without["instruments"])) == ([], [], 1)
    spanish = " ".join(call("progress P01 --note --language es").out.split())
    assert "cambio +11. Alcanza MDC95 6,82 puntos, 51 personas, 1 a 6 semanas" in spanish
    assert "doi:10.1177/15459683231186985" in spanish
    (found,) = call("progress P01 --json").json["instruments"]
    assert (found["instrument"]["name"], found["change"]) == ("FMA-UE", 11.0)
    assert [each["reached"] for each in found["reached"]] == [True] * 5


@pytest.mark.parametrize(
    ("who", "more", "says"),
    [
        ("P99", (), "There is no participant P99: add --new for a new participant."),
        ("P01", ("severity=awful",), "Severity is mild, moderate or severe"),
        ("P01", ("--on", "yesterday"), "Onset is a date, such as 2026-03-01"),
        ("P01", ("--on", f"{datetime.now() + timedelta(days=2):%Y-%m-%d}"), "in the future"),
        ("P01", ("what= ",), "Say what happened, in a few words."),
        ("P01", ("colour=red",), "adverse-event has no field colour."),
        ("P01", ("mild",), "A value is given as FIELD=VALUE"),
        ("P01", ("--session", "nowhere"), "There is no session nowhere."),
        ("P02", ("--session", "last"), "is not one of P02."),
    ],
)
@pytest.mark.usefixtures("data")
def test_bad_input_is_refused_in_a_sentence(
    call: Call, who: str, more: tuple[str, ...], says: str
) -> None:
    call(*EVENT, who, *FALL, *more).refused(says)
    assert call("record list adverse-event --json").json["records"] == []


def test_a_form_on_paper_is_entered_scored_and_corrected(call: Call) -> None:
    items = [f"q{number}={5 if number % 2 else 1}" for number in range(1, 10)]
    added = call("record add SUS P01", *items, "--new", "--json").json["record"]
    assert (added["content"]["score"], added["content"]["score_missing"]) == (95.0, 1)
    call("record list -p P01").shows("Usability 95 (0 to 100, 1 missing)")
    changed = call("record correct", added["id"], "q10=1", "q1=not said", "--json").json["record"]
    assert changed["content"]["score"] == 95.0
    call("record show", added["id"]).shows("q1: not said", "score: 95.0")
    call("record add Godspeed P01 q1=3").refused("Godspeed may be used only if its owner allows it")
    call("record kinds").shows("form of 24 items")
    call("record add SUS P01 q1=6").refused("lies within 1 to 5, not at 6.")
    call("record add SUS P01").refused("System Usability Scale has no answers.")
    call("record fill SUS P01").refused("terminal")
    shown = " ".join(call("progress P01").out.split())
    assert "System Usability Scale" in shown or "SUS" in shown


@pytest.mark.usefixtures("simulated")
def test_a_form_that_was_filled_in_leaves_once_with_its_scores(call: Call, tmp_path: Path) -> None:
    sus = kinds()["SUS"]
    with closing(connect(tmp_path / "data")) as database:
        for _ in range(2):
            answers = FormAnswers(database, sus, Occasion("P01"))
            for item in sus.items:
                answers.answer(item, None if item.name == "q3" else 4, 1200)
        begun = FormAnswers(database, sus, Occasion("P01", moment="before"))
        begun.answer(sus.items[0], 2, 900)
        begun.answer(sus.items[1], 2, 900)
    assert call("export --all --simulated --to", tmp_path / "out").code == 0
    with (tmp_path / "out" / "records.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    by_record: dict[str, dict[str, dict[str, str]]] = {}
    for row in rows:
        by_record.setdefault(row["record"], {})[row["field"]] = row
    assert len(rows) == sum(map(len, by_record.values())), "one version of each leaves"
    *complete, last = by_record.values()
    assert len(complete) == 2
    for found in complete:
        assert float(found["score"]["value"]) == 47.5
        assert float(found["score_missing"]["value"]) == 1
        assert found["q3"]["option"] == "not said"
        assert (float(found["q1"]["value"]), float(found["q1_ms"]["value"])) == (4, 1200)
        assert (found["status"]["option"], found["language"]["option"]) == ("complete", "en")
    assert (last["status"]["option"], last["q2"]["version"]) == ("open", "2")


def test_forms_leave_for_redcap_and_come_back(call: Call, tmp_path: Path) -> None:
    call("record redcap SUS --to", tmp_path / "sus.zip").shows("Written:")
    call("record redcap SUS --to", tmp_path / "sus.zip").refused("File exists")
    call("record redcap Godspeed --to", tmp_path / "g.zip").refused("is not here")
    call("record redcap SUS --language de --to", tmp_path / "g.zip").refused("has no words in 'de'")
    several = call("record redcap SUS effort --to", tmp_path / "all", "--json").json["files"]
    assert [Path(name).name for name in several] == ["sus.zip", "effort.zip"]
    found = call(
        "record from-redcap", tmp_path / "sus.zip", "--to", tmp_path / "own", "--json"
    ).json
    assert found == {
        "forms": [
            {
                "form": "sus",
                "file": str(tmp_path / "own" / "sus.toml"),
                "refused": [],
                "left_out": [],
            }
        ]
    }
    call("record from-redcap", tmp_path / "nothing.csv").refused("cannot be read")
    known = call("record from-redcap", tmp_path / "sus.zip")
    assert known.code == 1
    assert "There is a kind of record SUS already." in known.out
