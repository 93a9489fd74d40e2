"""A session of the past: its summary again."""

from typing import Any, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.screen import Screen
from textual.widgets import Footer, Static

from sar_tui.app.screens.summary import Summary
from sar_tui.framework.messages import AttemptEnded
from sar_tui.framework.parameters import ParameterError, build
from sar_tui.plugins import PluginError
from sar_tui.store import sessions


class PastSessionScreen(Screen[None]):
    """The plot and figures of one stored session."""

    HELP_TEXT = "What was done in a session: the result of each attempt and its level.\n"
    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape,enter,space", "dismiss", "Back", id="back")]

    app: Any

    def __init__(self, row: sessions.Row) -> None:
        super().__init__()
        self._row = row

    def compose(self) -> ComposeResult:
        row = self._row
        began = sessions.local_time(row["started_at"])
        yield Static(f"{row['participant']} · {row['task']} · {began} · {row['status']}", id="top", markup=False)
        try:
            kind = self.app.catalogue.task(row["task"])
            yield Summary(kind(build(kind.Parameters, row["parameters"])), id="summary")
        except (PluginError, ParameterError) as error:
            yield Static(f"This session cannot be drawn. {error}", markup=False)
        yield Footer()

    def on_mount(self) -> None:
        attempts = [
            AttemptEnded(
                attempt=row["attempt"],
                practice=row["practice"],
                level=row["level"],
                metric=row["metric"],
                metric_unit=row["metric_unit"],
                accuracy=row["accuracy"],
                correct=row["correct"],
                trials=row["trials"],
                outcome=row["outcome"],
                feedback=row["feedback"],
                started=row["started_ns"],
                ended=row["ended_ns"],
            )
            for row in sessions.rows(self.app.database, "attempts", self._row["id"])
            if not row["practice"]
        ]
        for summary in self.query(Summary):
            summary.show(attempts, self._row["status"])
