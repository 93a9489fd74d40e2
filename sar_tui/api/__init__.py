"""The front door: all that a plug-in, or a program of someone else, may import of sar-tui.

One module for each kind of plug-in: `task`, `node`, `view`, `sensor`, `output`, `export`, `policy`;
`testing` is for their tests. Nothing else of the package is promised (docs/stability.md).
"""

from sar_tui import API

__all__ = ["API"]
