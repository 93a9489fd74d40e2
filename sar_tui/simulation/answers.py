"""Answers of simulated participants to questions between attempts: the keys that give them."""

from sar_tui.model.random_streams import RandomStreams
from sar_tui.model.step import TIMED, Step, points
from sar_tui.model.step_entry import DECLINE_KEY, FULL

DECLINES = 0.03
"""Share of questions that a simulated participant would rather not answer."""
_WORDS = ("fine", "ok", "it went well", "my arm is tired")


def answer_keys(step: Step, streams: RandomStreams) -> tuple[str, ...]:
    """Return the keys with which a participant answers a step; none for one that ends by itself.

    Each option is equally likely; ratings lie near the middle. They agree to what is required.
    """
    if step.kind in TIMED:
        return ()
    if step.required:
        return (
            next(point.typed for point in points(step) if point.label == step.required),
            "enter",
        )
    if step.is_question and streams.uniform("declines") < DECLINES:
        return (DECLINE_KEY,)
    return (*_chosen(step, streams), "enter")


def _chosen(step: Step, streams: RandomStreams) -> tuple[str, ...]:
    """Return the keys before Enter."""
    match step.kind:
        case "text":
            return tuple(
                "space" if char == " " else char for char in streams.choice(_WORDS, "words")
            )
        case "line":
            return (str(int(_middling(streams) * FULL) // 10),)
        case "choices":
            return tuple(
                str(n) for n in range(1, len(step.labels) + 1) if streams.uniform("tick", n) < 0.5
            ) or ("1",)
        case "choice":
            return (streams.choice(points(step), "option").typed,)
        case "screen":
            return ()
    scale = points(step)
    return tuple(scale[int(_middling(streams) * len(scale))].typed)


def _middling(streams: RandomStreams) -> float:
    """Return a number in [0, 1), most often near a half."""
    return (streams.uniform("one") + streams.uniform("other")) / 2
