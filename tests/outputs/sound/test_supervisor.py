"""The supervisor goes on if its callback raises or its process has died."""

import asyncio
import os
import queue
import signal
import threading
from pathlib import Path

import pytest

from sar_tui.loop.clock import LiveClock
from sar_tui.model.theme import Note
from sar_tui.outputs.sound.protocol import Reply, Setup, Tone
from sar_tui.outputs.sound.supervisor import PartEvent, SoundJob, Supervisor
from tests.outputs.voice_fixtures import DEADLINE_S, NOBODY, is_alive, pids, real_program, until

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


def test_a_sound_is_played_although_the_end_of_the_last_process_is_not_yet_known(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    known = threading.Event()
    receive = Supervisor._receive

    def received(supervisor: Supervisor, reply: Reply | None) -> None:
        if reply is None:
            known.wait(DEADLINE_S)
        receive(supervisor, reply)

    monkeypatch.setattr(Supervisor, "_receive", received)
    ended: queue.SimpleQueue[PartEvent] = queue.SimpleQueue()
    file = tmp_path / "pids"
    supervisor = Supervisor(
        Setup(backends=NOBODY),
        lambda event: ended.put(event) if event.state in ("done", "failed") else None,
        program=real_program(file),
    )  # fmt: skip
    supervisor.add(SoundJob("tone", "a1", Tone(1, "a1", BEEP)))
    assert ended.get(timeout=DEADLINE_S).state == "done"
    os.kill(pids(file)[0], signal.SIGKILL)
    until(lambda: not is_alive(pids(file)[0]))
    supervisor.add(SoundJob("tone", "a2", Tone(2, "a2", BEEP)))
    assert ended.get(timeout=DEADLINE_S).state == "done"
    known.set()
    supervisor.close()


def test_a_callback_for_a_loop_that_is_closing_is_ignored(monkeypatch: pytest.MonkeyPatch) -> None:
    loop = asyncio.new_event_loop()
    loop.close()
    monkeypatch.setattr(loop, "is_closed", lambda: False)  # as it was a moment ago
    called: list[str] = []
    LiveClock(loop).call_soon(lambda: called.append("soon"))
    assert called == []
