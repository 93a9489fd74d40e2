"""Whether a voice can read a text aloud: an engine does not refuse what it cannot read, but spells out its code."""

import unicodedata

_LATIN = "ca cs da de en es et eu fi fr ga gl hr hu id is it lt lv ms nb nl nn no pl pt ro sk sl sv sw tr vi"
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
"""What a language is written in, by the first word of its letters' Unicode names. Others are not judged."""


def why_unreadable(text: str, language: str) -> str:
    """Why a voice of that language cannot read a text, in a sentence; empty where it can.

    It cannot if there is neither letter nor digit, or if more letters than not are of a script it is not written in.
    """
    if not any(character.isalnum() for character in text):
        return "The voice cannot read this text: it has neither letters nor digits."
    scripts = _SCRIPTS.get(language.partition("-")[0])
    letters = [character for character in text if character.isalpha()]
    if scripts and letters:
        foreign = sum(not unicodedata.name(letter, "").startswith(scripts) for letter in letters)
        if 2 * foreign > len(letters):
            return f'The voice cannot read this text: it is in a script that the language "{language}" does not use.'
    return ""
