"""Entry point of ``sar-tui`` and ``python -m sar_tui``. It imports so little that Ctrl-C always ends it in order."""

import sys

from sar_tui.tui.exit_codes import INTERRUPTED


def main() -> None:
    """Run the program, and end it in order on Ctrl-C, even while it is loading."""
    try:
        from sar_tui.cli import main as run

        run()
    except KeyboardInterrupt:
        print("Stopped.", file=sys.stderr)
        raise SystemExit(INTERRUPTED) from None


if __name__ == "__main__":
    main()
