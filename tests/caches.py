"""Savings of time for all tests: caches of parsed style sheets and of the bundled themes; and, in a
quick run, apps without a terminal compose no frames.
"""

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import typer.main
from rich.console import RenderableType
from textual._compositor import Compositor
from textual._context import active_app
from textual.css import stylesheet
from textual.css.model import RuleSet
from textual.screen import Screen

from sar_tui import plugins, theme_folder
from sar_tui.model.theme import ENGLISH, Theme
from tests.examples import QUICK


def _cached_parse(parse: Callable[..., Any]) -> Callable[..., list[RuleSet]]:
    parsed: dict[object, list[RuleSet]] = {}

    def cached(*given: Any, variable_tokens: dict[str, list[Any]], **more: Any) -> list[RuleSet]:
        variables = tuple(
            (name, tuple(token.value for token in tokens))
            for name, tokens in variable_tokens.items()
        )
        key = (given, variables, tuple(more.items()))
        if key not in parsed:
            parsed[key] = list(parse(*given, variable_tokens=variable_tokens, **more))
        return parsed[key]

    return cached


def _cached_themes(read_theme: Callable[..., Theme], shipped: Path) -> Callable[..., Theme]:
    themes: dict[object, Theme] = {}

    def cached(folder: Path, language: str = ENGLISH, base: Theme | None = None) -> Theme:
        if folder.parent != shipped:
            return read_theme(folder, language, base)
        key = (folder, language, base is None)
        if key not in themes:
            themes[key] = read_theme(folder, language, base)
        return themes[key]

    return cached


_render_update = Compositor.render_update


def _without_frames(
    compositor: Compositor,
    full: bool = False,
    screen_stack: list[Screen[Any]] | None = None,
    simplify: bool = False,
) -> RenderableType | None:
    """Compose a whole screen, as tests do that look at it, but no frame for a terminal that is not
    there.
    """
    if full or not active_app.get().is_headless:
        return _render_update(compositor, full, screen_stack, simplify)
    compositor._dirty_regions.clear()
    return None


def compose_frames(patch: pytest.MonkeyPatch) -> None:
    """Let apps compose their frames in a quick run, too."""
    patch.setattr(Compositor, "render_update", _render_update)


@pytest.fixture(scope="session", autouse=True)
def _caches() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stylesheet, "parse", _cached_parse(stylesheet.parse))
        patch.setattr(typer.main, "get_command", cache(typer.main.get_command))
        patch.setattr(
            theme_folder,
            "read_theme",
            _cached_themes(theme_folder.read_theme, plugins._shipped("themes")),
        )
        if QUICK:
            patch.setattr(Compositor, "render_update", _without_frames)
        yield
