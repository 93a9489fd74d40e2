"""Recognises texts that a voice cannot read, because an engine would spell out the codes of unknown
characters.
"""

import unicodedata

_LATIN = (
    "ca cs da de en es et eu fi fr ga gl hr hu id is it lt lv ms nb nl nn no pl pt ro sk sl "
    "sv sw tr vi"
)
_SCRIPTS = {
    **dict.fromkeys(_LATIN.split(), ("LATIN",)),
    **dict.fromkeys("be bg mk ru uk".split(), ("CYRILLIC",)),
    **dict.fromkeys("ar fa ur".split(), ("ARABIC",)),
    **dict.fromkeys("hi mr ne".split(), ("DEVANAGARI",)),
    "el": ("GREEK",),
    "he": ("HEBREW",),
    "ja": ("HIRAGANA", "KATAKANA", "CJK"),
    "ko": ("HANGUL", "CJK"),
    "zh": ("CJK",),
}
"""Scripts of a language, by the first word of its letters' Unicode names. Other languages are not
checked.
"""


def why_unreadable(text: str, language: str) -> str:
    """Return why a voice of a language cannot read a text, as a sentence; empty if it can.

    It cannot if the text has neither letters nor digits, or if most letters are of a script of
    other languages.
    """
    if not any(character.isalnum() for character in text):
        return "The voice cannot read this text: it has neither letters nor digits."
    scripts = _SCRIPTS.get(language.partition("-")[0])
    letters = [character for character in text if character.isalpha()]
    if scripts and letters:
        foreign = sum(not unicodedata.name(letter, "").startswith(scripts) for letter in letters)
        if 2 * foreign > len(letters):
            return (
                "The voice cannot read this text: it is in a script that the language "
                f'"{language}" does not use.'
            )
    return ""
