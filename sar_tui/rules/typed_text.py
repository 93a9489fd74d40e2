"""Text that a participant types in answer to a prompt, from its keys."""

import msgspec

from sar_tui.model.trial_types import Act, Performance, Stimulus

LONGEST_TEXT = 60
"""Most characters of a typed text; it stands on one line of the screen."""
KEY_GAP_MS = 250.0
"""Time between two keys of a simulated participant."""


class TypedText(msgspec.Struct, frozen=True):
    """Text typed so far. ``began``: time stamp (ns) of its first key; ``corrections``: number of
    deleted characters.
    """

    text: str = ""
    began: int | None = None
    keys: int = 0
    corrections: int = 0

    def pressed(self, key: str, at: int, expects: str) -> "TypedText":
        """Return the text after a key: a character is added, Backspace deletes the last one, others
        do nothing.

        Args:
            key: its name, as in `messages.KeyPerceived`.
            at: its time stamp (ns).
            expects: of the stimulus; with ``digits``, only these can be typed.
        """
        text = self.text
        if key == "backspace":
            text = text[:-1]
        elif len(text) < LONGEST_TEXT:
            text += _character(key, expects)
        if text == self.text:
            return self
        deleted = len(text) < len(self.text)
        began = at if self.began is None else self.began
        return TypedText(text, began, self.keys + 1, self.corrections + deleted)


def _character(key: str, expects: str) -> str:
    """Return the character that a key adds; empty if it adds none."""
    character = " " if key == "space" else key
    if len(character) != 1 or (expects == "digits" and not character.isdecimal()):
        return ""
    return character


def problem(stimulus: Stimulus) -> str:
    """Return a sentence that says why a prompt cannot be answered by typing; empty if it can, or
    need not be.
    """
    if stimulus.expects == "key":
        return ""
    if stimulus.expects not in ("text", "digits"):
        return f"A prompt expects a key, text or digits, not {stimulus.expects!r:.60}."
    if stimulus.halves or (stimulus.frames and stimulus.frames[-1].halves):
        return "A prompt that expects typed text has no halves: the text stands below the prompt."
    if stimulus.frames and not stimulus.frames[-1].awaited:
        return (
            "Typed text is awaited from the last frame of a prompt on: that frame must have "
            "awaited=True."
        )
    return ""


def typing(text: str, performance: Performance) -> list[Act]:
    """Return the acts of a simulated participant who types and sends a text; a slip leaves out its
    last character.
    """
    if performance.slips:
        text = text[:-1] or "0"
    keys = ["space" if character == " " else character for character in text]
    return [
        (performance.reaction_ms + number * KEY_GAP_MS, key)
        for number, key in enumerate([*keys, "enter"])
    ]
