"""The child process that speaks and sounds, as the program holds it: started, told, listened to, killed."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from typing import IO

import msgspec

from sar_tui.outputs.sound.protocol import Reply, Request, Setup, line, reply

PROGRAM: Sequence[str] = (sys.executable, "-P", "-m", "sar_tui.outputs.sound.voice")
"""``-P``: no module of the folder that the program was started in takes the place of a library."""
_REAPED_S = 1.0


class Child:
    """A voice. ``heard`` gets each of its replies, and None when there are no more, on a thread of its own.

    Raises:
        OSError: the process cannot be started.
    """

    def __init__(
        self, setup: Setup, heard: "Callable[[Child, Reply | None], object]", program: Sequence[str] = PROGRAM
    ) -> None:
        apart = 0
        if sys.platform == "win32":
            apart = subprocess.CREATE_NO_WINDOW | subprocess.CREATE_NEW_PROCESS_GROUP
        pipe, nothing = subprocess.PIPE, subprocess.DEVNULL
        self._process = subprocess.Popen(
            program,
            bufsize=0,
            stdin=pipe,
            stdout=pipe,
            stderr=nothing,
            creationflags=apart,
            start_new_session=sys.platform != "win32",
        )
        assert self._process.stdin
        assert self._process.stdout
        self._requests: IO[bytes] = self._process.stdin
        self._replies: IO[bytes] = self._process.stdout
        self._heard = heard
        self._listener = threading.Thread(target=self._listen, name="voice replies", daemon=True)
        self._listener.start()
        self.send(setup)

    def send(self, request: Request) -> None:
        """Ask for something. If it is no longer there, ``heard`` is told, and not the caller."""
        with contextlib.suppress(OSError):
            self._requests.write(line(request))

    def kill(self) -> None:
        """End it at once, whatever it is doing, and all that it started. Harmless if it has ended."""
        with contextlib.suppress(OSError):
            if sys.platform == "win32":
                self._process.kill()
            elif self._process.poll() is None:
                os.killpg(self._process.pid, signal.SIGKILL)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_REAPED_S)
        with contextlib.suppress(OSError):
            self._requests.close()
        self._listener.join(_REAPED_S)

    def _listen(self) -> None:
        with contextlib.suppress(OSError, msgspec.DecodeError), self._replies:
            for told in self._replies:
                self._heard(self, reply(told))
        self._heard(self, None)
