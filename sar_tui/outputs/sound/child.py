"""The child process that speaks and sounds, as the program holds it: started, told, listened to, killed."""

import contextlib
import threading
from collections.abc import Callable, Sequence
from typing import IO

import msgspec

from sar_tui.drivers import child_process
from sar_tui.outputs.sound.protocol import Reply, Request, Setup, line, reply

PROGRAM = child_process.python("sar_tui.outputs.sound.voice")


class Child:
    """A voice. ``heard`` gets each of its replies, and None when there are no more, on a thread of its own.

    Raises:
        OSError: the process cannot be started.
    """

    def __init__(
        self, setup: Setup, heard: "Callable[[Child, Reply | None], object]", program: Sequence[str] = PROGRAM
    ) -> None:
        self._process = child_process.start(program)
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
        child_process.kill(self._process)
        with contextlib.suppress(OSError):
            self._requests.close()
        self._listener.join(child_process.REAPED_S)

    def _listen(self) -> None:
        with contextlib.suppress(OSError, msgspec.DecodeError), self._replies:
            for told in self._replies:
                self._heard(self, reply(told))
        self._heard(self, None)
