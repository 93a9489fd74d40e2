"""Checks how a task's prompts will look: what is drawn small, which colours they have, and their
pictures.
"""

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from rich.cells import cell_len

from sar_tui.app.prompt_needs import NO_COLOR, colour_problems, picture_problems
from sar_tui.checks.check import Check
from sar_tui.loop.prompt_colors import OKABE_ITO, color_on
from sar_tui.loop.task import Task
from sar_tui.model.contrast import contrast, cut
from sar_tui.model.messages import Prompt
from sar_tui.model.theme import Theme
from sar_tui.plugins import PluginError, task_folder
from sar_tui.widgets.large_characters import is_large, unknown
from sar_tui.widgets.task_view import TaskView, view_of

WIDTH, HEIGHT = 78, 11
"""Columns and rows for a drawing in a terminal of 80 by 24."""
_LARGEST = 4_000_000
"""Pixels of a picture that can be prepared in a foreperiod."""
_SHOWN = 8
"""At most this many examples are named."""


def checks(kind: type[Task], prompts: Sequence[Prompt], themes: Iterable[Theme]) -> Iterator[Check]:
    """Check the prompts of simulated sessions, on the backgrounds of some themes."""
    yield Check("draws its prompts large", warning=size_warning(kind, prompts))
    if colours := list(dict.fromkeys(prompt.colour for prompt in prompts if prompt.colour)):
        yield colour_check(colours, prompts, themes)
    if names := list(dict.fromkeys(prompt.picture for prompt in prompts if prompt.picture)):
        folder = task_folder(kind)
        problems = picture_problems(prompts, folder)
        warning = "" if problems else _large_pictures(folder, names)
        yield Check("has the pictures of its prompts", tuple(problems), ", ".join(names), warning)


def colour_check(
    colours: Sequence[str], prompts: Iterable[Prompt], themes: Iterable[Theme]
) -> Check:
    """Check that the colours of prompts exist; tell their contrasts, and where they are not as
    published.
    """
    known = [colour for colour in colours if colour in OKABE_ITO]
    contrasts, changed = [], []
    for theme in themes:
        ground = theme.colors.background
        least = min((contrast(color_on(name, ground), ground) for name in known), default=21.0)
        contrasts.append(f"{theme.name} {cut(least):.2f}")
        if others := [name for name in known if color_on(name, ground) != OKABE_ITO[name]]:
            changed.append(
                f"With the theme {theme.name}, these are darker or lighter: {', '.join(others)}."
            )
    if "NO_COLOR" in os.environ:
        changed.append(NO_COLOR)
    found = f"least contrast: {', '.join(contrasts)}" if known else ""
    return Check(
        "has colours of the colour-blind-safe set",
        tuple(colour_problems(prompts)),
        found,
        " ".join(changed),
    )


def _large_pictures(folder: Path, names: Iterable[str]) -> str:
    """Return a sentence that names pictures so large that a foreperiod may be too short to prepare
    them.
    """
    from PIL import Image

    large = []
    for name in names:
        with Image.open(folder / name) as picture:
            if picture.width * picture.height > _LARGEST:
                large.append(f"{name} ({picture.width}×{picture.height})")
    return (
        f"Make these pictures smaller, so that they are soon prepared: {_named(large)}."
        if large
        else ""
    )


def size_warning(kind: type[Task], prompts: Iterable[Prompt]) -> str:
    """Return sentences on what is drawn small, or has a plain line wider than the screen; empty for
    a view of its own.

    Args:
        kind: the task.
        prompts: of simulated sessions.
    """
    if not _is_drawn_plainly(kind):
        return ""
    strange, long, wide = dict[str, None](), dict[str, None](), dict[str, None]()
    for prompt in (one.shown(place) for one in prompts for place in range(max(1, len(one.frames)))):
        for glyph, columns in _drawings(prompt):
            if missing := unknown(glyph):
                strange.update(dict.fromkeys(missing))
            elif not is_large(glyph, columns, HEIGHT):
                long[glyph] = None
        if cell_len(prompt.text) > WIDTH:
            wide[prompt.text] = None
    return " ".join(_sentences(list(strange), list(long), list(wide)))


def _is_drawn_plainly(kind: type[Task]) -> bool:
    try:
        return view_of(kind).prompt_lines is TaskView.prompt_lines
    except PluginError:
        return False


def _drawings(prompt: Prompt) -> Iterator[tuple[str, int]]:
    """Yield what a prompt draws, with the columns that there are for it."""
    if prompt.picture:
        return
    if prompt.halves:
        yield from ((half, WIDTH // 2 - 2) for half in prompt.halves if half.strip())
    elif prompt.glyph.strip():
        yield prompt.glyph, WIDTH


def _sentences(strange: list[str], long: list[str], wide: list[str]) -> Iterator[str]:
    if strange:
        named = _named(
            [f"{each} ({' '.join(f'U+{ord(part):04X}' for part in each)})" for each in strange]
        )
        yield (
            "Prompts with these characters are drawn small, in a frame, as there are no large "
            f"ones: {named}."
        )
    if long:
        yield (
            "These prompts are too long to be drawn large in a terminal of 80 columns: "
            f"{_named(long)}."
        )
    if wide:
        yield (
            "These plain lines are wider than a terminal of 80 columns, so that their onset is "
            "less certain: "
            f"{_named(wide)}."
        )


def _named(items: list[str]) -> str:
    more = f" and {len(items) - _SHOWN} more" if len(items) > _SHOWN else ""
    return ", ".join(items[:_SHOWN]) + more
