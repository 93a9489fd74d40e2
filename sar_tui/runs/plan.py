"""The plan of a session, and the checks that it can be carried out."""

from pathlib import Path

import msgspec

from sar_tui.framework.declaration import ParameterError
from sar_tui.framework.parameters import TaskParameters
from sar_tui.framework.task import Task
from sar_tui.framework.theme import Theme
from sar_tui.store import sessions
from sar_tui.store.database import StoreError
from sar_tui.theme_folder import languages


class Plan(msgspec.Struct, frozen=True):
    """What a session will be. ``partner``: who sits at seat B, in a task for two. ``id``: the session's; else drawn."""

    task: type[Task]
    parameters: TaskParameters
    theme: str
    participant: str
    seed: int
    mode: sessions.Mode = "live"
    partner: str = ""
    id: str = ""


class Failed(Exception):
    """A session could not go on; one or two clear sentences."""


def check_seats(task: type[Task], participant: str, partner: str) -> None:
    """Raise StoreError unless as many different participants are named as a task has seats."""
    if len(task.seats) == 1 and partner:
        raise StoreError(f"The task {task.name} is for one: name one participant only.", bad_input=True)
    if len(task.seats) > 1 and not partner:
        raise StoreError(
            f"The task {task.name} is for two: name the participant on the left, and then the one on the right.",
            bad_input=True,
        )
    if participant.strip().upper() == partner.strip().upper():
        raise StoreError(f"{participant} cannot sit at both seats: name two participants.", bad_input=True)


def check_language(language: str, folder: Path) -> None:
    """A language of which a theme has nothing at all is more likely a slip than a wish for English."""
    known = languages(folder)
    if language.partition("-")[0] not in {name.partition("-")[0] for name in known}:
        raise ParameterError({"language": f"The theme {folder.name} has no {language}; it has: {', '.join(known)}."})


def check_outputs(parameters: TaskParameters) -> None:
    """Raise ParameterError if there is no output of a name that ``outputs`` has, or ``speech`` can go nowhere."""
    from sar_tui.outputs.output import OutputError
    from sar_tui.outputs.outputs import check_outputs as check

    try:
        check(parameters.outputs, parameters.speech)
    except OutputError as error:
        raise ParameterError({"outputs": str(error)}) from error


def set_up(kind: type[Task], parameters: TaskParameters, theme: Theme) -> Task:
    """The task with its parameters; a start level that it does not have is refused."""
    if parameters.outputs != ("screen",):
        check_outputs(parameters)
    try:
        task = kind(parameters)
        levels = task.levels
    except Exception as error:
        raise Failed(f"The task {kind.name} cannot be set up ({type(error).__name__}: {error}).") from error
    for name in ("start_level", "min_level"):
        if (level := getattr(parameters, name)) > levels:
            raise ParameterError(
                {name: f"The task {kind.name} has {levels} levels as it is set; there is no level {level}."}
            )
    return task
