"""Keys of the progress screen that show a note, and write a page."""

from collections.abc import Callable
from typing import Any

from textual import work
from textual.screen import Screen

from sar_tui.loop.task import Task
from sar_tui.reports import progress_words
from sar_tui.reports.progress import LineProgress, Progress


class Reports(Screen[None]):
    """The part of `ProgressScreen` for what leaves the program."""

    app: Any
    _participant: str
    _motor_task: type[Task]
    _found: Progress | None

    @property
    def _shown_line(self) -> LineProgress | None:
        raise NotImplementedError

    def action_note(self) -> None:
        """Show a paragraph to paste into a record."""
        from sar_tui.app.screens.progress_note import ProgressNoteScreen

        if (line := self._shown_line) and self._found:
            found = self._found

            def text(language: str) -> str:
                tr = progress_words.words(language, self._motor_task)
                return "\n\n".join(
                    [
                        progress_words.note(self._participant, line, tr),
                        *progress_words.after_notes(found, tr),
                    ]
                )

            self.app.push_screen(ProgressNoteScreen(text))

    def action_page(self) -> None:
        """Write a page with charts into the data folder."""
        if self._found:
            self.notify("Drawing the page …", timeout=3)
            self._write_page(self._found)

    @work(thread=True, exclusive=True, group="page")
    def _write_page(self, found: Progress) -> None:
        from sar_tui.drivers.new_file import unused, write_private
        from sar_tui.reports.html_page import ChartsMissing
        from sar_tui.reports.progress_page import page

        find: Callable[[str], type[Task] | None] = {self._motor_task.name: self._motor_task}.get
        name = f"progress-{self._participant}-{self._motor_task.name}"
        try:
            text = page(found, find, "en")
            path = unused(self.app.folder / f"{name}.html")
            write_private(path, text)
        except ChartsMissing as error:
            self.app.call_from_thread(self.notify, str(error), severity="warning", timeout=20)
        except OSError as error:
            said = f"The page cannot be written: {error.strerror or error}."
            self.app.call_from_thread(self.notify, said, severity="error", timeout=20)
        else:
            said = f"{path} is written. Open it in a browser, which can also print it."
            self.app.call_from_thread(self.notify, said, timeout=12)
