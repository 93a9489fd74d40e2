"""Which keys reach the screen that a participant sees: see `rules.keys` for the rule."""

from collections.abc import Callable
from typing import Any, ClassVar

from rich.table import Table
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical, VerticalScroll
from textual.events import Key
from textual.screen import ModalScreen, Screen
from textual.widgets import Input, Static

from sar_tui.model.spoken_text import sentences
from sar_tui.model.units import MS, SECOND
from sar_tui.rules.keys import LONGEST_INTERVAL, KeyGuard
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.language import language_of

_ALWAYS = frozenset(("ctrl+c", "ctrl+q", "f2"))
"""Keys that stop something, on any screen and at any time."""
_AT_ONCE = frozenset(("escape", "f1", "question_mark", "f12"))
"""Keys that act as soon as a screen appears; their repeats do nothing."""
_CONFIRM = frozenset(("enter", "space"))
_MOVES = frozenset(
    (
        "up",
        "down",
        "left",
        "right",
        "home",
        "end",
        "pageup",
        "pagedown",
        "tab",
        "shift+tab",
        "backspace",
        "delete",
    )
)
"""Keys that may be held, as they choose and correct, and confirm nothing."""


class ScreenKeys:
    """Judges the keys of the app.

    What a key leads to is not on the screen before the app has handled the key, so each key that is
    let through counts as a new appearance; that holds for screens whose contents change with each
    key, too.

    Args:
        now: the present time in s, on the clock of the stamps.
    """

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._guard = KeyGuard()
        self._last = ("", 0.0)
        self.is_repeat = False
        """True if the last key bounced, or is held: for keys that a therapist may press twice at
        short intervals.
        """

    def set_bounce(self, ms: int) -> None:
        """Take presses of one key within this time for one."""
        self._guard.bounce = ms * MS

    def changed(self, screen: Screen[Any]) -> None:
        """Note that another screen is shown, or something else on it: from now on, and once it is
        drawn.
        """
        self.appeared()
        screen.call_after_refresh(self.appeared)

    def appeared(self) -> None:
        """Note that something else is there, which nobody has read yet."""
        self._guard.appeared(round(self._now() * SECOND))

    def pass_on(self, event: Key, at: float, screen: object, *, is_therapist: bool) -> bool:
        """Return True if a key, stamped at ``at`` (s), is meant for a screen.

        A therapist who is at the keyboard knows the screens: only keys that are still held do
        nothing.
        """
        press = self._guard.press(event.key, round(at * SECOND))
        (last, before), self._last = self._last, (event.key, at)
        self.is_repeat = event.key == last and at - before < LONGEST_INTERVAL / SECOND
        is_typed = event.is_printable and isinstance(getattr(screen, "focused", None), Input)
        if event.key in _ALWAYS or getattr(screen, "is_in_trial", False):
            return True
        if is_therapist:
            return not (press.is_left_over and event.key in _CONFIRM)
        if event.key in _AT_ONCE or is_typed:
            return press.is_new or is_typed
        if event.key in _MOVES or getattr(screen, "judges_keys", False):
            return press.counts
        if (only_chooses := getattr(screen, "only_chooses", None)) and only_chooses(event.key):
            return press.is_new and press.counts
        passes = press.is_new and press.counts
        if passes:
            self.appeared()
        return passes


# --- the help screen


class HelpScreen(DismissedOnce[None], ModalScreen[None]):
    """Lists the keys of the screen below it."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,enter,space,f1,question_mark,q", "dismiss", "Close", id="help-close")
    ]

    def __init__(self, about: Screen[object]) -> None:
        super().__init__()
        self._about = about

    def compose(self) -> ComposeResult:
        tr = language_of(self.app)
        with Vertical(id="help"):
            with VerticalScroll(id="help-text"):
                yield Static(getattr(self._about, "help_text", ""), markup=False)
                yield Static(self._keys())
            yield Static(tr("Press Enter to close this."), classes="muted", markup=False)

    def on_mount(self) -> None:
        if aloud := getattr(self.app, "aloud", None):
            aloud.read(self)

    @property
    def sentences(self) -> list[str]:
        """The help in sentences, without the list of keys that the footer has."""
        tr = language_of(self.app)
        about = getattr(self._about, "help_text", "")
        return sentences(about, tr("Press Enter to close this."))

    def _keys(self) -> Table:
        table, tr = Table.grid(padding=(0, 2)), language_of(self.app)
        seen = set()
        for binding in self._about.active_bindings.values():
            name = binding.binding.description
            if binding.binding.show and binding.enabled and name and name not in seen:
                seen.add(name)
                table.add_row(self.app.get_key_display(binding.binding), tr(name).capitalize())
        is_hidden = any(footer.for_participant for footer in self._about.query(KeyFooter))
        if is_hidden and self.app.use_command_palette:
            table.add_row(f"{tr('Ctrl')}-P", tr("Everything that can be done here"))
        return table
