"""The commands. Each is a few lines that call other packages, which are imported when the command runs."""

import sys

from sar_tui import __version__


def main() -> None:
    """Run the program, and exit with 0: done, 1: failed, 2: bad usage or input, 130: stopped by Ctrl-C."""
    if sys.argv[1:] == ["--version"]:  # loading the parser of the command line takes longer than starting Python
        print(f"sar-tui {__version__}")
        raise SystemExit(0)
    from sar_tui.cli.visible_output import make_output_visible

    make_output_visible()
    from sar_tui.cli.commands import app

    app(prog_name="sar-tui")
