"""The playful theme in Spanish addresses the participant as tú on every screen."""

import re
from pathlib import Path

import pytest

import sar_tui.app
import sar_tui.loop
from sar_tui.model.language import language, read_words, slot_problem
from sar_tui.plugins import Catalogue, task_folder
from sar_tui.runs.plan import make_plan
from tests.app.app_driver import AppDriver, OpenApp

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


def test_the_forms_of_usted_are_recognised(shipped: dict[str, str]) -> None:
    assert len(spoken_to(list(shipped.values()))) > 60


def test_every_text_with_usted_has_a_form_with_tu(
    catalogue: Catalogue, shipped: dict[str, str]
) -> None:
    own = catalogue.theme("playful", "es").texts
    assert spoken_to(list({**shipped, **own}.values())) == []


def test_each_form_with_tu_has_the_slots_of_its_english_text(
    catalogue: Catalogue, shipped: dict[str, str]
) -> None:
    written = read_words(catalogue.theme_folder("playful") / "words.es.toml")
    assert [
        problem for english, own in written.items() if (problem := slot_problem(english, own))
    ] == []
    assert set(written) - set(shipped) == set()
    assert [english for english, own in written.items() if own == shipped[english]] == []


class Child:
    """The texts on the screen at each step."""

    def __init__(self, driver: AppDriver) -> None:
        self.driver = driver
        self.seen: list[str] = []

    def look(self, *words: str) -> None:
        self.seen.append(" ".join(self.driver.text.split()))
        for each in words:
            assert self.driver.sees(each), f"{each!r} is not on the screen:\n{self.driver.text}"

    async def press(self, key: str, *words: str) -> None:
        await self.driver.press(key)
        self.look(*words)


async def test_a_session_of_keys_uses_tu_from_the_welcome_to_the_summary(
    opened: OpenApp, catalogue: Catalogue
) -> None:
    settings = {"language": "es", "attempts": 1, "prompts_per_attempt": 2}
    plan = make_plan(catalogue, "keyboard", ["P01"], settings, theme="playful", seed=7)
    async with opened(plan) as driver:
        child = Child(driver)
        child.look("¡Hola!", "Púlsala lo más rápido que puedas", "Pulsa Enter para seguir.")
        await child.press("f1", "Cuando la pantalla te lo pida, pulsa Enter.")
        await child.press("enter")
        await child.press(
            "enter", "Pulsa Enter para empezar el intento 1 de 1.", "Tu meta: pulsar la tecla"
        )
        prompt = await driver.begin()
        child.look(f"Pulsa: {prompt.expected}")
        await child.press("escape", "Tómate tu tiempo.")
        await child.press("down")
        await child.press("enter", "Descansa todo lo que quieras.")
        await child.press("enter")
        await driver.do_attempt(await driver.to_prompt())
        child.look("¡Ya está todo!")
        await driver.see_the_summary()
        child.look("Has hecho 1 intento", "Tu mejor marca", "Pulsa Enter para terminar.")
        assert spoken_to(child.seen) == []
