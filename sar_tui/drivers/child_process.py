"""Child processes with their own pipes, detached from the terminal, and killed together with their
children.
"""

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Sequence

REAPED_S = 1.0
"""Longest wait for the end of a killed process."""


def python(module: str, *arguments: str) -> list[str]:
    """Return the command line that runs a Python module: the only one by which the program starts
    Python.

    With ``-P``, no module in the current folder can replace a library.
    """
    without_cache = ["-B"] if sys.dont_write_bytecode else []
    return [sys.executable, *without_cache, "-P", "-m", module, *arguments]


def start(program: Sequence[str]) -> subprocess.Popen[bytes]:
    """Start a child with unbuffered pipes; a Ctrl-C in the terminal does not reach it.

    Raises:
        OSError: it cannot be started.
    """
    flags = 0
    if sys.platform == "win32":
        flags = subprocess.CREATE_NO_WINDOW | subprocess.CREATE_NEW_PROCESS_GROUP
    return subprocess.Popen(
        program,
        bufsize=0,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        creationflags=flags,
        start_new_session=sys.platform != "win32",
    )


def kill(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and everything it started, at once. Harmless if it has ended."""
    with contextlib.suppress(OSError):
        if sys.platform == "win32":
            process.kill()
        elif process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(REAPED_S)
