"""Sections of a report, for a terminal and for a page: paragraphs, tables of texts, and drawings of
characters.
"""

from collections.abc import Iterable, Iterator, Sequence
from html import escape

import msgspec

from sar_tui.reports import html_page


class Table(msgspec.Struct, frozen=True):
    """A table of texts.

    Attributes:
        right: heads of the columns with numbers.
        whole: heads of the columns that are not to be wrapped in a narrow terminal.
        more: a sentence on rows that are left out, or empty.
    """

    heads: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    right: tuple[str, ...] = ()
    whole: tuple[str, ...] = ()
    more: str = ""


class Drawing(msgspec.Struct, frozen=True):
    """A chart drawn with characters, under its caption."""

    caption: str
    lines: list[str]


class Section(msgspec.Struct, frozen=True):
    """A part of a report with a title. A text among its parts is a paragraph."""

    title: str
    parts: Sequence[str | Table | Drawing]


def page(title: str, sections: Iterable[Section], foot: str = "") -> str:
    """Return a self-contained page of sections. ``foot``: a text at its end."""
    body = [f"<h1>{escape(title)}</h1>"]
    for section in sections:
        body.append(f"<h2>{escape(section.title)}</h2>")
        body += _shown(section.parts)
    return html_page.document(title, body, foot=foot)


def _shown(parts: Sequence[str | Table | Drawing]) -> Iterator[str]:
    for part in parts:
        match part:
            case str():
                yield f"<p>{escape(part).replace(chr(10), '<br>')}</p>"
            case Table():
                yield html_page.table(part.heads, part.rows, right=part.right)
                if part.more:
                    yield f"<p>{escape(part.more)}</p>"
            case Drawing():
                drawn = escape("\n".join(part.lines))
                caption = f"<figcaption>{escape(part.caption)}</figcaption>"
                yield f"<figure>{caption}<pre>{drawn}</pre></figure>"
