"""Screen of the operator's panel: agent, participant, proposals, palette, log, and its keys."""

import asyncio
import time
from collections.abc import Callable
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from rich.cells import cell_len
from textual import events
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.geometry import Size
from textual.message import Message
from textual.widget import Widget
from textual.widgets import Static

from sar_tui.link.errors import LinkError
from sar_tui.link.peer import Peer, PeerEvent, PeerListener, Welcome
from sar_tui.loop.agent_state import AgentState
from sar_tui.loop.clock import Clock, LiveClock, host_now
from sar_tui.loop.topics import DECISION, NOTE_ADDED, REMARK
from sar_tui.model.language import ENGLISH, Language
from sar_tui.model.messages import PendingApproval, Valence
from sar_tui.model.protocol import WizardProtocol
from sar_tui.model.theme import Theme
from sar_tui.model.units import SECOND
from sar_tui.operator import keymap, status_view
from sar_tui.operator.commands import CONFIRM_SECONDS, TOO_SOON, Commands, editable, takes_valence
from sar_tui.operator.event_text import Line
from sar_tui.operator.keymap import KEY_COMMANDS, bindings
from sar_tui.operator.palette import Palette, palette_page
from sar_tui.operator.phrases import MAX_TEXT, addressee, addressee_code
from sar_tui.operator.proposal_strip import ProposalStrip
from sar_tui.operator.protocol import ProtocolActs, protocol_line, reasons_page
from sar_tui.operator.session_state import SessionState
from sar_tui.operator.text_charts import trend, wrap
from sar_tui.operator.widgets import CachedStatic, TooSmallNotice
from sar_tui.tui.base_app import OrderedScreen
from sar_tui.tui.terminal_probe import INTERVAL_S as PROBE_INTERVAL_S
from sar_tui.widgets.agent import Agent
from sar_tui.widgets.robot import WIDTH

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
_ACTIONS = {command.action.partition("(")[0] for command in KEY_COMMANDS}
_FOR_ALL = {command.action.partition("(")[0] for command in KEY_COMMANDS if not command.acts}
_WHILE_TYPING = ("stop", "leave", "keys", "event")
_WHILE_COVERED = ("stop", "leave", "keys")
"""Actions that work while something hides the panel: nobody should act on what they cannot see."""
_MAX_NOTE = 4000


class PanelScreen(OrderedScreen[str]):
    """Panel of an operator or an observer. The result is an error message if no link can be made.

    Args:
        connect: makes the link, given the function that receives what comes over it.
        theme: applied until the session's theme is known.
        folder: holds the operator's own file.
        clock: drives the agent's motion, and withdraws questions; given by tests.
        wall_time: returns the local date and time.
        tr: language of the panel.
        protocol: the operator's, if the session is to follow one.
        practised: recorded sessions on which the operator has practised it.

    Attributes:
        commands: acts of this operator, and the session as it is known here.
        palette: the open page of the palette.
        strip: the proposal to decide on, and the text field.
    """

    CSS_PATH = "operator.tcss"
    AUTO_FOCUS = ""

    BINDINGS: ClassVar[list[BindingType]] = [*bindings()]

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
        tr: Language = ENGLISH,
        protocol: WizardProtocol | None = None,
        practised: int = 0,
    ) -> None:
        super().__init__()
        self.tr = tr
        self._wall_time = wall_time
        self._connect = connect
        self.file, self._file_problem = keymap.read(folder, tr)
        self._clock = clock or LiveClock(asyncio.get_running_loop())
        self._agent = AgentMirror(theme, self._clock)
        self.commands = Commands(tr)
        self.commands.control_key = keymap.key_label("control", self.file, tr)
        self.protocol = ProtocolActs(self.commands, protocol, practised)
        self.palette = Palette(self.file)
        self.strip = ProposalStrip(self.file, tr)
        self._selected = ""
        self._question = ""
        self._asks_reason = False
        self._is_stale = True
        self._absence: Line | None = None
        self._drawn_at = 0.0

    # --- beginning and ending

    def compose(self) -> ComposeResult:
        with Horizontal(id="header"):
            yield CachedStatic("session")
            yield CachedStatic("link", fits_content=True)
        with Horizontal(id="participant"):
            with Vertical(id="agent-frame"):
                yield self._agent.widget
            activity = CachedStatic("activity")
            activity.border_title = self.tr("What they do")
            yield activity
        yield self.strip
        yield CachedStatic("protocol")
        with Horizontal(id="lower"):
            with Vertical(id="palette-and-log"):
                with Horizontal(id="palette-header"):
                    yield CachedStatic("palette-title")
                    keys = keymap.palette_keys(self.file, self.tr)
                    yield Static(keys, id="palette-keys", markup=False)
                yield CachedStatic("palette")
                log = CachedStatic("log")
                log.border_title = self.tr("Log")
                yield log
            yield CachedStatic("trend")
        yield CachedStatic("footer")
        help_sheet = CachedStatic("key-help")
        help_sheet.border_title = self.tr("Keys")
        yield help_sheet
        yield TooSmallNotice(keymap.key_label("stop", self.file, self.tr), self.tr)

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
        self.protocol.receive(event)
        if isinstance(event, Welcome):
            self._report_absence()
        if self.commands.state.theme is not theme:
            self.palette.use_theme(self.commands.state)
            if self.commands.state.theme:
                self.post_message(self.Themed(self.commands.state.theme))
        self._is_stale = True
        if time.monotonic() - self._drawn_at > FRAME_SECONDS:
            self.call_later(self._tick)

    def _report_absence(self) -> None:
        """Say in the log that this terminal was away, once it is back; the session may not have
        told it of its loss.
        """
        if self.commands.peer is None or not self.commands.state.is_connected:
            return
        seconds = self.app.terminal_probe.take_longest_silence() / SECOND
        if seconds >= _SHORTEST_ABSENCE_S:
            text = self.tr(
                "This terminal did not answer for {seconds} s. Meanwhile the session may have gone "
                "on without it.",
                seconds=round(seconds),
            )
            self._absence = self.commands.log.report(self.commands.peer.now(), text)
            self._is_stale = True

    def on_resize(self, event: events.Resize) -> None:
        self.set_class(event.size.height >= _TALL, "tall")
        self.set_class(event.size.width >= _WIDE, "wide")
        self.set_class(event.size.width >= _BROAD, "broad")
        self.query_one(TooSmallNotice).fit(event.size)
        self._is_stale = True
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
            if self._question == question:
                self._question = ""
                self.draw()

        self._question = question
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
        selected = (each for each in undecided if each.proposal.id == self._selected)
        return next(selected, undecided[0] if undecided else None)

    # --- drawing

    def _tick(self) -> None:
        """Draw if something has changed, a countdown is shown, or a stop may turn out not to have
        happened.
        """
        if not self.is_mounted or time.monotonic() - self._drawn_at < FRAME_SECONDS / 2:
            return
        self._report_absence()
        counts_down = any(each.deadline is not None for each in self.commands.pending)
        is_moving = counts_down or self._awaits_stop or self._asks_reason
        if self._is_stale or is_moving or self.commands.state.scheduled:
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
        self._is_stale, self._drawn_at = False, time.monotonic()
        now = peer.now()
        self._agent.show(state, now)
        self.query_one("#agent-frame").border_title = self.tr(
            "What they see and hear" if state.theme else "What they see and hear: not known yet"
        )
        link = status_view.link_status(state, self.commands.control_key)
        width = self._width("header")
        room = width - min(cell_len(link.plain), round(_LINK_SHARE * width)) - _GAP
        self._put("session", Content(status_view.session_line(state, room)))
        self._put("link", link)
        self._put("activity", status_view.activity(state, self._width("activity"), now))
        self._draw_proposals(now)
        self.set_class(state.protocol is not None, "by-protocol")
        self._put("protocol", protocol_line(state, self.file, self._width("footer")))
        self._draw_palette(now)
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
        question = keymap.question(self._question, state, self.file)
        footer = keymap.footer(
            self.file, question, self._width("footer"), self.tr, is_observer=self.is_observer
        )
        self._put("footer", footer)
        help_sheet = keymap.help_sheet(
            self.file,
            self.tr,
            is_observer=self.is_observer,
            has_protocol=state.protocol is not None,
        )
        self._put("key-help", help_sheet)

    def _place_in_log(self, now: int, line: Line) -> tuple[bool, int]:
        """Return what lines are ordered by: their time, but what was just told of an absence stays
        the newest.

        The lines of joining again come after it, and a low log shows no more than those.
        """
        is_news = line is self._absence and now - line.at < _JUST_NOW_S * SECOND
        return is_news, line.at

    def _draw_proposals(self, now: int) -> None:
        approval = self.chosen
        if self.strip.draw(approval, self.commands, now, is_tall=self.has_class("tall")):
            self._selected = approval.proposal.id if approval else ""
            if approval and self._selected != self.commands.shown[0]:
                self.call_after_refresh(self._painted, approval)

    def _painted(self, approval: PendingApproval) -> None:
        if self.commands.peer:
            self.commands.report_seen(approval, self.commands.peer.now())

    def _draw_palette(self, now: int) -> None:
        self.set_class(self.is_observer, "observer")
        state, width = self.commands.state, self._width("palette")
        # a digit of somebody who still reads the question must not say a phrase
        self._asks_reason = self.commands.asked_reason(now + TOO_SOON) is not None
        if self._asks_reason and state.protocol:
            self._put("palette-title", Content(self.tr("Why? A digit, if you like")))
            self._put("palette", reasons_page(state.protocol, width, _PALETTE_ROWS, self.tr))
            return
        if self.strip.overflows:
            self._put("palette-title", Content(self.tr("What you type, in full")))
            typed = wrap(self.strip.typed, width, _PALETTE_ROWS)
            self._put("palette", Content("\n".join(typed)))
            return
        page, number, count = self.palette.find(state)
        title = f"{page.title} {number + 1}/{count}"
        is_for_one = page.kind in ("phrases", "gestures")
        if to := addressee(state, self.palette.seat) if is_for_one else "":
            title += f" ·{to} ({keymap.key_label('seat', self.file, self.tr)})"
        self._put("palette-title", Content(title))
        self._put("palette", palette_page(page, width, _PALETTE_ROWS))

    def _draw_trend(self) -> None:
        plot, state = self.query_one("#trend", CachedStatic), self.commands.state
        if not plot.display or state.welcome is None:
            return
        seat, names = self.palette.seat, state.welcome.participants
        is_one = len(names) <= 1
        who = names.get(seat, seat)
        plot.border_title = self.tr("Attempts") if is_one else self.tr("Attempts of {who}", who=who)
        size, metric = plot.content_size, state.welcome.metric
        plot.show(trend(state.seat(seat).attempts, metric, size.width, size.height, self.tr))

    def _width(self, name: str) -> int:
        return self.query_one(f"#{name}").content_size.width

    def _put(self, name: str, content: Content) -> None:
        self.query_one(f"#{name}", CachedStatic).show(content)

    # --- proposals

    @property
    def _at(self) -> int:
        """Time stamp of the key that is being handled (ns, session clock)."""
        peer = self.commands.peer
        assert peer
        pressed = round(self.app.key_seconds * SECOND)
        return peer.now() - (max(0, host_now() - pressed) if pressed else 0)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Disable an observer's acts, and most keys while text is typed or the panel is hidden."""
        welcome = self.commands.state.welcome
        if welcome and welcome.role == "observer" and action in _ACTIONS and action not in _FOR_ALL:
            return False
        if action not in _ACTIONS:
            return True
        if self.is_covered:
            return action in _WHILE_COVERED
        return action in _WHILE_TYPING if self.strip.is_typing else True

    def action_approve(self) -> None:
        if approval := self.chosen:
            self.commands.decide(approval, "accept", self._at)
            self.draw()

    def action_veto(self) -> None:
        if approval := self.chosen:
            self.commands.decide(approval, "veto", self._at)
            self.draw()

    def action_valence(self, valence: Valence) -> None:
        if (approval := self.chosen) and takes_valence(approval):
            self.commands.change_valence(approval, valence, self._at)
            self.draw()

    def action_select(self, step: int) -> None:
        waiting = self.commands.pending
        if approval := self.chosen:
            self._selected = waiting[(waiting.index(approval) + step) % len(waiting)].proposal.id
            self.draw()

    def action_edit(self) -> None:
        """Edit the proposal. If it has just gone, let the operator type anyway, so that letters do
        not act as keys.
        """
        if approval := self.chosen:
            self._selected = approval.proposal.id
            unused = self.commands.log.unused_text(DECISION, approval.proposal.id)
            text = unused or editable(approval, self.commands.state)
            self._open_entry(
                self.tr("Edit:"),
                text,
                lambda text, at: self._edited(approval, text, at),
                edited=approval,
            )
        else:
            text = self.tr("No proposal is pending: the agent will say what you type.")
            self.commands.log.report(self._at, text)
            self.action_say()

    def _edited(self, approval: PendingApproval, text: str, at: int) -> bool:
        if any(each.proposal.id == approval.proposal.id for each in self.commands.pending):
            return self.commands.edit(approval, text, at)
        tr, has_words = self.tr, approval.level is None and approval.proposal.text
        what = "Nothing was sent; Enter says it anyway." if has_words else "Nothing was sent."
        self.commands.log.report(at, f"{tr('Too late: it was already decided.')} {tr(what)}")
        if has_words:
            seat = approval.proposal.seat
            self._open_entry(tr("Say:"), text, lambda text, at: self.commands.say(text, seat, at))
        return not has_words

    # --- the protocol

    def action_tick(self) -> None:
        self.protocol.tick(self.palette.seat, self._at)
        self.draw()

    def action_leave_out(self) -> None:
        self.protocol.leave_out(self._at)
        self.draw()

    # --- the session

    def action_stop(self) -> None:
        self.commands.command("stop", self._at)
        self.draw()

    def action_pause(self) -> None:
        if self.commands.may_resume(self._at):
            self._question = ""
            self.commands.pause(self._at)
            self.draw()
        else:
            self.ask_for(CONFIRM_SECONDS, "resume")

    def action_skip(self) -> None:
        self.commands.prompt_command("skip", self._at)
        self.draw()

    def action_repeat(self) -> None:
        self.commands.prompt_command("repeat", self._at)
        self.draw()

    def action_level(self, step: int) -> None:
        self.commands.level(step, self._at)
        self.draw()

    def action_hold(self) -> None:
        self.commands.hold(self._at)
        self.draw()

    def action_undo(self) -> None:
        self.commands.command("undo", self._at)
        self.draw()

    def action_end(self) -> None:
        if self._confirm("end"):
            self.commands.command("end", self._at)
            self.draw()

    def action_close(self) -> None:
        if self.may_quit():
            self.dismiss("")

    def may_quit(self) -> bool:
        """Return True if the panel may be left; else ask."""
        return self.is_over or self.is_covered or self._confirm("close")

    def _confirm(self, question: str) -> bool:
        """Ask a question, or return True if it was asked already."""
        was_asked, self._question = (
            self._question == question,
            "" if self._question == question else question,
        )
        self.draw()
        return was_asked

    # --- palette, speech, notes

    def action_pick(self, index: int) -> None:
        if self.commands.asked_reason(self._at):
            self.commands.give_reason((index + 1) % 10, self._at)
            self.draw()
            return
        items = self.palette.find(self.commands.state)[0].items
        if index < len(items):
            self.commands.pick(items[index], self._at)
            self.draw()

    def action_page(self, step: int) -> None:
        self.commands.forget_reason()
        self.palette.turn(self.commands.state, step)
        self.draw()

    def action_show(self, kind: str) -> None:
        self.commands.forget_reason()
        self.palette.open(self.commands.state, kind)
        self.draw()

    def action_seat(self) -> None:
        self.palette.take_next_seat(self.commands.state)
        self.draw()

    def action_say(self) -> None:
        seat = self.palette.seat
        to = addressee_code(self.commands.state, seat)
        label = self.tr("Say to {who}:").format(who=to) if to else self.tr("Say:")
        unused = self.commands.log.unused_text(REMARK)
        self._open_entry(label, unused, lambda text, at: self.commands.say(text, seat, at))

    def action_note(self) -> None:
        began = self._at
        unused = self.commands.log.unused_text(NOTE_ADDED)
        self._open_entry(
            self.tr("Note:"),
            unused,
            lambda text, at: self.commands.note(text, began),
            max_length=_MAX_NOTE,
        )

    def action_event(self, index: int) -> None:
        if index < len(self.file.events):
            self.commands.event(self.file.events[index], self._at)
            self.draw()

    def action_take_control(self) -> None:
        if self.commands.peer and self.commands.state.is_connected:
            self.commands.peer.take_control()

    def action_keys(self) -> None:
        keys = self.query_one("#key-help")
        keys.display = not keys.display

    def action_leave(self) -> None:
        """Close one thing: the text field, the key help, the question, or the palette's page."""
        keys = self.query_one("#key-help")
        if self.strip.is_typing:
            self.strip.close_entry()
        elif keys.display:
            keys.display = False
        elif self._question:
            self._question = ""
        elif self.commands.asked_reason(self._at):
            self.commands.forget_reason()
        else:
            self.palette.close()
        self.draw()

    # --- typing

    def takes(self, event: events.Key | events.Paste) -> bool:
        if not self.strip.is_typing or self.is_covered:
            return False
        if isinstance(event, events.Key) and event.key == "enter":
            self.strip.submit(self._at)
            self.draw()
        elif not self.strip.type(event):
            return False
        self._is_stale = True
        return True

    def _open_entry(
        self,
        label: str,
        text: str,
        then: Callable[[str, int], bool],
        max_length: int = MAX_TEXT,
        edited: PendingApproval | None = None,
    ) -> None:
        """Open the text field (see `ProposalStrip.open_entry`), unless nothing can be sent."""
        if reason := self.commands.refusal():
            self.commands.log.report(self._at, f"{reason} {self.tr('Nothing can be sent.')}")
        else:
            self.strip.open_entry(label, text, then, max_length, edited)
        self.draw()


# --- the agent as the participant sees it


_MARGINS = 3
"""Columns beside the drawing and beside the text."""
_FRESH = 2 * SECOND
"""A gesture requested longer ago is over, or was never shown here."""


class AgentMirror:
    """Keeps the agent on the screen in step with the session state.

    Args:
        theme: until the session's is known; the agent is hidden until then.
        clock: drives its motion.
    """

    def __init__(self, theme: Theme, clock: Clock) -> None:
        self.widget = Agent(theme, clock, id="agent")
        self.widget.display = False
        self._theme: Theme | None = None
        self._shown = AgentState()
        self._shown_text: tuple[str, str] = ("", "")

    def show(self, state: SessionState, now: int) -> None:
        """Bring the agent up to date. ``now``: session clock (ns)."""
        if state.theme is None:
            return
        if state.theme is not self._theme:
            self._theme = state.theme
            self.widget.apply_theme(state.theme)
            self.widget.display = True
        agent, before = state.agent, self._shown
        self._shown = agent
        self._show_text(agent, before)
        if agent.halts != before.halts:
            self.widget.be_still()
        self._hold_still(state, before)
        action = agent.moves
        if action and action is not before.moves and now - action.decided < _FRESH:
            if action.gesture in state.theme.gestures:
                self.widget.gesture(state.theme.gestures[action.gesture])
            if action.gaze:
                self.widget.gaze(action.gaze)
        self.widget.speaking(agent.is_speaking and state.is_connected)

    def _hold_still(self, state: SessionState, before: AgentState) -> None:
        """Keep still while the participant's agent does, and show its cue."""
        cue = state.agent.cue
        if not state.is_quiet or (before.cue and before.cue is not cue):
            self.widget.release()
        if state.is_quiet:
            self.widget.hold()
        if cue and cue is not before.cue:
            self.widget.cue(
                cue.gaze, state.theme.gestures.get(cue.gesture) if state.theme else None
            )

    def _show_text(self, agent: AgentState, before: AgentState) -> None:
        text = self._fit_text(agent)
        if text == self._shown_text and agent.valence == before.valence:
            if agent.face != before.face:
                self.widget.look(agent.face)
            return
        self._shown_text = text
        words, more = text
        if not words:
            self.widget.clear(agent.face)
            return
        self.widget.say(words, agent.face, agent.valence)
        if more:
            self.widget.say(more, joins=True)

    def _fit_text(self, agent: AgentState) -> tuple[str, str]:
        """Return the text that fits here, where there is less size: of joined texts, the end is
        shown.
        """
        parent = self.widget.parent
        size = parent.content_size if isinstance(parent, Widget) else Size(0, 0)
        width = size.width - WIDTH - _MARGINS
        if width <= 0 or not agent.words:  # nothing has been laid out yet
            return agent.words, agent.more
        more, most = wrap(agent.more, width, len(agent.more)), max(2, size.height - 2)
        if len(more) > most:
            more = ["…", *more[1 - most :]]
        words = wrap(agent.words, width, size.height - (len(more) + 1 if more else 0))
        return "\n".join(words), "\n".join(more)
