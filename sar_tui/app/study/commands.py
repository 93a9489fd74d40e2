"""Commands on studies, as they can be typed, in messages and on screens."""

import re
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from sar_tui.app.command_line import command_line, hint
from sar_tui.store.database import StoreError, connect_to_read
from sar_tui.store.participants import UnknownParticipant, admit
from sar_tui.store.studies import names

_COMMAND = re.compile(r"\s+sar-tui (study (?:consent|enrol|exit|next)) (.+)$")
"""A command at the end of a message."""


class StudyCommands(NamedTuple):
    """Writes commands with the folders in use, and with the study if there are several.

    Attributes:
        folder: of the data.
        tasks: additional folders of tasks.
        study: name of the study; empty if it was not given, as there is one only.
    """

    folder: Path
    tasks: Sequence[Path] = ()
    study: str = ""

    def command(self, name: str, *arguments: str) -> str:
        """Return a command, such as ``study next``."""
        with closing(connect_to_read(self.folder)) as database:
            is_named = bool(self.study) and len(names(database)) > 1
        which = ("--study", self.study) if is_named else ()
        return command_line(self.folder, self.tasks, name, *arguments, *which)

    def complete(self, said: str) -> str:
        """Return a message whose last words may be a command, with that command as it can be
        typed.
        """
        found = _COMMAND.search(said)
        if found is None:
            return said
        name, arguments = found[1], found[2].split()
        if name == "study exit":
            arguments += ["--reason", "WHY"]
        if name == "study enrol" and self._is_new(arguments[0]):
            arguments.append("--new")
        return hint(said[: found.start()], self.command(name, *arguments))

    def _is_new(self, code: str) -> bool:
        """Return True if nobody is known by a code."""
        with closing(connect_to_read(self.folder)) as database:
            try:
                admit(database, [code])
            except UnknownParticipant:
                return True
            except StoreError:
                pass
        return False
