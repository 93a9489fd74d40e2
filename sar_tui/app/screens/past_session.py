"""The summary of a past session."""

from typing import Any, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.widgets import Static

from sar_tui.app.home.words import day_words, status_words
from sar_tui.app.screens.summary import Summary
from sar_tui.plugins import PluginError
from sar_tui.reports.wellbeing import session_lines
from sar_tui.store import provenance, records, sessions, wellbeing
from sar_tui.store.training_days import trained_at
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.language import language_of
from sar_tui.widgets.task_view import stored_facts


class PastSessionScreen(DismissedOnce[None]):
    """The plot and figures of one stored session."""

    help_text = "The results of a past session: each attempt and its level.\n"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,enter,space", "dismiss", "Back", id="back"),
        Binding("f4", "progress", "Progress", id="progress"),
        Binding("a", "report_event", "Adverse event", id="adverse-event"),
    ]

    app: Any

    def __init__(self, row: sessions.Row) -> None:
        super().__init__()
        self._row = row

    def compose(self) -> ComposeResult:
        row = self._row
        yield Static(self._title(), id="top", markup=False)
        metric = provenance.metric(row["software"])
        try:
            task = self.app.catalogue.task(row["task"])
        except PluginError:  # it is no longer installed
            yield Summary(metric, id="summary")
        else:
            tr = language_of(self.app)
            yield Summary(
                metric, lambda attempts: stored_facts(task, attempts, metric, tr), id="summary"
            )
        yield Static("", id="felt", markup=False)
        yield KeyFooter()

    def _title(self) -> str:
        """Return who, what and when: "P01 · Keyboard reaction · Tue 17 Nov, 15:04 · completed"."""
        row = self._row
        began = trained_at(row["started_at"], row["utc_offset_s"])
        title = row["software"].get("task", {}).get("title", row["task"])
        when = f"{day_words(began.date(), self.app.today())}, {began:%H:%M}"
        return " · ".join(
            (
                sessions.participant_codes(row),
                title,
                when,
                status_words(row["status"]) or str(row["status"]),
            )
        )

    def action_report_event(self) -> None:
        """Record an adverse event that began in this session."""
        from sar_tui.app.screens.record_form import RecordForm
        from sar_tui.records.kind import of_group

        row = self._row
        codes = list(sessions.codes(row))
        began = sessions.local_time(row["started_at"], row["utc_offset_s"])
        form = RecordForm(list(of_group("event")), codes, began, row["id"])
        self.app.push_screen(form, lambda _: self._show_wellbeing())

    def action_progress(self) -> None:
        """Show the participant's progress in this task; of two participants, that of the one on the
        left.
        """
        from sar_tui.app.screens.progress import ProgressScreen

        try:
            task = self.app.catalogue.task(self._row["task"])
        except PluginError as error:
            self.notify(str(error), severity="warning", timeout=15)
        else:
            self.app.push_screen(ProgressScreen(self._row["participant"], task))

    def on_mount(self) -> None:
        self._show_wellbeing()
        rows = sessions.rows(self.app.database, "attempts", self._row["id"])
        attempts = [sessions.attempt_ended(row) for row in rows if not row["practice"]]
        codes = {"A": self._row["participant"], "B": self._row["partner"]}
        seats = [seat for seat, code in codes.items() if code]
        each = [[one for one in attempts if one.seat == seat] for seat in seats]
        names = [codes[seat] for seat in seats] if len(seats) > 1 else []
        for summary in self.query(Summary):
            summary.show(*each, status=self._row["status"], names=names)

    def _show_wellbeing(self) -> None:
        """Show what was said of pain and tiredness, and the session's adverse events."""
        from sar_tui.records.kind import of_group

        database, session = self.app.database, self._row["id"]
        kinds = [kind.name for kind in of_group("event")]
        events = records.listing(database, kinds=kinds, session=session)
        felt = session_lines(self._row, wellbeing.of_session(database, session), events)
        self.query_one("#felt", Static).update("\n".join(felt))
        self.query_one("#felt").display = bool(felt)
