"""The operator's file, phrases and their slots, the palette."""

from pathlib import Path

import pytest

from sar_tui.link.peer import Connection
from sar_tui.loop import topics as t
from sar_tui.model import messages as m
from sar_tui.model.theme import Theme
from sar_tui.operator.keymap import EVENTS, FILE, KEY_COMMANDS, KeymapFile, is_key, key_name, read
from sar_tui.operator.palette import PER_PAGE, PhraseBook, pages
from sar_tui.operator.phrases import Phrase, fill, slot_values
from sar_tui.operator.session_state import SessionState
from sar_tui.plugins import Catalogue
from tests.operator import panel_driver as b


@pytest.fixture
def theme(catalogue: Catalogue) -> Theme:
    return catalogue.theme("calm")


@pytest.fixture
def state(theme: Theme) -> SessionState:
    return (
        SessionState()
        .receive(Connection("connected"))
        .receive(b.welcome(marks=b.MARKS))
        .receive(b.session_frames(theme))
    )


def test_without_a_file_the_defaults_apply_and_each_key_has_one_command(tmp_path: Path) -> None:
    file, problem = read(tmp_path)
    assert (problem, file.events) == ("", EVENTS)
    keys = [key for key_command in KEY_COMMANDS for key in file.keys_of(key_command)]
    assert len(keys) == len(set(keys))
    assert all(is_key(key) for key in keys)


def test_a_file_changes_keys_phrases_and_events(tmp_path: Path) -> None:
    (tmp_path / FILE).write_text(
        'phrases = ["Go on, {participant}.", {text = "Fine.", valence = "positive", gesture = '
        '"nod"}]\n'
        'events = ["noise"]\n[keys]\napprove = "y,+"\npositive = "p"\nphrases = "v"\n'
    )
    file, problem = read(tmp_path)
    assert problem == ""
    assert file.keymap == {
        "wizard-approve": "y,plus",
        "wizard-positive": "p",
        "wizard-phrases": "v",
    }
    assert file.own_phrases == (Phrase("Go on, {participant}."), Phrase("Fine.", "positive", "nod"))
    assert file.events == ("noise",)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[keys]\napprov = 'y'", "there is no command 'approv'"),
        ("[keys]\napprove = 'x'", "the key x is used for both approve and veto"),
        ("[keys]\napprove = 'hyperspace'", "'hyperspace', for approve, is not the name of a key"),
        ("phrases = ['You are {better}.']", "has an unknown slot"),
        ("phrases = ['You are {level']", "has broken slots"),
        ("phrases = ['']", "is not one line of at most 400 characters"),
        ("events = [1]", "Expected `str`"),
        ("colour = 'red'", "unknown field"),
        ("[keys", "Expected ']'"),
    ],
)
def test_an_invalid_file_is_ignored_and_one_sentence_says_why(
    tmp_path: Path, text: str, why: str
) -> None:
    (tmp_path / FILE).write_text(text)
    file, problem = read(tmp_path)
    assert file == KeymapFile()
    assert why in problem
    assert FILE in problem


def test_an_unreadable_file_is_ignored(tmp_path: Path) -> None:
    (tmp_path / FILE).write_bytes(b"\xff\xfe")
    assert "is ignored" in read(tmp_path)[1]
    (tmp_path / FILE).unlink()
    (tmp_path / FILE).mkdir()
    assert "cannot be read" in read(tmp_path)[1]


def test_keys_are_named_as_on_the_keyboard() -> None:
    called = [key_name(key) for key in ("enter", "plus", "ctrl+t", "f2", "escape", "x")]
    assert called == ["Enter", "+", "Ctrl-T", "F2", "Esc", "x"]


def test_slots_are_filled_from_the_state(state: SessionState) -> None:
    phrase = Phrase("{participant}: {result} of {goal}, attempt {attempt}, level {level}.")
    assert (
        fill(phrase, slot_values(state, "A")).text
        == "P01: 0.50 seconds of 0.52 seconds, attempt 3, level 4."
    )


def test_a_phrase_cannot_be_chosen_while_a_slot_has_no_value() -> None:
    known = SessionState().receive(Connection("connected")).receive(b.welcome())
    page = pages(
        known, PhraseBook.of(known, KeymapFile(phrases=("Last: {result}.", "Good."))), "A"
    )[0]
    assert [(item.why, item.topic is None) for item in page.items] == [
        ("{result} is not known yet", True),
        ("", False),
    ]


def test_own_phrases_come_first_then_the_themes_by_heading(
    state: SessionState, theme: Theme
) -> None:
    found = pages(state, PhraseBook.of(state, KeymapFile(phrases=("Hello, {participant}.",))), "A")
    assert [page.title for page in found][:3] == ["Yours", "Encourage", "Praise"]
    assert found[0].items[0].text == "Hello, P01."
    assert [item.text for item in found[1].items] == list(theme.phrases["encouragement"])
    assert all(len(page.items) <= PER_PAGE for page in found)


def test_praise_has_the_face_and_gesture_of_praise(state: SessionState) -> None:
    praise = next(
        page
        for page in pages(state, PhraseBook.of(state, KeymapFile()), "A")
        if page.title == "Praise"
    )
    remark = praise.items[0].message
    assert isinstance(remark, m.Remark)
    assert (remark.valence, remark.face, remark.gesture, remark.source) == (
        "positive",
        "happy",
        "nod",
        "phrase",
    )


def test_marks_modes_and_queue_have_pages(state: SessionState) -> None:
    said = b.action("a9", text="Next.")
    full = state.receive(
        [
            b.frame(
                t.ARBITER_STATE,
                b.arbiter_state(queued=(said,), current=b.action("a8", text="Now.")),
            )
        ]
    )
    found = {page.kind: page for page in pages(full, PhraseBook.of(full, KeymapFile()), "A")}
    assert [item.text for item in found["marks"].items] == ["Marker missed", "Assisted"]
    assert found["modes"].items[0].message == m.ModeChanged(kind="feedback", mode="manual")
    assert [item.text for item in found["queue"].items] == ["feedback “Now.”", "feedback “Next.”"]
    assert [item.is_current for item in found["queue"].items] == [True, False]
    assert found["queue"].items[1].message == m.Decision(action="a9", verdict="veto")


def test_the_documentation_lists_every_id_and_its_example_file_is_valid(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "run-a-wizard-of-oz-study.md").read_text()
    numbered = ("pick-", "event-")  # listed as ranges
    assert [
        key_command.id
        for key_command in KEY_COMMANDS
        if not key_command.id.startswith(numbered) and f"`{key_command.id}`" not in page
    ] == []
    (tmp_path / FILE).write_text(page.partition("```toml\n")[2].partition("```")[0])
    file, problem = read(tmp_path)
    assert problem == ""
    assert file.phrases
