"""Layout of the operator's panel: agent, participant, proposals, palette, log."""

import asyncio
from collections.abc import Callable
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

from rich.cells import cell_len
from textual import events
from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.message import Message
from textual.widgets import Static

from sar_tui.link.errors import LinkError
from sar_tui.link.peer import Peer, PeerEvent, PeerListener, Welcome
from sar_tui.loop.clock import Clock, LiveClock, host_now
from sar_tui.model.messages import PendingApproval
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.operator import key_help, keymap, palette, proposal_view, status_view
from sar_tui.operator.agent_mirror import AgentMirror
from sar_tui.operator.commands import Commands
from sar_tui.operator.event_log import Line
from sar_tui.operator.phrases import addressee
from sar_tui.operator.proposal_strip import ProposalStrip
from sar_tui.operator.text_charts import trend, wrap
from sar_tui.operator.widgets import CachedStatic, TooSmallNotice
from sar_tui.tui.base_app import OrderedScreen
from sar_tui.tui.terminal_probe import INTERVAL_S as PROBE_INTERVAL_S

FRAME_SECONDS = 1 / 15
"""Shortest time between two drawings."""
_TALL, _WIDE = 27, 92
"""Lines from which the log is longer, and columns from which the agent's text is wider."""
_BROAD = 120
"""Columns from which the attempts are plotted beside palette and log."""
_PALETTE_ROWS = 5
_GAP, _LINK_SHARE = 2, 0.6
"""Columns between the session and the link in the header, and the largest share of the link (see
`operator.tcss`).
"""
_SHORTEST_ABSENCE_S = 1.0
"""Shorter silences of the terminal are not worth a line in the log."""
_JUST_NOW_S = 10
"""Time for which the line on an absence stays the newest of the log."""


class PanelLayout(OrderedScreen[str]):
    """Base of the panel's screen: everything that it shows. The result is an error message if no
    link can be made.

    Args:
        connect: makes the link, given the function that receives what comes over it.
        theme: applied until the session's theme is known.
        folder: holds the operator's own file.
        clock: drives the agent's motion, and withdraws questions; given by tests.
        wall_time: returns the local date and time.
    """

    CSS_PATH = "operator.tcss"
    AUTO_FOCUS = ""

    app: Any

    class Themed(Message):
        """The session's theme is known, or has changed."""

        def __init__(self, theme: Theme) -> None:
            super().__init__()
            self.theme = theme

    def __init__(
        self,
        connect: Callable[[PeerListener], Peer],
        theme: Theme,
        folder: Path,
        clock: Clock | None = None,
        wall_time: Callable[[], datetime] = datetime.now,
    ) -> None:
        super().__init__()
        self._wall_time = wall_time
        self._connect = connect
        self.file, self._file_problem = keymap.read(folder)
        self._clock = clock or LiveClock(asyncio.get_running_loop())
        self._agent = AgentMirror(theme, self._clock)
        self.commands = Commands()
        self.commands.control_key = key_help.key_label("control", self.file)
        self.phrase_book = palette.PhraseBook({})
        self.selected = ""
        self.page: tuple[str, str] = ("", "")
        self.seat = "A"
        self.question = ""
        self.entry_label = ""
        self.edited: PendingApproval | None = None
        self.is_stale = True
        self._absence: Line | None = None
        self._drawn_at = 0

    # --- beginning and ending

    def compose(self) -> ComposeResult:
        with Horizontal(id="header"):
            yield CachedStatic("session")
            yield CachedStatic("link", fits_content=True)
        with Horizontal(id="participant"):
            with Vertical(id="agent-frame"):
                yield self._agent.widget
            activity = CachedStatic("activity")
            activity.border_title = "What they do"
            yield activity
        yield ProposalStrip(self.file)
        with Horizontal(id="lower"):
            with Vertical(id="palette-and-log"):
                with Horizontal(id="palette-header"):
                    yield CachedStatic("palette-title")
                    yield Static(key_help.palette_keys(self.file), id="palette-keys", markup=False)
                yield CachedStatic("palette")
                log = CachedStatic("log")
                log.border_title = "Log"
                yield log
            yield CachedStatic("trend")
        yield CachedStatic("footer")
        help_sheet = CachedStatic("key-help")
        help_sheet.border_title = "Keys"
        yield help_sheet
        yield TooSmallNotice(key_help.key_label("stop", self.file))

    def on_mount(self) -> None:
        if isinstance(self._clock, LiveClock):
            self.run_worker(self._clock.run(), name="motion", group="motion")
        self.app.set_keymap(self.file.keymap)
        try:
            self.commands.peer = self._connect(self._on_link)
        except LinkError as error:
            self.dismiss(str(error))
            return
        self.commands.peer.watch_terminal(self.app.terminal_probe.state)
        self.app.terminal_probe.ask()
        self.set_interval(PROBE_INTERVAL_S, self.app.terminal_probe.ask)
        if self._file_problem:
            self.commands.log.report(self.commands.peer.now(), self._file_problem)
        self.set_interval(FRAME_SECONDS, self._tick)
        self.draw()

    def on_unmount(self) -> None:
        if self.commands.peer:
            self.commands.peer.close(says_goodbye=not self.app.has_lost_terminal)

    def _on_link(self, event: PeerEvent) -> None:
        """Receive from the link, which knows no app: an exception here must end the app with a
        message.
        """
        try:
            self.receive(event)
        except Exception as error:
            self.app._handle_exception(error)

    def receive(self, event: PeerEvent) -> None:
        """Handle an event of the link. Draw at once, or with the next frame if the last drawing was
        too recent.
        """
        theme = self.commands.state.theme
        self.commands.receive(event)
        if isinstance(event, Welcome):
            self._report_absence()
        if self.commands.state.theme is not theme:
            self.phrase_book = palette.PhraseBook.of(self.commands.state, self.file)
            if self.commands.state.theme:
                self.post_message(self.Themed(self.commands.state.theme))
        self.is_stale = True
        if host_now() - self._drawn_at > FRAME_SECONDS * SECOND:
            self.call_later(self._tick)

    def _report_absence(self) -> None:
        """Say in the log that this terminal was away, once it is back; the session may not have
        told it of its loss.
        """
        if self.commands.peer is None or not self.commands.state.is_connected:
            return
        seconds = self.app.terminal_probe.take_longest_silence() / SECOND
        if seconds >= _SHORTEST_ABSENCE_S:
            text = (
                f"This terminal did not answer for {seconds:.0f} s. Meanwhile the session may "
                "have gone on without it."
            )
            self._absence = self.commands.log.report(self.commands.peer.now(), text)
            self.is_stale = True

    def on_resize(self, event: events.Resize) -> None:
        self.set_class(event.size.height >= _TALL, "tall")
        self.set_class(event.size.width >= _WIDE, "wide")
        self.set_class(event.size.width >= _BROAD, "broad")
        self.query_one(TooSmallNotice).fit(event.size)
        self.is_stale = True
        self.call_after_refresh(self.draw)

    @property
    def is_covered(self) -> bool:
        """True if something hides the panel, so that the operator cannot see what a key would
        do.
        """
        return self.query_one("#key-help").display or self.query_one(TooSmallNotice).display

    @property
    def is_over(self) -> bool:
        """True if nothing more can come from the session."""
        return bool(self.commands.state.ended) or self.commands.state.connection.state == "ended"

    @property
    def is_observer(self) -> bool:
        """True if this panel only watches."""
        welcome = self.commands.state.welcome
        return bool(welcome and welcome.role == "observer")

    def ask_for(self, seconds: float, question: str) -> None:
        """Ask a question that is withdrawn after some seconds."""

        def withdraw() -> None:
            if self.question == question:
                self.question = ""
                self.draw()

        self.question = question
        self._clock.call_at(self._clock.now() + round(seconds * SECOND), withdraw)
        self.draw()

    @property
    def chosen(self) -> PendingApproval | None:
        """The proposal that keys apply to: the shown or selected one while it waits, then the most
        urgent.

        A new proposal does not take its place, because a key that is on its way is not meant for
        it.
        """
        pending = self.commands.pending
        undecided = [
            each for each in pending if not self.commands.log.deciding(each.proposal.id)
        ] or list(pending)
        selected = (each for each in undecided if each.proposal.id == self.selected)
        return next(selected, undecided[0] if undecided else None)

    # --- drawing

    def _tick(self) -> None:
        """Draw if something has changed, a countdown is shown, or a stop may turn out not to have
        happened.
        """
        if not self.is_mounted or host_now() - self._drawn_at < FRAME_SECONDS * SECOND / 2:
            return
        self._report_absence()
        counts_down = any(each.deadline is not None for each in self.commands.pending)
        if (
            self.is_stale
            or counts_down
            or self._awaits_stop
            or proposal_view.scheduled_action(self.commands.state)
        ):
            self.draw()

    @property
    def _awaits_stop(self) -> bool:
        peer, stops = self.commands.peer, self.commands.state.stops
        return peer is not None and any(stop.is_awaited(peer.now()) for stop in stops)

    def draw(self) -> None:
        """Bring the screen up to date."""
        peer, state = self.commands.peer, self.commands.state
        if peer is None or not self.is_mounted:
            return
        self.is_stale, self._drawn_at = False, host_now()
        now = peer.now()
        self._agent.show(state, now)
        title = "What they see and hear"
        self.query_one("#agent-frame").border_title = (
            title if state.theme else f"{title}: {status_view.UNKNOWN}"
        )
        link = status_view.link_status(state, self.commands.control_key)
        width = self._width("header")
        room = width - min(cell_len(link.plain), round(_LINK_SHARE * width)) - _GAP
        self._put("session", Content(status_view.session_line(state, room)))
        self._put("link", link)
        self._put("activity", status_view.activity(state, self._width("activity"), now))
        self._draw_proposals(now)
        self._draw_palette()
        log = self.query_one("#log")
        stops = [stop.line(now) for stop in state.stops]
        lines = sorted(
            [*state.log, *stops, *self.commands.log.lines],
            key=partial(self._place_in_log, now),
        )
        wall = self._wall_time()
        times = partial(status_view.time_of_day, now=now, wall=wall)
        self._put(
            "log", status_view.log_lines(lines, self._width("log"), log.content_size.height, times)
        )
        self._draw_trend()
        question = key_help.question(self.question, state, self.file)
        footer = key_help.footer(
            self.file, question, self._width("footer"), is_observer=self.is_observer
        )
        self._put("footer", footer)
        self._put("key-help", key_help.help_sheet(self.file, is_observer=self.is_observer))

    def _place_in_log(self, now: int, line: Line) -> tuple[bool, int]:
        """Return what lines are ordered by: their time, but what was just told of an absence stays
        the newest.

        The lines of joining again come after it, and a low log shows no more than those.
        """
        is_news = line is self._absence and now - line.at < _JUST_NOW_S * SECOND
        return is_news, line.at

    def _draw_proposals(self, now: int) -> None:
        strip, commands, approval = self.query_one(ProposalStrip), self.commands, self.chosen
        loss = status_view.link_loss(commands.state)
        strip.configure(
            self.entry_label,
            is_pending=approval is not None,
            is_alarm=bool(loss),
            is_tall=self.has_class("tall"),
        )
        if self.edited and all(
            each.proposal.id != self.edited.proposal.id for each in commands.pending
        ):
            strip.draw_expired_edit(self.edited, commands, now)
        elif approval is None:
            self.selected = ""
            strip.draw_empty(commands.state, loss, now)
        else:
            self.selected = approval.proposal.id
            strip.draw_proposal(approval, commands, now)
            if self.selected != commands.shown[0]:
                self.call_after_refresh(self._painted, approval)

    def _painted(self, approval: PendingApproval) -> None:
        if self.commands.peer:
            self.commands.report_seen(approval, self.commands.peer.now())

    def _draw_palette(self) -> None:
        self.set_class(self.is_observer, "observer")
        strip, width = self.query_one(ProposalStrip), self._width("palette")
        if self.entry_label and strip.overflows:
            self._put("palette-title", Content("What you type, in full"))
            self._put("palette", Content("\n".join(wrap(strip.entry.value, width, _PALETTE_ROWS))))
            return
        page, number, count = self.find_page()
        to = (
            addressee(self.commands.state, self.seat)
            if page.kind in ("phrases", "gestures")
            else ""
        )
        to = f" ·{to} ({key_help.key_label('seat', self.file)})" if to else ""
        self._put("palette-title", Content(f"{page.title} {number + 1}/{count}{to}"))
        self._put("palette", key_help.palette_page(page, width, _PALETTE_ROWS))

    def _draw_trend(self) -> None:
        plot, state = self.query_one("#trend", CachedStatic), self.commands.state
        if not plot.display or state.welcome is None:
            return
        several = len(state.welcome.participants) > 1
        plot.border_title = (
            f"Attempts of {state.welcome.participants.get(self.seat, self.seat)}"
            if several
            else "Attempts"
        )
        size = plot.content_size
        plot.show(
            trend(state.seat(self.seat).attempts, state.welcome.metric, size.width, size.height)
        )

    def find_page(self) -> tuple[palette.Page, int, int]:
        """Return the palette's open page, its index and the number of pages."""
        pages = palette.pages(self.commands.state, self.phrase_book, self.seat)
        names = [(page.kind, page.title) for page in pages]
        index = names.index(self.page) if self.page in names else 0
        return pages[index], index, len(pages)

    def _width(self, name: str) -> int:
        return self.query_one(f"#{name}").content_size.width

    def _put(self, name: str, content: Content) -> None:
        self.query_one(f"#{name}", CachedStatic).show(content)
