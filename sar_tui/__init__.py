"""sar-tui: motor-rehabilitation tasks in a terminal, measured, adapted and answered."""

__version__ = "0.2.0"
API = 1
"""Number of the interface for plug-ins, `sar_tui.api`. A name leaves it only with a new number."""
