"""Sections of a report, for a terminal and for a page: paragraphs, tables of texts, and drawings of
characters.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from html import escape
from typing import Any

import msgspec

from sar_tui.reports import charts


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
    return document(title, body, foot=foot)


def _shown(parts: Sequence[str | Table | Drawing]) -> Iterator[str]:
    for part in parts:
        match part:
            case str():
                yield f"<p>{escape(part).replace(chr(10), '<br>')}</p>"
            case Table():
                yield table(part.heads, part.rows, right=part.right)
                if part.more:
                    yield f"<p>{escape(part.more)}</p>"
            case Drawing():
                drawn = escape("\n".join(part.lines))
                caption = f"<figcaption>{escape(part.caption)}</figcaption>"
                yield f"<figure>{caption}<pre>{drawn}</pre></figure>"


# --- a page of HTML


_STYLE = """
body { font: 15px/1.5 sans-serif; color: #111; background: #fff;
  max-width: 46rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
figure { margin: 1rem 0; } figure svg { max-width: 100%; height: auto; }
figcaption { font-size: .85rem; color: #333; }
table { border-collapse: collapse; font-size: .85rem; }
th, td { padding: .2rem .6rem; text-align: right; }
th { border-bottom: 1px solid #888; } td:first-child, th:first-child, .text { text-align: left; }
ul.claims { list-style: none; padding-left: 0; }
pre { font-size: 1rem; line-height: 1.6; }
.wide { overflow-x: auto; } .wide td { vertical-align: top; }
.drawing { font-size: .65rem; line-height: 1.2; overflow-x: auto; }
dt { font-weight: bold; margin-top: .6rem; } dd { margin: 0 0 0 1rem; font-size: .85rem; }
.foot { font-size: .85rem; color: #333; margin-top: 2rem; }
@media print { body { margin: 0; max-width: none; } figure, table, tr, dd { break-inside: avoid; } }
"""


def document(title: str, body: Iterable[str], *, language: str = "en", foot: str = "") -> str:
    """Return a page. ``title`` and ``foot`` are texts, ``body`` has parts in HTML."""
    end = f'\n<p class="foot">{escape(foot)}</p>' if foot else ""
    return (
        f'<!DOCTYPE html>\n<html lang="{escape(language)}">\n<head>\n<meta charset="utf-8">\n'
        f'<meta name="viewport" content="width=device-width">\n<title>{escape(title)}</title>\n'
        f"<style>{_STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(body)
        + f"{end}\n</body>\n</html>\n"
    )


def table(
    heads: Sequence[str], rows: Iterable[Sequence[str]], *, right: Collection[str] | None = None
) -> str:
    """Return a table of texts.

    Args:
        right: heads of the columns that are aligned to the right; None: all but the first.
    """
    is_number = [index > 0 if right is None else head in right for index, head in enumerate(heads)]
    head = "".join(_cell('th scope="col"', *each) for each in zip(heads, is_number, strict=True))
    lines = (
        "".join(_cell("td", *each) for each in zip(row, is_number, strict=True)) for row in rows
    )
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(tag: str, text: str, is_number: bool) -> str:
    align = "" if is_number else ' class="text"'
    return f"<{tag}{align}>{escape(text)}</{tag[:2]}>"


def figure(spec: dict[str, Any], caption: str, more: str = "", *, is_captioned: bool = True) -> str:
    """Return a drawn chart with its caption; ``more`` is added to its text alternative.

    Args:
        spec: of the chart, in Vega-Lite.
        is_captioned: False if the caption stands above the chart already.

    Raises:
        ChartsMissing: the extra ``report`` is not installed.
    """
    label = escape(f"{caption} {more}".strip(), quote=True)
    drawing = charts.drawn(spec).replace("<svg ", f'<svg role="img" aria-label="{label}" ', 1)
    shown = f"<figcaption>{escape(caption)}</figcaption>" if is_captioned else ""
    return f"<figure>{drawing}{shown}</figure>"
