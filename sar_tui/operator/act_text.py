"""Log text of acts that the session has published, in the past tense."""

from typing import Any

from sar_tui.link.peer import Welcome
from sar_tui.model.messages import (
    Action,
    Decision,
    Message,
    ModeChanged,
    NoteAdded,
    PendingApproval,
    Proposal,
    Remark,
    SessionCommand,
)

_MAX_KINDS = 500
_COMMANDS = {
    "skip": "Skipped the prompt",
    "repeat": "Repeated the prompt",
    "end": "Ended the session",
}


class KindsOfAction:
    """Kinds of the latest proposals and actions, by id."""

    def __init__(self) -> None:
        self._kinds: dict[str, str] = {}

    def receive(self, message: Message) -> None:
        """Note the kind of a proposal or an action."""
        if isinstance(message, PendingApproval):
            message = message.proposal
        if isinstance(message, Proposal | Action):
            self._kinds[message.id] = message.kind
            if len(self._kinds) > _MAX_KINDS:
                del self._kinds[next(iter(self._kinds))]

    def __getitem__(self, id: str) -> str:
        return self._kinds.get(id, "proposal")


def is_stop(message: Any) -> bool:
    """Return True for a stop of the agent."""
    return isinstance(message, SessionCommand) and message.command == "stop"


def act_text(message: Message, me: Welcome, kinds: KindsOfAction) -> str:  # noqa: PLR0911
    """Return the text of an act; empty for a pause, its end and a stop, which have lines of their
    own.
    """
    match message:
        case Decision():
            return _decision(message, kinds[message.action])
        case Remark():
            to = f" to {me.participants[message.seat]}" if len(me.participants) > 1 else ""
            return (
                f"Said{to} “{message.text}”"
                if message.text
                else f"Gesture: {message.gesture.replace('_', ' ')}"
            )
        case ModeChanged():
            return f"{message.kind.capitalize()}: {message.mode}"
        case NoteAdded():
            return f"Event: {message.label}" if message.label else f"Noted “{message.text}”"
        case SessionCommand(command="skip", reason="rest"):
            return "Ended the rest"
        case SessionCommand(command="skip", reason="step"):
            return "Skipped the question"
        case SessionCommand(command="level"):
            return f"Level {message.value}"
        case SessionCommand(command="mark"):
            titles = {mark.name: mark.title for mark in me.marks}
            return f"Marked: {titles.get(message.reason, message.reason).lower()}"
        case SessionCommand():
            return _COMMANDS.get(message.command, "")
    return ""


def _decision(decision: Decision, kind: str) -> str:
    if decision.verdict != "edit":
        return f"{'Approved' if decision.verdict == 'accept' else 'Vetoed'} {kind}"
    if decision.text is not None:
        return f"Edited {kind}: “{decision.text}”"
    if decision.valence is not None:
        return f"{decision.valence.capitalize()} face, same words: {kind}"
    return f"Edited {kind}" + (f": level {decision.level}" if decision.level is not None else "")
