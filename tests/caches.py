"""Caches shared by all tests: parsed style sheets and the bundled themes."""

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import typer.main
from textual.css import stylesheet
from textual.css.model import RuleSet

from sar_tui import plugins, theme_folder
from sar_tui.model.theme import ENGLISH, Theme


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
        yield
