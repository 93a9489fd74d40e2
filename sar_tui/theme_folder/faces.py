"""Drawings of faces: their size and their characters."""

import unicodedata
from collections.abc import Mapping

WIDTH, HEIGHT = 11, 4
"""Largest number of columns and lines of a face; arms are drawn beside it."""


def drawing_problems(name: str, face: str, mouth_line: int) -> list[str]:
    """Return what is wrong with a drawing, one sentence each."""
    lines = face.split("\n")
    found = []
    if len(lines) > HEIGHT or max(map(len, lines)) > WIDTH:
        found.append(f"The face {name} is larger than {WIDTH} columns and {HEIGHT} lines.")
    if mouth_line >= len(lines):
        found.append(
            f"The face {name} has no line {mouth_line}, counted from 0, for its mouth (mouth_line)."
        )
    odd = sorted(
        {character for line in lines for character in line if not _is_one_column(character)}
    )
    if odd:
        found.append(
            f"The face {name} is drawn with what does not fill one column: "
            f"{', '.join(map(ascii, odd))}."
        )
    return found


def fitted(faces: Mapping[str, str]) -> dict[str, str]:
    """Return faces padded to the size of the largest: editors strip trailing spaces."""
    lines = {name: face.split("\n") for name, face in faces.items()}
    height = max(map(len, lines.values()), default=0)
    width = max((len(line) for face in lines.values() for line in face), default=0)
    return {
        name: "\n".join(line.ljust(width) for line in [*face, *[""] * (height - len(face))])
        for name, face in lines.items()
    }


def _is_one_column(character: str) -> bool:
    """Return whether a character takes one column: no emoji, wide East Asian or combining
    character.
    """
    return (
        unicodedata.category(character)[0] not in "MC"
        and unicodedata.east_asian_width(character) not in "WF"
    )
