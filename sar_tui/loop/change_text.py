"""Sentences that tell a participant why the level or the goal has changed."""

from sar_tui.model.language import Language

_HARDER = {
    "target": "That went well, so it gets a little harder.",
    "sequence": "Your plan goes on: a little harder now.",
}
_EASIER = {
    "target": "It gets a little easier now.",
    "sequence": "Your plan goes on: a little easier now.",
}


def level_change_text(reason: str, *, harder: bool, tr: Language) -> str:
    """Return why the level changed, by the reason in `messages.LevelChanged`.

    Empty under the default difficulty policy, as the feedback has just said whether the goal was
    reached, and empty if somebody changed the level by hand.
    """
    text = (_HARDER if harder else _EASIER).get(reason, "")
    return tr(text) if text else ""


def goal_change_text(tr: Language) -> str:
    """Return why the goal changed."""
    return tr("The goal follows what you have just done.")
