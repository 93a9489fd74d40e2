"""All screens of a session in Spanish are in Spanish only, and in the playful theme as tú."""

import re
from itertools import chain
from pathlib import Path
from typing import Any

import pytest
from textual.binding import Binding

import sar_tui.app
import sar_tui.loop
from sar_tui.app.app import SarTui
from sar_tui.app.screens.sensor_check import SensorCheckScreen
from sar_tui.app.screens.session import SessionScreen
from sar_tui.app.screens.settings import SettingsScreen
from sar_tui.app.screens.wellbeing import QUESTIONS, WellbeingScreen
from sar_tui.checks.task_translations import texts_in
from sar_tui.model.language import language, read_words, slot_problem
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.reports.charts import MARKERS
from sar_tui.rules.declaration import COMMON, texts
from sar_tui.rules.parameters import fields
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.store.wellbeing import NOT_SAID
from sar_tui.tui.base_app import BaseApp
from sar_tui.tui.language import app_language, session_language
from tests.app.app_driver import OpenApp, known
from tests.untranslated import english_in, phrases

APP = Path(sar_tui.app.__file__).parent
_FRAMES = str.maketrans("│▌╭╮╰╯─━", "        ")


def plan(catalogue: Catalogue, name: str, theme: str = "calm", **parameters: Any) -> Plan:
    settings = {"language": "es", "attempts": 2, **parameters}
    return make_plan(catalogue, name, ["P01"], settings, theme=theme, seed=7)


# --- the app's own words


def test_every_text_of_the_app_is_translated_and_no_translation_is_obsolete() -> None:
    package = APP.parent
    rooms = (APP, package / "widgets", package / "tui")
    code = [
        *(path for room in rooms for path in room.rglob("*.py")),
        package / "reports" / "charts.py",
    ]
    bindings = [
        *BaseApp.BINDINGS,
        *SarTui.BINDINGS,
        *SessionScreen.BINDINGS,
        *SensorCheckScreen.BINDINGS,
    ]
    bindings += [*WellbeingScreen.BINDINGS, *SettingsScreen.BINDINGS]
    labels = {
        binding.description for binding in bindings if isinstance(binding, Binding) and binding.show
    }
    steps = QUESTIONS.values()
    answers = {NOT_SAID, *chain.from_iterable((step.text, *step.labels) for step in steps)}
    texts = {"palette", *labels, *MARKERS, *answers}.union(
        *(texts_in(path.read_text("utf-8")) for path in code)
    )
    translations = read_words(APP / "words.es.toml")
    assert set(translations) == texts
    assert [
        problem for text, own in translations.items() if (problem := slot_problem(text, own))
    ] == []


async def test_texts_of_a_theme_precede_those_of_the_app_and_an_unknown_language_is_english(
    opened: OpenApp, catalogue: Catalogue
) -> None:
    tr = app_language("es", {"Welcome": "¡Hola!"})
    assert (tr("Welcome"), tr("Go on")) == ("¡Hola!", "Seguir")
    assert app_language("de")("Press {key} to start.", key="Space") == "Press Space to start."
    async with opened(plan(catalogue, "keyboard", "playful")) as driver:
        driver.see("Púlsala lo más rápido que puedas", "Pulsa Enter para seguir.")


# --- sessions


async def test_a_session_of_keys_is_in_spanish(opened: OpenApp, catalogue: Catalogue) -> None:
    settings = {"prompts_per_attempt": 2, "practice_attempts": 1, "threshold": 850.0}
    seen: list[str] = []
    async with opened(plan(catalogue, "keyboard", **settings)) as driver:

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

        look("Reacción con el teclado", "Le damos la bienvenida")
        await press("f1", "enter", "enter")
        look("en menos de 0,85 segundos de media, y acertar 2 de 2.", "Teclas 0 de 2")
        prompt = await driver.begin()
        look(f"Pulse: {prompt.expected}")
        await press("ctrl+q", "escape", "escape", *["down", "enter"] * 3)
        await driver.resize(60, 20)
        look("Tiene 60 por 20 caracteres; hacen falta 80 por 24.")
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
        look("Ha hecho 2 intentos; meta alcanzada en 2.")
        said = phrases(catalogue.theme("calm"), catalogue.theme("calm", "es"))
        assert english_in(seen, session_language(driver.session.task).texts | said) == []


@pytest.mark.parametrize("name", Catalogue().task_names())
def test_every_setting_is_in_spanish(catalogue: Catalogue, name: str) -> None:
    kind = catalogue.task(name)
    own = language("es", COMMON, task_folder(kind))
    units = {"ms", "s", "min", "%", "cm", "rad/s"}
    missing = (
        {text for field in fields(kind.Parameters) for text in texts(field)}
        - own.texts.keys()
        - units
    )
    assert not missing
    assert not [text for english, text in own.texts.items() if slot_problem(english, text)]


async def test_settings_are_in_the_saved_language(opened: OpenApp, data: Path) -> None:
    known(data, "P01", language="es")
    async with opened() as driver:
        await driver.press("f2")
        driver.see("Teclas por intento", "Número de teclas de un intento. De 1 a 200.")
        assert "Ctrl-S Guardar" in driver.rows[-1]
        await driver.press("/", *"manos", "escape", "down", "enter", "down", "enter", "ctrl+s")
        driver.see("● Teclas ambas manos → flechas")
        await driver.press(*"más fácil", "enter")
        driver.see("guardada: versión 2")


TASKS = tuple(Catalogue().task_names())
USTED = re.compile(
    r"\b(su(?! sesgo)|sus|usted|le damos|verle|lo ha|ha (hecho|tenido)|haya vuelto"
    r"|tómese|hágal[oa]|púlsela|manténgala|(des)?conéctelo|tiene (?!\{)|puede (leer|desc)"
    r"|pulse|empiece|espere|suelte|descanse|pare|avise|sujete|apoye|mantenga|compruebe|pruebe|vuelva|extienda|toque"
    r"|vaya|procure|intente|hable|ponga|(como|que|cuando) (pueda|quiera|vea)|necesite|alcance "
    r"un)\b",
    re.IGNORECASE,
)


def spoken_to(texts: list[str]) -> list[str]:
    """Return the texts that address the reader as usted."""
    return [text for text in texts if USTED.search(text)]


@pytest.fixture
def shipped(catalogue: Catalogue) -> dict[str, str]:
    """All Spanish texts of the screens, without those of themes."""
    modules = (sar_tui.loop, sar_tui.app)
    folders = [Path(str(module.__file__)).parent for module in modules]
    return language("es", *folders, *(task_folder(catalogue.task(name)) for name in TASKS)).texts


def test_each_usted_has_a_form_of_tu(catalogue: Catalogue, shipped: dict[str, str]) -> None:
    own = catalogue.theme("playful", "es").texts
    assert spoken_to(list({**shipped, **own}.values())) == []


def test_each_tu_has_the_slots_of_usted(catalogue: Catalogue, shipped: dict[str, str]) -> None:
    written = read_words(catalogue.theme_folder("playful") / "words.es.toml")
    assert [
        problem for english, own in written.items() if (problem := slot_problem(english, own))
    ] == []
    assert set(written) - set(shipped) == set()
    assert [english for english, own in written.items() if own == shipped[english]] == []
