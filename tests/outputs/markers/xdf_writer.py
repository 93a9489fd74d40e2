"""Writes one stream of texts as an XDF file, by the specification
(github.com/sccn/xdf/wiki/Specifications).
"""

import struct
from collections.abc import Sequence
from pathlib import Path

_HEADER, _STREAM_HEADER, _SAMPLES, _CLOCK_OFFSET, _STREAM_FOOTER = 1, 2, 3, 4, 6
_STREAM = struct.pack("<I", 1)


def write_xdf(
    path: Path,
    stream_xml: str,
    samples: Sequence[tuple[float, str]],
    offsets: Sequence[tuple[float, float]],
) -> None:
    """Write texts with their stamps (s), and clock offsets (s) measured at certain times, as a
    recorder would.
    """
    stamps = [stamp for stamp, _ in samples]
    footer = (
        f"<?xml version='1.0'?><info><first_timestamp>{stamps[0]!r}</first_timestamp>"
        f"<last_timestamp>{stamps[-1]!r}</last_timestamp><sample_count>{len(samples)}</sample_count></info>"
    )
    chunks = [
        _chunk(_HEADER, b"<?xml version='1.0'?><info><version>1.0</version></info>"),
        _chunk(_STREAM_HEADER, _STREAM + stream_xml.encode()),
        _chunk(
            _SAMPLES,
            _STREAM + _count(len(samples)) + b"".join(_sample(*sample) for sample in samples),
        ),
        *(_chunk(_CLOCK_OFFSET, _STREAM + struct.pack("<dd", *offset)) for offset in offsets),
        _chunk(_STREAM_FOOTER, _STREAM + footer.encode()),
    ]
    path.write_bytes(b"XDF:" + b"".join(chunks))


def _chunk(tag: int, content: bytes) -> bytes:
    return _count(len(content) + 2) + struct.pack("<H", tag) + content


def _sample(stamp: float, text: str) -> bytes:
    encoded = text.encode()
    return b"\x08" + struct.pack("<d", stamp) + _count(len(encoded)) + encoded


def _count(number: int) -> bytes:
    """Return a number with the number of its bytes before it."""
    return b"\x04" + struct.pack("<I", number)
