"""Signals of programs that tests start."""

import signal

_NAMES = ("SIGHUP", "SIGINT", "SIGQUIT", "SIGTERM")


def let_programs_heed_signals() -> None:
    """Let programs heed signals that this process was told to ignore, as under ``nohup`` or in the
    background.

    A program inherits what is ignored, but not a handler: so this process ignores such a signal by
    a handler.
    """
    for name in _NAMES:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, lambda *_: None)
