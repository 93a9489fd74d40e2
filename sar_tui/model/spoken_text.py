"""Texts as a voice reads them: sentence by sentence."""

import re

_END = re.compile(r"(?<=[.?!…])\s+|\s*\n\s*")


def sentences(*texts: str) -> list[str]:
    """Return the sentences of some texts, in order. A line is a sentence, too; one without letters
    and digits is none.
    """
    found = (part.strip() for text in texts for part in _END.split(text))
    return [part for part in found if any(letter.isalnum() for letter in part)]
