"""``words.<language>.toml``: a theme's own words for what the screens say."""

from pathlib import Path

from sar_tui.framework.language import slot_problem, words_files
from sar_tui.theme_folder.appearance import read_toml


def screen_texts(folder: Path, language: str) -> tuple[dict[str, str], list[str]]:
    """The words for a language that can be used, by their English, and what is wrong with the others.

    Raises:
        ThemeError: a file is no TOML.
    """
    texts: dict[str, str] = {}
    told: list[str] = []
    for path in words_files(folder, language):
        if path.is_file():
            own, wrong = read_texts(path)
            texts.update(own)
            told += wrong
    return texts, told


def read_texts(path: Path) -> tuple[dict[str, str], list[str]]:
    """The same, of one file. Raises ThemeError."""
    texts: dict[str, str] = {}
    told = []
    for english, own in read_toml(path).items():
        if not isinstance(own, str):
            told.append(f"The wording of {english!r} in {path.name} is not a text.")
        elif problem := slot_problem(english, own):
            told.append(f"The wording of {english!r} in {path.name} {problem}.")
        else:
            texts[english] = own
    return texts, told
