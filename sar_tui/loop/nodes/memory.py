"""Memory: answers recalls of the session's scored attempts."""

from sar_tui.loop.node import Node, on, serves
from sar_tui.loop.topics import ATTEMPT_ENDED, RECALL, SESSION
from sar_tui.model.messages import AttemptEnded, Recall, RecalledAttempts, SessionStarted


class Memory(Node):
    """Working memory (thesis 3.2.5). It receives an attempt before the feedback on it, so a recall
    includes it.
    """

    name = "memory"

    def __init__(self) -> None:
        super().__init__()
        self._attempts: dict[tuple[str, int], AttemptEnded] = {}
        self._earlier_best: dict[str, dict[str, float]] = {}

    @on(SESSION)
    def session_started(self, session: SessionStarted) -> None:
        """Store the best results of earlier sessions."""
        self._earlier_best = {session.seat: session.best, **session.others_best}

    @on(ATTEMPT_ENDED)
    def attempt_ended(self, attempt: AttemptEnded) -> None:
        """Store an attempt; one that is scored again replaces its earlier score."""
        self._attempts[attempt.seat, attempt.attempt] = attempt

    @serves(RECALL)
    def recall(self, request: Recall) -> RecalledAttempts:
        return RecalledAttempts(
            attempts=tuple(
                attempt
                for attempt in self._attempts.values()
                if attempt.seat == request.seat
                and not attempt.practice
                and request.level in (None, attempt.level)
                and request.condition in (None, attempt.condition)
            ),
            earlier_best=self._earlier_best.get(request.seat, {}).get(
                best_key(request.level, request.condition or "")
            ),
        )


def best_key(level: int | None, condition: str) -> str:
    """Return the key of a best result: attempts at a level and in a condition are comparable."""
    return f"{level} {condition}".rstrip()
