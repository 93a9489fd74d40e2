"""The lists of the panel: a page of the palette, the foot, all keys."""

from itertools import zip_longest

from rich.cells import set_cell_size
from textual.content import Content

from sar_tui.operator import status_view
from sar_tui.operator.keymap import KEY_COMMANDS, KeyCommand, KeymapFile, key_name
from sar_tui.operator.palette import Item, Page
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import Piece, cut

_BY_ID = {key_command.id: key_command for key_command in KEY_COMMANDS}
_COLUMN = 38
_ASKED = {
    "end": "End the session? {key} again ends it, Esc lets it go on.",
    "close": "Leave the panel? {key} again leaves it, Esc stays. The session goes on.",
    "resume": "{why}. {key} again, within 3 s, lets it go on.",
}
_KEY_OF = {"resume": "pause"}
_PAGES = ("phrases", "gestures", "marks", "modes", "queue")


def key_label(id: str, file: KeymapFile) -> str:
    """The key of something, as it is called."""
    return key_name(file.keys_of(_BY_ID[id])[0])


def palette_page(page: Page, width: int, rows: int) -> Content:
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


def palette_keys(file: KeymapFile) -> str:
    """The keys of the palette's pages."""
    return " ".join(f"{key_label(id, file)} {_BY_ID[id].short.lower()}" for id in _PAGES)


def question(what: str, state: SessionState, file: KeymapFile) -> str:
    """The words, with the key that says yes; empty where nothing is asked, or no longer needs to be."""
    if not what or (what == "resume" and not state.is_their_pause):
        return ""
    return _ASKED[what].format(key=key_label(_KEY_OF.get(what, what), file), why=status_view.waiting_text(state))


def footer(file: KeymapFile, asked: str, width: int, *, is_observer: bool) -> Content:
    """The keys that are used most; or a question that has to be answered first."""
    if asked:
        return Content.assemble((cut(asked, width), "$warning bold"))
    parts: list[Piece] = []
    for key_command in KEY_COMMANDS:
        if key_command.in_footer and not (is_observer and key_command.acts):
            key = key_label(key_command.id, file)
            if sum(len(text) for text, _ in parts) + len(key) + len(key_command.short) + 1 > width:
                break
            parts += [(key, "$accent bold"), (f" {key_command.short} ", "$text-muted")]
    return Content.assemble(*parts)


def help_sheet(file: KeymapFile, *, is_observer: bool) -> Content:
    """All keys that do something, in two columns, under their headings."""
    groups: dict[str, list[KeyCommand]] = {}
    for key_command in _seen() if is_observer else KEY_COMMANDS:
        groups.setdefault(key_command.group, []).append(key_command)
    rows: list[tuple[Piece, Piece]] = []
    for group, key_commands in groups.items():
        rows.append(((group, "$accent bold"), ("", "")))
        rows += [
            ((f"{_called(key_command, file):<9} ", "bold"), (cut(words, _COLUMN - 11), ""))
            for key_command in key_commands
            if (words := _words(key_command, file))
        ]
    half = (len(rows) + 1) // 2
    parts: list[Piece] = []
    for left, right in zip_longest(rows[:half], rows[half:], fillvalue=(("", ""), ("", ""))):
        parts += [*left, (" " * (_COLUMN - len(left[0][0]) - len(left[1][0])), ""), *right, ("\n", "")]
    return Content.assemble(*parts)


def _seen() -> list[KeyCommand]:
    """What an observer can do, with neither a palette nor proposals to decide on."""
    return [key_command for key_command in KEY_COMMANDS if not key_command.acts and key_command.group != "Palette"]


def _called(key_command: KeyCommand, file: KeymapFile) -> str:
    if key_command.id == "pick-1":  # the first of ten that are told in one line
        last = key_label("pick-0", file)
        return f"{key_label(key_command.id, file)}…{last}"
    return " ".join(key_name(key) for key in file.keys_of(key_command))


def _words(key_command: KeyCommand, file: KeymapFile) -> str:
    """What it is; of an event mark, its name. Empty for what is told in another line, or is not there."""
    if key_command.id.startswith("event-"):
        number = int(key_command.id.removeprefix("event-")) - 1
        return f"Event: {file.events[number]}" if number < len(file.events) else ""
    if key_command.id.startswith("pick-"):
        return "Choose from the page" if key_command.id == "pick-1" else ""
    return key_command.words
