"""The results of a past session, for a therapist."""

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.widgets import Static

from sar_tui.app.home.words import day_words
from sar_tui.model.language import Language, in_language
from sar_tui.model.messages import AttemptEnded
from sar_tui.model.results_for_people import axis, result_text
from sar_tui.model.trial_types import Metric
from sar_tui.plugins import PluginError
from sar_tui.reports import progress_words
from sar_tui.reports.wellbeing import session_lines
from sar_tui.store import provenance, records, sessions, wellbeing
from sar_tui.store.training_days import trained_at
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.language import language_of
from sar_tui.widgets.task_view import stored_facts

if TYPE_CHECKING:
    from sar_tui.reports.charts import ResultName


class PastSessionScreen(DismissedOnce[None]):
    """The plot and figures of one stored session."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,enter,space", "dismiss", "Back", id="back"),
        Binding("f4", "progress", "Progress", id="progress"),
        Binding("a", "report_event", "Adverse event", id="adverse-event"),
    ]

    app: Any

    def __init__(self, row: sessions.Row) -> None:
        super().__init__()
        self._row = row

    @functools.cached_property
    def tr(self) -> Language:
        """The language of the app, with the texts of reports and, if it is installed, of the
        task.
        """
        spoken: Language = self.app.tr
        try:
            task = self.app.catalogue.task(self._row["task"])
        except PluginError:
            task = None
        return spoken.including(progress_words.words(spoken.code, task).texts)

    @property
    def help_text(self) -> str:
        """Help on the plot, and on what can be done."""
        tr = self.tr
        return "\n\n".join(
            (
                tr("The results of a past session: each attempt and its level."),
                tr("F4 shows the sessions of this person. A adds an adverse event of this one."),
                "",
            )
        )

    def compose(self) -> ComposeResult:
        row = self._row
        yield Static(self._title(), id="top", markup=False)
        yield Results(
            provenance.metric(row["software"]), self._attempts(), row["status"], self._facts
        )
        yield Static("", id="felt", markup=False)
        yield KeyFooter()

    def _title(self) -> str:
        """Return who, what and when: "P01 · Keyboard reaction · Tue 17 Nov, 15:04 · completed"."""
        row = self._row
        began = trained_at(row["started_at"], row["utc_offset_s"])
        title = row["software"].get("task", {}).get("title", row["task"])
        when = f"{day_words(began.date(), self.app.today(), self.tr)}, {began:%H:%M}"
        return " · ".join(
            (
                sessions.participant_codes(row),
                self.tr(title),
                when,
                progress_words.status(row["status"], self.tr),
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
            self.notify(in_language(error, self.tr), severity="warning", timeout=15)
        else:
            self.app.push_screen(ProgressScreen(self._row["participant"], task))

    def on_mount(self) -> None:
        self._show_wellbeing()

    def _attempts(self) -> dict[str, list[AttemptEnded]]:
        """Return the scored attempts of each participant, by code."""
        rows = sessions.rows(self.app.database, "attempts", self._row["id"])
        attempts = [sessions.attempt_ended(row) for row in rows if not row["practice"]]
        codes = {self._row["participant"]: "A", self._row["partner"]: "B"}
        return {
            code: [each for each in attempts if each.seat == seat]
            for code, seat in codes.items()
            if code
        }

    def _facts(self, attempts: Sequence[AttemptEnded]) -> Sequence[str]:
        """Return what the task's view adds, if the task is still installed."""
        try:
            task = self.app.catalogue.task(self._row["task"])
        except PluginError:
            return ()
        metric = provenance.metric(self._row["software"])
        return stored_facts(task, attempts, metric, self.tr)

    def _show_wellbeing(self) -> None:
        """Show what was said of pain and tiredness, and the session's adverse events."""
        from sar_tui.records.kind import of_group

        database, session = self.app.database, self._row["id"]
        kinds = [kind.name for kind in of_group("event")]
        events = records.listing(database, kinds=kinds, session=session)
        felt = session_lines(self._row, wellbeing.of_session(database, session), events, self.tr)
        self.query_one("#felt", Static).update("\n".join(felt))
        self.query_one("#felt").display = bool(felt)


# --- results


_GAP = 3
"""Columns between the plots of two participants."""


class Results(Vertical):
    """Results of a session in words and as a plot of results and levels over attempts (Figure 4.4 of
    the thesis).

    Args:
        metric: the task's metric.
        attempts: the scored ones, by participant.
        status: of the session.
        more_facts: returns sentences that the task's view adds for one participant's attempts.
    """

    def __init__(
        self,
        metric: Metric,
        attempts: Mapping[str, Sequence[AttemptEnded]],
        status: str,
        more_facts: Callable[[Sequence[AttemptEnded]], Sequence[str]],
    ) -> None:
        super().__init__(id="results")
        self._metric = metric
        self._attempts = tuple(attempts.values())
        self._names = list(attempts) if len(attempts) > 1 else [""]
        self._status = status
        self._more_facts = more_facts

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        lines = []
        for name, attempts in zip(self._names, self._attempts, strict=True):
            words = self._facts(attempts, self._status)
            lines.append(tr("{who}: {words}", who=name, words=words) if name else words)
        yield Static("\n".join(lines), id="facts", markup=False)
        yield Static("", id="plot")

    def on_resize(self) -> None:
        self._draw()

    def _facts(self, attempts: Sequence[AttemptEnded], status: str) -> str:
        tr, count = language_of(self.app), len(attempts)
        if status == "completed":
            done = (
                tr("You did 1 attempt")
                if count == 1
                else tr("You did {count} attempts", count=count)
            )
        elif status == "running":
            done = (
                tr("1 attempt so far") if count == 1 else tr("{count} attempts so far", count=count)
            )
        else:
            done = (
                tr("Ended early, after 1 attempt")
                if count
                else tr("Ended before the first attempt was finished")
            )
            if count > 1:
                done = tr("Ended early, after {count} attempts", count=count)
        reached = [a.metric for a in attempts if a.outcome == "success" and a.metric is not None]
        more = "".join(f" {fact}" for fact in self._more_facts(attempts))
        if not reached:
            return f"{done}.{more}"
        best = (min if self._metric.better == "lower" else max)(reached)
        facts = tr(
            "{done}; goal reached in {count}. Best: {best}. Highest level: {level}.",
            done=done,
            count=len(reached),
            best=result_text(self._metric, best, tr),
            level=max(a.level for a in attempts),
        )
        return f"{facts}{more}"

    def _draw(self) -> None:
        from sar_tui.reports.charts import BARS, MARKERS

        plot = self.query_one("#plot", Static)
        several = len(self._attempts) > 1
        width = plot.size.width // len(self._attempts)
        figures = [self._figure(each, width, plot.size.height - several) for each in self._attempts]
        if not all(figures):
            return
        lines = list(map("".join, zip(*figures, strict=True)))
        text = Text(
            "\n".join([self._legend().rjust(plot.size.width), *lines] if several else lines)
        )
        colors = self.app.theme_variables
        text.highlight_regex(f"[{BARS}]+", colors["text-muted"])
        for name, marker in MARKERS.items():
            text.highlight_regex(
                f"{marker}+",
                colors[{"reached": "success", "no goal": "accent"}.get(name, "text-muted")],
            )
        plot.update(text)

    def _legend(self) -> str:
        """Return the legend of both participants' plots, which has no room beside either
        heading.
        """
        from sar_tui.reports.charts import legend

        results = [self._result(attempt) for each in self._attempts for attempt in each]
        goals = [goal for each in self._attempts for goal in self._plotted(each)[1]]
        return "  ".join(legend(goals, results, language_of(self.app)))

    def _result(self, attempt: AttemptEnded) -> "ResultName":
        from sar_tui.reports.charts import result_name

        return result_name(attempt.outcome, attempt.metric, attempt.goal, self._metric)

    def _figure(self, attempts: Sequence[AttemptEnded], width: int, height: int) -> list[str]:
        """Return the lines of a plot, all ``width`` wide; none if there is nothing to draw, or no
        room.

        The plots of two participants share the scale of their left axis.
        """
        from sar_tui.reports.charts import attempts_figure

        tr = language_of(self.app)
        if not attempts or self._metric.is_none or width < 20 or height < 6:
            return []
        values, goals = self._plotted(attempts)
        shown = [self._plotted(each) for each in self._attempts]
        figure = attempts_figure(
            [a.level for a in attempts],
            values,
            metric=axis(self._metric, tr)[0],
            goals=goals,
            width=width - _GAP if len(self._attempts) > 1 else width,
            height=height,
            color=False,
            results=[self._result(attempt) for attempt in attempts],
            beside=[
                *(value for own, _ in shown for value in own),
                *(goal for _, own in shown for goal in own if goal is not None),
            ],
            has_legend=len(self._attempts) == 1,
            tr=tr,
        )
        return [line.ljust(width) for line in figure.splitlines()]

    def _plotted(
        self, attempts: Sequence[AttemptEnded]
    ) -> tuple[list[float | None], list[float | None]]:
        """Return the plotted values of attempts, and their goals, as people read them."""
        _, factor = axis(self._metric, language_of(self.app))
        return [_scaled(a.metric, factor) for a in attempts], [
            _scaled(a.goal, factor) for a in attempts
        ]


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor
