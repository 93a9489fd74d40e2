"""Checks that a task keeps no state: a new one gives the same answers in another order."""

import random
from collections.abc import Callable
from typing import Any, NamedTuple

from sar_tui.loop.author_lines import at, line_of
from sar_tui.loop.task import Task
from sar_tui.model.trial_types import PastAttempt, Situation, Trial
from sar_tui.plugin_calls import PLUGIN_ERRORS, line_of_error

_METHODS = (
    "condition",
    "stimulus",
    "perceived",
    "timed_out",
    "score",
    "measures",
    "learning",
    "trials_at",
    "target",
)
_WATCHED = (*_METHODS, "rehearse")
"""Methods whose calls are kept; a simulated person, whom `rehearse` moves, is not asked again."""
_GIVEN = ("names", "tr")
"""Attributes of a task that the session sets."""
_MOST_KEPT = 5000
_MOST_ASKED = 400


class Call(NamedTuple):
    """A call of a task's method in a session, and what it returned."""

    method: str
    arguments: tuple[Any, ...]
    returned: Any
    given: dict[str, Any]


def recorded(kind: type[Task], calls: list[Call]) -> type[Task]:
    """Return a subclass of a task that is used like it, and keeps the calls of its methods."""
    wrapped = {name: _wrapped(name, getattr(kind, name), calls) for name in _WATCHED}
    return type(
        kind.__name__, (kind,), {**wrapped, "__module__": kind.__module__, "__doc__": kind.__doc__}
    )


def _wrapped(name: str, method: Callable[..., Any], calls: list[Call]) -> Callable[..., Any]:
    def call(self: Task, *arguments: Any) -> Any:
        kept = tuple(list(each) if isinstance(each, list) else each for each in arguments)
        returned = method(self, *arguments)
        # not of a copy with another goal
        if len(calls) < _MOST_KEPT and "target" not in vars(self):
            calls.append(
                Call(name, kept, returned, {given: getattr(self, given) for given in _GIVEN})
            )
        return returned

    return call


def problem(task: Task, calls: list[Call], seed: int) -> str:
    """Return a sentence if a new task answers calls that were made in a session otherwise, in a
    shuffled order.
    """
    asked = [call for call in calls if call.method in _METHODS]
    shuffled = random.Random(seed).sample(asked, min(len(asked), _MOST_ASKED))
    for call in shuffled:
        vars(task).update(call.given)
        try:
            returned = getattr(task, call.method)(*call.arguments)
        except PLUGIN_ERRORS as error:
            return at(
                line_of_error(error),
                f"{_where(call)} it raised {type(error).__name__} when it was asked in another "
                f"order ({error}).",
            )
        if returned != call.returned:
            return at(
                line_of(type(task), call.method),
                f"{_where(call)} it returned something else when a new task was asked in another "
                "order. Does it keep something from call to call? What it needs is in its "
                "arguments: see trial.percepts, situation.results and situation.history.",
            )
    return ""


def _where(call: Call) -> str:
    """Return the method and the place in the session: "In stimulus, at attempt 2, trial 3,"."""
    for argument in call.arguments:
        place = argument.situation if isinstance(argument, Trial) else argument
        if isinstance(place, Situation):
            return f"In {call.method}, at attempt {place.attempt}, trial {place.trial},"
        if isinstance(place, PastAttempt):
            return f"In {call.method}, at attempt {place.attempt},"
    return f"In {call.method}"
