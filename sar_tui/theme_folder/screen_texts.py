"""Reads ``words.<language>.toml``: a theme's own wordings of texts on the screens."""

from pathlib import Path

from sar_tui.model.language import slot_problem, words_files
from sar_tui.model.visible_text import control_problem
from sar_tui.theme_folder.appearance import read_toml


def screen_texts(folder: Path, language: str) -> tuple[dict[str, str], list[str]]:
    """Return the usable wordings for a language by their English, and the problems of the others.

    Raises:
        ThemeError: a file is not TOML.
    """
    texts: dict[str, str] = {}
    problems: list[str] = []
    for path in words_files(folder, language):
        if path.is_file():
            own, wrong = read_texts(path)
            texts.update(own)
            problems += wrong
    return texts, problems


def read_texts(path: Path) -> tuple[dict[str, str], list[str]]:
    """Return the usable wordings in one file, and the problems of the others. Raises ThemeError."""
    texts: dict[str, str] = {}
    problems = []
    for english, own in read_toml(path).items():
        if not isinstance(own, str):
            problems.append(f"The wording of {english!r} in {path.name} is not a text.")
        elif problem := slot_problem(english, own):
            problems.append(f"The wording of {english!r} in {path.name} {problem}.")
        elif problem := control_problem(f"The wording of {english!r} in {path.name}", own):
            problems.append(problem)
        else:
            texts[english] = own
    return texts, problems
