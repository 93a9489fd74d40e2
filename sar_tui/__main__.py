"""``python -m sar_tui`` is ``sar-tui``."""

from sar_tui.cli import main

if __name__ == "__main__":
    main()
