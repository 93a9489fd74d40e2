"""What a session is told on the command line: NAME=VALUE pairs, checked against the task's declaration."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from sar_tui.cli.errors import Refused

if TYPE_CHECKING:
    from sar_tui.framework.parameters import TaskParameters
    from sar_tui.framework.task import Task


def pairs(given: Sequence[str] | None) -> dict[str, str]:
    """NAME=VALUE pairs as a mapping; the last of a name counts. Raises Refused."""
    found = {}
    for pair in given or ():
        name, sign, value = pair.partition("=")
        if not sign or not name.strip():
            raise Refused(f"--set takes NAME=VALUE, such as --set attempts=10, not {pair!r}.")
        found[name.strip()] = value
    return found


def parameters(task: "type[Task]", values: Mapping[str, object]) -> "TaskParameters":
    """A task's checked parameters. Raises Refused, saying what is wrong and where to look."""
    from sar_tui.framework.declaration import ParameterError
    from sar_tui.framework.parameters import build

    try:
        return build(task.Parameters, values)
    except ParameterError as error:
        raise Refused(f"{error} `sar-tui tasks show {task.name}` lists what can be set.") from error
