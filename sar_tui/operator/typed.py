"""The line in which an operator types."""

from textual.widgets import Input


class Typed(Input):
    """Is given what is typed by the panel, which keeps the order of the keys (see `ordered_keys`)."""

    def put(self, text: str) -> None:
        """Type it where the cursor is, in the place of what is selected."""
        self.replace(text, *self.selection)
