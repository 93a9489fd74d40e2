"""A session of a shipped task in Spanish contains no English, and every text fits."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from sar_tui.checks.task_translations import declared, numbers, problems, remarks_in, texts_in
from sar_tui.loop import task as module
from sar_tui.loop.phrase_keys import holds_number
from sar_tui.loop.task import Task
from sar_tui.model.language import language, read_words, slot_problem
from sar_tui.model.messages import Action, Feedback, Prompt, Waiting
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
    "keyboard": {"attempts": 6, "prompts_per_attempt": 3, "practice_attempts": 1, "start_level": 9},
    "pairs": {"attempts": 6, "prompts_per_attempt": 4, "practice_attempts": 1, "policy": "race"},
    "reaching": {"attempts": 6, "practice_attempts": 1, "feedback_on": "both", "imu": "simulated"},
}


def make(name: str, **parameters: object) -> Task:
    kind = Catalogue().task(name)
    return kind(build(kind.Parameters, {"language": "es", **parameters}))


def translations(name: str) -> dict[str, str]:
    """All the Spanish that a session of a task has, but for the app's."""
    return language("es", Path(module.__file__).parent, task_folder(Catalogue().task(name))).texts


@pytest.mark.parametrize("name", TASKS)
def test_every_text_of_a_task_is_translated_and_no_translation_is_obsolete(name: str) -> None:
    kind = Catalogue().task(name)
    folder = task_folder(kind)
    texts = declared(kind).union(
        *(texts_in(path.read_text("utf-8")) for path in folder.glob("*.py"))
    )
    own = read_words(folder / "words.es.toml")
    needed = texts - set(read_words(Path(module.__file__).parent / "words.es.toml"))
    of_settings = {
        text
        for field in fields(kind.Parameters)
        for text in (*setting_texts(field), *field.choices)
    }
    assert needed <= set(own) <= needed | of_settings
    assert [problem for text, word in own.items() if (problem := slot_problem(text, word))] == []
    assert problems(kind) == []


# --- no number in words


@pytest.mark.parametrize("name", Catalogue().task_names())
def test_remarks_of_a_task_contain_no_number_in_any_language(name: str) -> None:
    assert numbers(Catalogue().task(name)) == []


def test_the_remarks_of_reaching_are_checked_and_none_asks_for_a_trial_that_will_not_come() -> None:
    folder = task_folder(Catalogue().task("reaching"))
    remarks = remarks_in((folder / "task.py").read_text("utf-8"))
    assert {"The sensor missed a part of that reach, so it does not count."} < remarks
    own = read_words(folder / "words.es.toml")
    for remark in remarks:
        assert not re.search(r"\b(once|repeat|more)\b", remark)
        assert not re.search(r"\b(una vez|repita|repítalo)\b", own[remark].lower())


@pytest.mark.parametrize("code", ["en", "es"])
@pytest.mark.parametrize("person", first(1, PEOPLE))
@pytest.mark.parametrize("name", TASKS)
def test_feedback_in_words_contains_no_number_in_a_session(
    name: str, person: str, code: str, data: Path
) -> None:
    catalogue = Catalogue()
    wanted = {"language": code, "feedback_form": "qualitative", "feedback_schedule": "every"}
    plan = make_plan(
        catalogue, name, ["P1"], {**SETTINGS.get(name, USUAL), **wanted}, seed=3, mode="simulated"
    )
    session = simulate(plan, PEOPLE[person], data, catalogue)
    database = connect(data)
    try:
        messages = [record.message for record in sessions.history(database, session)]
    finally:
        database.close()
    answers = [m for m in messages if isinstance(m, Action) and m.kind == "feedback"]
    remarks = [m.remark for m in messages if isinstance(m, Feedback) and m.remark]
    assert answers
    assert [
        text for text in (*remarks, *(m.text for m in answers)) if holds_number(text, code)
    ] == []


# --- a session


def reported(data: Path, name: str, person: str, code: str = "es") -> Iterator[str]:
    """All that a simulated participant of a whole session reads and hears."""
    catalogue = Catalogue()
    settings = {"language": code, "feedback_form": "both", **SETTINGS.get(name, USUAL)}
    plan = make_plan(catalogue, name, ["P1"], settings, seed=3, mode="simulated")
    session = simulate(plan, PEOPLE[person], data, catalogue)
    database = connect(data)
    try:
        yield plan.task(plan.parameters).instructions()
        for record in sessions.history(database, session):
            match record.message:
                case Waiting(attempt_name=attempt, goal=goal, notice=notice):
                    yield from (attempt, goal, notice)
                case Prompt(text=text, glyph=glyph, hint=hint):
                    yield from (text, glyph, hint)
                case Action(text=text, spoken=spoken):
                    yield from (text, spoken)
    finally:
        database.close()


@pytest.mark.parametrize("person", first(1, ["poor", "competent"]))
@pytest.mark.parametrize("name", TASKS)
def test_a_session_in_spanish_contains_no_english(name: str, person: str, data: Path) -> None:
    shown = list(reported(data, name, person))
    said = phrases(Catalogue().theme("calm"), Catalogue().theme("calm", "es"))
    assert english_in(shown, translations(name) | said) == []
    assert any("meta: " in text for text in shown)
    assert {"intento de práctica 1 de 1", "intento 6 de 6"} <= set(shown)


@pytest.mark.parametrize("name", TASKS)
def test_the_same_session_in_english_contains_the_english_texts(name: str, data: Path) -> None:
    found = {text for text, _ in english_in(reported(data, name, "poor", "en"), translations(name))}
    assert {"attempt {number} of {total}", "practice {number} of {total}"} <= found


# --- what stands on the screen


def stimulus(task: Task, level: int = 1, trial: int = 1) -> Stimulus:
    return task.stimulus(Situation(1, trial, level, RandomStreams(1, 1, trial), RandomStreams(1)))


def test_a_key_prompt_is_one_plain_line() -> None:
    shown = stimulus(make("keyboard"))
    assert shown.text == f"Pulse: {shown.expected}"


def test_an_arrow_key_is_named() -> None:
    task = make("keyboard", choice_set="arrow keys")
    shown = {stimulus(task, 3, trial).text for trial in range(40)}
    assert shown == {"Pulse: izquierda", "Pulse: derecha", "Pulse: arriba", "Pulse: abajo"}
    assert stimulus(task).hint == "tecla de flecha"


@pytest.mark.parametrize(("go_signal", "glyph"), [(True, "YA"), (False, "ALCANCE")])
def test_a_reach_prompt_fits_in_large_letters(go_signal: bool, glyph: str) -> None:
    shown = stimulus(make("reaching", go_signal=go_signal, marker_distances_cm=[22.5]))
    assert (shown.text, shown.glyph, shown.name) == ("Alcance: 22,5 cm", glyph, "22.5 cm")
    assert len(draw(glyph, 78, 12)) > 1


@pytest.mark.parametrize(
    ("parameters", "goal"),
    [
        (
            {},
            "Su meta: pulsar la tecla correcta en menos de 1 segundo de media, y acertar al menos "
            "16 de 20.",
        ),
        (
            {"threshold": 850, "min_accuracy": 0},
            "Su meta: pulsar la tecla correcta en menos de 0,85 segundos de media.",
        ),
    ],
)
def test_numbers_and_plurals_of_a_goal_follow_spanish_rules(
    parameters: dict[str, object], goal: str
) -> None:
    assert make("keyboard", **parameters).goal(1) == goal


@pytest.mark.parametrize(("prompts", "asks"), [(1, "pide 1 tecla."), (20, "pide 20 teclas.")])
def test_the_instructions_use_spanish_plurals(prompts: int, asks: str) -> None:
    assert asks in make("keyboard", prompts_per_attempt=prompts).instructions()


def test_the_texts_of_a_reach_are_in_spanish() -> None:
    task = make("reaching")
    assert task.goal(2) == "Hasta el marcador 2 (20 cm) y vuelta.\nSu meta: menos de 1,39 segundos."
    assert (
        task.start(1)
        == "Apoye la mano en el punto de salida.\nDespués vaya hasta el marcador 1 (15 cm) y "
        "vuelva."
    )
    assert task.notice(2, 1) == "Ahora el marcador 2: un poco más lejos"
    assert task.notice(1, 2) == "Ahora el marcador 1: un poco más cerca"


def test_every_instruction_fits_on_the_screen() -> None:
    for name in TASKS:
        lines = make(name).instructions().split("\n")
        assert sum(1 + len(line) // 72 for line in lines) <= 9
