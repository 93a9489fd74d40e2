"""Memory: what happened so far in this session, for those who ask."""

from sar_tui.framework.messages import AttemptEnded, Recall, RecalledAttempts, SessionStarted
from sar_tui.framework.node import Node, on, serves
from sar_tui.framework.topics import ATTEMPT_ENDED, RECALL, SESSION


class Memory(Node):
    """Working memory (thesis 3.2.5). It hears an attempt before feedback on it is due, so a recall includes it."""

    name = "memory"

    def __init__(self) -> None:
        super().__init__()
        self._attempts: dict[tuple[str, int], AttemptEnded] = {}
        self._earlier_best: dict[str, dict[str, float]] = {}

    @on(SESSION)
    def session_started(self, session: SessionStarted) -> None:
        """What was achieved in earlier sessions is told at the beginning."""
        self._earlier_best = {session.seat: session.best, **session.others_best}

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, attempt: AttemptEnded) -> None:
        """An attempt that is scored once more takes its own place."""
        self._attempts[attempt.seat, attempt.attempt] = attempt

    @serves(RECALL)
    def recall(self, request: Recall) -> RecalledAttempts:
        return RecalledAttempts(
            attempts=tuple(
                attempt
                for attempt in self._attempts.values()
                if attempt.seat == request.seat and not attempt.practice and request.level in (None, attempt.level)
            ),
            earlier_best=self._earlier_best.get(request.seat, {}).get(str(request.level)),
        )
