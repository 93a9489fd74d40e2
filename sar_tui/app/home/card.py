"""A participant's card: their task and theme, their programme, how they are doing, and START."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from textual.app import ComposeResult
from textual.containers import Center, Container, Horizontal, Vertical
from textual.events import Resize
from textual.widgets import Button, Static

from sar_tui.app.home.chart import LABEL, SessionChart
from sar_tui.widgets.lists import PickList

if TYPE_CHECKING:
    from sar_tui.app.home.contents import CardContents

_WELCOME = (
    "Nobody has trained here yet.",
    "1. Press Enter, and give the first person a code, such as P01. Never a name.",
    "2. Choose their task and their theme. Settings (F2) are yours: what they train, how much, "
    "how hard.",
    "3. START. From there on the screen tells the participant what to do.",
    "To look around first: Ctrl-Q, then sar-tui demo.",
)
_NEW = (
    "Each participant has a code, such as P01. Never use a name.",
    "F6 shows the sessions of everyone.",
)
_LABELS = {
    "task": "Task",
    "theme": "Theme",
    "programme": "Programme",
    "progress": "Progress",
    "last": "Last",
}


class StartButton(Button):
    """START, marked and with its key while Enter presses it."""

    app: Any

    def on_mount(self) -> None:
        self._show_label()

    def watch_has_focus(self, has_focus: bool) -> None:
        super().watch_has_focus(has_focus)
        self._show_label()

    def _show_label(self) -> None:
        start = self.app.tr("START")
        self.label = f"▸ {start} · Enter" if self.has_focus else start


class ParticipantCard(Vertical):
    """All that a therapist wants to know before a session. It is an empty frame until ``open`` is
    called.
    """

    app: Any
    _is_open = False
    _tells = False
    _is_in_study = False
    _is_at_home = False
    _found: "CardContents | None" = None

    async def open(self) -> None:
        """Mount the parts of the card, which take longer than all else on the screen."""
        self._is_open = True
        await self.recompose()

    def compose(self) -> ComposeResult:
        if not self._is_open:
            return
        yield Static("", id="told", markup=False)
        yield Static("", id="study", markup=False)
        yield Static("", id="at-home", markup=False)
        with Container(id="choices"):
            for name in ("task", "theme"):
                with Horizontal(classes="row"):
                    yield self._label(name)
                    with Vertical(classes="slot"):
                        yield PickList(id=name, markup=False)
        with Vertical(id="facts"):
            with Horizontal(classes="row"):
                yield self._label("programme")
                yield Static("", id="programme", classes="value", markup=False)
            yield SessionChart(id="chart")
            for name in ("progress", "last"):
                with Horizontal(classes="row", id=f"{name}-row"):
                    yield self._label(name)
                    yield Static("", id=name, classes="value", markup=False)
        yield Static("", id="welcome", markup=False)
        with Vertical(id="go"):
            yield Static("", id="offer", markup=False)
            with Center():
                yield StartButton(id="start")

    def _label(self, name: str) -> Static:
        return Static(self.app.tr(_LABELS[name]), classes="label", markup=False)

    def show(
        self,
        participant: str,
        title: str,
        found: "CardContents",
        look: Sequence[str],
        offer: str,
        study: str,
        at_home: str = "",
    ) -> None:
        """Show the card of a participant; ``look``: why they need a look today, a sentence each;
        ``study``: what is due in a study; ``at_home``: what is known of their computer at home.
        """
        self.border_title = f"{participant} · {title}"
        self._found = found
        texts = {"progress": found.progress, "last": found.last}
        told = look or found.told
        beside = {"offer": offer, "study": study, "at-home": at_home}
        self._write(texts | {"told": "\n".join(told)} | beside)
        for name, text in texts.items():
            self.query_one(f"#{name}-row").display = bool(text)
        self._tells, self._is_in_study = bool(told), bool(study)
        self._is_at_home = bool(at_home)
        self.query_one("#offer").display = bool(offer)
        without = "" if found.last else self.app.tr("No session yet. START begins the first one.")
        self.query_one(SessionChart).show(found.chart, without)
        self._show_programme()
        self._shows_facts(True)

    def _show_programme(self) -> None:
        if found := self._found:
            room = self.content_size.width - LABEL
            text = found.programme_in_full
            if len(text) > room:
                text = found.programme
            if len(text) > room:
                text = text.replace(" · ", "\n", 1)
            self._write({"programme": text})

    def on_resize(self, event: Resize) -> None:
        """Say the programme in as many words as there is room for."""
        self._show_programme()

    def show_nobody(self, *, is_first: bool) -> None:
        """Say what to do on the line that adds a participant."""
        tr = self.app.tr
        self.border_title = tr("Welcome") if is_first else tr("New participant")
        said = [tr(text) for text in (_WELCOME if is_first else _NEW)]
        self._write({"welcome": "\n\n".join(said), "offer": ""})
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
        self.query_one("#study").display = shows and self._is_in_study
        self.query_one("#at-home").display = shows and self._is_at_home
        self.query_one("#welcome").display = not shows

    def _write(self, texts: dict[str, Any]) -> None:
        for name, text in texts.items():
            self.query_one(f"#{name}", Static).update(text)
