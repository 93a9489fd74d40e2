"""Breaks texts into lines of about the same length, and spaces their letters."""

import re
import textwrap
from functools import lru_cache

_KEPT = re.compile(r"(?<=\d) (?=[^\W\d]|→)|(?<=→) ")
"""A space between a number and its unit, or beside an arrow."""
_BEFORE_SIGN = re.compile(r" (?=[.,:;!?])")
_NO_BREAK = "\N{NO-BREAK SPACE}"


@lru_cache(maxsize=64)
def balanced(text: str, width: int) -> str:
    """Return a text on as few lines as fit a width, all of about the same length, with no line
    between a number and its unit, or beside an arrow. Lines of the text stay apart.
    """
    return "\n".join(_balanced_line(line, max(1, width)) for line in text.split("\n"))


def _balanced_line(text: str, width: int) -> str:
    kept = _KEPT.sub(_NO_BREAK, text)
    lines = textwrap.wrap(kept, width)
    for narrower in range(max(1, len(kept) // max(1, len(lines))), width):
        if len(tried := textwrap.wrap(kept, narrower)) <= len(lines):
            lines = tried
            break
    return "\n".join(lines).replace(_NO_BREAK, " ")


def spaced(text: str, columns: int) -> str:
    """Return a text in spaced capitals, ``W E L L   D O N E``; as it is if there is no room."""
    words = (_BEFORE_SIGN.sub("", " ".join(word)) for word in text.upper().split(" "))
    wide = "   ".join(words)
    return wide if len(wide) <= columns else text
