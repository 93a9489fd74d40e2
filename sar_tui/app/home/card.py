"""A participant's card: their task and theme, their programme, how they are doing, and START."""

from typing import TYPE_CHECKING, Any

from textual.app import ComposeResult
from textual.containers import Container, Horizontal, Vertical
from textual.events import Resize
from textual.widgets import Button, Static

from sar_tui.app.home.chart import SessionChart
from sar_tui.widgets.lists import PickList

if TYPE_CHECKING:
    from sar_tui.app.home.contents import CardContents

_ROOMY = 80
"""Columns from which on the programme is said in full."""
_WELCOME = (
    "Nobody has trained here yet.\n\n"
    "1. Press Enter, and give the first person a code, such as P01. Never a name.\n\n"
    "2. Choose their task and their theme. Settings (F2) are yours: what they train, how much, "
    "how hard.\n\n"
    "3. START. From there on the screen tells the participant what to do.\n\n"
    "To look around first: Ctrl-Q, then sar-tui demo."
)
_NEW = "Each participant has a code, such as P01. Never use a name.\n\nF6 shows the sessions of everyone."
_FIRST = "No session yet. START begins the first one."


class ParticipantCard(Vertical):
    """All that a therapist wants to know before a session. It is an empty frame until ``open`` is
    called.
    """

    _is_open = False
    _tells = False
    _found: "CardContents | None" = None

    async def open(self) -> None:
        """Mount the parts of the card, which take longer than all else on the screen."""
        self._is_open = True
        await self.recompose()

    def compose(self) -> ComposeResult:
        if not self._is_open:
            return
        yield Static("", id="told", markup=False)
        with Container(id="choices"):
            for name in ("Task", "Theme"):
                with Horizontal(classes="row"):
                    yield Static(name, classes="label")
                    with Vertical(classes="slot"):
                        yield PickList(id=name.lower(), markup=False)
        with Vertical(id="facts"):
            with Horizontal(classes="row"):
                yield Static("Programme", classes="label", markup=False)
                yield Static("", id="programme", classes="value", markup=False)
            yield SessionChart(id="chart")
            for name in ("Progress", "Last"):
                with Horizontal(classes="row", id=f"{name.lower()}-row"):
                    yield Static(name, classes="label", markup=False)
                    yield Static("", id=name.lower(), classes="value", markup=False)
        yield Static("", id="welcome", markup=False)
        with Vertical(id="go"):
            yield Static("", id="offer", markup=False)
            yield Button("START", id="start", variant="primary")

    def show(self, participant: str, title: str, found: "CardContents", offer: str) -> None:
        """Show the card of a participant."""
        self.border_title = f"{participant} · {title}"
        self._found = found
        texts = {"progress": found.progress, "last": found.last}
        self._write(texts | {"told": "\n".join(found.told), "offer": offer})
        for name, text in texts.items():
            self.query_one(f"#{name}-row").display = bool(text)
        self._tells = bool(found.told)
        self.query_one(SessionChart).show(found.chart, "" if found.last else _FIRST)
        self._show_programme()
        self._shows_facts(True)

    def _show_programme(self) -> None:
        from sar_tui.app.home.words import programme_words

        if self._found:
            programme, problem = self._found.programme, self._found.problem
            said = (
                programme_words(programme, is_roomy=self.size.width >= _ROOMY)
                if programme
                else problem
            )
            self._write({"programme": said})

    def on_resize(self, event: Resize) -> None:
        """Say the programme in as many words as there is room for."""
        self._show_programme()

    def show_nobody(self, *, is_first: bool) -> None:
        """Say what to do on the line that adds a participant."""
        self.border_title = "Welcome" if is_first else "New participant"
        self._write({"welcome": _WELCOME if is_first else _NEW, "offer": ""})
        self._shows_facts(False)

    def show_problem(self, participant: str, text: str) -> None:
        """Say why there is no card."""
        self.border_title = participant
        self._write({"welcome": text})
        self._shows_facts(False)

    def _shows_facts(self, shows: bool) -> None:
        for name in ("#choices", "#facts", "#go"):
            self.query_one(name).display = shows
        self.query_one("#told").display = shows and self._tells
        self.query_one("#welcome").display = not shows

    def _write(self, texts: dict[str, Any]) -> None:
        for name, text in texts.items():
            self.query_one(f"#{name}", Static).update(text)
