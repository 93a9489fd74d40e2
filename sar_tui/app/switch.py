"""One or two switches in place of the keys, on every screen of a participant.

A screen lists what can be done on it as ``switch_choices``, each with the keys that do it there. A
mark moves through them (see `rules.scanning`), and a press sends the keys of the marked one. A
screen that draws the mark itself has ``mark``; others show it in the row of the key. Within a
trial a screen names the one key of a response as ``switch_key``: every press is that key.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from textual.events import Key
from textual.screen import Screen

from sar_tui.loop.clock import Clock, host_now
from sar_tui.model.units import MS, SECOND
from sar_tui.rules.parameters import TaskParameters
from sar_tui.rules.scanning import SWITCHES, Choice, Scan
from sar_tui.tui.key_line import KeyLine
from sar_tui.widgets.language import language_of

if TYPE_CHECKING:
    from sar_tui.app.app import SarTui

_TYPED = {"space": " ", "enter": "\r", "tab": "\t"}


class Switch:
    """The switch of a participant.

    Args:
        app: shows the screens.
        clock: for tests: a clock that is advanced by hand.
        parameters: of the session; they set a switch.
        people: the participants' codes.
        press_times_ms: of the person, from earlier sessions.
    """

    def __init__(
        self,
        app: "SarTui",
        clock: Clock | None,
        parameters: TaskParameters,
        people: Sequence[str],
        press_times_ms: Sequence[float],
    ) -> None:
        self._app = app
        self._clock = clock
        self._for = self._key(parameters, people)
        switches: Literal[1, 2] = 2 if parameters.switch == "two" else 1
        self._has_two = switches == 2
        self._scan = Scan(
            switches,
            parameters.scan_interval_ms,
            parameters.bounce_ms * MS,
            press_times_ms=press_times_ms,
        )
        self._screen: Screen[Any] | None = None
        self._timer: Any = None
        self._is_marked = False

    def is_for(self, parameters: TaskParameters, people: Sequence[str]) -> bool:
        """Return True if this is the switch of these people, as it is set."""
        return self._for == self._key(parameters, people)

    @staticmethod
    def _key(parameters: TaskParameters, people: Sequence[str]) -> tuple[object, ...]:
        return (
            parameters.switch,
            parameters.scan_interval_ms,
            parameters.bounce_ms,
            tuple(people),
        )

    @property
    def _now(self) -> int:
        return self._clock.now() if self._clock else host_now()

    def close(self) -> None:
        """Let the mark rest, and remove it."""
        self._stop_timer()
        if self._screen is not None and self._screen.is_attached:
            self._unmark(self._screen)

    # --- the screen

    def look(self) -> None:
        """Follow the screen: it is another one, or something else can be done on it."""
        screen = self._app.screen
        if screen is not self._screen:
            self._scan.show((), self._now)
            self._screen = screen
        choices: Sequence[Choice] = getattr(screen, "switch_choices", ())
        tr = language_of(self._app)
        self._scan.answers = tr("Yes"), tr("No")
        self._scan.show(choices, self._now)
        if choices:
            self._draw(screen)
        elif self._is_marked:  # in a trial nothing is left to do
            self._unmark(screen)
        self._set_timer()

    def _tick(self) -> None:
        """Move the mark, if it is time."""
        self._timer = None
        if self._app.screen is not self._screen:
            self.look()
            return
        if self._scan.due is not None and self._now >= self._scan.due:
            self._scan.move(self._now)
        self.look()

    def _set_timer(self) -> None:
        self._stop_timer()
        due = self._scan.due
        if due is None:
            return
        if self._clock:
            self._timer = self._clock.call_at(due, self._tick).cancel
        else:
            self._timer = self._app.set_timer(max(0, due - self._now) / SECOND, self._tick).stop

    def _stop_timer(self) -> None:
        if self._timer is not None:
            self._timer()
            self._timer = None

    # --- the mark

    @property
    def marked(self) -> str:
        """The words that are marked; empty if there is nothing to choose."""
        labels = self._scan.labels
        return labels[self._scan.at] if labels else ""

    @property
    def how_to_choose(self) -> str:
        """The presses that choose, in a sentence."""
        tr = language_of(self._app)
        if self._has_two:
            return tr("Space moves the mark, Enter takes it.")
        return tr("Press when your choice is marked.")

    def _draw(self, screen: Screen[Any]) -> None:
        """Show the mark: where the choice is drawn, and in the row of the key."""
        scan, tr = self._scan, language_of(self._app)
        choice = scan.marked
        assert choice
        if (mark := getattr(screen, "mark", None)) and not scan.asked:
            mark(scan.at, choice)
        labels: Sequence[str] = scan.labels
        at = scan.at
        if scan.asked:
            words = scan.asked.question
        elif choice.entry is not None:
            labels, at = (), 0
            words = self.how_to_choose
        elif len(labels) == 1:
            words = tr("Press your switch:")
        else:
            words = tr("Space moves, Enter takes:") if self._has_two else tr("Press to choose:")
            if any(other.entry is not None for other in scan.choices):
                labels, at = (choice.label,), 0
        for line in screen.query(KeyLine):
            line.mark(words, labels, at)
        self._is_marked = True
        self._app.aloud.read_more()

    def _unmark(self, screen: Screen[Any]) -> None:
        for line in screen.query(KeyLine):
            line.unmark()
        self._is_marked = False

    # --- presses

    async def takes(self, event: Key, at: float) -> bool:
        """Handle a key, stamped at ``at`` (s), if it is a press of the switch. Return True if it
        was.
        """
        if event.key not in SWITCHES:
            return False
        stamp = round(at * SECOND)
        if key := getattr(self._app.screen, "switch_key", ""):
            self._scan.note(event.key, stamp)
            if key == event.key:
                return False
            await self._send(key, event)
            return True
        self.look()
        if not self._scan.choices:
            self._scan.note(event.key, stamp)
            return False
        screen, interval = self._app.screen, 0 if self._has_two else self._scan.interval_ms
        choices, asked = self._scan.choices, self._scan.asked
        pressed = self._scan.press(event.key, stamp)
        if live := self._app.open_session:
            live.keyboard.switched(event.key, live.stamp(event.time), pressed, interval)
        if not pressed.keys:
            self.look()
            return True
        if not asked and (mark := getattr(screen, "mark", None)):
            mark(pressed.place, choices[pressed.place])
        self._set_timer()
        for key in pressed.keys:
            await self._send(key, event)
        return True

    async def _send(self, key: str, event: Key) -> None:
        """Press a key in place of the switch, at the same time."""
        made = Key(key, _TYPED.get(key, key if len(key) == 1 else None))
        made.time = event.time
        await self._app.take_key(made)
