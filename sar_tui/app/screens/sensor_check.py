"""Before a session with a motion sensor: is it there, is it worn right, does it see a reach."""

import functools
import math
from typing import Any, ClassVar

from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.screen import Screen
from textual.widgets import Footer, Static

from sar_tui.app.language import planned_language, translated
from sar_tui.app.sensor_watch import SensorWatch
from sar_tui.app.sensor_words import MARKS, Fact, Mark, facts, signed, words_of
from sar_tui.framework.clock import MS, SECOND, Clock, Handle, LiveClock
from sar_tui.framework.language import Language
from sar_tui.inputs.feed import ImuFeed
from sar_tui.runs import Plan
from sar_tui.widgets.speed_trace import SpeedTrace
from sar_tui.widgets.worn_sensor import bar, draw_hand

LOOK = 100 * MS
"""How often the screen is brought up to date."""
ZEROING = 3 * SECOND
"""A sensor takes up to two seconds to find its bias."""

_BAR = 8
_PLACE = "Fasten the sensor as drawn, and lay the hand flat on the table, palm down."
_IDLE = "T: a test reach.  Z: zero the sensor.  Enter: begin the session."
_ZEROED = "The sensor takes its bias for zero: keep the hand still for two seconds."
_NONE = "There is no sensor, so the session will wait for one. Press Enter again to begin it all the same."
_NOTHING_TO_ZERO = "There is no sensor to zero. Plug it in first."
_HELP = (
    "Fasten the sensor to the back of the hand as drawn: y along the fingers, z out of the hand. "
    "Lay the hand flat and still: z points up, and the bias of each axis is shown.",
    "Zero takes that bias for zero, where the sensor can. A test shows what a session would see of a reach: "
    "rest, reach out and back, and rest. Nothing of it is kept.",
    "The session may begin at any time; without a sensor it waits for one. To try the task without: Escape, then "
    "F2 on the first screen, and set Motion sensor to simulated.",
)


class SensorCheckScreen(Screen[bool]):
    """Shows what comes from a feed that was started; ends with whether the session is to begin.

    Args:
        plan: the session that waits.
        feed: of its sensor; it is neither started nor stopped here.
        clock: the feed's.
    """

    AUTO_FOCUS = ""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("t", "test", "Test", id="test-reach"),
        Binding("z", "zero", "Zero", id="zero"),
        Binding("enter", "begin", "Begin", id="begin"),
        Binding("escape", "leave", "Back", id="leave-check"),
    ]

    app: Any

    def __init__(self, plan: Plan, feed: ImuFeed, clock: Clock) -> None:
        super().__init__()
        self.sensor = SensorWatch(feed, clock.now, getattr(plan.parameters, "hand", "right"))
        self._plan = plan
        self._clock = clock
        self._next: Handle | None = None
        self._notice: tuple[str, Mark, int] = ("", "wait", 0)
        self._shown: dict[str, tuple[str, object]] = {}
        self._asked = self._over = False

    @functools.cached_property
    def tr(self) -> Language:
        """The language of the session that waits."""
        return planned_language(self._plan, self.app.catalogue)

    @property
    def help_text(self) -> str:
        """How the sensor is worn, what zero and test do, and what there is without a sensor."""
        return "\n\n".join(self.tr(paragraph) for paragraph in _HELP) + "\n"

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        return translated(super().active_bindings, self.tr)

    def compose(self) -> ComposeResult:
        with Horizontal(id="top"):
            yield Static(self.tr("Check the sensor"), id="task", markup=False)
            yield Static(f"{self._plan.participant} · {self.tr(self._plan.task.title)}", id="where", markup=False)
        yield Static(self.tr(_PLACE), id="place", markup=False)
        with Horizontal(id="worn"):
            yield Static(id="hand")
            with Vertical(id="known"):
                yield Static(id="facts")
                yield Static(id="axes")
        with Vertical(id="reach") as reach:
            reach.border_title = self.tr("Test reach")
            yield Static(id="told")
            yield SpeedTrace(id="trace")
        yield Footer()

    def on_mount(self) -> None:
        self.query_one("#hand", Static).update(draw_hand(self.sensor.hand))
        if isinstance(self._clock, LiveClock):
            self.run_worker(self._clock.run(), name="sensor check", group="sensor check")
        self._look()

    def on_unmount(self) -> None:
        self._stop_looking()

    # --- what is done -------------------------------------------------------------------------------------

    def action_test(self) -> None:
        """Begin a test reach, anew if one is under way."""
        self._say("")
        self.sensor.begin_test()
        self._show()

    def action_zero(self) -> None:
        """Take the present rate for rest."""
        if self.sensor.attached:
            self.sensor.zero()
            self._say(self.tr(_ZEROED), "wait", ZEROING)
        else:
            self._say(self.tr(_NOTHING_TO_ZERO), "wrong", ZEROING)
        self._show()

    def action_begin(self) -> None:
        """On to the session; without a sensor only when asked twice."""
        if self.sensor.state in ("attached", "ended") or self._asked:
            self._stop_looking()
            self.dismiss(True)
        else:
            self._asked = True
            self._show()

    def action_leave(self) -> None:
        """Back, without a session."""
        self._stop_looking()
        self.dismiss(False)

    # --- what is shown ------------------------------------------------------------------------------------

    def _stop_looking(self) -> None:
        """What comes from here on belongs to the session."""
        self._over = True
        if self._next:
            self._next.cancel()

    def _look(self) -> None:
        if self._over:
            return
        self.sensor.look()
        self._show()
        self._next = self._clock.call_at(self._clock.now() + LOOK, self._look)

    def _show(self) -> None:
        """Bring the screen up to date; what has not changed stays untouched."""
        if self.sensor.attached:
            self._asked = False
        known, words = facts(self.sensor, self.tr), self._words()
        if self._is_new("facts", known):
            self.query_one("#facts", Static).update(self._facts(known))
        if self._is_new("told", words):
            self.query_one("#told", Static).update(self._marked(words))
        self.query_one("#axes", Static).update(self._axes(), layout=False)
        trace = self.sensor.test.trace if self.sensor.test else None
        if self._is_new("trace", trace):
            self.query_one(SpeedTrace).show([trace] if trace else [])

    def _is_new(self, where: str, what: object) -> bool:
        """Whether something else stands there, or in other colours."""
        before, self._shown[where] = self._shown.get(where), (self.app.theme, what)
        return before != self._shown[where]

    def _say(self, words: str, mark: Mark = "wait", lasting: int = 0) -> None:
        self._notice = (words, mark, self._clock.now() + lasting)

    def _words(self) -> list[tuple[Mark, str]]:
        """What stands in the box of the test reach, the most urgent first."""
        words, mark, until = self._notice
        if self._asked:
            return [("wrong", self.tr(_NONE))]
        if words and self._clock.now() < until:
            return [(mark, words)]
        if self.sensor.test:
            return words_of(self.sensor.test, self.sensor.hand, self.tr)
        return [("wait", self.tr(_IDLE))] if self.sensor.attached else []

    def _facts(self, known: list[Fact]) -> Table:
        table = Table.grid(padding=(0, 1))
        for mark, title, text in known:
            table.add_row(Text(title, self._color("text-muted")), self._mark(mark), Text(text))
        return table

    def _marked(self, words: list[tuple[Mark, str]]) -> Table:
        table = Table.grid(padding=(0, 1))
        for mark, text in words:
            table.add_row(self._mark(mark), Text(text))
        return table

    def _mark(self, mark: Mark) -> Text:
        color = {"right": "success", "wrong": "warning", "wait": "text-muted"}[mark]
        return Text(MARKS[mark], f"bold {self._color(color)}")

    def _axes(self) -> Text:
        """Each axis: how the hand turns about it, as a bar and a number, and its bias at rest."""
        tr, rate, bias = self.tr, self.sensor.rate, self.sensor.bias
        text = Text(f"{tr('turning'):>{_BAR + 6}}{'rad/s':>{_BAR + 5}}{tr('bias deg/s'):>12}{'rad/s':>8}")
        text.stylize(self._color("text-muted"))
        for index, name in enumerate("xyz"):
            turning = rate[index] if rate else 0.0
            now = signed(turning, 2) if rate else "–"
            degrees = signed(math.degrees(bias[index]), 2) if bias else "–"
            radians = signed(bias[index], 3) if bias else "–"
            text.append(f"\n{name} ", f"bold {self._color('accent')}")
            text.append(bar(turning, _BAR), self._color("foreground" if rate else "text-muted"))
            text.append(tr.figures(f"{now:>8}{degrees:>12}{radians:>8}"))
        return text

    def _color(self, name: str) -> str:
        return str(self.app.theme_variables[name])
