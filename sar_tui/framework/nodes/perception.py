"""Perception: raw messages become what a task needs. Filtering lives here."""

from collections.abc import Callable

from sar_tui.framework.clock import MS
from sar_tui.framework.messages import KeyPerceived, KeyPressed, SessionStarted
from sar_tui.framework.node import Node, on
from sar_tui.framework.settings.timing import TimingSettings
from sar_tui.framework.topics import KEY, PERCEIVED, SESSION


class Perception(Node):
    """Tells presses from repeats, and how far apart they are (thesis 4.2.1: "the time between key presses").

    Args:
        parameters: the Task Base.
        seat_of: where several people share a keyboard: whose a key is, empty for nobody's. Each has presses, repeats
            and gaps of their own.
    """

    name = "perception"
    emits = (PERCEIVED,)

    def __init__(self, parameters: TimingSettings, seat_of: Callable[[str], str] | None = None) -> None:
        super().__init__()
        self._repeat_interval = parameters.repeat_interval_ms * MS
        self._seat_of = seat_of
        self._last: dict[str, KeyPressed] = {}

    @on(SESSION)
    def session_started(self, _: SessionStarted) -> None:
        """Stamps of an earlier run cannot be compared."""
        self._last.clear()

    @on(KEY)
    def key_pressed(self, press: KeyPressed) -> None:
        seat = self._seat_of(press.key) if self._seat_of else press.seat
        last, self._last[seat] = self._last.get(seat), press
        gap = press.at - last.at if last else None
        self.emit(
            PERCEIVED,
            KeyPerceived(
                seat=seat,
                key=press.key,
                at=press.at,
                gap=gap,
                repeat=last is not None and last.key == press.key and press.at - last.at < self._repeat_interval,
                delay=self.now - press.at,
                loop_lag=press.loop_lag,
            ),
        )
