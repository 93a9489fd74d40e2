"""The commands. Each is a few lines that call other packages, which are imported when the command
runs.
"""

import os
import sys

from sar_tui import __version__
from sar_tui.tui.exit_codes import FAILED


def main() -> None:
    """Run the program, and exit with 0: done, 1: failed, 2: bad usage or input, 130: stopped by
    Ctrl-C.
    """
    if sys.stdout is None:  # closed by the caller
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    try:
        _run()
    except BrokenPipeError:
        raise SystemExit(FAILED) from None
    # the help or the version cannot be printed; commands report their errors themselves
    except OSError as error:
        from sar_tui.cli.errors import report

        raise SystemExit(report(error)) from None


def _run() -> None:
    # loading the parser of the command line takes longer than starting Python
    if sys.argv[1:] == ["--version"]:
        print(f"sar-tui {__version__}", flush=True)
        raise SystemExit(0)
    from sar_tui.cli.visible_output import make_output_visible

    make_output_visible()
    from sar_tui.cli.commands import app

    app(prog_name="sar-tui")
