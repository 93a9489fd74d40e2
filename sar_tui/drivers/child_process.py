"""A child process with pipes of its own, apart from the terminal: started, and ended with all that it started."""

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Sequence

REAPED_S = 1.0


def python(module: str) -> Sequence[str]:
    """The command line of a module of ours.

    ``-P``: no module of the folder that the program was started in takes the place of a library.
    """
    return (sys.executable, "-P", "-m", module)


def start(program: Sequence[str]) -> subprocess.Popen[bytes]:
    """Start a child with unbuffered pipes in and out; a Ctrl-C in the terminal does not reach it.

    Raises:
        OSError: it cannot be started.
    """
    apart = 0
    if sys.platform == "win32":
        apart = subprocess.CREATE_NO_WINDOW | subprocess.CREATE_NEW_PROCESS_GROUP
    return subprocess.Popen(
        program,
        bufsize=0,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        creationflags=apart,
        start_new_session=sys.platform != "win32",
    )


def kill(process: subprocess.Popen[bytes]) -> None:
    """End it at once, whatever it is doing, and all that it started. Harmless if it has ended."""
    with contextlib.suppress(OSError):
        if sys.platform == "win32":
            process.kill()
        elif process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(REAPED_S)
