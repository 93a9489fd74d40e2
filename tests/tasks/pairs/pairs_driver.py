"""Two people at one table: who pressed what, and what is kept of it."""

from sar_tui.framework import messages as m
from sar_tui.framework.clock import MS
from sar_tui.framework.topics import TRIAL
from tests.loop_driver import LoopDriver

SHORT: dict[str, object] = {"prompts_per_attempt": 2, "attempts": 2, "foreperiod_min_ms": 500}


class PairsDriver(LoopDriver):
    """A desk at which two press keys after so many milliseconds."""

    def press_after(self, *presses: tuple[float, str]) -> list[m.TrialEnded]:
        """See the next prompt; then let keys be pressed so long after it. The rows that come of it."""
        self.to_prompt()
        onset = self.clock.now()
        known = len(self.all(TRIAL))
        for delay_ms, key in sorted(presses):
            self.clock.advance(max(0, onset + round(delay_ms * MS) - self.clock.now()))
            self.press(key)
        return self.all(TRIAL)[known:]

    @property
    def keys(self) -> tuple[str, str]:
        """What A and B are asked for: "" for who is not."""
        prompt = self.to_prompt()
        left, right = prompt.halves
        return left, right

    def by_seat(self, rows: list[m.TrialEnded]) -> dict[str, m.TrialEnded]:
        assert len({row.seat for row in rows}) == len(rows)
        return {row.seat: row for row in rows}

    def both(self, a_ms: float, b_ms: float) -> dict[str, m.TrialEnded]:
        """Both press their own key, so long after the prompt."""
        left, right = self.keys
        return self.by_seat(self.press_after((a_ms, left), (b_ms, right)))
