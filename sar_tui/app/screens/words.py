"""What the session's screen says while it waits for somebody."""

from typing import NamedTuple

from sar_tui.framework.messages import Waiting
from sar_tui.framework.task import Task


class Words(NamedTuple):
    """A headline, what there is to know, and what to press (empty where nothing helps)."""

    headline: str
    text: str
    press: str


def words(waiting: Waiting, task: Task) -> Words | None:  # noqa: PLR0911
    """The words for a wait; None where something else stands on the screen: a prompt, the pause menu, the summary."""
    match waiting.stage:
        case "instructions":
            return Words("Welcome", task.instructions(), "Press Enter to go on.")
        case "attempt":
            headline = waiting.notice or waiting.attempt_name.capitalize()
            return Words(headline, waiting.goal, f"Press Enter to begin {waiting.attempt_name}.")
        case "review":
            return Words("You have done it", "That was the last attempt.", "Press Enter to see how it went.")
        case "trial" if waiting.what == "start":
            press = f"Press {task.start_key.capitalize()} to start."
            if waiting.notice:
                return Words("Once more", f"{waiting.notice}\n\n{waiting.goal}", press)
            return Words("Ready?", waiting.goal, press)
        case "paused":
            return _paused(waiting)
        case "broken":
            text = "Something went wrong in this task, so the session has stopped.\nEverything you did is kept."
            return Words("Please fetch the experimenter", text, "Press Enter to close.")
        case "ended" if waiting.reason == "storage":
            return _no_space(waiting.detail)
        case "ended" if waiting.what == "storage":
            return Words("Finished", "Your results are being saved.", "")
    return None


def _paused(waiting: Waiting) -> Words | None:
    match waiting.reason:
        case "interrupted":
            go_on = f"We go on with {waiting.attempt_name}. {waiting.goal}"
            return Words("Welcome back", go_on, "Press Enter to go on.")
        case "restored":
            return Words("Thank you for waiting", "Everything is saved again.", "Press Enter to go on.")
        case "storage":
            return _no_space(waiting.detail)
        case "sensor":
            return Words(
                "Please wait",
                "The sensor on your hand is not heard just now. Nothing is lost.\n\n"
                f"For the experimenter: {waiting.detail or 'The sensor sends nothing. Check its cable.'}\n"
                "The session goes on by itself if it is heard again. To end it: Escape.",
                "",
            )
    return None


def _no_space(detail: str) -> Words:
    return Words(
        "Please fetch the experimenter",
        "The computer cannot save just now, so the session has paused.\n"
        "Everything you did is kept.\n\n"
        f"For the experimenter: {detail or 'The disk refuses to write.'}\n"
        "When it can be saved again, the session can go on.",
        "",
    )
