"""Result of one check of a plug-in."""

import msgspec


class Check(msgspec.Struct, frozen=True):
    """A named check, the problems it found, and, if worth showing, what it found otherwise.

    ``warning``: something to think about that breaks no contract.
    """

    check: str
    problems: tuple[str, ...] = ()
    found: str = ""
    warning: str = ""

    @property
    def ok(self) -> bool:
        """True if there is no problem."""
        return not self.problems
