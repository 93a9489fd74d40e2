"""What operators do: steer the session, and rule over what the agent says."""

from typing import Literal

from sar_tui.framework.messages.base import Message


class Operator(Message, frozen=True, kw_only=True):
    """An act that steers the session.

    ``command``: ``pause``, ``resume``, ``end``, ``skip`` (this prompt), ``repeat`` (this prompt), ``level``
    (``value``), ``mark`` (the trial under way, else the last), ``stop`` (everything the agent says and does; ``at`` is
    the key's stamp). ``reason``: for a pause, how the person is: ``tired``,
    ``pain``, ``finished``, or empty; for a mark, which (see `task.Mark`).
    """

    command: Literal["pause", "resume", "end", "skip", "repeat", "level", "mark", "stop"]
    actor: str = "participant"
    reason: str = ""
    value: int | None = None
    at: int = 0
