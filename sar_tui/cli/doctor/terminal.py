"""The terminal: its kind, size and colours, and how it is connected to this machine."""

import os
import shutil
import sys

from sar_tui.cli.common import CANNOT_PLACE_TEXT, terminal_kind
from sar_tui.cli.doctor.finding import Finding

SMALLEST = (80, 24)
"""Columns and lines that every screen fits in."""


def terminal() -> Finding:
    """Check that the program runs in a terminal that can place text."""
    term = terminal_kind()
    if term in CANNOT_PLACE_TEXT:
        return Finding(
            "Terminal",
            "bad",
            f"TERM={term}: it cannot place text.",
            "Use another terminal program.",
        )
    if not all(
        stream is not None and stream.isatty() for stream in (sys.stdin, sys.stdout, sys.stderr)
    ):
        return Finding(
            "Terminal",
            "care",
            "Input or output is redirected here.",
            "The app needs a terminal; simulate does not.",
        )
    if not term:
        return Finding(
            "Terminal",
            "bad",
            "TERM is empty.",
            "Set it to your terminal's kind, such as xterm-256color.",
        )
    return Finding("Terminal", "ok", os.environ.get("TERM_PROGRAM") or term)


def size() -> Finding:
    """Check that the terminal is large enough."""
    columns, lines = shutil.get_terminal_size(SMALLEST)
    if columns < SMALLEST[0] or lines < SMALLEST[1]:
        return Finding(
            "Terminal size",
            "care",
            f"{columns}×{lines}",
            f"Make the window {SMALLEST[0]}×{SMALLEST[1]} or larger.",
        )
    return Finding("Terminal size", "ok", f"{columns}×{lines}")


def colours() -> Finding:
    """Check how many colours the terminal can show."""
    from rich.console import Console

    if "NO_COLOR" in os.environ:
        return Finding(
            "Colours",
            "ok",
            "off, as NO_COLOR asks; only tasks whose prompts have colours cannot be done here",
        )
    system = Console(force_terminal=True).color_system
    if system in (None, "standard"):
        return Finding(
            "Colours",
            "care",
            "16 or fewer; the colours of themes are approximated",
            "Set TERM=xterm-256color or COLORTERM=truecolor if your terminal can do more.",
        )
    return Finding("Colours", "ok", {"truecolor": "16 million"}.get(str(system), str(system)))


def pictures() -> Finding:
    """Find out how the terminal shows the pictures of prompts. Asks it."""
    from sar_tui.widgets.prompt_pictures import find_way, no_package

    way = find_way()
    if way is None:
        how = f"To install it: {no_package().rpartition(': ')[2]}"
        return Finding(
            "Pictures", "ok", "not installed. Only tasks whose prompts have pictures need it.", how
        )
    as_they_are = {"kitty": "by kitty's graphics", "sixel": "by sixel graphics"}
    return Finding(
        "Pictures", "ok", as_they_are.get(way) or f"in {way}, as this terminal has no graphics"
    )


def connection() -> Finding:
    """Check that there is neither SSH nor a multiplexer between the person and the program."""
    from sar_tui.store.provenance import machine

    facts = machine()
    if not facts["flags"]:
        return Finding("Connection", "ok", "directly at this machine")
    ways = " and ".join("SSH" if flag == "ssh" else flag for flag in facts["flags"])
    return Finding(
        "Connection",
        "care",
        f"through {ways}: it delays keys and frames, and each session is marked with it",
        "For timed sessions use a terminal on the machine itself, without a multiplexer.",
    )
