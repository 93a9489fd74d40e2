"""The program's side of the voice process: starts it, sends requests, receives replies, kills
it.
"""

import contextlib
import threading
from collections.abc import Callable, Sequence
from typing import IO

import msgspec

from sar_tui.drivers import child_process
from sar_tui.outputs.sound.protocol import Reply, Request, Setup, decode_reply, encode

PROGRAM = child_process.python("sar_tui.outputs.sound.voice_main")


class VoiceProcess:
    """A voice process. ``on_reply`` gets each reply on a thread of its own, and None after the
    last.

    Raises:
        OSError: if the process cannot be started.
    """

    def __init__(
        self,
        setup: Setup,
        on_reply: "Callable[[VoiceProcess, Reply | None], object]",
        program: Sequence[str] = PROGRAM,
    ) -> None:
        self._process = child_process.start(program)
        assert self._process.stdin
        assert self._process.stdout
        self._requests: IO[bytes] = self._process.stdin
        self._replies: IO[bytes] = self._process.stdout
        self._on_reply = on_reply
        self._listener = threading.Thread(target=self._listen, name="voice replies", daemon=True)
        self._listener.start()
        self.send(setup)

    @property
    def has_ended(self) -> bool:
        """True if the process has ended, even before ``on_reply`` has reported it."""
        return self._process.poll() is not None

    def send(self, request: Request) -> None:
        """Send a request; it is dropped if the process has ended, which ``on_reply`` reports with
        None.
        """
        with contextlib.suppress(OSError):
            self._requests.write(encode(request))

    def kill(self) -> None:
        """Kill the process and everything it started, at once. Harmless if it has ended."""
        child_process.kill(self._process)
        with contextlib.suppress(OSError):
            self._requests.close()
        self._listener.join(child_process.REAPED_S)

    def _listen(self) -> None:
        with contextlib.suppress(OSError, msgspec.DecodeError), self._replies:
            for sent in self._replies:
                self._on_reply(self, decode_reply(sent))
        self._on_reply(self, None)
