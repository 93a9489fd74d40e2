"""Texts are larger where there is room, and complete everywhere."""

from sar_tui.app.screens.message_panel import large_message
from sar_tui.app.screens.waiting_text import WaitingText
from tests.app.app_driver import OpenSession

TEXT = WaitingText(
    "Welcome", "A key appears.\nPress that key.\n\nYou may rest.", "Press Enter to go on.", "Enter"
)


def test_the_key_comes_first_then_air_then_the_headline() -> None:
    def larger(height: int) -> tuple[bool, bool, bool]:
        message = large_message(TEXT, 88, height)
        assert message.press == TEXT.press
        return bool(message.key), message.text != TEXT.text, message.headline != TEXT.headline

    assert larger(10) == (False, False, False)
    assert larger(15) == (True, False, False)
    assert larger(17) == (True, True, False)
    assert larger(30) == (True, True, True)


def test_a_headline_of_several_words_or_without_large_letters_stays_as_it_is() -> None:
    for headline in ("Now level 2.", "Bienvenidísimos", "続き"):
        assert large_message(TEXT._replace(headline=headline), 88, 40).headline == headline


async def test_only_a_large_window_draws_the_key(open_session: OpenSession) -> None:
    async with open_session() as driver:
        assert "█" not in driver.text
        await driver.resize(100, 30)
        assert "█" in driver.text
        assert driver.sees("Press that key as fast as you can, and then wait for the next one.")
        assert driver.sees("Press Enter to go on.")
        await driver.resize(80, 24)
        assert "█" not in driver.text
