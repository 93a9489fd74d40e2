"""A session of a bundled task in Spanish contains no English, and every text fits."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.checks.task_translations import declared, texts_in
from sar_tui.loop import task as module
from sar_tui.loop.phrase_keys import holds_number
from sar_tui.loop.task import Task
from sar_tui.model.language import language, read_words
from sar_tui.model.messages import Action, Feedback, Message, Prompt, Waiting
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Situation, Stimulus
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.rules.declaration import texts as setting_texts
from sar_tui.rules.parameters import build, fields
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.widgets.large_characters import draw
from tests.examples import first
from tests.untranslated import english_in, phrases

pytestmark = pytest.mark.usefixtures("fewer_blocks")

TASKS = tuple(Catalogue().task_names())
USUAL: dict[str, object] = {"attempts": 6, "practice_attempts": 1}
SETTINGS: dict[str, dict[str, object]] = {
    "keyboard": {"prompts_per_attempt": 3, "start_level": 9},
    "pairs": {"prompts_per_attempt": 4, "policy": "race"},
    "reaching": {"feedback_on": "both", "imu": "simulated"},
}


def make(name: str, **parameters: object) -> Task:
    kind = Catalogue().task(name)
    return kind(build(kind.Parameters, {"language": "es", **parameters}))


@pytest.mark.parametrize("name", TASKS)
def test_no_translation_of_a_task_is_obsolete(name: str) -> None:
    kind = Catalogue().task(name)
    folder = task_folder(kind)
    used = declared(kind).union(
        *(texts_in(path.read_text("utf-8")) for path in folder.glob("*.py"))
    )
    for field in fields(kind.Parameters):
        used.update(setting_texts(field), field.choices)
    assert set(read_words(folder / "words.es.toml")) <= used


# --- a session


def played(name: str, data: Path, **settings: object) -> list[Message]:
    """Simulate a session of a poor participant, and return its messages."""
    catalogue = Catalogue()
    wanted = {**USUAL, **SETTINGS.get(name, {}), **settings}
    plan = make_plan(catalogue, name, ["P1"], wanted, seed=3, mode="simulated")
    session = simulate(plan, PEOPLE["poor"], data, catalogue)
    with closing(connect(data)) as database:
        return [record.message for record in sessions.history(database, session)]


def shown_in(messages: list[Message]) -> Iterator[str]:
    """Yield all texts that a participant reads and hears in a session."""
    for message in messages:
        match message:
            case Waiting(attempt_name=attempt, goal=goal, notice=notice):
                yield from (attempt, goal, notice)
            case Prompt(text=text, glyph=glyph, hint=hint):
                yield from (text, glyph, hint)
            case Action(text=text, spoken=spoken):
                yield from (text, spoken)


def translations(name: str) -> dict[str, str]:
    """Return all the Spanish of a task's session, but for the app's."""
    return language("es", Path(module.__file__).parent, task_folder(Catalogue().task(name))).texts


@pytest.mark.parametrize("name", first(4, TASKS))
def test_a_session_in_spanish_contains_no_english(name: str, data: Path) -> None:
    messages = played(name, data, language="es", feedback_form="both")
    shown = [make(name).instructions(), *shown_in(messages)]
    said = phrases(Catalogue().theme("calm"), Catalogue().theme("calm", "es"))
    assert english_in(shown, translations(name) | said) == []
    assert any("meta: " in text for text in shown)
    assert {"intento de práctica 1 de 1", "intento 6 de 6"} <= set(shown)


def test_english_would_be_found_in_an_english_session(data: Path) -> None:
    shown = shown_in(played("keyboard", data))
    found = {text for text, _ in english_in(shown, translations("keyboard"))}
    assert {"attempt {number} of {total}", "practice {number} of {total}"} <= found


@pytest.mark.parametrize("name", ["keyboard", "reaching"])
def test_feedback_in_words_contains_no_number(name: str, data: Path) -> None:
    messages = played(name, data, language="es", feedback_form="qualitative")
    said = [each.text for each in messages if isinstance(each, Action) and each.kind == "feedback"]
    remarks = [each.remark for each in messages if isinstance(each, Feedback) and each.remark]
    assert len(said) == 7
    assert [text for text in (*said, *remarks) if holds_number(text, "es")] == []


# --- on the screen


def stimulus(task: Task, level: int = 1, trial: int = 1) -> Stimulus:
    return task.stimulus(Situation(1, trial, level, RandomStreams(1, 1, trial), RandomStreams(1)))


def test_an_arrow_key_is_named() -> None:
    task = make("keyboard", choice_set="arrow keys")
    shown = {stimulus(task, 3, trial).text for trial in range(40)}
    assert shown == {"Pulse: izquierda", "Pulse: derecha", "Pulse: arriba", "Pulse: abajo"}


@pytest.mark.parametrize(("go_signal", "glyph"), [(True, "YA"), (False, "ALCANCE")])
def test_a_reach_prompt_fits_in_large_letters(go_signal: bool, glyph: str) -> None:
    shown = stimulus(make("reaching", go_signal=go_signal, marker_distances_cm=[22.5]))
    assert (shown.text, shown.glyph, shown.name) == ("Alcance: 22,5 cm", glyph, "22.5 cm")
    assert len(draw(glyph, 78, 12)) > 1


def test_numbers_and_plurals_follow_spanish_rules() -> None:
    assert "en menos de 1 segundo de media" in make("keyboard").goal(1)
    assert "0,85 segundos" in make("keyboard", threshold=850).goal(1)
    for prompts, asked in ((1, "1 tecla."), (20, "20 teclas.")):
        assert asked in make("keyboard", prompts_per_attempt=prompts).instructions()


@pytest.mark.parametrize("name", TASKS)
def test_every_instruction_fits_on_the_screen(name: str) -> None:
    lines = make(name).instructions().split("\n")
    assert sum(1 + len(line) // 72 for line in lines) <= 9
