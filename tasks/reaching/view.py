"""The view of the reaching task: between attempts, curves of the hand's angular rate in the last
reaches.
"""

from collections import deque
from typing import TYPE_CHECKING

from sar_tui.api.view import REACH, Colors, Drawing, ReachPerceived, Task, TaskView, Text, on

if TYPE_CHECKING:
    from sar_tui.api.view import Trace

_DRAWN = 3
"""Number of reaches that are drawn: the newest and those before it."""


class ReachingView(TaskView):
    """Keeps the last reaches, and draws them while the participant rests."""

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self._traces: deque[Trace] = deque(maxlen=_DRAWN)
        self._count = 0

    @on(REACH)
    def reached(self, reach: ReachPerceived) -> None:
        self._count += 1
        if reach.trace_marks:
            from sar_tui.api.view import Trace  # loads numpy

            onset, arrival, departure, end = reach.trace_marks
            self._traces.append(
                Trace(
                    rate=list(reach.trace),
                    rate_hz=reach.trace_hz,
                    onset_s=onset,
                    arrival_s=arrival,
                    departure_s=departure,
                    end_s=end,
                    label=self.tr("reach {number}", number=self._count),
                )
            )

    def between_attempts(self) -> Drawing | None:
        return self._draw if self._traces else None

    def _draw(self, width: int, height: int, colors: Colors) -> Text:
        from sar_tui.api.view import draw_traces

        muted = colors["text-muted"]
        styles = dict.fromkeys(("rest", "earlier", "axis"), muted)
        styles |= {
            "out": f"bold {colors['accent']}",
            "dwell": f"bold {muted}",
            "back": f"bold {colors['foreground']}",
        }
        return draw_traces(tuple(self._traces), width, height, styles, self.tr)
