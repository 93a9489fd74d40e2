"""Questions between attempts: those that therapists can choose on the settings form, and those of a
file, TOML with a table ``[[steps]]`` for each.
"""

from pathlib import Path

import msgspec
from msgspec.structs import replace

from sar_tui.model.step import USUAL_SCALE, Step, problem
from sar_tui.model.toml_lines import TomlError, TomlLines, decode
from sar_tui.rules.wellbeing import PAIN_ENDS

MOST_STEPS = 200
"""Largest number of steps of a task or a file."""
_AGREE = ("not at all true", "a little true", "somewhat true", "rather true", "very true")
PAIN = "pain"
"""Name of the question about pain now: too much leads to the advice to stop, whoever declares a
question like it.
"""
QUESTIONS: dict[str, Step] = {
    step.name: step
    for step in (
        Step(
            name="exertion",
            text="How hard was that for you?",
            kind="number",
            labels=("no effort at all", "as hard as can be"),
        ),
        Step(
            name=PAIN,
            text="How strong is your pain now?",
            kind="number",
            labels=PAIN_ENDS,
        ),
        Step(
            name="tiredness",
            text="How tired are you now?",
            kind="number",
            labels=("not tired at all", "as tired as can be"),
        ),
        Step(
            name="enjoyment",
            text="I enjoyed this exercise very much.",
            kind="likert",
            labels=_AGREE,
        ),
        Step(
            name="difficulty",
            text="How was the exercise for you?",
            kind="likert",
            labels=("much too easy", "too easy", "just right", "too hard", "much too hard"),
        ),
        Step(name="remark", text="Is there anything you would like to tell us?", kind="text"),
    )
}
"""Questions by name. ``enjoyment`` is an item of the Intrinsic Motivation Inventory (Ryan 1982,
J Pers Soc Psychol 43:450-461), with five points instead of seven.
"""
EARLIER: dict[str, Step] = {
    "effort": Step(name="effort", text="How hard was that for you?", kind="borg")
}
"""Questions that sessions of earlier releases have, and that are not asked in new ones: Borg's CR10
needs a licence.
"""
_REPLACED = {"effort": "exertion"}
"""Questions that are asked in place of those."""


def chosen(names: tuple[str, ...], every: int) -> tuple[Step, ...]:
    """Return the questions of these names, each after so many attempts; 0: after the last.

    Raises KeyError for an unknown name.
    """
    return tuple(replace((QUESTIONS | EARLIER)[name], every=every) for name in names)


def current(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the questions that a new session asks for these names, such as those of a programme."""
    return tuple(dict.fromkeys(_REPLACED.get(name, name) for name in names))


class StepFileError(ValueError):
    """A file of steps cannot be used. The message is one or two sentences."""


class _Steps(msgspec.Struct, forbid_unknown_fields=True):
    steps: tuple[Step, ...]


def read_steps(path: Path) -> tuple[Step, ...]:
    """Return the steps of a file, in order.

    Raises:
        StepFileError: it cannot be read, or a step cannot be used.
    """
    try:
        text = path.read_bytes().decode()
        read = msgspec.convert(decode(text), _Steps)
    except OSError as error:
        raise StepFileError(
            f"The steps cannot be read: {error.strerror or error}: {path.name}."
        ) from error
    except UnicodeDecodeError:
        raise StepFileError(f"{path.name} is not a text in UTF-8.") from None
    except TomlError as error:
        raise StepFileError(f"{path.name}, {error}") from error
    except msgspec.ValidationError as error:
        raise StepFileError(TomlLines(text, path.name).invalid(str(error))) from error
    if why := problem_of(read.steps):
        raise StepFileError(f"{path.name}: {why}")
    return read.steps


def problem_of(steps: tuple[Step, ...]) -> str:
    """Return why some steps cannot be used together, in one sentence; empty if they can."""
    if not isinstance(steps, tuple | list):
        return (
            "The steps of a task are a tuple of Step, even if there is one, (Step(…),), not "
            f"{steps!r:.60}."
        )
    if wrong := [step for step in steps if not isinstance(step, Step)]:
        return f"Among the steps is {wrong[0]!r:.60}, which is no Step."
    names = [step.name for step in steps]
    if len(names) > MOST_STEPS:
        return f"There are {len(names)} steps; at most {MOST_STEPS} can be used."
    if twice := next((name for name in names if names.count(name) > 1), None):
        return f"Two steps are named {twice!r}."
    if any(step.name == PAIN and step.scale != USUAL_SCALE for step in steps):
        return f"The step {PAIN!r} goes from 0 to 10, as its limits do."
    return next(filter(None, map(problem, steps)), "")
