"""All screens of a session in Spanish are in Spanish only."""

from itertools import chain
from pathlib import Path
from typing import Any

import msgspec
import pytest
from textual.binding import Binding

import sar_tui.app
from sar_tui.app.app import SarTui
from sar_tui.app.screens.sensor_check import SensorCheckScreen
from sar_tui.app.screens.session import SessionScreen
from sar_tui.app.screens.settings import SettingsScreen
from sar_tui.app.screens.wellbeing import ENDS, PLACES, WellbeingScreen
from sar_tui.checks.task_translations import texts_in
from sar_tui.loop.topics import SENSOR
from sar_tui.model.language import language, read_words, slot_problem
from sar_tui.model.messages import SensorChanged, SensorState
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.reports.charts import MARKERS
from sar_tui.rules.declaration import COMMON, texts
from sar_tui.rules.parameters import fields
from sar_tui.runs.plan import Plan, make_plan
from sar_tui.store.wellbeing import NOT_SAID
from sar_tui.tui.base_app import BaseApp
from sar_tui.tui.language import app_language, session_language
from tests.app.app_driver import AppDriver, OpenApp, known
from tests.untranslated import english_in, phrases

APP = Path(sar_tui.app.__file__).parent
_FRAMES = str.maketrans("│▌╭╮╰╯─━", "        ")


def plan(catalogue: Catalogue, name: str, theme: str = "calm", **parameters: Any) -> Plan:
    settings = {"language": "es", "attempts": 2, **parameters}
    return make_plan(catalogue, name, ["P01"], settings, theme=theme, seed=7)


class Tour:
    """Walk through a session that collects the texts seen."""

    def __init__(self, driver: AppDriver) -> None:
        self.driver = driver
        self.seen: list[str] = []

    def look(self, *words: str) -> None:
        """Collect the texts on the screen, and check that these are among them."""
        self.seen += [
            " ".join(self.driver.text.translate(_FRAMES).split()),
            *self.driver.text.split("\n"),
        ]
        for each in words:
            assert self.driver.sees(each), f"{each!r} is not on the screen:\n{self.driver.text}"

    async def press(self, key: str, *words: str) -> None:
        await self.driver.press(key)
        self.look(*words)

    async def sensor(self, state: SensorState) -> None:
        changed = SensorChanged(state=state, at=self.driver.clock.now(), rate_hz=250.0)
        self.driver.session.bus.post(SENSOR, changed)
        await self.driver.settle()

    def found(self, catalogue: Catalogue) -> list[tuple[str, str]]:
        """Return the English texts found."""
        said = phrases(catalogue.theme("calm"), catalogue.theme("calm", "es"))
        return english_in(self.seen, session_language(self.driver.session.task).texts | said)


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
    answers = {NOT_SAID, *PLACES.values(), *chain.from_iterable(ENDS.values())}
    texts = {"palette", *labels, *MARKERS, *answers}.union(
        *(texts_in(path.read_text("utf-8")) for path in code)
    )
    translations = read_words(APP / "words.es.toml")
    assert set(translations) == texts
    assert [
        problem for text, own in translations.items() if (problem := slot_problem(text, own))
    ] == []


def test_texts_of_a_theme_precede_those_of_the_app() -> None:
    tr = app_language("es", {"Welcome": "¡Hola!"})
    assert (tr("Welcome"), tr("Go on")) == ("¡Hola!", "Seguir")


def test_an_untranslated_language_is_english() -> None:
    assert app_language("de")("Press {key} to start.", key="Space") == "Press Space to start."


# --- sessions


async def test_a_session_of_keys_is_in_spanish_from_the_welcome_to_the_summary(
    opened: OpenApp, catalogue: Catalogue
) -> None:
    settings = {"prompts_per_attempt": 2, "practice_attempts": 1, "threshold": 850.0}
    async with opened(plan(catalogue, "keyboard", **settings)) as driver:
        tour = Tour(driver)
        tour.look(
            "Reacción con el teclado",
            "Le damos la bienvenida",
            "Pulse Enter para seguir.",
            "Pausa",
            "Ayuda",
        )
        await tour.press(
            "f1", "Cuando se lo pida la pantalla, pulse Enter.", "Pulse Enter para cerrar esto."
        )
        await tour.press("enter")
        await tour.press(
            "enter",
            "Intento de práctica 1 de 1",
            "Pulse Enter para empezar el intento de práctica 1 de 1.",
        )
        tour.look(
            "en menos de 0,85 segundos de media, y acertar 2 de 2.", "nivel 1", "Teclas 0 de 2"
        )
        prompt = await driver.begin()
        tour.look(f"Pulse: {prompt.expected}", "Práctica 0 de 1")
        await tour.press(
            "escape", "En pausa", "Tómese su tiempo.", "flechas para elegir, Enter para confirmar"
        )
        await tour.press("down")
        await tour.press("enter", "Descanse todo lo que necesite.")
        await tour.press("down")
        await tour.press("enter", "Antes de seguir, hable del dolor con su terapeuta")
        await tour.press("down")
        await tour.press("enter", "¿Terminar ahora la sesión?", "Sí, terminar la sesión")
        await driver.resize(60, 20)
        tour.look(
            "Esta ventana es demasiado pequeña.",
            "Tiene 60 por 20 caracteres; hacen falta 80 por 24.",
        )
        await driver.resize(80, 24)
        await tour.press("enter")
        await driver.do_attempt(await driver.to_prompt())
        await driver.disk(working=False)
        tour.look(
            "Por favor, avise a quien dirige la sesión", "El ordenador no puede guardar ahora mismo"
        )
        await driver.disk(working=True)
        tour.look("Gracias por esperar", "Ya se guarda todo otra vez.")
        await tour.press("enter", "Intento 1 de 2", "Intentos 0 de 2")
        await driver.do_attempt(await driver.begin())
        tour.look("Intento 2 de 2")
        await driver.do_attempt(await driver.begin())
        tour.look("Ya está todo", "Ese ha sido el último intento.")
        await driver.see_the_summary()
        tour.look(
            "Ha hecho 2 intentos; meta alcanzada en 2.",
            "metas alcanzadas",
            "Pulse Enter para terminar.",
        )
        assert tour.found(catalogue) == []


@pytest.mark.slow
async def test_a_session_of_reaches_is_in_spanish_from_the_sensor_to_the_summary(
    opened: OpenApp, catalogue: Catalogue
) -> None:
    async with opened(plan(catalogue, "reaching", imu="simulated")) as driver:
        tour = Tour(driver)
        await driver.wait(2000)
        tour.look(
            "Comprobar el sensor",
            "Sujete el sensor como en el dibujo",
            "Muestras",
            "Empezar",
            "Alcance",
        )
        await tour.press("z", "El sensor elimina su sesgo")
        await tour.press("t", "Apoye la mano en el punto de salida")
        await driver.wait(2000)
        tour.look("Ahora extienda el brazo, vuelva y descanse.")
        await driver.wait(6000)
        tour.look("s: ida 0,46, pausa 0,00, vuelta 0,34; máximos +2,4 y −3,4 rad/s.", "F1 Ayuda")
        await tour.press("f1", "Sujete el sensor al dorso de la mano", "Probar")
        await tour.press("enter")

        await tour.press(
            "enter", "Le damos la bienvenida", "Apoye la mano del sensor en el punto de salida."
        )
        await tour.press("f1", "F8 con compensación, F9 con ayuda.")
        await tour.press("enter")
        await tour.press(
            "enter", "Hasta el marcador 1 (15 cm) y vuelta.", "Su meta: menos de 1,20 segundos."
        )
        await tour.sensor("detached")
        tour.look("Espere, por favor", "El sensor de su mano no envía datos ahora mismo.")
        await tour.sensor("attached")
        await driver.wait(300)
        await tour.press(
            "space",
            "Pulse Enter para empezar el intento 1 de 2. (Más tarde hará falta la barra "
            "espaciadora.)",
        )
        for attempt in (1, 2):
            await driver.wait(300)
            await tour.press("enter")
            await driver.wait(3000)
            tour.look("¿Todo listo?", "Pulse la barra espaciadora para empezar.")
            await tour.press("space", "Alcance: 15 cm" if attempt == 1 else "Alcance: ")
            await driver.wait(2500)
            await tour.press("space")
            await driver.wait(1500)
            tour.look(f"Intentos {attempt} de 2", "ida", "vuelta")
            await tour.press("f7", "Marcado: marcador no tocado")
        await driver.see_the_summary()
        tour.look("Ha hecho 2 intentos")
        assert tour.found(catalogue) == []


@pytest.mark.slow
async def test_an_interrupted_session_is_resumed_in_its_language(
    opened: OpenApp, catalogue: Catalogue
) -> None:
    async with opened(plan(catalogue, "keyboard", prompts_per_attempt=2)) as driver:
        await driver.answer(await driver.to_first_prompt())
        await driver.wait(300)
        session = driver.session_id
    async with opened(session) as driver:
        tour = Tour(driver)
        tour.look(
            "Nos alegra verle de nuevo",
            "Seguimos con el intento 1 de 2.",
            "Pulse Enter para seguir.",
        )
        assert tour.found(catalogue) == []


@pytest.mark.parametrize("name", Catalogue().task_names())
def test_every_setting_has_a_title_and_a_meaning_in_spanish(
    catalogue: Catalogue, name: str
) -> None:
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


async def test_settings_are_in_the_language_of_the_saved_sessions(
    opened: OpenApp, data: Path
) -> None:
    known(data, "P01", language="es")
    async with opened() as driver:
        await driver.press("f2")
        assert driver.sees("Configuración de P01 para Reacción con el teclado: versión 1")
        assert driver.sees("Teclas por intento")
        assert driver.sees("Número de teclas de un intento. De 1 a 200.")
        assert "Ctrl-S Guardar" in driver.rows[-1]
        await driver.press("/", *"manos", "escape", "down", "enter", "down", "enter", "ctrl+s")
        assert driver.sees("● Teclas ambas manos → flechas")
        await driver.press(*"más fácil", "enter")
        assert driver.sees("guardada: versión 2")
        assert driver.sees("La próxima sesión empieza en el nivel 1.")


@pytest.mark.slow
async def test_home_stays_english_after_a_session_in_spanish(opened: OpenApp, data: Path) -> None:
    known(data, "P01", language="es")
    async with opened() as driver:
        await driver.press("right", "right", "right", "enter")
        assert "F1 Ayuda" in driver.rows[-1]
        await driver.press("escape", "up", "up", "enter", "down", "enter")
        await driver.wait(300)
        assert driver.sees("Terminado antes de acabar el primer intento.")
        await driver.press("enter")
        assert driver.screen_name == "HomeScreen"
        assert "F1 Help" in driver.rows[-1]
        await driver.press("f1")
        assert driver.sees("Press Enter to close this.")


@pytest.mark.slow
async def test_a_theme_may_replace_texts_of_the_app(
    opened: OpenApp, tmp_path: Path, catalogue: Catalogue, monkeypatch: pytest.MonkeyPatch
) -> None:
    theme = catalogue.theme("calm", "es")
    own = msgspec.structs.replace(
        theme, texts={"Welcome": "¡Hola!", "Your goal: less than {goal}.": "Meta: {goal}."}
    )
    monkeypatch.setattr(Catalogue, "theme", lambda self, name, language="en": own)
    async with opened(plan(catalogue, "keyboard")) as driver:
        assert driver.sees("¡Hola!")
        assert driver.sees("Pulse Enter para seguir.")
        assert driver.session.task.tr("Your goal: less than {goal}.", goal="5 s") == "Meta: 5 s."


def test_degrees_per_second_are_in_spanish_format() -> None:
    assert app_language("es")("bias deg/s") == "sesgo °/s"
