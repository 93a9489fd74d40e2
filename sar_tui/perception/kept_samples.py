"""Samples of a sensor that perception keeps until a reach is over."""

from collections import deque

import numpy as np

from sar_tui.motion.samples import Samples, unpack

EVER = -(2**63)
"""Before all stamps."""


class KeptSamples:
    """The newest samples of a sensor, in blocks.

    In a replay the same samples can be divided differently among blocks, so the oldest are cut by
    their stamps.
    """

    def __init__(self) -> None:
        self._blocks: deque[tuple[int, bytes]] = deque()
        """The stamp of each block's newest sample, and its samples."""
        self._from = EVER

    def clear(self) -> None:
        """Forget all samples."""
        self._blocks.clear()
        self._from = EVER

    def add(self, block: bytes) -> Samples:
        """Add packed samples, at least one, and return them."""
        samples = unpack(block)
        self._blocks.append((int(samples["at"][-1]), block))
        return samples

    def forget_before(self, stamp: int) -> None:
        """Forget samples before a stamp, ns."""
        self._from = stamp
        while self._blocks and self._blocks[0][0] < stamp:
            self._blocks.popleft()

    def all(self) -> Samples:
        """Return the samples that are kept."""
        samples = unpack(b"".join([block for _, block in self._blocks]))
        return samples[np.searchsorted(samples["at"], self._from) :]
