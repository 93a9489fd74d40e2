"""What is seen of the operator's panel: the mirror, the proposal that is to be decided, the palette, the log."""

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content, Span
from textual.message import Message
from textual.widgets import Static

from sar_tui.framework.clock import SECOND, Clock, LiveClock, host_now
from sar_tui.framework.messages import PendingApproval
from sar_tui.framework.theme import Theme
from sar_tui.link.errors import LinkError
from sar_tui.link.peer import Peer, PeerEvent, PeerListener
from sar_tui.operator import key_help, own_file, palette, proposal_view, status_view
from sar_tui.operator.agent_mirror import AgentMirror
from sar_tui.operator.commands import Commands, takes_valence
from sar_tui.operator.phrases import addressee
from sar_tui.operator.questions import question
from sar_tui.operator.small import Small
from sar_tui.operator.text_charts import cut, folded
from sar_tui.operator.typed import Typed
from sar_tui.tui.ordered_keys import OrderedScreen

FRAME_SECONDS = 1 / 15
"""At most so often is the panel drawn."""
_TALL, _WIDE = 27, 92
"""From how many lines there is room for a longer log, from how many columns for longer words."""


class PanelLayout(OrderedScreen[str]):
    """The base of the panel's screen: all that it shows. It ends with a sentence if there can be no link at all.

    Args:
        connect: makes the link, given who hears.
        theme: is worn until the session's is known.
        folder: where the operator's own file is.
        clock: of the mirrored agent's motion, for tests.
    """

    CSS_PATH = "operator.tcss"
    AUTO_FOCUS = ""

    app: Any

    class Themed(Message):
        """The theme that the participant's program wears is known, or another."""

        def __init__(self, theme: Theme) -> None:
            super().__init__()
            self.theme = theme

    def __init__(
        self, connect: Callable[[PeerListener], Peer], theme: Theme, folder: Path, clock: Clock | None = None
    ) -> None:
        super().__init__()
        self._connect = connect
        self.file, self._problem = own_file.read(folder)
        self._clock = clock or LiveClock(asyncio.get_running_loop())
        self._agent = AgentMirror(theme, self._clock)
        self.steering = Commands()
        self.steering.baton_key = key_help.key_of("baton", self.file)
        self.words = palette.Words({})
        self.selected = ""
        self._given: dict[str, int] = {}
        self.page: tuple[str, str] = ("", "")
        self.seat = "A"
        self.asks = ""
        self.asked = ""
        self.edits: PendingApproval | None = None
        self.is_stale = True
        self._drawn_at = 0
        self._drawn: dict[str, object] = {}

    # --- beginning and ending ----------------------------------------------------------------------------------

    def compose(self) -> ComposeResult:
        with Horizontal(id="head"):
            yield Static("Operator", id="where", markup=False)
            yield Static("", id="link")
        with Horizontal(id="mirror"):
            with Vertical(id="seen"):
                yield self._agent.widget
            doing = Static("", id="doing")
            doing.border_title = "They do"
            yield doing
        with Vertical(id="strip"):
            yield Static("", id="offer")
            yield Static("", id="buttons")
            with Horizontal(id="typing"):
                yield Static("", id="asked", markup=False)
                yield Typed(id="typed", compact=True, select_on_focus=False)
            yield Static("", id="behind", markup=False)
        with Horizontal(id="page"):
            yield Static("", id="title", markup=False)
            yield Static(key_help.pages(self.file), id="pages", markup=False)
        yield Static("", id="palette")
        yield Static("", id="log")
        yield Static("", id="foot")
        keys = Static("", id="keys")
        keys.border_title = "Keys"
        yield keys
        yield Small(key_help.key_of("stop", self.file))

    def on_mount(self) -> None:
        if isinstance(self._clock, LiveClock):
            self.run_worker(self._clock.run(), name="motion", group="motion")
        self.app.set_keymap(self.file.keymap)
        self.query_one("#log").border_title = "Log"
        try:
            self.steering.peer = self._connect(self._told)
        except LinkError as error:
            self.dismiss(str(error))
            return
        if self._problem:
            self.steering.log.told(self.steering.peer.now(), self._problem)
        self.set_interval(FRAME_SECONDS, self._tick)
        self.draw()

    def on_unmount(self) -> None:
        if self.steering.peer:
            self.steering.peer.close()

    def _told(self, heard: PeerEvent) -> None:
        """From the link, which knows no app: a fault here ends the panel in words, and does not leave it half alive."""
        try:
            self.hear(heard)
        except Exception as error:
            self.app._handle_exception(error)

    def hear(self, heard: PeerEvent) -> None:
        """What came over the link. It is drawn at once after a quiet spell, else with the next frame."""
        theme = self.steering.mirror.theme
        self.steering.hear(heard)
        if self.steering.mirror.theme is not theme:
            self.words = palette.Words.of(self.steering.mirror, self.file)
            if self.steering.mirror.theme:
                self.post_message(self.Themed(self.steering.mirror.theme))
        self.is_stale = True
        if host_now() - self._drawn_at > FRAME_SECONDS * SECOND:
            self.call_later(self._tick)

    def on_resize(self, event: events.Resize) -> None:
        self.set_class(event.size.height >= _TALL, "tall")
        self.set_class(event.size.width >= _WIDE, "wide")
        self.query_one("#small", Small).fit(event.size)
        self.is_stale = True
        self.call_after_refresh(self.draw)

    @property
    def is_covered(self) -> bool:
        """Whether something lies over the panel, so that what keys would do is not seen."""
        return self.query_one("#keys").display or self.query_one("#small").display

    @property
    def is_over(self) -> bool:
        """Whether there is nothing more that could come."""
        return bool(self.steering.mirror.ended) or self.steering.mirror.connection.state == "away"

    @property
    def is_observer(self) -> bool:
        """Whether whoever sits here only watches."""
        welcome = self.steering.mirror.welcome
        return bool(welcome and welcome.role == "observer")

    def ask_for(self, seconds: float, what: str) -> None:
        """Ask something that stands for so long."""

        def no_longer() -> None:
            if self.asks == what:
                self.asks = ""
                self.draw()

        self.asks = what
        self.set_timer(seconds, no_longer)
        self.draw()

    @property
    def chosen(self) -> PendingApproval | None:
        """The proposal that keys are about: the one that stands there, or was selected, for as long as it waits.

        Then the first. One that comes meanwhile takes nobody's place: a key that is on its way is not for that.
        """
        waiting = self.steering.pending
        undecided = [offer for offer in waiting if not self.steering.ruled(offer.proposal.id)] or list(waiting)
        selected = (offer for offer in undecided if offer.proposal.id == self.selected)
        return next(selected, undecided[0] if undecided else None)

    # --- drawing -------------------------------------------------------------------------------------------------

    def _tick(self) -> None:
        """Draw, if something has changed or time runs out."""
        if not self.is_mounted or host_now() - self._drawn_at < FRAME_SECONDS * SECOND / 2:
            return
        waits = any(offer.deadline is not None for offer in self.steering.pending)
        if self.is_stale or waits or proposal_view.on_its_way(self.steering.mirror):
            self.draw()

    def draw(self) -> None:
        """Bring the screen up to what is known."""
        peer, mirror = self.steering.peer, self.steering.mirror
        if peer is None or not self.is_mounted:
            return
        self.is_stale, self._drawn_at = False, host_now()
        now = peer.now()
        self._agent.show(mirror, now)
        seen = "They see and hear"
        self.query_one("#seen").border_title = seen if mirror.theme else f"{seen}: {status_view.UNKNOWN}"
        self._put("where", Content(status_view.where(mirror)))
        self._put("link", status_view.link(mirror, self.steering.baton_key))
        self._put("doing", status_view.doing(mirror, self._room("doing")))
        self._draw_strip(now)
        self._draw_palette()
        log = self.query_one("#log")
        lines = sorted([*mirror.log, *self.steering.log.lines(now)], key=lambda line: line.at)
        self._put("log", status_view.log(lines, self._room("log"), log.content_size.height))
        asked = question(self.asks, mirror, self.file)
        self._put("foot", key_help.foot(self.file, asked, self._room("foot"), is_observer=self.is_observer))
        self._put("keys", key_help.keys(self.file, is_observer=self.is_observer))

    def _draw_strip(self, now: int) -> None:
        mirror, width = self.steering.mirror, self._room("offer")
        strip, offer, loss = self.query_one("#strip"), self.chosen, status_view.loss(self.steering.mirror)
        strip.set_class(offer is not None, "waits")
        strip.set_class(bool(loss), "alarm")
        modes = "Enter sends, Esc leaves" if self.asked else proposal_view.modes(mirror, width - 4)
        if self._draw_too_late(now, modes, width):
            return
        self._put("asked", Content(self.asked))
        if offer is None:
            self.selected = ""
            self._frame("Connection" if loss else "Proposals", modes)
            self._put("offer", proposal_view.quiet(mirror, loss, now, width, key_help.key_of("close", self.file)))
            self._put("buttons", Content(""))
            self._put("behind", Content(""))
            return
        waiting = self.steering.pending
        to = addressee(mirror, offer.proposal.seat) if offer.level is None else ""
        title = proposal_view.title(offer, waiting.index(offer) + 1, len(waiting), to)
        id = self.selected = offer.proposal.id
        self._given = {
            each.proposal.id: self._given.get(each.proposal.id, each.deadline - now)
            for each in waiting
            if each.deadline is not None
        }
        self._put("offer", proposal_view.body(offer, now, self._given.get(id), width))
        keys = proposal_view.buttons(self.file, has_words=takes_valence(offer))
        keys = proposal_view.decides(mirror, self.file) if self.steering.obstacle() else keys
        sent = self.steering.ruled(id)
        self._put("buttons", Content(f"{sent} …") if sent else keys)
        behind = proposal_view.behind(waiting, offer, now, width)
        self._put("behind", Content(behind))
        is_told = behind and not self.has_class("tall") and not self.asked
        self._frame(title, cut(behind, width - 4) if is_told else modes)
        if id != self.steering.stands[0]:
            self.call_after_refresh(self._painted, offer)

    def _draw_too_late(self, now: int, below: str, width: int) -> bool:
        """What is edited no longer waits: that stands there, and not the next, which these words are not for."""
        edited, waiting = self.edits, self.steering.pending
        if edited is None or any(each.proposal.id == edited.proposal.id for each in waiting):
            return False
        is_late = edited.deadline is not None and edited.deadline <= now
        why = "Its time is over" if is_late else "It no longer waits"
        behind = proposal_view.behind(waiting, None, now, width)
        is_told = behind and not self.has_class("tall")
        self._frame(f"{edited.proposal.kind.upper()} · {why.lower()}", cut(behind, width - 4) if is_told else below)
        self._put("offer", proposal_view.gone(edited, width))
        self._put("asked", Content(f"{why}:", [Span(0, len(why) + 1, "$warning bold")]))
        self._put("behind", Content(behind))
        return True

    def _frame(self, title: str, subtitle: str) -> None:
        """What stands in the border of the strip: text as it is, which holds brackets now and then."""
        if self._drawn.get("strip") != (title, subtitle):
            self._drawn["strip"] = (title, subtitle)
            strip = self.query_one("#strip")
            strip.border_title, strip.border_subtitle = Content(title), Content(subtitle)

    def _painted(self, offer: PendingApproval) -> None:
        if self.steering.peer:
            self.steering.seen(offer, self.steering.peer.now())

    def _draw_palette(self) -> None:
        self.set_class(self.is_observer, "observes")
        typed = self.query_one("#typed", Typed).value
        if self.asked and len(typed) > self._room("typed") - 1:
            self._put("title", Content("What you type, in full"))
            self._put("palette", Content("\n".join(folded(typed, self._room("palette"), 5))))
            return
        page, number, count = self.find_page()
        to = addressee(self.steering.mirror, self.seat) if page.kind in ("phrases", "gestures") else ""
        to = f" ·{to} ({key_help.key_of('seat', self.file)})" if to else ""
        self._put("title", Content(f"{page.title} {number + 1}/{count}{to}"))
        self._put("palette", key_help.items(page, self._room("palette"), 5))

    def find_page(self) -> tuple[palette.Page, int, int]:
        pages = palette.pages(self.steering.mirror, self.words, self.seat)
        names = [(page.kind, page.title) for page in pages]
        index = names.index(self.page) if self.page in names else 0
        return pages[index], index, len(pages)

    def _room(self, name: str) -> int:
        return self.query_one(f"#{name}").content_size.width

    def _put(self, name: str, content: Content) -> None:
        """Draw what has changed, and nothing else."""
        key = (content.plain, tuple(content.spans))
        if self._drawn.get(name) != key:
            self._drawn[name] = key
            self.query_one(f"#{name}", Static).update(content, layout=name in ("link", "asked"))
