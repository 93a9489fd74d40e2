"""The screens as they stand at 80 by 24, in every theme, as plain text.

They are kept in ``snapshots/``. ``SAR_TUI_UPDATE_SNAPSHOTS=1`` draws them anew; then look at what has changed.
"""

import os
from pathlib import Path

import pytest

from sar_tui.framework.task import Task
from sar_tui.plugins import Catalogue
from tests.app.chair import Chair, plan, sit_down

FOLDER = Path(__file__).parent / "snapshots"
THEMES = ("calm", "high-contrast", "playful")
HOME = ("home", "help", "new-participant", "home-with-a-participant", "settings", "settings-to-mend", "too-small")
SESSION = (
    "instructions",
    "before-practice",
    "prompt",
    "between-prompts",
    "paused",
    "tired",
    "in-pain",
    "end-now",
    "before-an-attempt",
    "disk-full",
    "disk-works-again",
    "review",
    "summary",
)


class Album:
    """Compares screens with their snapshots, and tells in the end which have changed."""

    def __init__(self, theme: str) -> None:
        self._theme = theme
        self.taken: list[str] = []
        self.changed: dict[str, str] = {}

    def take(self, name: str, chair: Chair) -> None:
        assert len(chair.rows) <= 24
        assert max(map(len, chair.rows)) <= 80
        self.taken.append(name)
        path = FOLDER / f"{name}.{self._theme}.txt"
        seen = chair.text.rstrip("\n") + "\n"
        if os.environ.get("SAR_TUI_UPDATE_SNAPSHOTS"):
            path.write_text(seen, encoding="utf-8")
        elif not path.exists() or path.read_text(encoding="utf-8") != seen:
            self.changed[name] = seen

    def check(self) -> None:
        for name, seen in self.changed.items():
            print(f"--- {name} is now:\n{seen}")
        assert not self.changed, f"{', '.join(self.changed)}: SAR_TUI_UPDATE_SNAPSHOTS=1 keeps them as they are now"


@pytest.mark.parametrize("theme", THEMES)
async def test_home_and_settings_look_as_they_did(theme: str, data: Path, catalogue: Catalogue) -> None:
    album = Album(theme)
    async with sit_down(data, catalogue) as chair:
        chair.app.screen.query_one("#theme").highlighted = THEMES.index(theme)  # type: ignore[attr-defined]
        await chair.settle()
        album.take("home", chair)
        await chair.press("f1")
        album.take("help", chair)
        await chair.press("enter", "enter")
        await chair.write(*"Peter Maier")
        album.take("new-participant", chair)
        await chair.press("ctrl+u")
        await chair.write(*"p01")
        await chair.press("enter")
        album.take("home-with-a-participant", chair)
        await chair.press("f2")
        album.take("settings", chair)
        await chair.press("end")
        await chair.write("x")
        album.take("settings-to-mend", chair)
        await chair.resize(60, 20)
        album.take("too-small", chair)
    assert tuple(album.taken) == HOME
    album.check()


@pytest.mark.parametrize("theme", THEMES)
async def test_a_session_looks_as_it_did(theme: str, data: Path, catalogue: Catalogue, keyboard: type[Task]) -> None:
    album = Album(theme)
    async with sit_down(data, catalogue, plan(keyboard, theme=theme, attempts=4, practice_attempts=1)) as chair:
        album.take("instructions", chair)
        await chair.press("enter")
        album.take("before-practice", chair)
        prompt = await chair.begin()
        album.take("prompt", chair)
        await chair.answer(prompt)
        album.take("between-prompts", chair)
        await chair.to_prompt()
        await chair.press("escape")
        album.take("paused", chair)
        for name in ("tired", "in-pain", "end-now"):
            await chair.press("down", "enter")
            album.take(name, chair)
        await chair.press("enter")
        await chair.answer(await chair.to_prompt())
        album.take("before-an-attempt", chair)
        await chair.do_attempt(await chair.begin())
        await chair.begin()
        await chair.disk(False)
        album.take("disk-full", chair)
        await chair.disk(True)
        album.take("disk-works-again", chair)
        await chair.press("enter")
        await chair.do_attempt(await chair.to_prompt())
        await chair.answer(await chair.begin(), after_ms=1900)
        await chair.answer(await chair.to_prompt(), after_ms=900)
        await chair.begin()
        await chair.wait(6000)
        await chair.to_prompt()
        await chair.wait(6000)
        album.take("review", chair)
        await chair.see_the_summary()
        await chair.wait(8000)  # the last gestures end
        album.take("summary", chair)
    assert tuple(album.taken) == SESSION
    album.check()


def test_there_is_no_snapshot_of_a_screen_that_is_gone() -> None:
    names = {f"{name}.{theme}.txt" for name in (*HOME, *SESSION) for theme in THEMES}
    assert {path.name for path in FOLDER.iterdir()} == names
