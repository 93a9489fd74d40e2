"""Texts of prompts and of their frames, which could not be stored if they were anything else."""

from sar_tui.model.frames import Frame
from sar_tui.model.trial_types import Stimulus

_OF_BOTH = ("text", "glyph", "hint", "colour", "picture")
_OF_PROMPT = ("name", "expected", "seat", *_OF_BOTH)


def problem(stimulus: Stimulus) -> str:
    """Return a sentence that names what should be a text and is none; empty if all are texts."""
    if found := _problem_of("prompt", stimulus, _OF_PROMPT):
        return found
    return next(
        filter(None, (_problem_of("frame", frame, _OF_BOTH) for frame in stimulus.frames)), ""
    )


def _problem_of(what: str, shown: Stimulus | Frame, names: tuple[str, ...]) -> str:
    for name in names:
        if not isinstance(value := getattr(shown, name), str):
            return f"The {name} of a {what} is a text, not {value!r:.80}."
    halves = shown.halves
    if (
        isinstance(halves, tuple)
        and len(halves) in (0, 2)
        and all(isinstance(half, str) for half in halves)
    ):
        return ""
    return f"The halves of a {what} are a pair of texts, not {halves!r:.80}."
