"""The check of a task reports, text by text, what its translation lacks."""

import re
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.checks.task import check
from sar_tui.checks.task_translations import remarks_in, texts_in
from tests.program import Call

CHECK = "has all its texts in each of its languages"
TASK = """
from sar_tui.loop.task import Metric, Quality, Result, Stimulus, Task

_AGAIN = {"gap": "Once more.", "slow": ("Wait.", "Rest.")}


class Arrows(Task):
    name = "arrows"
    title = "Arrows"
    metric = Metric("reaction_time", unit="ms", better="lower", improved="faster", worsened="slower")

    def instructions(self):
        return self.tr("Press the {count} arrows.", count=4)

    def stimulus(self, situation):
        key = situation.streams.choice(("left", "right"), "order")
        return Stimulus(name=key, expected=key, text=self.tr("Press: {key}", key=key), choices=2)

    def perceived(self, trial, percept):
        right = percept.key == trial.stimulus.expected
        remark = self.tr(_AGAIN["gap"])
        return Result(correct=right, response=percept.key, response_at=percept.at, value=1.0, remark=remark)
"""
WORDS = {
    "Arrows": "Flechas",
    "reaction time (ms)": "tiempo de reacción (ms)",
    "faster": "más rápido",
    "slower": "más lento",
    "Press the {count} arrows.": "Pulse las {count} flechas.",
    "Press: {key}": "Pulse: {key}",
    "Once more.": "Una vez más.",
    "Wait.": "Espere.",
    "Rest.": "Descanse.",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A task that asks for its texts in every way there is."""
    folder = tmp_path / "mine" / "arrows"
    folder.mkdir(parents=True)
    (folder / "task.py").write_text(TASK)
    return folder


def translate(folder: Path, words: dict[str, str]) -> None:
    lines = (f'"{english}" = {own}' for english, own in words.items())
    (folder / "words.es.toml").write_text("\n".join(lines), encoding="utf-8")


def problem(folder: Path, name: str = CHECK) -> str:
    """Return the problems that a check finds; later checks are not made."""
    return " ".join(next(done.problems for done in check(folder) if done.check == name))


def quoted(words: dict[str, str]) -> dict[str, str]:
    return {english: f'"{own}"' for english, own in words.items()}


def test_each_untranslated_text_is_reported_without_those_of_the_framework(folder: Path) -> None:
    translate(folder, quoted(WORDS))
    assert problem(folder) == ""
    translate(folder, {})
    lacks = re.findall(
        r"task\.py:\d+: words\.es\.toml has no translation of '(.*?)'\.", problem(folder)
    )
    assert sorted(lacks) == sorted(WORDS)


@pytest.mark.parametrize(
    ("own", "reported"),
    [
        ('"Pulse: {tecla}"', "lacks {key}."),
        ('"Pulse: {key} {tecla}"', "has {tecla}, which the English does not have."),
        ('"Pulse: {key"', "has broken slots (expected '}' before end of string)."),
    ],
)
def test_translations_with_other_slots_are_reported(folder: Path, own: str, reported: str) -> None:
    translate(folder, {**quoted(WORDS), "Press: {key}": own})
    assert problem(folder) == f"The translation of 'Press: {{key}}' in words.es.toml {reported}"


def test_a_translation_that_is_not_text_is_reported(call: Call, folder: Path) -> None:
    translate(folder, {**quoted(WORDS), "Arrows": "5"})
    assert problem(folder) == "The translation of 'Arrows' in words.es.toml is not a text."
    called = call("tasks", "check", folder)
    assert (called.code, f"✗ {CHECK}. The translation of 'Arrows'" in called.out) == (1, True)


def test_an_invalid_toml_file_is_reported(folder: Path) -> None:
    (folder / "words.es.toml").write_text("Pulse = = {")
    assert problem(folder).startswith("words.es.toml cannot be read: ")


def test_a_broken_translation_is_shown_in_english(call: Call, folder: Path, tmp_path: Path) -> None:
    translate(folder, {**quoted(WORDS), "Press: {key}": '"Pulse: {tecla}"'})
    settings = ("--set", "language=es", "--attempts", 1, "--tasks", folder.parent)
    assert call("simulate", "arrows", "--user", "competent", *settings).code == 0
    with closing(sqlite3.connect(tmp_path / "data" / "sar-tui.db")) as database:
        read = "".join(message for (message,) in database.execute("SELECT message FROM events"))
    assert '"text":"Press: ' in read
    assert "Pulse: " not in read
    assert "intento 1 de 1" in read


# --- numbers

NUMBERS = "gives feedback in words without numbers"
WITHOUT_NUMBERS = TASK.replace("Once more.", "That slipped.")


@pytest.mark.parametrize(
    ("declared", "old", "new", "reported"),
    [
        ("", 'improved="faster"', 'improved="twice as fast"', "twice as fast"),
        ("", 'worsened="slower"', 'worsened="half as fast"', "half as fast"),
        ("", '"gap": "That slipped."', '"gap": "Do 2 more."', "Do 2 more."),
        ('marks = (Mark("m", "f7", "M", False, "One was missed."),)', "", "", "One was missed."),
        ('qualities = (Quality("s", "lower", "twice as steady", "well", 1.0),)', "", "", "twice as steady"),
        ('qualities = (Quality("s", "lower", "steadier", "in one go", 1.0),)', "", "", "in one go"),
    ],
)  # fmt: skip
def test_a_number_in_a_remark_is_reported(
    folder: Path, declared: str, old: str, new: str, reported: str
) -> None:
    title = '    title = "Arrows"\n'
    source = WITHOUT_NUMBERS.replace("import Metric, ", "import Mark, Metric, ").replace(old, new)
    (folder / "task.py").write_text(source.replace(title, f"{title}    {declared}\n"))
    assert (
        problem(folder, NUMBERS) == f"{reported!r} holds a number (en); feedback in words has none."
    )


def test_a_number_in_a_translated_remark_is_reported_with_its_language(
    call: Call, folder: Path
) -> None:
    (folder / "task.py").write_text(WITHOUT_NUMBERS)
    assert problem(folder, NUMBERS) == ""
    translate(folder, quoted({**WORDS, "That slipped.": "Se soltaron dos."}))
    said = "'Se soltaron dos.' holds a number (es); feedback in words has none."
    assert problem(folder, NUMBERS) == said
    call("tasks check", folder).shows(f"✗ {NUMBERS}. {said}", code=1)


@pytest.mark.parametrize(
    ("source", "texts"),
    [
        ('Result(correct=False, remark=self.tr("a"))', {"a"}),
        ('Result(correct=False, remark=tr("a" if x else "b"))\ntr("c")', {"a", "b"}),
        ('A = {"k": "a"}\nwhy = tr(A[x])\nAgain("k", why)', {"a"}),
        ('Again(reason="k", text=self.tr("a"))', {"a"}),
        ('task.Again("k", "a")', {"a"}),
        ('Other("k", tr("a"))', set()),
    ],
)
def test_remarks_are_found_however_they_are_built(source: str, texts: set[str]) -> None:
    assert remarks_in(source) == texts


# --- where the texts are found


@pytest.mark.parametrize(
    ("source", "texts"),
    [
        ('self.tr("a")', {"a"}),
        ('tr("a" "b")', {"ab"}),
        ('tr("a" if x else "b")', {"a", "b"}),
        ('A = "a"\ntr(A)', {"a"}),
        ('A: dict[str, str] = {"k": "a"}\ntr(A[x])', {"a"}),
        ('A = {"k": "a"}\ntr(A.get(x, "b"))', {"a", "b"}),
        ('A = {"k": ("a", "b")}\nfirst, last = A[x]\ntr(first)', {"a", "b"}),
        ('A = ("a", "b")\n[tr(each) for each in A]', {"a", "b"}),
        ('A = ("a", "b")\nfor each in A:\n    tr(each)', {"a", "b"}),
        ("f\"{tr('a')} b\"", {"a"}),
        ("a = a\ntr(a)", set()),
        ('tr(x.title)\ntr()\nother("a")\ntr("")', set()),
    ],
)
def test_texts_are_found_however_they_are_passed(source: str, texts: set[str]) -> None:
    assert texts_in(source) == texts
