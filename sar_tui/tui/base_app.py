"""The base of the three apps: the participant's, the operator's panel, and the agent in a window of
its own.
"""

import asyncio
import contextlib
import functools
import os
import selectors
import signal
import sqlite3
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.app import App
from textual.binding import Binding, BindingType
from textual.color import Color
from textual.dom import DOMNode
from textual.driver import Driver
from textual.filter import LineFilter, Monochrome
from textual.geometry import Size
from textual.message import Message
from textual.screen import Screen
from textual.theme import Theme as TextualTheme

from sar_tui.model.theme import Theme
from sar_tui.model.visible_text import visible
from sar_tui.tui.exit_codes import INTERRUPTED, after_signal
from sar_tui.tui.gc_control import SWITCH_INTERVAL
from sar_tui.tui.terminal_input import PasteDropped, UnreadableInput, capped, tolerate_in_terminals
from sar_tui.tui.terminal_output import unblocked
from sar_tui.tui.terminal_probe import TerminalProbe, is_relayed
from sar_tui.tui.timestamps import stamp_keys_as_read


class VisibleLines(LineFilter):
    """Makes characters visible that a terminal would obey. A changed line keeps its width."""

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        if all(segment.control or visible(segment.text) == segment.text for segment in segments):
            return segments
        width = sum(segment.cell_length for segment in segments)
        return Segment.adjust_line_length(_shown(segments), width, pad=False)


def _shown(segments: list[Segment]) -> list[Segment]:
    """Return the line with signs, which take the place of the next spaces, so that a border stays
    where it is.
    """
    found, wider = [], 0
    for segment in segments:
        sign = segment if segment.control else segment._replace(text=visible(segment.text))
        wider += sign.cell_length - segment.cell_length
        spaces = min(wider, len(sign.text) - len(sign.text.rstrip(" ")))
        wider -= spaces
        found.append(sign._replace(text=sign.text[: len(sign.text) - spaces]))
    return found


_SIMILAR = {
    "◠": "^",
    "□": "░",
    "◧": "▒",
    "‿": "_",
    "◉": "o",
    "○": "o",
    "◆": "♦",
    "▽": "v",
    "◁": "<",
    "▷": ">",
    "✓": "*",
    "▌": "│",
    "▐": "│",
    "▏": "│",
    "▎": "│",
    "▔": " ",
    "╷": "│",
    "╵": "│",
    "▁": "_",
    "▂": "_",
    "▃": "░",
    "▀": "▒",
    "▄": "▒",
    "▅": "▒",
    "▆": "█",
    "▇": "█",
    "⠀": " ",
    **{chr(dots): "·" for dots in range(0x2801, 0x2900)},
}
"""Each missing character with a similar one of the same width.

The console draws one sign for all characters that its font lacks. Known are the fonts of Debian's
and Ubuntu's console-setup (Fixed, Terminus and VGA, with the sets Lat15 and Uni2): of what the apps
draw they lack half blocks, fine bars, braille, rings and arcs.
"""
_TABLE = str.maketrans(_SIMILAR)


def on_linux_console() -> bool:
    """Return True if the terminal is the console of Linux itself."""
    return os.environ.get("TERM") == "linux"


class ConsoleGlyphs(LineFilter):
    """Replaces characters that the console's font lacks by similar ones."""

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        return [
            segment
            if segment.control or segment.text.isascii()
            else segment._replace(text=drawn(segment.text))
            for segment in segments
        ]


def drawn(text: str) -> str:
    """Return a text with characters that a console's font has; it keeps its length and width."""
    return text.translate(_TABLE)


class Uncoloured(LineFilter):
    """Sends no colours, as ``NO_COLOR`` asks. What stood on a coloured bar is reversed.

    Args:
        app: its background is that of the terminal.
    """

    def __init__(self, app: App[Any]) -> None:
        super().__init__()
        self._app = app

    def apply(self, segments: list[Segment], background: Color) -> list[Segment]:
        ground = Color.parse(self._app.current_theme.background or "black")
        return [
            segment
            if segment.control or segment.style is None
            else segment._replace(style=_uncoloured(segment.style, ground))
            for segment in segments
        ]


_BAR = 0.15
"""Least difference in brightness, 0 to 1, between a bar and the background."""


@functools.lru_cache(1024)
def _uncoloured(style: Style, ground: Color) -> Style:
    bar = style.bgcolor
    stands_out = (
        bar is not None
        and not bar.is_default
        and abs(Color.from_rich_color(bar).brightness - ground.brightness) >= _BAR
    )
    return style.without_color + Style(reverse=True) if stands_out else style.without_color


DESIGN = Path(__file__).with_name("design.tcss")
"""The style sheet that all apps share; theirs come after it."""
DEBUG = "SAR_TUI_DEBUG"
"""Environment variable: show the traceback of a fault."""


class BaseApp(App[int]):
    """An app that ends in order: with an exit code, and after a fault with one sentence in place of
    a traceback.

    A signal ends it, too, with the terminal restored, even if that takes no output any more.

    Attributes:
        failure: why it ended, for the terminal it leaves; empty if all is well.
        key_seconds: when the last key was read (s), for actions, which Textual does not pass the
            key event.
        has_lost_terminal: True if it ends because its terminal is gone: closed, or the connection
            to it broken.
        terminal_probe: proves that the terminal is there, for screens that ask it.
    """

    TITLE = "sar-tui"
    CSS_PATH: ClassVar[Any] = DESIGN
    CSS = "OptionList { min-width: 12; }"  # Textual fails on options that are left no column
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+q", "quit", "Quit", priority=True, id="quit"),
        Binding("ctrl+c", "interrupt", "Stop", show=False, priority=True, id="interrupt"),
    ]

    def __init__(self) -> None:
        self.terminal_probe = TerminalProbe(
            self.write_to_terminal, is_relayed=lambda: not self.is_web and is_relayed()
        )
        super().__init__()
        self.failure = ""
        self.key_seconds = 0.0
        if self.no_color:
            self._filters = [
                Uncoloured(self) if isinstance(each, Monochrome) else each for each in self._filters
            ]
        self._line_filters = [VisibleLines(), *([ConsoleGlyphs()] if on_linux_console() else [])]
        self._unreadable, self._last_unreadable = 0, ""
        self._pastes_dropped: list[int] = []
        self.has_lost_terminal = False

    def run_here(self) -> int:
        """Run in this terminal or browser; returns the exit code."""
        tolerate_in_terminals()
        stamp_keys_as_read()
        sys.setswitchinterval(SWITCH_INTERVAL)
        try:
            with asyncio.Runner(loop_factory=punctual_loop) as runner:
                runner.run(self.run_async())
        finally:
            self._end_input()
        self._report_unreadable()
        return self.return_code or int(bool(self.failure))

    def _end_input(self) -> None:
        """Let the driver's input thread end, for which Python waits, even if a lost terminal has
        kept it running.
        """
        if (ends := getattr(self._driver, "exit_event", None)) is not None:
            ends.set()

    def get_driver_class(self) -> type[Driver]:
        driver = unblocked(
            super().get_driver_class(), self._terminal_recovered, self._terminal_gone
        )
        return _steady(driver, self.terminal_probe)

    def catch_signals(self) -> None:
        """Let signals end the app in order; called by the driver before it changes the terminal."""
        if os.name == "posix":
            loop = asyncio.get_running_loop()
            for number in (signal.SIGINT, signal.SIGQUIT, signal.SIGTERM, signal.SIGHUP):
                loop.add_signal_handler(number, self.signalled, number)

    def signalled(self, number: int) -> None:
        """End the app on a signal."""
        if number == getattr(signal, "SIGHUP", None):
            self.lose_terminal()
        else:
            self.exit(return_code=after_signal(number))

    def lose_terminal(self) -> None:
        """End the app, as its terminal has hung up."""
        self.has_lost_terminal = True
        self.exit(return_code=after_signal(getattr(signal, "SIGHUP", 1)))

    def _terminal_gone(self) -> None:
        """End the app; called from the writing thread."""
        self.call_later(self.lose_terminal)

    def _terminal_recovered(self) -> None:
        """Draw everything; called from a thread."""
        self.call_later(self._draw_everything)

    def _draw_everything(self) -> None:
        screen = self.screen
        self._display(
            screen,
            screen._compositor.render_update(full=True, screen_stack=self._background_screens),
        )

    def write_to_terminal(self, text: str) -> None:
        """Write to the terminal at once, after the frames before."""
        if self._driver is not None and not self.is_headless:
            self._driver.write(text)
            self._driver.flush()

    async def on_event(self, event: events.Event) -> None:
        if isinstance(event, events.Key):
            self.key_seconds = event.time
        elif isinstance(event, events.Resize) and event.size != capped(event.size):
            event = events.Resize(capped(event.size), capped(event.size))
        if not await in_order(self, event):
            await super().on_event(event)

    def update_styles(self, node: DOMNode, animate: bool = True) -> None:
        """Style a node and those below it, except a widget that is not mounted yet: mounting styles
        it.
        """
        if node.parent is not None or node is self:
            super().update_styles(node, animate)

    # --- what may come from anywhere

    @property
    def size(self) -> Size:
        """The size of the terminal, at most `terminal_input.LARGEST`."""
        return capped(super().size)

    def get_line_filters(self) -> Sequence[LineFilter]:
        """Return the filters of all lines: Textual's, one that makes control characters visible,
        and a console's.
        """
        return [*super().get_line_filters(), *self._line_filters]

    def notify(self, message: str, *, markup: bool = False, **how: Any) -> None:
        """Show a notification. Its text may quote anything, so it is not read as markup."""
        super().notify(message, markup=markup, **how)

    def on_unreadable_input(self, message: UnreadableInput) -> None:
        self._unreadable, self._last_unreadable = self._unreadable + 1, message.what
        self.log.warning(f"unreadable input: {message.what}")

    def on_paste_dropped(self, message: PasteDropped) -> None:
        self._pastes_dropped.append(message.length)
        self.log.warning(f"dropped a paste of {message.length} characters")

    def _report_unreadable(self) -> None:
        """Print a line if the terminal sent what cannot be read, and one if it sent pastes that
        were dropped.
        """
        if self._pastes_dropped:
            count, longest = len(self._pastes_dropped), max(self._pastes_dropped)
            pastes = "A paste was" if count == 1 else f"{count} pastes were"
            with contextlib.suppress(OSError):
                print(
                    f"{pastes} dropped: too long, or no text ({longest:,} characters).",
                    file=sys.stderr,
                )
        if self._unreadable:
            times = "once" if self._unreadable == 1 else f"{self._unreadable} times"
            with contextlib.suppress(OSError):  # the terminal may be gone
                print(
                    f"The terminal sent input that cannot be read, {times} (last: "
                    f"{self._last_unreadable}). It was "
                    "dropped. Is the terminal set to UTF-8?",
                    file=sys.stderr,
                )

    def apply_theme(self, theme: Theme) -> None:
        """Show the colours of a theme, also if it has the name of the present one."""
        colors = textual_theme(theme)
        is_new = self.available_themes.get(colors.name) != colors
        if is_new:
            self.register_theme(colors)
        if not self.is_running and colors.dark == self.current_theme.dark:
            # Setting the attribute would have the style sheets parsed twice before the first frame.
            self.set_reactive(App.theme, colors.name)
            self.stylesheet.set_variables(self.get_css_variables())
        elif self.theme != colors.name:
            self.theme = colors.name
        elif is_new:
            self.mutate_reactive(App.theme)

    async def action_quit(self) -> None:
        """Ctrl-Q: exit, unless the screen has a ``may_quit`` that asks first, and returns True if
        it was asked.
        """
        if getattr(self.screen, "may_quit", lambda: True)():
            self.exit()

    def action_interrupt(self) -> None:
        """Ctrl-C."""
        self.exit(return_code=INTERRUPTED)

    def _handle_exception(self, error: Exception) -> None:
        """End after an unhandled exception, without a traceback unless `SAR_TUI_DEBUG` is set."""
        if self.is_headless or os.environ.get(DEBUG):
            super()._handle_exception(error)
            return
        # a signal came while screens were still being made: they miss what is not made any more
        if self._exit:
            self._close_messages_no_wait()
            return
        self.failure = explain_failure(error)
        self._return_code = 1
        self._close_messages_no_wait()


def punctual_loop() -> asyncio.AbstractEventLoop:
    """Return a new event loop, whose timers are precise to a fraction of a millisecond.

    On Linux asyncio would wait with ``epoll``, whose time-outs are whole milliseconds: timers come
    1 to 2 ms late. The time-outs of ``select`` are microseconds. It takes file descriptors below
    1024 only; an app has some twenty.
    """
    if sys.platform == "linux":
        return asyncio.SelectorEventLoop(selectors.SelectSelector())
    return asyncio.new_event_loop()


def _steady(driver: type[Driver], probe: TerminalProbe) -> type[Driver]:
    """Return a driver class that ends its app on a signal, and passes the terminal's answers to a
    probe.

    Args:
        driver: the class Textual chose.
        probe: asks the terminal.
    """

    class Steady(driver):  # type: ignore[valid-type, misc]
        def start_application_mode(self) -> None:
            """Catch signals before the terminal is changed, so that it is restored however early
            one comes.
            """
            self._app.catch_signals()
            super().start_application_mode()

        def stop_application_mode(self) -> None:
            if not self.is_web:
                probe.await_answers()
            super().stop_application_mode()

        def process_message(self, message: Message) -> None:
            """Note an answer, on the input thread."""
            if isinstance(message, events.CursorPosition):
                probe.answered()
            else:
                super().process_message(message)

    return Steady


def explain_failure(error: Exception) -> str:
    """Return a sentence about an unhandled exception. Those of the database are sentences
    already.
    """
    # the panel and the agent's window have no database
    from sar_tui.store.database import (
        StoreError,
        explain,
    )

    if isinstance(error, sqlite3.Error):
        error = explain(error)
    if isinstance(error, StoreError):
        return str(error)
    return f"sar-tui failed ({type(error).__name__}: {error}). Set {DEBUG}=1 to see where."


T = TypeVar("T")


class OrderedScreen(Screen[T]):
    """A screen on which a key may open a text field, so that the keys after it in the same burst
    are typed there.

    Textual queues a key for the focused widget, so that keys read together would all go to the
    widget that had the focus before the first of them.
    """

    def takes(self, event: events.Key | events.Paste) -> bool:
        """Type a key if a field takes it; return True if so. Other keys are looked up in the
        bindings: here, all.
        """
        return False


async def in_order(app: App[Any], event: events.Event) -> bool:
    """Handle a key on an `OrderedScreen` at once; returns True if it was handled."""
    if not isinstance(event, (events.Key, events.Paste)) or event.is_forwarded:
        return False
    screen = app.screen
    if not isinstance(screen, OrderedScreen):
        return False
    app.app_focus = True
    if not screen.takes(event) and isinstance(event, events.Key):
        for is_first in (True, False):
            if await app._check_bindings(event.key, priority=is_first):
                break
    return True


# --- a theme's colours for Textual


def textual_theme(theme: Theme) -> TextualTheme:
    """Return the colours under Textual's names."""
    colors = theme.colors
    return TextualTheme(
        name=f"sar-{theme.name}",
        primary=colors.accent,
        secondary=colors.accent,
        accent=colors.accent,
        foreground=colors.text,
        background=colors.background,
        surface=colors.surface,
        panel=colors.surface,
        success=colors.positive,
        warning=colors.negative,
        error=colors.negative,
        dark=theme.dark,
        variables={
            "text-muted": colors.muted,
            "neutral": colors.neutral,
            "footer-key-foreground": colors.accent,
            "footer-description-foreground": colors.muted,
            "footer-background": colors.background,
            "border": colors.muted,
            "border-blurred": colors.muted,
            "input-selection-background": f"{colors.accent} 35%",
            "block-cursor-foreground": colors.background,
            "block-cursor-background": colors.accent,
        },
    )
