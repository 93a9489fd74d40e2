"""A voice that fails in every way: each part ends, and the next one works."""

import os
import signal
import sys
import threading
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from sar_tui.model.theme import Note, Theme
from sar_tui.outputs.sound.mixer import Sound, check_sound, examine
from sar_tui.outputs.sound.protocol import Setup, SoundError, Tone
from sar_tui.outputs.sound.supervisor import PartEvent, SoundJob, Supervisor
from tests.needs_speech import needs_speech
from tests.outputs.voice_fixtures import (
    DEADLINE_S,
    ENGINE,
    LONG,
    NOBODY,
    Listener,
    is_alive,
    listening,
    pids,
    program_with,
    real_program,
    until,
)

pytestmark = needs_speech

LACKING = """
def init():
    raise RuntimeError("This means you probably do not have eSpeak or eSpeak-ng installed!")
"""
CRASHES = f"""{ENGINE}
def speak(engine):
    os._exit(3) if 'crash' in engine.text else beep(engine)
"""
HANGS = f"""{ENGINE}
def speak(engine):
    time.sleep(120) if 'hang' in engine.text else beep(engine)
"""
HANGS_IN_C = f"""{ENGINE}
import ctypes
def speak(engine):
    if 'hang' in engine.text:
        ctypes.PyDLL(None).sleep(120)  # without letting any other thread of the process run
    beep(engine)
"""
WRITES_RUBBISH = f"""{ENGINE}
def speak(engine): open(engine.path, 'wb').write(b'RIFF' + bytes([4, 0, 0, 0]) + b'what')
"""


def talking(theme: Theme, *program: list[str], **options: Any) -> AbstractContextManager[Listener]:
    """Provide speech and tones in real time, to no loudspeaker."""
    own = {"program": program[0]} if program else {}
    return listening(Sound(backends=NOBODY, **own, **options), theme)


# --- what is killed, stands still, hangs or crashes


@pytest.mark.slow
def test_a_voice_killed_in_mid_utterance_fails_it_and_the_next_is_spoken(
    calm: Theme, tmp_path: Path
) -> None:
    with talking(calm, real_program(file := tmp_path / "pids")) as listener:
        listener.speech.say("a1", LONG)
        listener.wait("a1", "started")
        os.kill(pids(file)[0], signal.SIGKILL)
        assert listener.wait("a1").detail == "The voice stopped working in the middle of it."
        listener.speech.say("a2", "Well done.")
        assert listener.wait("a2").state == "done"
        assert listener.states("a1") == ["started", "failed"]
        assert len(pids(file)) == 2


@pytest.mark.slow
def test_an_engine_that_hangs_is_aborted_by_a_stop(calm: Theme) -> None:
    with talking(calm, program_with(HANGS_IN_C)) as listener:
        listener.tones.tone("go", "go")
        listener.wait("go")
        listener.speech.say("a1", "Please hang.")
        listener.speech.stop()
        assert listener.wait("a1").state == "aborted"
        listener.speech.say("a2", "Well done.")
        assert listener.wait("a2").state == "done"


@pytest.mark.slow
def test_an_engine_that_hangs_is_killed_after_a_while_and_the_next_is_spoken(
    calm: Theme, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.outputs.sound.supervisor._A_LETTER_S", 0.3)
    with talking(calm, program_with(HANGS), patience_s=1.0) as listener:
        listener.speech.say("a1", "hang")
        listener.speech.say("a2", "Well done. " * 10)  # so long a text has half a minute to begin
        assert listener.wait("a1").detail == "The voice did not begin within 1 s and was ended."
        assert listener.wait("a2").state == "done"
        assert listener.states("a1") == ["failed"]


def test_a_voice_that_never_comes_to_an_end_is_killed(
    calm: Theme, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sar_tui.outputs.sound.supervisor._OVERTIME_S", 0.2)
    with talking(calm, real_program(file := tmp_path / "pids")) as listener:
        listener.tones.tone("a1", "success")
        listener.wait("a1", "started")
        os.kill(pids(file)[0], signal.SIGSTOP)
        assert listener.wait("a1").detail == "The voice did not come to an end and was ended."
        assert not is_alive(pids(file)[0])


@pytest.mark.slow
def test_an_engine_that_crashes_fails_what_it_was_to_say_and_the_rest_is_spoken(
    calm: Theme,
) -> None:
    with talking(calm, program_with(CRASHES)) as listener:
        texts = ("crash", "crash", "Well done.", "crash", "Well done.")
        for number, text in enumerate(texts):
            listener.speech.say(f"a{number}", text)
        assert listener.wait("a4").state == "done", "not three failures in a row"
        for crashed in ("a0", "a1", "a3"):
            assert listener.wait(crashed).detail == "The voice stopped working before it began."
        assert listener.states("a2") == ["started", "done"]


def test_a_voice_that_dies_while_idle_costs_nothing(calm: Theme, tmp_path: Path) -> None:
    with talking(calm, real_program(file := tmp_path / "pids")) as listener:
        listener.tones.tone("a1", "go")
        listener.wait("a1")
        os.kill(pids(file)[0], signal.SIGKILL)
        until(lambda: not is_alive(pids(file)[0]))
        listener.tones.tone("a2", "go")
        assert listener.wait("a2").state == "done"


@pytest.mark.parametrize(
    "program", [["/no/such/program"], [sys.executable, "-c", "print('no reply')"]]
)
def test_a_program_that_is_no_voice_fails_each_part(calm: Theme, program: list[str]) -> None:
    with talking(calm, program) as listener:
        listener.speech.say("a1", "Well done.")
        assert listener.wait("a1").state == "failed"
        assert listener.wait("a1").detail.startswith("The voice ")


# --- what is missing


def test_after_three_failures_in_a_row_speech_stays_off_and_says_why(calm: Theme) -> None:
    with talking(calm, program_with(WRITES_RUBBISH)) as listener:
        for index in range(5):
            listener.speech.say(f"a{index}", "Well done.")
        listener.tones.tone("go", "go")
        reason = listener.wait("a2").detail
        assert reason.startswith("The speech engine gave no sound that can be read")
        for off in (listener.wait(action).detail for action in ("a3", "a4")):
            assert "failed three times" in off
            assert off.endswith(reason)
        assert listener.wait("go").state == "done"


def test_texts_that_cannot_be_read_do_not_put_speech_off(calm: Theme) -> None:
    with talking(calm) as listener:
        for index in range(4):
            listener.speech.say(f"a{index}", "做得好")
        listener.speech.say("a4", "Good.")
        assert listener.wait("a4").state == "done"
        assert {listener.wait(f"a{index}").state for index in range(4)} == {"failed"}


# --- stop and close


def test_a_stop_or_the_end_of_speech_leaves_the_tones(calm: Theme) -> None:
    with talking(calm) as listener:
        listener.speech.say("a1", LONG)
        listener.tones.tone("a1-tone", "success")
        listener.wait("a1", "started")
        listener.speech.stop()
        assert listener.wait("a1").state == "aborted"
        assert listener.wait("a1-tone").state == "done"
        listener.speech.say("a2", LONG)
        listener.wait("a2", "started")
        listener.speech.close()
        listener.tones.tone("a3", "go")
        assert listener.wait("a3").state == "done"
        assert listener.states("a2") == ["started"]


def test_a_voice_that_stops_on_request_is_used_again(
    calm: Theme, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # it may be late on a busy machine
    monkeypatch.setattr("sar_tui.outputs.sound.supervisor._STOP_S", 60.0)
    with talking(calm, real_program(file := tmp_path / "pids")) as listener:
        for action in ("a1", "a2", "a3"):
            listener.speech.say(action, LONG)
            listener.wait(action, "started")
            listener.speech.stop()
            listener.wait(action, "aborted")
        assert len(pids(file)) == 1


def test_close_ends_the_process_and_the_threads(calm: Theme, tmp_path: Path) -> None:
    file = tmp_path / "pids"
    before = set(threading.enumerate())
    with talking(calm, real_program(file)) as listener:
        listener.speech.say("a1", LONG)
        listener.wait("a1", "started")
        listener.close()
        assert set(threading.enumerate()) <= before
        assert not is_alive(pids(file)[0])
        listener.speech.say("a2", "Well done.")
        assert listener.states("a2") == []


def test_the_next_sound_is_played_although_a_report_of_the_last_one_failed() -> None:
    reported: list[PartEvent] = []
    over = threading.Event()

    def refuse(event: PartEvent) -> None:
        reported.append(event)
        if event.job.action == "a2" and event.state == "done":
            over.set()
        raise RuntimeError("the loop has gone")

    beep = (Note(880, 20),)
    supervisor = Supervisor(Setup(backends=NOBODY), refuse)
    supervisor.add(SoundJob("tone", "a1", Tone(1, "a1", beep)))
    supervisor.add(SoundJob("tone", "a2", Tone(2, "a2", beep)))
    second_was_reported = over.wait(DEADLINE_S)
    supervisor.close()
    assert second_was_reported
    assert [(event.job.action, event.state) for event in reported] == [
        (action, state) for action in ("a1", "a2") for state in ("started", "done")
    ]


# --- where sound goes


def test_sound_may_go_to_the_card_or_to_a_folder_that_may_not_exist_yet(tmp_path: Path) -> None:
    for where in ("sound", f"file:{tmp_path}", f"file:{tmp_path / 'not' / 'yet'}"):
        check_sound(where)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("where", "says"),
    [
        ("loud", "Sound cannot go to 'loud': use sound, or file:FOLDER"),
        ("file:", "Sound cannot go to 'file:'"),
        ("", "Sound cannot go to ''"),
        ("file:{}/taken", "is a file: name a folder"),
        ("file:{}/taken/below", "is a file: name a folder"),
        ("file:{}", "is not writable"),
        ("file:a\0b", "is not a folder for sound files"),
        (f"file:/{'x' * 300}", "cannot be a folder for sound files"),
    ],
)
def test_an_unusable_destination_of_sound_is_reported_in_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str, says: str
) -> None:
    (tmp_path / "taken").write_text("a file")
    if says == "is not writable":
        monkeypatch.setattr(os, "access", lambda path, mode: False)
    with pytest.raises(SoundError, match=says):
        check_sound(where.format(tmp_path))


# --- what there is


def test_it_finds_the_voices_and_the_card_and_nothing_is_left_of_it(tmp_path: Path) -> None:
    file = tmp_path / "pids"
    before = threading.active_count()
    found = examine(real_program(file), NOBODY)
    assert threading.active_count() == before
    assert not is_alive(pids(file)[0])
    assert any(voice.speaks("en") for voice in found.voices)
    assert any(voice.speaks("es") for voice in found.voices)
    assert (found.no_voices, found.card, found.no_card) == ("", "Null", "")


def test_it_finds_that_there_is_no_engine_and_no_card() -> None:
    found = examine(program_with(LACKING), ("WASAPI",))
    assert found.voices == ()
    assert found.no_voices
    assert "There is no sound card" in found.no_card


@pytest.mark.parametrize(
    ("program", "says"),
    [
        ([sys.executable, "-c", "import time; time.sleep(30)"], "gave no answer within"),
        ([sys.executable, "-c", "print('{}')"], "stopped working"),
        (["/no/such/program"], "cannot be started"),
    ],
)
def test_a_voice_that_cannot_be_examined_is_reported_in_words(
    program: list[str], says: str
) -> None:
    with pytest.raises(SoundError, match=says):
        examine(program, patience_s=1.0 if "sleep" in program[-1] else 20.0)
