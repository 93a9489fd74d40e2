"""One check of a plug-in, and its result."""

import msgspec


class Check(msgspec.Struct, frozen=True):
    """A named check, the problems it found, and what it measured if that is worth showing."""

    check: str
    problems: tuple[str, ...] = ()
    found: str = ""

    @property
    def ok(self) -> bool:
        """True if there is no problem."""
        return not self.problems
