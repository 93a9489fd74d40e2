"""A Reachy Mini, by the HTTP interface of its daemon. The package reachy-mini is not needed.

The robot has no voice: speech is synthesised here, and the sound is played by the robot.
"""

import http.client
import json
import math
import queue
import secrets
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar

import msgspec

from sar_tui.drivers.address import Address
from sar_tui.model.gesture import Gesture, Pose
from sar_tui.model.messages import ActionPart, PartState
from sar_tui.model.units import SECOND
from sar_tui.outputs.output import OutputError
from sar_tui.outputs.robot import Answer, Changed, Heard, Link, Request, Robot, plain, read_address
from sar_tui.outputs.sound.child import VOICE, SoundProgram
from sar_tui.outputs.sound.protocol import Ended, Reply, Say, Setup, Started, Voicing, Warm
from sar_tui.outputs.speech import speakable, voicing

PORT = 8000
ASK_S = 2.0
"""Time limit of one request to the daemon."""
WATCH_S = 2.0
"""Interval at which the daemon is asked whether it is there."""
SPEAK_S = 20.0
"""Time limit of the synthesis of one text."""
FIRST_WORD = 6 * SECOND
"""Time in which it must begin to speak: synthesis and upload come before."""
CLOSE_S = 1.0
"""Longest wait for the robot when closing."""
POLL_S = 0.02
LATE_S = 1.0
"""Time after the end of a movement in which the daemon must have ended it."""
_NOD, _TURN, _ARM, _LEAN = math.radians(20), math.radians(35), math.radians(70), 0.015
"""Head, antennas (rad) and the head's shift (m) where a joint of a gesture is 1."""
GAZES = {
    "left": Pose(turn=-0.8),
    "right": Pose(turn=0.8),
    "up": Pose(nod=-0.8),
    "down": Pose(nod=0.8),
}
LOOK_S = 0.5
SHORTEST_S = 0.1
"""Shortest movement between two poses."""
_EXAMPLE = "reachy://HOST or reachy://HOST:PORT"


class Options(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The address has no options."""


class Unanswered(OutputError):
    """The daemon did not answer a request: the robot is lost, until it answers again."""


class Job:
    """A request that a thread carries out, and whether it is to stop."""

    def __init__(self, request: Request) -> None:
        self.request = request
        self.stopped = threading.Event()


class Daemon:
    """The connection: requests to the daemon, and two threads that carry out what it is to do.

    The daemon carries out two movements at the same time, which pull the head to and fro; so
    gestures and looks share a thread. Sounds have the other one.
    """

    problem = ""

    def __init__(self, address: Address, how: Voicing, changed: Changed, heard: Heard) -> None:
        self._address = address
        self._changed, self._heard = changed, heard
        self._closed = threading.Event()
        self._status: dict[str, Any] | None = None
        self._voice = Voice(how)
        self._body: queue.SimpleQueue[Job | None] = queue.SimpleQueue()
        self._mouth: queue.SimpleQueue[Job | None] = queue.SimpleQueue()
        self._file = f"sar-tui-{secrets.token_hex(4)}.wav"  # every sound takes its place
        self._jobs: list[Job] = []
        self._was_lost = False
        self._threads: list[threading.Thread] = []

    @property
    def is_connected(self) -> bool:
        return self._status is not None

    def open(self) -> None:
        self._start(self._watch)
        self._start(lambda: self._work(self._body, self._move))
        self._start(lambda: self._work(self._mouth, self._speak))

    def _start(self, run: Callable[[], None]) -> None:
        thread = threading.Thread(target=run, name="reachy", daemon=True)
        self._threads = [each for each in self._threads if each.is_alive()] + [thread]
        thread.start()

    def send(self, request: Request) -> bool:
        status = self._status
        if status is None:
            return False
        if request.part == "say":
            if status.get("no_media") or status.get("media_released"):
                raise OutputError("The robot's loudspeaker is off or used by another program.")
            request.answer = FIRST_WORD
        elif _motors(status) == "disabled":
            raise OutputError("The robot's motors are off: wake it up in its control panel.")
        job = Job(request)
        self._jobs.append(job)
        (self._mouth if request.part == "say" else self._body).put(job)
        return True

    def stop(self, id: str) -> bool:
        """Stop the jobs of this id; if it is empty all, and what goes on since the robot was
        lost.
        """
        for job in list(self._jobs):
            if id in ("", job.request.id):
                job.stopped.set()
        if self._was_lost and not id and self.is_connected:
            self._was_lost = False
            self._start(self._stop_all)
        return self.is_connected

    def close(self) -> None:
        for job in list(self._jobs):
            job.stopped.set()
        self._closed.set()
        self._body.put(None)
        self._mouth.put(None)
        until = time.monotonic() + CLOSE_S
        for thread in self._threads:  # what is to be stopped is stopped first
            thread.join(max(0.0, until - time.monotonic()))

    # --- on threads of its own

    def _watch(self) -> None:
        """Ask again and again whether the daemon is there."""
        while not self._closed.is_set():
            status = self._running_status()
            if self.is_connected and status is None:
                self._lose()
            elif status is not None:
                was_there, self._status = self.is_connected, status
                if not was_there:
                    self._tell_change()
            self._closed.wait(WATCH_S if self.is_connected else WATCH_S / 4)

    def _running_status(self) -> dict[str, Any] | None:
        """Return the daemon's status; None if it does not answer, or the robot is not ready."""
        try:
            status = self._ask("GET", "/api/daemon/status")
        except OutputError:
            return None
        is_ready = isinstance(status, dict) and status.get("state") == "running"
        return status if is_ready else None

    def _lose(self) -> None:
        """End all jobs: the output fails them."""
        self._status = None
        self._was_lost = True
        for job in list(self._jobs):
            job.stopped.set()
        self._tell_change()

    def _tell_change(self) -> None:
        if not self._closed.is_set():
            self._changed()

    def _work(self, jobs: "queue.SimpleQueue[Job | None]", do: Callable[[Job], None]) -> None:
        """Carry out one job after another."""
        if jobs is self._mouth:
            self._voice.prepare()
        while job := jobs.get():
            try:
                do(job)
            except Unanswered:
                self._lose()
            except OutputError as error:
                self._answer(job, "failed", str(error))
            except (KeyError, TypeError) as error:
                why = f"The robot's answer could not be understood ({plain(error)})."
                self._answer(job, "failed", why)
            else:
                self._answer(job, "aborted" if job.stopped.is_set() else "done")
            self._jobs.remove(job)
        if jobs is self._mouth:
            self._voice.end()
            if self.is_connected:
                with suppress(OutputError):
                    self._ask("DELETE", f"/api/media/sounds/{self._file}")

    def _move(self, job: Job) -> None:
        """Go from pose to pose; stop the movement under way if the job is stopped."""
        for number, (pose, seconds) in enumerate(poses(job.request)):
            if job.stopped.is_set():
                return
            uuid = self._ask("POST", "/api/move/goto", goto(pose, seconds))["uuid"]
            if not number:
                self._answer(job, "started")
            until = time.monotonic() + seconds
            if not job.stopped.wait(seconds):
                while self._is_running(uuid) and not job.stopped.wait(POLL_S):
                    if time.monotonic() > until + LATE_S:
                        raise OutputError("The robot did not end a movement in time.")
            if job.stopped.is_set():
                self._stop_move(uuid)

    def _speak(self, job: Job) -> None:
        """Synthesise the text, and have the robot play the sound."""
        made = self._voice.speak(job)
        if made is None:
            return
        sound, seconds = made
        self._upload(self._file, sound)
        if job.stopped.is_set():
            return
        self._ask("POST", "/api/media/play_sound", {"file": self._file})
        self._answer(job, "started")
        if job.stopped.wait(seconds):
            self._ask("POST", "/api/media/stop_sound")

    def _stop_all(self) -> None:
        """Stop what this program has lost sight of, too."""
        with suppress(OutputError):
            self._ask("POST", "/api/media/stop_sound")
            for move in self._ask("GET", "/api/move/running"):
                self._stop_move(move["uuid"])

    def _is_running(self, uuid: str) -> bool:
        return any(move["uuid"] == uuid for move in self._ask("GET", "/api/move/running"))

    def _stop_move(self, uuid: str) -> None:
        """Stop a movement. The daemon answers when it has stopped; with an error if it had ended."""
        try:
            self._ask("POST", "/api/move/stop", {"uuid": uuid})
        except OutputError:
            if self._is_running(uuid):
                raise

    def _answer(self, job: Job, state: PartState, detail: str = "") -> None:
        if not self._closed.is_set():
            request = job.request
            self._heard(Answer(state, request.id, request.part, detail))

    # --- the daemon

    def _ask(self, method: str, path: str, what: Any = None) -> Any:
        """Return the daemon's answer. Raises OutputError."""
        body = None if what is None else json.dumps(what).encode()
        return self._http(method, path, body, "application/json")

    def _upload(self, name: str, sound: bytes) -> None:
        line = secrets.token_hex(16)
        head = (
            f'--{line}\r\nContent-Disposition: form-data; name="file"; filename="{name}"\r\n'
            "Content-Type: audio/wav\r\n\r\n"
        )
        body = head.encode() + sound + f"\r\n--{line}--\r\n".encode()
        self._http(
            "POST", "/api/media/sounds/upload", body, f"multipart/form-data; boundary={line}"
        )

    def _http(self, method: str, path: str, body: bytes | None, kind: str) -> Any:
        connection = http.client.HTTPConnection(
            self._address.host, self._address.port, timeout=ASK_S
        )
        try:
            connection.request(method, path, body, {"Content-Type": kind} if body else {})
            response = connection.getresponse()
            text = response.read()
            if response.status >= 400:
                why = _detail(text) or response.reason
                raise OutputError(f"The robot refused {path} ({response.status}: {plain(why)}).")
            return json.loads(text)
        except (OSError, http.client.HTTPException) as error:
            raise Unanswered(f"{path}: {plain(error)}") from error
        except ValueError as error:
            raise OutputError(f"The robot's answer to {path} could not be understood.") from error
        finally:
            connection.close()


def _detail(text: bytes) -> str:
    """Return why the daemon refused something."""
    try:
        answer = json.loads(text)
    except ValueError:
        return ""
    return str(answer.get("detail", "")) if isinstance(answer, dict) else ""


def _motors(status: dict[str, Any]) -> str:
    backend = status.get("backend_status")
    return str(backend.get("motor_control_mode", "")) if isinstance(backend, dict) else ""


def poses(request: Request) -> list[tuple[Pose, float]]:
    """Return the poses of a gesture or a look, each with the time to get there, in s."""
    if request.part == "gaze":
        return [(GAZES.get(request.what, Pose()), LOOK_S)]
    return _poses(request.gesture)


def _poses(gesture: Gesture) -> list[tuple[Pose, float]]:
    found: list[tuple[Pose, float]] = []
    before = 0
    for frame in gesture.keyframes:
        found.append((frame.pose, max(SHORTEST_S, (frame.at_ms - before) / 1000)))
        before = frame.at_ms
    return found


def goto(pose: Pose, seconds: float) -> dict[str, Any]:
    """Return the request for a pose. The robot faces the participant, whose right is its left.

    An antenna at a positive angle points to the robot's right.
    """
    head = {"x": _LEAN * pose.lean, "y": 0.0, "z": 0.0}
    head |= {"roll": 0.0, "pitch": _NOD * pose.nod, "yaw": _TURN * pose.turn}
    antennas = [_ARM * pose.left_arm, -_ARM * pose.right_arm]  # the robot's right and left one
    return {"head_pose": head, "antennas": antennas, "duration": seconds}


class Voice:
    """Turns texts into sounds, by the child program that speaks (see `sound.child`)."""

    def __init__(self, how: Voicing) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="sar-tui-", ignore_cleanup_errors=True)
        self._replies: queue.SimpleQueue[Reply | None] = queue.SimpleQueue()
        setup = Setup(self._folder.name, in_real_time=False)
        self._program = SoundProgram(VOICE, setup, self._replies.put)
        self._number = 0
        self._how = how

    def prepare(self) -> None:
        """Start the program, so that the first words come soon."""
        with suppress(OSError):
            self._program.prepare("say", Warm(self._how))

    def speak(self, job: Job) -> tuple[bytes, float] | None:
        """Return the sound of a text, as a WAV file, and its duration in s; None if the job is
        stopped meanwhile. Raises OutputError.
        """
        text = speakable(job.request.what)
        if not text:
            raise OutputError("There is nothing to say: the text is empty.")
        self._number += 1
        try:
            while not self._replies.empty():
                self._replies.get()
            self._program.start()
            self._program.send(Say(self._number, "say", text, voicing(job.request.theme)))
            seconds = self._wait(job)
            if seconds is None:
                return None
            files = sorted(Path(self._folder.name).glob("*.wav"))
            sound = files[-1].read_bytes()
            for file in files:
                file.unlink()
        except (OSError, IndexError, queue.Empty) as error:
            self._program.end()
            raise OutputError("The speech engine gave no sound.") from error
        return sound, seconds

    def end(self) -> None:
        """End the program, and remove the files."""
        self._program.end()
        self._folder.cleanup()

    def _wait(self, job: Job) -> float | None:
        """Return the duration of the sound in s when it is made; None if the job is stopped."""
        seconds, until = 0.0, time.monotonic() + SPEAK_S
        while not job.stopped.is_set():
            try:
                reply = self._replies.get(timeout=POLL_S)
            except queue.Empty:
                if time.monotonic() > until:
                    raise
                continue
            match reply:
                case Started(self._number, _, seconds):
                    pass
                case Ended(self._number, "failed", _, detail):
                    raise OutputError(detail)
                case Ended(self._number):
                    return seconds
                case None:
                    raise OutputError("The speech engine stopped working.")
        return None


class Reachy(Robot):
    """A Reachy Mini: its head and antennas move through the theme's keyframes.

    Args:
        address: ``reachy://HOST[:PORT]``. Raises OutputError if it is invalid.
    """

    name = "reachy"
    lanes: ClassVar[dict[ActionPart, str]] = {"gesture": "body", "gaze": "body"}

    def __init__(self, address: str) -> None:
        self._address, _ = read_address(address, "reachy", PORT, Options, _EXAMPLE)
        self.place = str(self._address)
        self.missing = f"no daemon of a Reachy Mini answers at {self.place}. Start it there."

    def connect(self, changed: Changed, heard: Heard) -> Link:
        return Daemon(self._address, voicing(self.theme), changed, heard)
