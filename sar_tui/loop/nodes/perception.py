"""Perception: turns raw key presses into percepts."""

from collections.abc import Callable

from sar_tui.loop.node import Node, on
from sar_tui.loop.topics import KEY, PERCEIVED, SESSION
from sar_tui.model.messages import KeyPerceived, KeyPressed, SessionStarted
from sar_tui.model.units import MS
from sar_tui.rules.keys import STREAM, is_stream
from sar_tui.rules.parameters import TaskParameters


class Perception(Node):
    """Distinguishes presses from repeats, and measures the time between them (thesis 4.2.1).

    Args:
        parameters: the Task Base.
        seat_of: returns the seat of a key if participants share a keyboard; empty for no seat.
            Repeats and gaps are determined for each seat.
    """

    name = "perception"
    emits = (PERCEIVED,)

    def __init__(
        self, parameters: TaskParameters, seat_of: Callable[[str], str] | None = None
    ) -> None:
        super().__init__()
        self._repeat_interval = max(parameters.repeat_interval_ms, parameters.bounce_ms) * MS
        self._seat_of = seat_of
        self._last: dict[str, KeyPressed] = {}
        self._same: dict[str, tuple[int, ...]] = {}
        """Stamps of the last presses of one key, by seat."""

    @on(SESSION)
    def session_started(self, _: SessionStarted) -> None:
        """Forget earlier presses: time stamps of different runs cannot be compared."""
        self._last.clear()
        self._same.clear()

    @on(KEY)
    def key_pressed(self, press: KeyPressed) -> None:
        seat = self._seat_of(press.key) if self._seat_of else press.seat
        if not isinstance(seat, str):
            raise TypeError(
                f"seat_of() returned {seat!r:.60} for the key {press.key}, not a seat or an empty "
                "text"
            )
        last, self._last[seat] = self._last.get(seat), press
        gap = press.at - last.at if last else None
        is_same = last is not None and last.key == press.key
        same = self._same[seat] = (
            *(self._same.get(seat, ())[1 - STREAM :] if is_same else ()),
            press.at,
        )
        is_held = is_stream(same)
        self.emit(
            PERCEIVED,
            KeyPerceived(
                seat=seat,
                key=press.key,
                at=press.at,
                gap=gap,
                repeat=is_held or (is_same and gap is not None and gap < self._repeat_interval),
                delay=self.now - press.at,
                loop_lag=press.loop_lag,
                stalled=press.stalled,
            ),
        )
