"""The agent: a drawn face, and its words beside it."""

from rich.text import Text
from textual.app import ComposeResult
from textual.containers import Horizontal
from textual.widgets import Static


class Agent(Horizontal):
    """Shows who speaks and what was said last. It is still unless told to change."""

    DEFAULT_CSS = """
    Agent { height: 6; padding: 0 1; }
    Agent > .face { width: 14; height: 5; color: $accent; }
    Agent > .words { width: 1fr; height: auto; padding: 1 1 0 1; }
    Agent.positive > .words { color: $success; }
    Agent.negative > .words { color: $warning; }
    """

    def __init__(self, faces: dict[str, str], id: str | None = None) -> None:
        super().__init__(id=id)
        self._faces = faces

    def compose(self) -> ComposeResult:
        yield Static(Text(self._faces["neutral"]), classes="face")
        yield Static("", classes="words", markup=False)

    def say(self, text: str, face: str, valence: str | None = None) -> None:
        """Speak: the words stay until the next ones. ``valence`` sets their colour; the words tell it too."""
        self.look(face)
        self.query_one(".words", Static).update(text)
        for name in ("positive", "neutral", "negative"):
            self.set_class(valence == name, name)

    def look(self, face: str) -> None:
        """Change the expression only."""
        self.query_one(".face", Static).update(Text(self._faces.get(face, self._faces["neutral"])))
