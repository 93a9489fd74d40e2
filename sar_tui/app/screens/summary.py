"""The closing summary: the metric and the level over attempts (the thesis' Figure 4.4), in words and as a plot."""

from collections.abc import Sequence

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Vertical
from textual.widgets import Static

from sar_tui.framework.messages import AttemptEnded
from sar_tui.framework.task import Metric


class Summary(Vertical):
    """What was done, for the participant and the therapist beside them."""

    def __init__(self, metric: Metric, id: str | None = None) -> None:
        super().__init__(id=id)
        self._metric = metric
        self._attempts: Sequence[AttemptEnded] = ()

    def compose(self) -> ComposeResult:
        yield Static("", id="facts", markup=False)
        yield Static("", id="plot")
        yield Static("Press Enter to finish.", id="finish", markup=False)

    def show(self, attempts: Sequence[AttemptEnded], status: str = "completed") -> None:
        """Show a session's scored attempts."""
        self._attempts = attempts
        self.query_one("#facts", Static).update(self._facts(status))
        self.call_after_refresh(self._draw)

    def on_resize(self) -> None:
        self._draw()

    def _facts(self, status: str) -> str:
        done = len(self._attempts)
        words = "You did" if status == "completed" else "Ended early, after"
        reached = [a.metric for a in self._attempts if a.outcome == "success" and a.metric is not None]
        facts = f"{words} {done} {'attempt' if done == 1 else 'attempts'}"
        if not reached:
            return f"{facts}."
        best = (min if self._metric.better == "lower" else max)(reached)
        highest = max(a.level for a in self._attempts)
        facts += f"; goal reached in {len(reached)}."
        return f"{facts} Best: {self._metric.show(best)}. Highest level: {highest}."

    def _draw(self) -> None:
        from sar_tui.plot import EMPTY, LEVEL, MISSED, REACHED, attempts_figure

        plot = self.query_one("#plot", Static)
        if not self._attempts or plot.size.width < 20 or plot.size.height < 6:
            return
        figure = attempts_figure(
            [a.level for a in self._attempts],
            [a.metric for a in self._attempts],
            metric=self._metric.label,
            goals=[a.goal or 0.0 for a in self._attempts],
            width=plot.size.width,
            height=plot.size.height,
            color=False,
            outcomes=[a.outcome for a in self._attempts],
        )
        text = Text(figure)
        colors = self.app.theme_variables
        for marks, color in ((LEVEL, "text-muted"), (REACHED, "success"), (MISSED + EMPTY, "warning")):
            text.highlight_regex(f"[{marks}]+", colors[color])
        plot.update(text)
