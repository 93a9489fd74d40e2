"""Needs of a task's prompts: colours that the terminal shows, and files of pictures in the task's
folder.

Asked before a session, so that it is never missing in one.
"""

import importlib.util
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Protocol

from sar_tui.loop.prompt_colors import color_problem
from sar_tui.loop.task import Task
from sar_tui.loop.task_pictures import picture_file
from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.trial_types import Situation
from sar_tui.plugin_calls import PLUGIN_ERRORS
from sar_tui.plugins import task_folder
from sar_tui.widgets.prompt_pictures import decode_problem, no_package

PROMPTS = 500
"""At most this many prompts of a task are looked at."""
NO_COLOR = (
    "The prompts of this task have colours, which NO_COLOR turns off in this terminal. "
    "Unset it first."
)


class Shown(Protocol):
    """A stimulus, a prompt, or a frame of it."""

    @property
    def colour(self) -> str: ...

    @property
    def picture(self) -> str: ...


def refusal(task: Task, seed: int, *, no_color: bool) -> str:
    """Return a sentence that says why a task's prompts cannot be shown here; empty if they can.

    Looks at the prompts of a session with this seed, at all levels. A task that fails has no
    prompts here: its session will say so. A task whose code names neither colours nor pictures is
    not asked for prompts ahead of their time.
    """
    if not _names_them(task_folder(type(task))):
        return ""
    try:
        prompts = list(islice(prompts_of(task, seed), PROMPTS))
    except PLUGIN_ERRORS:
        return ""
    if problem := next(iter(colour_problems(prompts)), ""):
        return problem
    if no_color and any(prompt.colour for prompt in prompts):
        return NO_COLOR
    return next(iter(picture_problems(prompts, task_folder(type(task)))), "")


def _names_them(folder: Path) -> bool:
    """Return True if the code of a task speaks of colours or pictures."""
    sources = (file.read_text(encoding="utf-8", errors="replace") for file in folder.glob("*.py"))
    return any(word in source for source in sources for word in ("colour", "picture"))


def colour_problems(prompts: Iterable[Shown]) -> list[str]:
    """Return a sentence for each colour that prompts have, and that there is not."""
    return [
        problem
        for colour in _named(prompt.colour for prompt in prompts)
        if (problem := color_problem(colour))
    ]


def picture_problems(prompts: Iterable[Shown], folder: Path) -> list[str]:
    """Return a sentence for each picture of prompts that is missing or cannot be read, or for the
    missing extra.
    """
    names = _named(prompt.picture for prompt in prompts)
    if names and not has_pictures_extra():
        return [no_package()]
    return [problem for name in names if (problem := _picture_problem(folder, name))]


def has_pictures_extra() -> bool:
    """Return True if what draws pictures is installed."""
    return all(importlib.util.find_spec(name) for name in ("PIL", "textual_image"))


def _picture_problem(folder: Path, name: str) -> str:
    try:
        return decode_problem(picture_file(folder, name))
    except (ValueError, OSError) as error:
        return str(error)


def _named(names: Iterable[str]) -> Sequence[str]:
    return list(dict.fromkeys(filter(None, names)))


def prompts_of(task: Task, seed: int) -> Iterator[Shown]:
    parameters = task.parameters
    for attempt in range(1, parameters.practice_attempts + parameters.attempts + 1):
        for level in range(1, min(task.levels, parameters.max_level) + 1):
            for trial in range(1, task.trials_at(level) + 1):
                streams = RandomStreams(seed, attempt, trial)
                stimulus = task.stimulus(
                    Situation(attempt, trial, level, streams, RandomStreams(seed))
                )
                yield stimulus
                yield from stimulus.frames
