"""The summary of a session in words and as a plot: for its participant the goals reached, for
others the results.
"""

from collections.abc import Callable, Sequence
from itertools import accumulate
from typing import TYPE_CHECKING

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Static

from sar_tui.model.messages import AttemptEnded
from sar_tui.model.results_for_people import axis, result_text
from sar_tui.model.trial_types import Metric
from sar_tui.widgets.language import language_of

if TYPE_CHECKING:  # loaded when a session ends
    from sar_tui.reports.charts import ResultName

_GAP = 3
"""Columns between the plots of two participants."""


class Summary(Vertical):
    """Results of a session.

    Args:
        metric: the task's metric.
        more_facts: sentences that the task's view adds for one seat's attempts.
        for_participant: True to plot the goals reached so far, a line that never falls: results get
            worse as the level rises, so that a session that went well would look like a decline.
            Without a goal nothing is plotted. False to plot results and levels over attempts
            (Figure 4.4 of the thesis).
    """

    def __init__(
        self,
        metric: Metric,
        more_facts: Callable[[Sequence[AttemptEnded]], Sequence[str]] = lambda _: (),
        *,
        for_participant: bool = False,
        id: str | None = None,
    ) -> None:
        super().__init__(id=id)
        self._metric = metric
        self._more_facts = more_facts
        self._for_participant = for_participant
        self._attempts: tuple[Sequence[AttemptEnded], ...] = ()
        self._names: Sequence[str] = ()

    def compose(self) -> ComposeResult:
        yield Static("", id="facts", markup=False)
        yield Static("", id="plot")
        yield Static("", id="finish", markup=False)

    def show(
        self,
        *attempts: Sequence[AttemptEnded],
        status: str = "completed",
        names: Sequence[str] = (),
    ) -> None:
        """Show the scored attempts, of each seat if there are several.

        Args:
            attempts: of each seat.
            status: of the session; ``mistake`` if it was started by mistake.
            names: the participants', by seat.
        """
        self._attempts, self._names, tr = attempts, names, language_of(self.app)
        facts = [self._facts(each, status) for each in attempts]
        if names:
            facts = [
                tr("{who}: {words}", who=who, words=words)
                for who, words in zip(names, facts, strict=True)
            ]
        self.query_one("#facts", Static).update("\n".join(facts))
        self.wait(awaits_goodbye=False)
        self.call_after_refresh(self._draw)

    def wait(self, *, awaits_goodbye: bool) -> None:
        """Say that the end is near, or how to finish: the goodbye that an operator decides on is
        waited for.
        """
        tr = language_of(self.app)
        self.query_one("#finish", Static).update(
            tr("One moment…") if awaits_goodbye else tr("Press Enter to finish.")
        )

    def compare(self, words: str) -> None:
        """Add how the session compares with an earlier one."""
        facts = self.query_one("#facts", Static)
        facts.update(f"{facts.content}\n{words}")
        self.call_after_refresh(self._draw)

    def on_resize(self) -> None:
        self._draw()

    def _facts(self, attempts: Sequence[AttemptEnded], status: str) -> str:
        tr, count = language_of(self.app), len(attempts)
        if status == "refused" and self._for_participant:
            return tr(
                "That is all right. The session does not begin, and nothing but this answer is "
                "kept. Thank you."
            )
        if status == "mistake":
            return tr("That is all right. This session does not count.")
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

        plots = list(self.query("#plot").results(Static))
        # none any more if it was removed before the refresh that was waited for
        if not self._attempts or not plots:
            return
        (plot,) = plots
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
                colors[{"reached": "success", "no goal": "accent"}.get(name, "warning")],
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

        found = result_name(attempt.outcome, attempt.metric, attempt.goal, self._metric)
        return "missed" if found == "no result" and self._for_participant else found

    def _figure(self, attempts: Sequence[AttemptEnded], width: int, height: int) -> list[str]:
        """Return the lines of a plot, all ``width`` wide; none if there is nothing to draw, or no
        room.

        The plots of two participants share the scale of their left axis.
        """
        from sar_tui.reports.charts import attempts_figure

        tr = language_of(self.app)
        has_goals = any(attempt.outcome == "success" for each in self._attempts for attempt in each)
        if not attempts or self._metric.is_none or width < 20 or height < 6:
            return []
        if self._for_participant and not has_goals:
            return []
        values, goals = self._plotted(attempts)
        shown = [self._plotted(each) for each in self._attempts]
        figure = attempts_figure(
            [a.level for a in attempts],
            values,
            metric=tr("goals reached") if self._for_participant else axis(self._metric, tr)[0],
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
            has_bars=not self._for_participant,
            tr=tr,
        )
        return [line.ljust(width) for line in figure.splitlines()]

    def _plotted(
        self, attempts: Sequence[AttemptEnded]
    ) -> tuple[list[float | None], list[float | None]]:
        """Return the plotted values of attempts, and their goals, as people read them."""
        if self._for_participant:
            reached = accumulate(float(attempt.outcome == "success") for attempt in attempts)
            return list(reached), [None] * len(attempts)
        _, factor = axis(self._metric, language_of(self.app))
        return [_scaled(a.metric, factor) for a in attempts], [
            _scaled(a.goal, factor) for a in attempts
        ]


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor
