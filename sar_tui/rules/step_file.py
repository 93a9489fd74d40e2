"""Steps from a file: TOML, with a table ``[[steps]]`` for each."""

from pathlib import Path

import msgspec

from sar_tui.model.step import Step, problem

MOST_STEPS = 200


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
        read = msgspec.toml.decode(path.read_bytes(), type=_Steps)
    except OSError as error:
        raise StepFileError(
            f"The steps cannot be read: {error.strerror or error}: {path.name}."
        ) from error
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise StepFileError(f"{path.name} is not a list of steps: {error}.") from error
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
    return next(filter(None, map(problem, steps)), "")
