"""Drives the pairs task with keys."""

from sar_tui.loop.topics import TRIAL
from sar_tui.model import messages as m
from sar_tui.model.units import MS
from tests.loop_driver import LoopDriver

SHORT: dict[str, object] = {"prompts_per_attempt": 2, "attempts": 2, "foreperiod_min_ms": 500}


class PairsDriver(LoopDriver):
    """Session in which two participants press keys at given times."""

    def press_after(self, *presses: tuple[float, str]) -> list[m.TrialEnded]:
        """Press keys at times after the next prompt (ms) and return the resulting rows."""
        self.to_prompt()
        onset = self.clock.now()
        known = len(self.all(TRIAL))
        for delay_ms, key in sorted(presses):
            self.clock.advance(max(0, onset + round(delay_ms * MS) - self.clock.now()))
            self.press(key)
        return self.all(TRIAL)[known:]

    @property
    def keys(self) -> tuple[str, str]:
        """Return the keys prompted from A and B; "" for a seat without a prompt."""
        prompt = self.to_prompt()
        left, right = prompt.halves
        return left, right

    def by_seat(self, rows: list[m.TrialEnded]) -> dict[str, m.TrialEnded]:
        assert len({row.seat for row in rows}) == len(rows)
        return {row.seat: row for row in rows}

    def both(self, a_ms: float, b_ms: float) -> dict[str, m.TrialEnded]:
        """Press the correct key of each seat at times after the prompt (ms)."""
        left, right = self.keys
        return self.by_seat(self.press_after((a_ms, left), (b_ms, right)))
