"""Result of one check of a plug-in."""

from collections.abc import Callable

import msgspec

from sar_tui.loop.author_lines import at
from sar_tui.plugin_calls import PLUGIN_ERRORS, line_of_error
from sar_tui.plugin_loader import CURRENT_NAMES
from sar_tui.rules.declaration import ParameterError
from sar_tui.runs.plan import Failed


class Check(msgspec.Struct, frozen=True):
    """A named check, the problems it found, and, if worth showing, what it found otherwise.

    ``warning``: something to think about that breaks no contract.
    """

    check: str
    problems: tuple[str, ...] = ()
    found: str = ""
    warning: str = ""

    @property
    def line(self) -> str:
        """The line that is printed."""
        sign = "✗" if not self.ok else "!" if self.warning else "✓"
        told = " ".join(filter(None, (*self.problems, self.warning)))
        return f"{sign} {self.check}" + (f". {told}" if told else "")

    @property
    def ok(self) -> bool:
        """True if there is no problem."""
        return not self.problems


def checked(name: str, problem: str | Callable[[], str]) -> Check:
    """Return a check with the problem given or found; an exception is a problem as well."""
    try:
        found = problem if isinstance(problem, str) else problem()
    except PLUGIN_ERRORS as error:
        found = reason(error)
    return Check(name, (found,) if found else ())


def reason(error: BaseException) -> str:
    """Return why a plug-in failed, at the last line of a task's own files that the error
    passed.
    """
    if isinstance(error, ParameterError | Failed):
        return str(error)
    line = line_of_error(error)
    raised = f"{'' if line else 'It raised '}{type(error).__name__}: {error}."
    hint = f" {CURRENT_NAMES}" if isinstance(error, AttributeError) else ""
    return at(line, raised + hint)
