"""A terminal at the end of a line: runs a program in a pseudo-terminal of its own, and answers it
as a terminal does.

``python -m tests.end_to_end.terminal_relay PROGRAM ...``. After SIGUSR1 it is a server whose ssh
client is frozen: it takes output, but shows and answers nothing until SIGUSR2.
"""

import os
import pty
import select
import signal
import sys

QUERY, ANSWER = b"\x1b[6n", b"\x1b[1;1R"


def relay(program: list[str]) -> int:
    """Relay until the program ends; return its exit code."""
    child, line = pty.fork()
    if child == 0:
        os.execvp(program[0], program)
    frozen: list[bool] = []
    signal.signal(signal.SIGUSR1, lambda *_: frozen.append(True))
    signal.signal(signal.SIGUSR2, lambda *_: frozen.clear())
    os.set_blocking(1, False)
    held = outgoing = b""
    while True:
        readable, writable, _ = select.select(
            [line, *([] if frozen else [0])], [1] if outgoing else [], []
        )
        if writable:
            outgoing = outgoing[os.write(1, outgoing) :]
        if 0 in readable:
            os.write(line, os.read(0, 4096))
        if line in readable:
            try:
                held += os.read(line, 65536)
            except OSError:  # the program has ended
                break
        if not frozen:
            os.write(line, ANSWER * held.count(QUERY))
            outgoing, held = outgoing + held.replace(QUERY, b""), b""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


if __name__ == "__main__":
    import termios
    import tty

    tty.setraw(0, termios.TCSANOW)
    sys.exit(relay(sys.argv[1:]))
