"""Makes characters visible that a terminal would obey instead of showing them.

Texts come from themes, tasks, files, arguments, sensors and other machines. A terminal that shows
them as they are can be made to move its cursor, change its title or show a line in another order
(https://trojansource.codes).
"""

import re

_OBEYED = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u206f\ud800-\udfff]")
"""Control characters (C0, DEL, C1), separators of lines and paragraphs, embeddings, overrides and
isolates of the direction of text, deprecated format characters, and surrogates, which stand for
bytes that are not UTF-8.

Marks and joiners that scripts and emoji need (U+200C to U+200F, U+061C) are not among them.
"""
_PICTURES = 0x2400
"""The first of Unicode's pictures of control characters: ␀."""
_DELETE = 0x7F


def visible(text: str, keep: str = "") -> str:
    """Return a text with a sign for each character that a terminal would obey: ``␛`` for Escape,
    ``�`` for others.

    The text keeps its length.

    Args:
        text: a text from anywhere.
        keep: characters that remain, such as a newline.
    """
    return _OBEYED.sub(lambda found: found[0] if found[0] in keep else _sign(ord(found[0])), text)


def obeyed(text: str, keep: str = "") -> tuple[str, ...]:
    """Return the different characters of a text that a terminal would obey, sorted, as
    ``U+001B``.
    """
    return tuple(
        f"U+{ord(each):04X}" for each in sorted(set(_OBEYED.findall(text)).difference(keep))
    )


def control_problem(where: str, text: str) -> str:
    """Return a sentence if a text has characters other than a newline that a terminal would obey,
    else an empty one.
    """
    found = obeyed(text, "\n")
    return f"{where} has control characters: {', '.join(found)}." if found else ""


def escaped(json: str) -> str:
    """Return JSON with escapes for the characters that a terminal would obey. It holds the same
    value.
    """
    return _OBEYED.sub(lambda found: f"\\u{ord(found[0]):04x}", json)


def _sign(code: int) -> str:
    if code < ord(" "):
        return chr(_PICTURES + code)
    return "␡" if code == _DELETE else "�"
