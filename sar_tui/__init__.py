"""sar-tui: motor-rehabilitation tasks in a terminal, measured, adapted and answered."""

__version__ = "0.1.0"
