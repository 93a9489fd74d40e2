"""A session of a bundled task in another language contains no English, and every text fits."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from sar_tui.loop import task as module
from sar_tui.loop.phrase_keys import holds_number
from sar_tui.loop.task import Task
from sar_tui.model.language import BUNDLED, language
from sar_tui.model.messages import Action, Feedback, Message, Prompt, Waiting
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Situation, Stimulus
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.rules.parameters import build
from sar_tui.runs.plan import make_plan
from sar_tui.runs.simulate import simulate
from sar_tui.simulation.participant_model import PEOPLE
from sar_tui.store import sessions
from sar_tui.store.database import connect
from sar_tui.widgets.large_characters import is_large
from tests.examples import first
from tests.untranslated import english_in, phrases

pytestmark = pytest.mark.usefixtures("fewer_blocks")

TASKS = tuple(Catalogue().task_names())
LANGUAGES = tuple(code for code in BUNDLED if code != "en")
USUAL: dict[str, object] = {"attempts": 6, "practice_attempts": 1}
SETTINGS: dict[str, dict[str, object]] = {
    "keyboard": {"prompts_per_attempt": 3, "start_level": 9},
    "pairs": {"prompts_per_attempt": 4, "policy": "race"},
    "reaching": {"feedback_on": "both", "imu": "simulated"},
}


def make(name: str, code: str, **parameters: object) -> Task:
    kind = Catalogue().task(name)
    return kind(build(kind.Parameters, {"language": code, **parameters}))


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


def translations(name: str, code: str = "es") -> dict[str, str]:
    """Return all translations of a task's session, but for the app's."""
    return language(code, Path(module.__file__).parent, task_folder(Catalogue().task(name))).texts


NAMED = {
    "es": ("meta: ", "intento de práctica 1 de 1", "intento 6 de 6"),
    "de": ("Ziel: ", "Probedurchgang 1 von 1", "Durchgang 6 von 6"),
}
"""A goal and the names of two attempts, by language."""


@pytest.mark.parametrize("code", LANGUAGES)
@pytest.mark.parametrize("name", first(4, TASKS))
def test_a_session_in_another_language_contains_no_english(
    name: str, code: str, data: Path
) -> None:
    messages = played(name, data, language=code, feedback_form="both")
    shown = [make(name, code).instructions(), *shown_in(messages)]
    said = phrases(Catalogue().theme("calm"), Catalogue().theme("calm", code))
    assert english_in(shown, translations(name, code) | said) == []
    goal, *attempts = NAMED[code]
    assert any(goal in text for text in shown)
    assert set(attempts) <= set(shown)


def test_english_would_be_found_in_an_english_session(data: Path) -> None:
    shown = shown_in(played("keyboard", data))
    found = {text for text, _ in english_in(shown, translations("keyboard"))}
    assert {"attempt {number} of {total}", "practice {number} of {total}"} <= found


@pytest.mark.parametrize("code", LANGUAGES)
@pytest.mark.parametrize("name", ["keyboard", "reaching"])
def test_feedback_in_words_contains_no_number(name: str, code: str, data: Path) -> None:
    messages = played(name, data, language=code, feedback_form="qualitative")
    said = [each.text for each in messages if isinstance(each, Action) and each.kind == "feedback"]
    remarks = [each.remark for each in messages if isinstance(each, Feedback) and each.remark]
    assert len(said) == 7
    assert [text for text in (*said, *remarks) if holds_number(text, code)] == []


# --- on the screen


def stimulus(task: Task, level: int = 1, trial: int = 1) -> Stimulus:
    return task.stimulus(Situation(1, trial, level, RandomStreams(1, 1, trial), RandomStreams(1)))


@pytest.mark.parametrize(
    ("code", "shown"),
    [
        ("es", {"Pulse: izquierda", "Pulse: derecha", "Pulse: arriba", "Pulse: abajo"}),
        ("de", {"Drücken: links", "Drücken: rechts", "Drücken: oben", "Drücken: unten"}),
    ],
)
def test_an_arrow_key_is_named(code: str, shown: set[str]) -> None:
    task = make("keyboard", code, choice_set="arrow keys")
    assert {stimulus(task, 3, trial).text for trial in range(40)} == shown


@pytest.mark.parametrize(
    ("code", "go_signal", "text", "glyph"),
    [
        ("es", True, "Alcance: 22,5 cm", "YA"),
        ("es", False, "Alcance: 22,5 cm", "ALCANCE"),
        ("de", True, "Bewegung: 22,5 cm", "LOS"),
        ("de", False, "Bewegung: 22,5 cm", "STRECKEN"),
    ],
)
def test_a_reach_prompt_fits_in_large_letters(
    code: str, go_signal: bool, text: str, glyph: str
) -> None:
    shown = stimulus(make("reaching", code, go_signal=go_signal, marker_distances_cm=[22.5]))
    assert (shown.text, shown.glyph, shown.name) == (text, glyph, "22.5 cm")
    assert is_large(glyph, 78, 12)


@pytest.mark.parametrize(
    ("code", "second", "less", "key", "keys"),
    [
        ("es", "en menos de 1 segundo de media", "0,85 segundos", "1 tecla.", "20 teclas."),
        (
            "de",
            "im Durchschnitt schneller als 1 Sekunde",
            "0,85 Sekunden",
            "1 Taste.",
            "20 Tasten.",
        ),
    ],
)
def test_numbers_and_plurals_follow_the_rules_of_the_language(
    code: str, second: str, less: str, key: str, keys: str
) -> None:
    assert second in make("keyboard", code).goal(1)
    assert less in make("keyboard", code, threshold=850).goal(1)
    for prompts, asked in ((1, key), (20, keys)):
        assert asked in make("keyboard", code, prompts_per_attempt=prompts).instructions()


@pytest.mark.parametrize("code", LANGUAGES)
@pytest.mark.parametrize("name", TASKS)
def test_every_instruction_fits_on_the_screen(name: str, code: str) -> None:
    lines = make(name, code).instructions().split("\n")
    assert sum(1 + len(line) // 72 for line in lines) <= 9
