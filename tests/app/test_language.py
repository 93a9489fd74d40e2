"""All screens of a session in another language are in that language only; those of the playful theme
address a child.
"""

import os
import re
from itertools import chain, islice
from pathlib import Path
from typing import Any, NamedTuple

import pytest

import sar_tui.app
import sar_tui.loop
from sar_tui.app.at_home import NOT_RECEIVED, NOT_RECEIVED_WHY
from sar_tui.app.screens.waiting_text import WATCHED
from sar_tui.app.wellbeing_interview import QUESTIONS
from sar_tui.model.language import BUNDLED, language, read_words
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.records.kind import NOT_SAID
from sar_tui.reports.charts import MARKERS
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.store.interface_language import FILE, choose_interface_language
from sar_tui.tui.language import app_language, session_language
from sar_tui.widgets.lists import PickList
from tests.app.app_driver import OpenApp, known
from tests.translations import rooms
from tests.untranslated import english_in, phrases

APP = Path(sar_tui.app.__file__).parent
_FRAMES = str.maketrans("│▌╭╮╰╯─━", "        ")


LANGUAGES = tuple(code for code in BUNDLED if code != "en")


def plan(
    catalogue: Catalogue, name: str, theme: str = "calm", language: str = "es", **parameters: Any
) -> Plan:
    settings = {"language": language, "attempts": 2, **parameters}
    return make_plan(catalogue, name, ["P01"], settings, theme=theme, seed=7)


# --- the app's own words


@pytest.mark.slow
def test_every_text_of_the_app_is_translated_and_no_translation_is_obsolete(
    catalogue: Catalogue,
) -> None:
    steps = QUESTIONS.values()
    answers = {NOT_SAID, *chain.from_iterable((step.text, *step.labels) for step in steps)}
    participants, app = islice(rooms(catalogue), 2)
    texts = app.needed | {"START", *MARKERS, NOT_RECEIVED, NOT_RECEIVED_WHY, WATCHED, *answers}
    for code in LANGUAGES:
        files = [folder / f"words.{code}.toml" for folder in (APP, APP / "therapist")]
        written = set[str]().union(*map(read_words, files))
        assert texts - participants.inherited <= written <= texts


async def test_texts_of_a_theme_precede_those_of_the_app_and_an_unknown_language_is_english(
    opened: OpenApp, catalogue: Catalogue
) -> None:
    tr = app_language("es", {"Welcome": "¡Hola!"})
    assert (tr("Welcome"), tr("Go on")) == ("¡Hola!", "Seguir")
    assert app_language("fr")("Press {key} to start.", key="Space") == "Press Space to start."
    async with opened(plan(catalogue, "keyboard", "playful")) as driver:
        driver.see("Púlsala lo más rápido que puedas", "Pulsa Enter para seguir.")


# --- sessions


class Seen(NamedTuple):
    """Some texts on the screens of a session of keys."""

    title: str
    welcome: str
    goal: str
    progress: str
    prompt: str
    size: str
    done: str


SEEN = {
    "es": Seen(
        "Reacción con el teclado",
        "Le damos la bienvenida",
        "en menos de 0,85 segundos de media, y acertar 2 de 2.",
        "Teclas 0 de 2",
        "Pulse: {key}",
        "Tiene 60 por 20 caracteres; hacen falta 80 por 24.",
        "metas alcanzadas",
    ),
    "de": Seen(
        "Reaktion mit Tasten",
        "Willkommen",
        "im Durchschnitt schneller als 0,85 Sekunden, und 2 von 2 richtig.",
        "Tasten 0 von 2",
        "Drücken: {key}",
        "Es hat 60 mal 20 Zeichen; 80 mal 24 sind nötig.",
        "Zielen erreicht",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("code", LANGUAGES)
async def test_a_session_of_keys_is_in_another_language(
    opened: OpenApp, catalogue: Catalogue, code: str
) -> None:
    settings = {"prompts_per_attempt": 2, "practice_attempts": 1, "threshold": 850.0}
    seen: list[str] = []
    words = SEEN[code]
    async with opened(plan(catalogue, "keyboard", language=code, **settings)) as driver:

        def look(*words: str) -> None:
            """Collect the texts on the screen, and check that these are among them."""
            seen.append(" ".join(driver.text.translate(_FRAMES).split()))
            seen.extend(driver.rows)
            driver.see(*words)

        async def press(*keys: str) -> None:
            """Press keys, and collect the texts after each."""
            for key in keys:
                await driver.press(key)
                look()

        look(words.title, words.welcome)
        await press("f1", "enter", "enter")
        look(words.goal)
        prompt = await driver.begin()
        look(words.prompt.format(key=prompt.expected), words.progress)
        await press("ctrl+q", "escape", "escape", *["down", "enter"] * 3)
        await driver.resize(60, 20)
        look(words.size)
        await driver.resize(80, 24)
        await press("enter", "escape", "up", "enter", "escape", "enter")
        await driver.do_attempt(await driver.to_prompt())
        for working in (False, True):
            await driver.disk(working)
            look()
        await press("enter")
        for _ in range(2):
            await driver.do_attempt(await driver.begin())
            look()
        await driver.see_the_summary()
        look(words.done)
        said = phrases(catalogue.theme("calm"), catalogue.theme("calm", code))
        assert english_in(seen, session_language(driver.session.task).texts | said) == []


async def test_the_command_palette_of_a_session_is_in_its_language(
    opened: OpenApp, catalogue: Catalogue
) -> None:
    async with opened(plan(catalogue, "keyboard", language="de")) as driver:
        await driver.press("ctrl+p")
        driver.see("Befehl suchen", "Wofür dieser Bildschirm da ist", "Ende")


@pytest.mark.parametrize("code", LANGUAGES)
async def test_the_keys_and_the_first_line_of_the_sensor_check_fit_in_80_columns(
    opened: OpenApp, catalogue: Catalogue, code: str
) -> None:
    tr = app_language(code)
    async with opened(plan(catalogue, "reaching", language=code, imu="simulated")) as driver:
        driver.see(tr("Fasten the sensor as drawn, and lay the hand flat on the table, palm down."))
        assert f"F1 {tr('Help')}" in driver.rows[-1]


@pytest.mark.parametrize("code", LANGUAGES)
async def test_the_keys_of_the_home_and_of_the_settings_fit_in_80_columns(
    opened: OpenApp, data: Path, code: str
) -> None:
    known(data, "P01")
    choose_interface_language(data, code)
    async with opened() as driver:
        assert f"F1 {app_language(code)('Help')}" in driver.rows[-1]
        await driver.press("f2")
        assert f"F1 {app_language(code)('Help')}" in driver.rows[-1]


async def test_settings_are_in_the_language_of_the_app(opened: OpenApp, data: Path) -> None:
    known(data, "P01", language="de")
    choose_interface_language(data, "es")
    async with opened() as driver:
        await driver.press("f2")
        driver.see("Más difícil si sale bien, más fácil si no.")
        await driver.press("pagedown")
        driver.see("Teclas por intento", "Número de teclas de un intento. De 1 a 200.")
        assert "F5 Versiones" in driver.rows[-1]
        await driver.press("/", *"manos", "escape", "down", "enter", "down", "enter", "ctrl+s")
        driver.see("● Teclas ambas manos → flechas")
        await driver.press(*"más fácil", "enter")
        driver.see("guardado versión 2")


async def test_what_is_wrong_is_said_in_the_language_of_the_app(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P01")
    choose_interface_language(data, "de")
    async with opened() as driver:
        await driver.press("f2", "f3")
        await driver.enter("prompts_per_attempt")
        await driver.press(*"333")
        driver.see("Tasten je Durchgang: eine ganze Zahl, 1 bis 200")


TASKS = tuple(Catalogue().task_names())
USTED = re.compile(
    r"\b(su(?! sesgo)|sus|usted|le damos|verle|lo ha|ha (hecho|tenido)|haya vuelto"
    r"|tómese|hágal[oa]|púlsela|manténgala|(des)?conéctelo|tiene (?!\{)|puede (leer|desc)"
    r"|pulse|empiece|espere|suelte|descanse|pare|avise|sujete|apoye|mantenga|compruebe|pruebe|vuelva|extienda|toque"
    r"|vaya|procure|intente|hable|ponga|(como|que|cuando) (pueda|quiera|vea)|necesite|alcance "
    r"un)\b",
    re.IGNORECASE,
)


SIE = re.compile(r"\b(Sie|Ihr|Ihre[mnrs]?|Ihnen)\b")
FORMAL = {"es": USTED, "de": SIE}
"""Patterns of texts that address an adult, by language."""


def shipped(catalogue: Catalogue, code: str) -> dict[str, str]:
    """Return the texts of participants' screens, without those of themes and of therapists."""
    modules = (sar_tui.loop, sar_tui.app)
    folders = [Path(str(module.__file__)).parent for module in modules]
    return language(code, *folders, *(task_folder(catalogue.task(name)) for name in TASKS)).texts


@pytest.mark.parametrize("code", LANGUAGES)
def test_a_child_is_never_addressed_as_an_adult(catalogue: Catalogue, code: str) -> None:
    own = catalogue.theme("playful", code).texts
    texts = {**shipped(catalogue, code), **own}.values()
    assert [text for text in texts if FORMAL[code].search(text)] == []


@pytest.mark.parametrize("code", LANGUAGES)
def test_each_text_for_a_child_differs_from_that_for_an_adult(
    catalogue: Catalogue, code: str
) -> None:
    adult = shipped(catalogue, code)
    written = read_words(catalogue.theme_folder("playful") / f"words.{code}.toml")
    assert [english for english, own in written.items() if own == adult.get(english)] == []


# --- the therapist's screens


@pytest.mark.slow
async def test_a_language_chosen_in_the_palette_is_that_of_the_home_at_once_and_from_then_on(
    opened: OpenApp, data: Path
) -> None:
    for code in ("P01", "P02"):
        known(data, code)
    async with opened() as driver:
        await driver.press("down")
        driver.see("P01 · Keyboard reaction")
        await driver.press("ctrl+p", *"Deutsch", "enter")
        await driver.settle()
        driver.see(
            "Einstellungen",
            "Zweimal Enter beginnt eine Sitzung mit P01.",
            "P01 · Reaktion mit Tasten",
        )
        assert driver.screen_name == "HomeScreen"
        await driver.press("enter")
        driver.see("Enter beginnt eine Sitzung mit P01.")
    file = data / FILE
    assert file.read_text("utf-8").strip() == "de"
    if os.name == "posix":
        assert file.stat().st_mode & 0o777 == 0o600
    async with opened() as driver:
        driver.see("Einstellungen", "Noch keine Sitzung. START beginnt die erste.")


@pytest.mark.slow
@pytest.mark.parametrize("code", LANGUAGES)
async def test_no_screen_around_the_home_has_english_words(
    opened: OpenApp, data: Path, code: str
) -> None:
    data.mkdir(exist_ok=True)
    choose_interface_language(data, code)
    seen: list[str] = []
    async with opened() as driver:

        async def look(*keys: str) -> None:
            for key in keys:
                await driver.press(key)
            await driver.settle()
            seen.extend(driver.rows)

        await look()
        await look("enter")
        await look("enter")
        await look("escape")
        known(data, "P01")
        known(data, "P01", task="pairs")
        await look("f1")
        await look("escape", "ctrl+p")
        await look("escape", "f6")
        await look("escape", "up")
        await look("right")
        await look("right", "right", "enter")
        await look("escape")
        driver.app.screen.query_one("#task", PickList).choose("keyboard")
        await look("escape", "f2")
        await look("f1")
        await look("escape", "f5")
        await look("f1")
        await look("escape", "escape", "f6")
        await look("escape", "slash")
        await look("escape", "pagedown", "down", "enter", "down", "enter", "ctrl+s")
    found = [row for row in seen if ENGLISH.search(row)]
    assert found == []


ENGLISH = re.compile(
    r"\b(the|of|and|press|session|sessions|level|levels|settings|task|choose|today|yesterday"
    r"|people|with|help|quit|search|goal|back|theme)\b",
    re.IGNORECASE,
)
