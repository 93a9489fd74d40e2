"""Entry point of ``sar-tui`` and ``python -m sar_tui``. It imports so little that Ctrl-C always
ends it in order.
"""

import os
import sys

from sar_tui.drivers.file_limit import largest_file
from sar_tui.tui.exit_codes import INTERRUPTED


def main() -> None:
    """Run the program, and end it in order on Ctrl-C, even while it is loading."""
    try:
        if largest_file() is not None:
            sys.dont_write_bytecode = (
                True  # Python would keep modules that it could only write in part
            )
        from sar_tui.cli import main as run

        run()
    except KeyboardInterrupt:
        print("Stopped.", file=sys.stderr)
        raise SystemExit(INTERRUPTED) from None
    finally:
        _drop_unwritable_output()


def _drop_unwritable_output() -> None:
    """Drop what cannot be written any more, as to a lost terminal: Python would end with an exit
    code of its own.
    """
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None and not stream.closed:
                stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


if __name__ == "__main__":
    main()
