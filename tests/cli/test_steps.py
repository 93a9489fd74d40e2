"""Questions between attempts from the command line: simulated, stored, replayed, exported."""

import csv
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.reports.session_facts import lines
from sar_tui.store.records import Record

Call = Callable[..., Any]
KEYBOARD = "simulate keyboard --user average --attempts 2 --seed 2".split()
SHORT = ("--set", "prompts_per_attempt=2")
STEPS = """
[[steps]]
name = "read"
text = "Next comes the harder part."
before = true

[[steps]]
name = "mood"
kind = "line"
text = "How do you feel?"
labels = ["very bad", "very good"]
every = 1

[[steps]]
name = "words"
kind = "text"
text = "Anything else?"
"""


@pytest.fixture
def asked(call: Call, tmp_path: Path) -> Path:
    """Return the data folder of a simulated session with questions from a file and from the
    settings.
    """
    file = tmp_path / "steps.toml"
    file.write_text(STEPS)
    data = tmp_path / "data"
    assert (
        call(*KEYBOARD, *SHORT, "--steps", file, "--set", "questions=effort", "--data", data).code
        == 0
    )
    return data


def rows(data: Path, sql: str) -> list[tuple[Any, ...]]:
    with closing(sqlite3.connect(data / "sar-tui.db")) as database:
        return database.execute(sql).fetchall()


def test_answers_are_stored_apart_from_trials_and_scores(asked: Path) -> None:
    found = rows(asked, "SELECT attempt, step, kind, status FROM answers ORDER BY number")
    assert [row[:3] for row in found] == [
        (0, "read", "screen"), (1, "mood", "line"), (2, "effort", "borg"), (2, "mood", "line"),
        (2, "words", "text"),
    ]  # fmt: skip
    assert {row[3] for row in found} <= {"done", "answered", "declined"}
    assert rows(asked, "SELECT count(*) FROM answers WHERE answered_ns <= shown_ns") == [(0,)]


def test_a_session_with_questions_replays_identically(call: Call, asked: Path) -> None:
    replayed = call("replay last --data", asked)
    assert (replayed.code, "identical" in replayed.out) == (0, True)


def test_typed_words_leave_only_with_notes(call: Call, asked: Path, tmp_path: Path) -> None:
    (typed,) = rows(asked, "SELECT answer, status FROM answers WHERE kind='text'")
    assert typed[1] == "answered"
    for more, has_words in (((), False), (("--with-notes",), True)):
        folder = tmp_path / f"export{has_words}"
        assert call("export --all --simulated", *more, "--data", asked, "--to", folder).code == 0
        with (folder / "answers.csv").open() as file:
            table = list(csv.DictReader(file))
        assert ("words" in table[0]) is has_words
        assert [row["labels"] for row in table if row["step"] == "mood"] == [
            "very bad; very good"
        ] * 2
        assert all(0 <= float(row["value"]) <= 100 for row in table if row["value"])
        assert (typed[0].strip('"') in (folder / "answers.csv").read_text()) is has_words


def test_steps_that_cannot_be_used_are_refused(call: Call, tmp_path: Path) -> None:
    file = tmp_path / "steps.toml"
    file.write_text('[[steps]]\nname="a"\ntext="A"\nkind="likert"\n')
    refused = call(*KEYBOARD, "--steps", file)
    assert (refused.code, "needs 2 to 9 labels" in refused.err) == (2, True)
    refused = call(*KEYBOARD, "--set", "questions=mood")
    assert (refused.code, 'There is no question "mood"' in refused.err) == (2, True)


def test_answers_are_shown_with_the_session(call: Call, asked: Path) -> None:
    shown = call("show last --data", asked).out
    assert "After attempt 1: How do you feel? " in shown
    assert "After attempt 2: How hard was that for you? " in shown
    assert "Next comes the harder part." not in shown
    known = call("show", "last", "--data", asked, "--json").json["records"]
    answers = [each["content"] for each in known if each["kind"] == "answer"]
    assert [each["step"] for each in answers] == ["read", "mood", "effort", "mood", "words"]
    assert answers[1]["labels"] == "very bad; very good"


def test_simulated_people_agree_to_what_is_required(call: Call, tmp_path: Path) -> None:
    file = tmp_path / "steps.toml"
    consent = (
        'name="consent"\nkind="choice"\ntext="Do you agree?"\nlabels=["no", '
        '"yes"]\nrequired="yes"\nbefore=true'
    )
    file.write_text(f"{STEPS}\n[[steps]]\n{consent}\n")
    done = call(*KEYBOARD, *SHORT, "--steps", file, "--set", "language=es", "--json").json
    known = call("show", done["session"], "--json").json["records"]
    answers = [each["content"] for each in known if each["kind"] == "answer"]
    assert [(each["step"], each.get("chosen")) for each in answers[:2]] == [
        ("consent", "yes"),
        ("read", None),
    ]
    assert call("replay", done["session"]).code == 0
    file.write_text(f"[[steps]]\n{consent.replace('before=true', 'every=1')}\n")
    refused = call(*KEYBOARD, "--steps", file)
    assert (refused.code, "it comes before the first attempt only" in refused.err) == (2, True)


def test_answers_are_told_in_words() -> None:
    def answer(attempt: int, seat: str = "A", status: str = "answered", **given: Any) -> Record:
        content = {"attempt": attempt, "status": status, "question": "Fun?", **given}
        return Record(id="1", kind="answer", participant="P01", at="", seat=seat, content=content)

    known = [
        answer(0, value=2, chosen="yes"),
        answer(3, chosen="no; yes"),
        answer(3, words="fine"),
        answer(4, status="declined"),
        answer(0, status="done"),
    ]
    assert lines(known, practice=0) == [
        "Before the first attempt: Fun? 2 (yes)",
        "After attempt 3: Fun? no; yes",
        'After attempt 3: Fun? "fine"',
        "After attempt 4: Fun? would rather not say",
    ]
    other = answer(0, seat="B", value=1, chosen="no")
    assert lines([*known, other], practice=0)[-1] == (
        "Before the first attempt, seat B: Fun? 1 (no)"
    )


def test_two_steps_of_one_name_are_refused_wherever_they_come_from(
    call: Call, tmp_path: Path
) -> None:
    file = tmp_path / "steps.toml"
    file.write_text(STEPS.replace('"mood"', '"effort"'))
    called = call(*KEYBOARD, *SHORT, "--steps", file, "--set", "questions=effort")
    assert (called.code, "Two steps are named 'effort'." in called.err) == (2, True)


def test_show_counts_the_attempts_of_answers_as_its_table_does(call: Call) -> None:
    settings = (
        "--set",
        "questions=effort",
        "--set",
        "questions_every=1",
        "--set",
        "practice_attempts=1",
    )
    done = call(*KEYBOARD, *SHORT, *settings, "--json")
    shown = " ".join(call("show", done.json["session"]).out.split())
    assert [f"After attempt {number}: How hard" in shown for number in (1, 2, 3)] == [
        False,
        True,
        True,
    ]
