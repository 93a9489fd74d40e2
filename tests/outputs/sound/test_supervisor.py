"""The supervisor goes on if its callback raises."""

import asyncio
import threading

import pytest

from sar_tui.framework.clock import LiveClock
from sar_tui.framework.theme import Note
from sar_tui.outputs.sound.protocol import Setup, Tone
from sar_tui.outputs.sound.supervisor import PartEvent, SoundJob, Supervisor
from tests.outputs.voice_fixtures import DEADLINE_S, NOBODY

BEEP = (Note(880, 20),)


def test_the_next_sound_is_played_although_a_report_of_the_last_one_failed() -> None:
    reported: list[PartEvent] = []
    over = threading.Event()

    def refuse(event: PartEvent) -> None:
        reported.append(event)
        if event.job.action == "a2" and event.state == "done":
            over.set()
        raise RuntimeError("the loop has gone")

    supervisor = Supervisor(Setup(backends=NOBODY), refuse)
    supervisor.add(SoundJob("tone", "a1", Tone(1, "a1", BEEP)))
    supervisor.add(SoundJob("tone", "a2", Tone(2, "a2", BEEP)))
    second_was_reported = over.wait(DEADLINE_S)
    supervisor.close()
    assert second_was_reported
    assert [(event.job.action, event.state) for event in reported] == [
        (action, state) for action in ("a1", "a2") for state in ("started", "done")
    ]


def test_a_callback_for_a_loop_that_is_closing_is_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    loop = asyncio.new_event_loop()
    loop.close()
    monkeypatch.setattr(loop, "is_closed", lambda: False)  # as it was a moment ago
    called: list[str] = []
    LiveClock(loop).call_soon(lambda: called.append("soon"))
    assert called == []
