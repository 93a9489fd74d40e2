"""The lists of the panel: a page of the palette, the foot, all keys."""

from itertools import zip_longest

from rich.cells import set_cell_size
from textual.content import Content

from sar_tui.operator.keymap import DEEDS, KeyCommand, key_name
from sar_tui.operator.own_file import KeymapFile
from sar_tui.operator.palette import Item, Page
from sar_tui.operator.text_charts import Piece, cut

_BY_ID = {deed.id: deed for deed in DEEDS}
_COLUMN = 38
_PAGES = ("phrases", "gestures", "marks", "modes", "queue")


def key_of(id: str, file: KeymapFile) -> str:
    """The key of something, as it is called."""
    return key_name(file.keys_of(_BY_ID[id])[0])


def items(page: Page, width: int, rows: int) -> Content:
    """A page of the palette: in two columns where there is room, else in one."""
    if not page.items:
        return Content.assemble((page.empty, "$text-muted"))
    is_wide = len(page.items) > rows
    room = width // 2 - 1 if is_wide else width
    parts: list[Piece] = []
    for row in range(min(rows, len(page.items))):
        for index in (row, row + rows) if is_wide else (row,):
            if index < len(page.items):
                parts += _item(page.items[index], (index + 1) % 10, room, pads=is_wide and index == row)
        parts.append(("\n", ""))
    return Content.assemble(*parts[:-1])


def _item(item: Item, number: int, width: int, *, pads: bool) -> list[Piece]:
    text = cut(f"{'▶ ' if item.now else ''}{item.text}", width - 3)
    style = "$text-muted" if item.topic is None else ""
    return [(f"{number} ", "$accent bold"), (f"{set_cell_size(text, width - 1)} " if pads else text, style)]


def pages(file: KeymapFile) -> str:
    """The keys of the palette's pages."""
    return " ".join(f"{key_of(id, file)} {_BY_ID[id].short.lower()}" for id in _PAGES)


def foot(file: KeymapFile, asked: str, width: int, *, is_observer: bool) -> Content:
    """The keys that are used most; or a question that has to be answered first."""
    if asked:
        return Content.assemble((cut(asked, width), "$warning bold"))
    parts: list[Piece] = []
    for deed in DEEDS:
        if deed.foot and not (is_observer and deed.acts):
            key = key_of(deed.id, file)
            if sum(len(text) for text, _ in parts) + len(key) + len(deed.short) + 1 > width:
                break
            parts += [(key, "$accent bold"), (f" {deed.short} ", "$text-muted")]
    return Content.assemble(*parts)


def keys(file: KeymapFile, *, is_observer: bool) -> Content:
    """All keys that do something, in two columns, under their headings."""
    groups: dict[str, list[KeyCommand]] = {}
    for deed in _seen() if is_observer else DEEDS:
        groups.setdefault(deed.group, []).append(deed)
    rows: list[tuple[Piece, Piece]] = []
    for group, deeds in groups.items():
        rows.append(((group, "$accent bold"), ("", "")))
        rows += [
            ((f"{_called(deed, file):<9} ", "bold"), (cut(words, _COLUMN - 11), ""))
            for deed in deeds
            if (words := _words(deed, file))
        ]
    half = (len(rows) + 1) // 2
    parts: list[Piece] = []
    for left, right in zip_longest(rows[:half], rows[half:], fillvalue=(("", ""), ("", ""))):
        parts += [*left, (" " * (_COLUMN - len(left[0][0]) - len(left[1][0])), ""), *right, ("\n", "")]
    return Content.assemble(*parts)


def _seen() -> list[KeyCommand]:
    """What an observer can do, with neither a palette nor proposals to decide on."""
    return [deed for deed in DEEDS if not deed.acts and deed.group != "Palette"]


def _called(deed: KeyCommand, file: KeymapFile) -> str:
    if deed.id == "pick-1":  # the first of ten that are told in one line
        last = key_of("pick-0", file)
        return f"{key_of(deed.id, file)}…{last}"
    return " ".join(key_name(key) for key in file.keys_of(deed))


def _words(deed: KeyCommand, file: KeymapFile) -> str:
    """What it is; of an event mark, its name. Empty for what is told in another line, or is not there."""
    if deed.id.startswith("event-"):
        number = int(deed.id.removeprefix("event-")) - 1
        return f"Event: {file.events[number]}" if number < len(file.events) else ""
    if deed.id.startswith("pick-"):
        return "Choose from the page" if deed.id == "pick-1" else ""
    return deed.words
