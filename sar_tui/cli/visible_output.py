"""Standard output and error of all commands, with characters made visible that a terminal would
obey.
"""

import sys
from collections.abc import Iterable
from typing import Any, TextIO

from sar_tui.model.visible_text import visible

KEPT = "\n\t"
"""Characters that may stand in output."""


class VisibleStream:
    """Stream for texts from anywhere.

    Attributes:
        rich_proxied_file: the stream itself. Consoles of rich write to it, as they send commands to
            the terminal.
        buffer: None, as bytes would not be checked.
    """

    buffer = None

    def __init__(self, stream: TextIO) -> None:
        self.rich_proxied_file = stream

    def write(self, text: str) -> int:
        self.rich_proxied_file.write(visible(text, KEPT))
        return len(text)

    def writelines(self, lines: Iterable[str]) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.rich_proxied_file, name)


def make_output_visible() -> None:
    """Let everything that is printed to standard output or error pass a `VisibleStream`."""
    for name in ("stdout", "stderr"):
        stream: Any = getattr(sys, name)
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
        if stream is not None and not isinstance(stream, VisibleStream):
            setattr(sys, name, VisibleStream(stream))
