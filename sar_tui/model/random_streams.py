"""Reproducible random numbers, derived from a key and a stream name instead of a running generator.

A prompt that is repeated after a pause, in a resumed session or in a replay is the same again,
whatever was drawn in between. The numbers come from BLAKE2b, so they do not depend on the version
of Python.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import random

T = TypeVar("T")


class RandomStreams:
    """Source of named random numbers.

    Args:
        key: the purpose of the numbers, e.g. ``(seed, attempt, trial)``.
    """

    def __init__(self, *key: int | str) -> None:
        self._prefix = "/".join(map(str, (*key, "")))

    def _bits(self, stream: tuple[int | str, ...]) -> int:
        from hashlib import blake2b

        name = self._prefix + "/".join(map(str, stream)) if stream else self._prefix[:-1]
        return int.from_bytes(blake2b(name.encode(), digest_size=8).digest(), "big")

    def uniform(self, *stream: int | str) -> float:
        """Return the number in [0, 1) of ``stream``: 53 random bits."""
        return (self._bits(stream) >> 11) / (1 << 53)

    def choice(self, options: Sequence[T], *stream: int | str) -> T:
        """Return the option of ``stream``; all are equally likely."""
        return options[int(self.uniform(*stream) * len(options))]

    def generator(self, *stream: int | str) -> "random.Random":
        """Return a new generator for ``stream``; each call returns one with the same numbers."""
        import random

        return random.Random(self._bits(stream))
