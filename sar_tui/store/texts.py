"""One rule for texts that somebody typed: those that are stored here, and those of a database that
is merged.
"""

from sar_tui.model.language import Sentence
from sar_tui.model.visible_text import obeyed
from sar_tui.store.database import StoreError

_LINES = "\n\r\t"
"""Control characters that a text of several lines has."""


def check_text(where: str, text: str, longest: int) -> str:
    """Return a text without blanks at its ends.

    Args:
        where: the name of the text, for the message: "The note".
        longest: in characters.

    Raises:
        StoreError: it is too long, is not UTF-8, or has characters that a terminal would obey.
    """
    cleaned = text.strip()
    if len(cleaned) > longest:
        problem = "{where} is too long: at most {longest} characters."
        raise StoreError(Sentence(problem, where=Sentence(where), longest=longest), bad_input=True)
    try:
        cleaned.encode()
    except UnicodeEncodeError:
        problem = "{where} has bytes that are not UTF-8."
        raise StoreError(Sentence(problem, where=Sentence(where)), bad_input=True) from None
    if found := obeyed(cleaned, _LINES):
        problem = "{where} has control characters: {found}."
        said = Sentence(problem, where=Sentence(where), found=", ".join(found))
        raise StoreError(said, bad_input=True)
    return cleaned
