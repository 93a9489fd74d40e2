"""The step timer: steps at once when woken, none when finished."""

from sar_tui.loop.clock import VirtualClock
from sar_tui.model.units import MS
from sar_tui.outputs.servo.servo import StepTimer


def test_steps_come_at_their_time_and_at_once_when_woken() -> None:
    clock = VirtualClock()
    steps: list[int] = []

    def step() -> int | None:
        steps.append(clock.now() // MS)
        return 20 * MS if len(steps) < 4 else None

    pace = StepTimer(clock, step, lambda: None)
    pace.start()
    clock.advance(25 * MS)
    pace.wake()
    clock.advance(1000 * MS)
    assert steps == [0, 20, 25, 45]


def test_once_finished_there_is_one_last_call_and_no_step_whoever_wakes_it() -> None:
    clock = VirtualClock()
    called: list[str] = []
    pace = StepTimer(clock, lambda: called.append("step"), lambda: called.append("last"))
    pace.start()
    clock.advance(MS)
    for _ in range(2):
        pace.finish(1)
    pace.wake()
    clock.advance(MS)
    assert called == ["step", "last"]
