"""Questions between attempts from the command line: simulated, stored, replayed, exported."""

import csv
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from sar_tui.reports.session_facts import lines
from sar_tui.store.records import Record
from tests.program import Call

KEYBOARD = "simulate keyboard --user average --attempts 2 --seed 2"
SHORT = f"{KEYBOARD} --set prompts_per_attempt=2"
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
CONSENT = """name = "consent"
kind = "choice"
text = "Do you agree?"
labels = ["no", "yes"]
required = "yes"
before=true"""


@pytest.fixture
def asked(call: Call, tmp_path: Path) -> Path:
    """Return the data folder of a simulated session with questions from a file and from the
    settings.
    """
    (tmp_path / "steps.toml").write_text(STEPS)
    assert call(f"{SHORT} --set questions=exertion --steps {tmp_path}/steps.toml").code == 0
    return tmp_path / "data"


def answers(call: Call, session: str) -> list[dict[str, Any]]:
    known = call("show", session, "--json").json["records"]
    return [each["content"] for each in known if each["kind"] == "answer"]


def rows(data: Path, sql: str) -> list[tuple[Any, ...]]:
    with closing(sqlite3.connect(data / "sar-tui.db")) as database:
        return database.execute(sql).fetchall()


def test_answers_are_stored_apart_from_trials_and_scores_and_shown(call: Call, asked: Path) -> None:
    found = rows(asked, "SELECT attempt, step, kind, status FROM answers ORDER BY number")
    assert [row[:3] for row in found] == [
        (0, "read", "screen"), (1, "mood", "line"), (2, "exertion", "number"), (2, "mood", "line"),
        (2, "words", "text"),
    ]  # fmt: skip
    assert {row[3] for row in found} <= {"done", "answered", "declined"}
    assert rows(asked, "SELECT count(*) FROM answers WHERE answered_ns <= shown_ns") == [(0,)]
    call("show last").shows("After attempt 1: How do you feel? ")
    assert answers(call, "last")[1]["labels"] == "very bad; very good"


def test_typed_words_leave_only_with_notes(call: Call, asked: Path, tmp_path: Path) -> None:
    (typed,) = rows(asked, "SELECT answer, status FROM answers WHERE kind='text'")
    assert typed[1] == "answered"
    for more, has_words in (("", False), ("--with-notes", True)):
        folder = tmp_path / f"export{has_words}"
        assert call(f"export --all --simulated {more} --to", folder).code == 0
        text = (folder / "answers.csv").read_text()
        table = list(csv.DictReader(text.splitlines()))
        assert (("words" in table[0]), (typed[0].strip('"') in text)) == (has_words, has_words)
        labels = [row["labels"] for row in table if row["step"] == "mood"]
        assert labels == ["very bad; very good"] * 2
        assert all(0 <= float(row["value"]) <= 100 for row in table if row["value"])


def test_steps_that_cannot_be_used_are_refused(call: Call, tmp_path: Path) -> None:
    """The faults of a file of steps have their table in tests/model/test_steps.py."""
    for steps, questions, said in (
        ('[[steps]]\nname="a"\ntext="A"\nkind="likert"', "exertion", "needs 2 to 9 labels"),
        (STEPS, "mood", 'There is no question "mood"'),
        (STEPS.replace('"mood"', '"exertion"'), "exertion", "Two steps are named 'exertion'."),
    ):
        (tmp_path / "steps.toml").write_text(steps)
        command = f"{SHORT} --steps {tmp_path}/steps.toml --set questions={questions}"
        call(command).refused(said)


def test_simulated_people_agree_to_what_is_required(call: Call, tmp_path: Path) -> None:
    (tmp_path / "steps.toml").write_text(f"{STEPS}\n[[steps]]\n{CONSENT}\n")
    spanish = f"{SHORT} --steps {tmp_path}/steps.toml --set language=es --json"
    session = call(spanish).json["session"]
    consent, read, *_ = answers(call, session)
    assert (consent["step"], consent["chosen"]) == ("consent", "yes")
    assert (read["step"], read.get("chosen")) == ("read", None)
    assert call("replay", session).code == 0


def test_answers_are_told_in_words() -> None:
    def answer(attempt: int, seat: str = "A", status: str = "answered", **given: Any) -> Record:
        content = {"attempt": attempt, "status": status, "question": "Fun?", **given}
        return Record(id="1", kind="answer", participant="P01", at="", seat=seat, content=content)

    given = [
        (answer(0, value=2, chosen="yes"), "Before the first attempt: Fun? 2 (yes)"),
        (answer(3, chosen="no; yes"), "After attempt 3: Fun? no; yes"),
        (answer(3, words="fine"), 'After attempt 3: Fun? "fine"'),
        (answer(4, status="declined"), "After attempt 4: Fun? would rather not say"),
    ]
    known = [*(record for record, _ in given), answer(0, status="done")]
    assert lines(known, practice=0) == [told for _, told in given]
    other = answer(0, seat="B", value=1, chosen="no")
    told = lines([*known, other], practice=0)[-1]
    assert told == "Before the first attempt, seat B: Fun? 1 (no)"
    assert lines([answer(1, words="fine")], practice=1) == ['After attempt 2: Fun? "fine"']
