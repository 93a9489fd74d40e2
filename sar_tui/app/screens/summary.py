"""The closing summary: the metric and the level over attempts (the thesis' Figure 4.4), in words and as a plot."""

from collections.abc import Sequence

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Static

from sar_tui.framework.messages import AttemptEnded
from sar_tui.framework.task import Metric
from sar_tui.widgets.language import language_of


class Summary(Vertical):
    """What was done, for the participant and the therapist beside them."""

    def __init__(self, metric: Metric, id: str | None = None) -> None:
        super().__init__(id=id)
        self._metric = metric
        self._attempts: Sequence[AttemptEnded] = ()

    def compose(self) -> ComposeResult:
        yield Static("", id="facts", markup=False)
        yield Static("", id="plot")
        yield Static("", id="finish", markup=False)

    def show(self, attempts: Sequence[AttemptEnded], status: str = "completed") -> None:
        """Show a session's scored attempts."""
        self._attempts, tr = attempts, language_of(self.app)
        self.query_one("#facts", Static).update(self._facts(status))
        self.query_one("#finish", Static).update(tr("Press Enter to finish."))
        self.call_after_refresh(self._draw)

    def on_resize(self) -> None:
        self._draw()

    def _facts(self, status: str) -> str:
        tr, count = language_of(self.app), len(self._attempts)
        if status == "completed":
            done = tr("You did 1 attempt") if count == 1 else tr("You did {count} attempts", count=count)
        else:
            done = tr("Ended early, after 1 attempt")
            if count != 1:
                done = tr("Ended early, after {count} attempts", count=count)
        reached = [a.metric for a in self._attempts if a.outcome == "success" and a.metric is not None]
        if not reached:
            return f"{done}."
        best = (min if self._metric.better == "lower" else max)(reached)
        return tr(
            "{done}; goal reached in {count}. Best: {best}. Highest level: {level}.",
            done=done,
            count=len(reached),
            best=self._metric.show(best),
            level=max(a.level for a in self._attempts),
        )

    def _draw(self) -> None:
        from sar_tui.plot import EMPTY, LEVEL, MISSED, REACHED, attempts_figure

        plot, tr = self.query_one("#plot", Static), language_of(self.app)
        if not self._attempts or plot.size.width < 20 or plot.size.height < 6:
            return
        figure = attempts_figure(
            [a.level for a in self._attempts],
            [a.metric for a in self._attempts],
            metric=tr(self._metric.label),
            goals=[a.goal or 0.0 for a in self._attempts],
            width=plot.size.width,
            height=plot.size.height,
            color=False,
            outcomes=[a.outcome for a in self._attempts],
            tr=tr,
        )
        text = Text(figure)
        colors = self.app.theme_variables
        for marks, color in ((LEVEL, "text-muted"), (REACHED, "success"), (MISSED + EMPTY, "warning")):
            text.highlight_regex(f"[{marks}]+", colors[color])
        plot.update(text)
