"""Checks how a task's prompts will look: which of them a session's screen cannot draw large."""

from collections.abc import Iterable, Iterator

from rich.cells import cell_len

from sar_tui.framework.messages import Prompt
from sar_tui.framework.task import Task
from sar_tui.plugins import PluginError
from sar_tui.widgets.large_characters import is_large, unknown
from sar_tui.widgets.task_view import TaskView, view_of

WIDTH, HEIGHT = 78, 9
"""Columns and rows for a drawing in a terminal of 80 by 24."""
_SHOWN = 8
"""At most this many examples are named."""


def size_warning(kind: type[Task], prompts: Iterable[Prompt]) -> str:
    """Return sentences on what is drawn small, or has a plain line wider than the screen; empty for a view of its own.

    Args:
        kind: the task.
        prompts: of simulated sessions.
    """
    if not _is_drawn_plainly(kind):
        return ""
    strange, long, wide = dict[str, None](), dict[str, None](), dict[str, None]()
    for prompt in prompts:
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
    if prompt.halves:
        yield from ((half, WIDTH // 2 - 2) for half in prompt.halves if half.strip())
    elif prompt.glyph.strip():
        yield prompt.glyph, WIDTH


def _sentences(strange: list[str], long: list[str], wide: list[str]) -> Iterator[str]:
    if strange:
        named = _named([f"{each} ({' '.join(f'U+{ord(part):04X}' for part in each)})" for each in strange])
        yield f"Prompts with these characters are drawn small, in a frame, as there are no large ones: {named}."
    if long:
        yield f"These prompts are too long to be drawn large in a terminal of 80 columns: {_named(long)}."
    if wide:
        yield (
            f"These plain lines are wider than a terminal of 80 columns, so that their onset is less certain: "
            f"{_named(wide)}."
        )


def _named(items: list[str]) -> str:
    more = f" and {len(items) - _SHOWN} more" if len(items) > _SHOWN else ""
    return ", ".join(items[:_SHOWN]) + more
