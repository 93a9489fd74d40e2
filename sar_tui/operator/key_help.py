"""Keys on the panel: a page of the palette, the footer, questions, the key help."""

from itertools import zip_longest

from rich.cells import set_cell_size
from textual.content import Content

from sar_tui.operator import status_view
from sar_tui.operator.keymap import KEY_COMMANDS, KeyCommand, KeymapFile, key_name
from sar_tui.operator.palette import Item, Page
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import Piece, cut

_BY_ID = {command.id: command for command in KEY_COMMANDS}
_COLUMN = 38
_QUESTIONS = {
    "end": "End the session? Press {key} again to end it, Esc to continue.",
    "close": "Leave the panel? Press {key} again to leave, Esc to stay. The session goes on.",
    "resume": "{why}. Press {key} again within 3 s to resume.",
}
_CONFIRMING = {"resume": "pause"}
"""Command whose key confirms a question, if it is not the question's own."""
_PAGES = ("phrases", "gestures", "marks", "modes", "queue")


def key_label(id: str, file: KeymapFile) -> str:
    """Return the name of a command's first key."""
    return key_name(file.keys_of(_BY_ID[id])[0])


def palette_page(page: Page, width: int, rows: int) -> Content:
    """Return a page of the palette, in two columns if one is too short."""
    if not page.items:
        return Content.assemble((page.empty, "$text-muted"))
    is_wide = len(page.items) > rows
    column = width // 2 - 1 if is_wide else width
    parts: list[Piece] = []
    for row in range(min(rows, len(page.items))):
        for index in (row, row + rows) if is_wide else (row,):
            if index < len(page.items):
                parts += _item(
                    page.items[index], (index + 1) % 10, column, pads=is_wide and index == row
                )
        parts.append(("\n", ""))
    return Content.assemble(*parts[:-1])


def _item(item: Item, number: int, width: int, *, pads: bool) -> list[Piece]:
    text = cut(f"{'▶ ' if item.is_current else ''}{item.text}", width - 3)
    style = "$text-muted" if item.topic is None else ""
    return [
        (f"{number} ", "$accent bold"),
        (f"{set_cell_size(text, width - 1)} " if pads else text, style),
    ]


def palette_keys(file: KeymapFile) -> str:
    """Return the keys of the palette's pages."""
    return " ".join(f"{key_label(id, file)} {_BY_ID[id].label.lower()}" for id in _PAGES)


def question(name: str, state: SessionState, file: KeymapFile) -> str:
    """Return a question with the key that confirms it; empty if there is none, or it no longer
    applies.
    """
    if not name or (name == "resume" and not state.is_their_pause):
        return ""
    key = key_label(_CONFIRMING.get(name, name), file)
    return _QUESTIONS[name].format(key=key, why=status_view.waiting_text(state))


def footer(file: KeymapFile, question: str, width: int, *, is_observer: bool) -> Content:
    """Return the most used keys, or a question that must be answered first."""
    if question:
        return Content.assemble((cut(question, width), "$warning bold"))
    parts: list[Piece] = []
    for command in KEY_COMMANDS:
        if command.in_footer and not (is_observer and command.acts):
            key = key_label(command.id, file)
            if sum(len(text) for text, _ in parts) + len(key) + len(command.label) + 1 > width:
                break
            parts += [(key, "$accent bold"), (f" {command.label} ", "$text-muted")]
    return Content.assemble(*parts)


def help_sheet(file: KeymapFile, *, is_observer: bool) -> Content:
    """Return all keys in two columns, under their headings."""
    groups: dict[str, list[KeyCommand]] = {}
    for command in _observer_commands() if is_observer else KEY_COMMANDS:
        groups.setdefault(command.group, []).append(command)
    rows: list[tuple[Piece, Piece]] = []
    for group, commands in groups.items():
        rows.append(((group, "$accent bold"), ("", "")))
        rows += [
            ((f"{_keys(command, file):<9} ", "bold"), (cut(text, _COLUMN - 11), ""))
            for command in commands
            if (text := _description(command, file))
        ]
    half = (len(rows) + 1) // 2
    parts: list[Piece] = []
    for left, right in zip_longest(rows[:half], rows[half:], fillvalue=(("", ""), ("", ""))):
        parts += [
            *left,
            (" " * (_COLUMN - len(left[0][0]) - len(left[1][0])), ""),
            *right,
            ("\n", ""),
        ]
    return Content.assemble(*parts)


def _observer_commands() -> list[KeyCommand]:
    """Return the commands of an observer, who has no palette."""
    return [command for command in KEY_COMMANDS if not command.acts and command.group != "Palette"]


def _keys(command: KeyCommand, file: KeymapFile) -> str:
    if command.id == "pick-1":  # stands for all ten
        return f"{key_label(command.id, file)}…{key_label('pick-0', file)}"
    return " ".join(key_name(key) for key in file.keys_of(command))


def _description(command: KeyCommand, file: KeymapFile) -> str:
    """Return the description; of an event mark, its name. Empty for a command without a line of its
    own.
    """
    if command.id.startswith("event-"):
        number = int(command.id.removeprefix("event-")) - 1
        return f"Event: {file.events[number]}" if number < len(file.events) else ""
    if command.id.startswith("pick-"):
        return "Choose from the page" if command.id == "pick-1" else ""
    return command.description
