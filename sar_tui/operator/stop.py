"""A stop of the agent, from the key until every output has reported that it is still. Pure."""

from typing import NamedTuple

from sar_tui.model.messages import OutputStopped
from sar_tui.model.units import MS, SECOND
from sar_tui.operator.event_log import Line, Tone

UNCONFIRMED = 3 * SECOND
"""An output that has not reported by then is named. Outputs give up earlier (see
`outputs.node.STOP_TIMEOUT`).
"""


class Stop(NamedTuple):
    """A stop.

    Attributes:
        at: when it was requested (ns, session clock).
        by: who pressed the key, for the log.
        awaited: outputs that have not reported.
        failed: outputs that could not stop, with the reason.
        still_at: when the last output was still (ns).
        is_past: the agent has acted since.
    """

    at: int
    by: str
    awaited: frozenset[str] = frozenset()
    failed: tuple[tuple[str, str], ...] = ()
    still_at: int = 0
    is_past: bool = False

    def reported(self, stopped: OutputStopped) -> "Stop":
        """Return the stop after an output has reported."""
        if stopped.output not in self.awaited:
            return self
        failed = (*self.failed, (stopped.output, stopped.detail)) if stopped.detail else self.failed
        awaited = self.awaited - {stopped.output}
        return self._replace(
            awaited=awaited, failed=failed, still_at=max(self.still_at, stopped.at)
        )

    def is_awaited(self, now: int) -> bool:
        """Return True while the outcome may change without a message of the session."""
        return bool(self.awaited) and now - self.at <= 2 * UNCONFIRMED

    def outcome(self, now: int) -> tuple[str, Tone]:
        """Return what is known at ``now`` (ns): stopping, stopped, or which output has not
        confirmed it.
        """
        late = sorted(self.awaited) if now - self.at > UNCONFIRMED else []
        names = [*(name for name, _ in self.failed), *late]
        if names:
            why = " ".join(detail for _, detail in self.failed)
            return f"not confirmed: {', '.join(names)}{f' ({why})' if why else ''}", "bad"
        if self.awaited:
            return f"stopping {', '.join(sorted(self.awaited))} …", "plain"
        if not self.still_at:
            return "no output is open", "plain"
        return f"stopped after {max(0, self.still_at - self.at) / MS:.0f} ms", "good"

    def line(self, now: int) -> Line:
        """Return its line of the log."""
        text, tone = self.outcome(now)
        return Line(self.at, f"{self.by}: {text}", tone)
