"""The child programs that speak and play, from both sides: `SoundProgram` starts, asks, watches and
ends one; in it, `Channel` receives the requests and sends the replies (see `protocol`).

The voice and the tones of prompts have a program each, so that speech cannot delay a tone. Either
may hang or be killed at any time.
"""

import contextlib
import ctypes
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from typing import NoReturn

import msgspec

from sar_tui.drivers import child_process
from sar_tui.outputs.sound.protocol import (
    Reply,
    Request,
    Setup,
    Warm,
    decode_reply,
    decode_request,
    encode,
)

VOICE = child_process.python("sar_tui.outputs.sound.voice_main")
TONES = child_process.python("sar_tui.outputs.sound.tone_main")
_PR_SET_PDEATHSIG = 1


class SoundProgram:
    """A child program that can be started again whenever it has ended.

    Args:
        program: its command line.
        setup: the first message to each process.
        on_reply: called with each reply, on a thread of its own; with None after a process has
            ended by itself.
    """

    def __init__(
        self, program: Sequence[str], setup: Setup, on_reply: Callable[[Reply | None], object]
    ) -> None:
        self._program, self._setup, self._on_reply = program, setup, on_reply
        self._process: subprocess.Popen[bytes] | None = None
        self._listener: threading.Thread | None = None
        self._prepared: dict[str, Warm] = {}

    @property
    def is_running(self) -> bool:
        """False once the process has ended, even before ``on_reply`` is called with None."""
        return self._process is not None and self._process.poll() is None

    def start(self) -> None:
        """Start a process unless one is running, and have it prepare.

        Raises:
            OSError: it cannot be started.
        """
        if self.is_running:
            return
        self.end()
        process = self._process = child_process.start(self._program)
        self._listener = threading.Thread(
            target=self._listen, args=(process,), name="sound replies", daemon=True
        )
        self._listener.start()
        self.send(self._setup)
        for request in self._prepared.values():
            self.send(request)

    def prepare(self, what: str, request: Warm) -> None:
        """Have this process, and each later one, prepare something.

        Raises:
            OSError: no process is running, and none can be started.
        """
        self._prepared[what] = request
        if self.is_running:
            self.send(request)
        else:
            self.start()

    def send(self, request: Request) -> None:
        """Send a request. It is dropped if the process has ended."""
        if self._process and self._process.stdin:
            with contextlib.suppress(OSError):
                self._process.stdin.write(encode(request))

    def end(self) -> None:
        """Kill the process and everything it started, at once. Harmless if it has ended."""
        process, self._process = self._process, None
        if process is None:
            return
        child_process.kill(process)
        with contextlib.suppress(OSError):
            if process.stdin:
                process.stdin.close()
        if self._listener:
            self._listener.join(child_process.REAPED_S)

    def _listen(self, process: "subprocess.Popen[bytes]") -> None:
        assert process.stdout
        with contextlib.suppress(OSError, msgspec.DecodeError), process.stdout:
            for line in process.stdout:
                self._on_reply(decode_reply(line))
        child_process.kill(process)  # it is of no use without replies
        if process is self._process:
            self._on_reply(None)


class Channel:
    """The requests and replies of the child program that creates it.

    Takes over standard input and output; libraries that print or read get the null device. On Linux
    the kernel kills the program with the one that started it, as its own threads may hang.

    Attributes:
        setup: the first message.
    """

    def __init__(self) -> None:
        self._requests = os.fdopen(os.dup(0), "rb")
        self._replies = os.fdopen(os.dup(1), "wb", buffering=0)
        null_device = os.open(os.devnull, os.O_RDWR)
        for standard in (0, 1, 2):
            os.dup2(null_device, standard)
        os.close(null_device)
        if sys.platform == "linux":
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        setup = decode_request(self._requests.readline())
        if not isinstance(setup, Setup):
            raise SystemExit(2)
        self.setup = setup

    def send(self, reply: Reply) -> None:
        """Send a reply."""
        self._replies.write(encode(reply))

    def serve(self, handle: Callable[[Request], object]) -> NoReturn:
        """Handle each request, and end the program after the last, whatever its threads do."""
        try:
            for line in self._requests:
                handle(decode_request(line))
        finally:
            os._exit(0)
