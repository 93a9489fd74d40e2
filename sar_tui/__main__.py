"""The program's door: ``sar-tui`` and ``python -m sar_tui``. Opens so fast that a Ctrl-C is always told in a word."""

import sys

from sar_tui import INTERRUPTED


def main() -> None:
    """Run the program; Ctrl-C while it is still being loaded ends it in order, too."""
    try:
        from sar_tui.cli import main as run

        run()
    except KeyboardInterrupt:
        print("Stopped.", file=sys.stderr)
        raise SystemExit(INTERRUPTED) from None


if __name__ == "__main__":
    main()
