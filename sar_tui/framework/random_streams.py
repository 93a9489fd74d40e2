"""Chance that is the same every time: numbers derived from what they are for, never from a running generator.

A prompt repeated after a pause, or drawn again by a resumed session or a replay, comes out the same, whatever
was drawn in between. The numbers come from BLAKE2b, so they do not change with the version of Python.
"""

import random
from collections.abc import Sequence
from hashlib import blake2b
from typing import TypeVar

T = TypeVar("T")


class RandomStreams:
    """A source of named random numbers.

    Args:
        key: what the numbers are for, e.g. ``(seed, attempt, trial)``.
    """

    def __init__(self, *key: int | str) -> None:
        self._key = key

    def _bits(self, stream: tuple[int | str, ...]) -> int:
        name = "/".join(map(str, (*self._key, *stream)))
        return int.from_bytes(blake2b(name.encode(), digest_size=8).digest(), "big")

    def uniform(self, *stream: int | str) -> float:
        """The number in [0, 1) that belongs to ``stream``: 53 random bits."""
        return (self._bits(stream) >> 11) / (1 << 53)

    def choice(self, options: Sequence[T], *stream: int | str) -> T:
        """The option that belongs to ``stream``, each as likely as the next."""
        return options[int(self.uniform(*stream) * len(options))]

    def generator(self, *stream: int | str) -> random.Random:
        """A generator for many numbers, begun anew for ``stream`` at each call."""
        return random.Random(self._bits(stream))
