"""Check of motion sensors before a session: attachment, placing on the hand, and a test reach."""

import functools
import math
from collections.abc import Sequence
from typing import Any, ClassVar

from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import ActiveBinding, Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.widgets import Static

from sar_tui.app.patient_mode import keys_in_mode
from sar_tui.app.sensor_advice import (
    MARKS,
    Fact,
    Mark,
    calibrated_text,
    calibration_text,
    facts,
    reach_test_text,
    signed,
    worst,
)
from sar_tui.app.sensor_monitor import Calibration, SensorWatch
from sar_tui.inputs.imu_feed import ImuFeed
from sar_tui.loop.clock import Clock, Handle, LiveClock
from sar_tui.model.language import Language
from sar_tui.model.spoken_text import sentences
from sar_tui.model.units import MS, SECOND
from sar_tui.motion.reach import Hand
from sar_tui.rules.scanning import Choice
from sar_tui.runs.plan import Plan
from sar_tui.tui.dismissed_once import DismissedOnce
from sar_tui.tui.key_line import KeyLine
from sar_tui.tui.language import planned_language, translated
from sar_tui.widgets.key_footer import KeyFooter
from sar_tui.widgets.speed_trace import SpeedTrace

LOOK = 100 * MS
"""Time between two updates of the screen."""
ZEROING = 3 * SECOND
"""A sensor takes up to two seconds to find its bias."""

_BAR = 8
_SIDES = ("On the left", "On the right")
_PARTS = ("On the hand", "On the trunk")
_PLACE_TRUNK = "Fasten this sensor to the breastbone, and lean against the back of the chair."
_PLACE = "Fasten the sensor as drawn, and lay the hand flat on the table, palm down."
_IDLE = "T: a test reach.  Z: zero the sensor.  Enter: begin the session."
_IDLE_PERSON = "T: test reach.  C: calibrate by three.  Z: zero the sensor.  Enter: begin."
_ZEROED = "The sensor removes its bias: keep the hand still for two seconds."
_IDLE_TRUNK = "Z: zero the sensor.  Enter: begin the session."
_ZEROED_TRUNK = "The sensor removes its bias: sit still for two seconds."
_NO_TRUNK = "There is no sensor on the trunk. Reaches count without it. Press Enter again to begin."
_IDLE_FIRST = "T: a test reach.  Z: zero the sensor.  Enter: on to the other sensor."
_NONE = (
    "There is no sensor, so the session will wait for one. Press Enter again to begin it anyway."
)
_NOT_BOTH = (
    "A sensor is missing, so the session will wait for it. Press Enter again to begin it anyway."
)
_KEEPS_BIAS = "This sensor cannot be zeroed: it keeps its bias."
_NOTHING_TO_ZERO = "There is no sensor to zero. Plug it in first."
_HELP = (
    "Fasten the sensor to the back of the hand as drawn: y along the fingers, z out of the hand. "
    "Lay the hand flat and still: z points up, and the bias of each axis is shown.",
    "Zero removes that bias, if the sensor can. A test shows what a session would measure: "
    "rest, reach out and back, and rest. It is not stored.",
    "Calibrate measures three reaches of this person to the nearest marker: a movement that turns "
    "the hand less than a third of the smallest is no reach from then on. Do it again when the "
    "person reaches farther.",
    "The session may begin at any time; without a sensor it waits for one.",
)
_HELP_WITH_TRUNK = (
    *_HELP[:2],
    "The sensor on the breastbone measures how far the trunk leans in a reach. It may point in "
    "any direction.",
    "The session may begin at any time; without the sensor on the hand it waits for one.",
)
_HELP_OF_TWO = (
    *_HELP[:2],
    "The session may begin at any time; without both sensors it waits for them.",
)
_WITHOUT = (
    "To try the task without: Escape, then F2 on the first screen, and set Motion sensor "
    "to simulated."
)
_WITHOUT_BOTH = (
    "To try the task without: Escape, then F2 on the first screen, and set Sensor on the left and "
    "Sensor on the right "
    "to simulated."
)


class SensorCheckScreen(DismissedOnce[bool]):
    """Shows the data of started feeds; its result is True if the session is to begin.

    Two sensors are checked one after the other; a line at the top shows the state of both. A sensor
    on the trunk has no test reach, and no session waits for it.

    Args:
        plan: the session that waits.
        feeds: the started feeds of its sensors, in the order of the seats; one on the trunk comes
            last.
        clock: the clock of the feeds.
    """

    AUTO_FOCUS = ""
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("t", "test", "Test", id="test-reach"),
        Binding("c", "calibrate", "Calibrate", id="calibrate"),
        Binding("z", "zero", "Zero", id="zero"),
        Binding("tab", "other", "Other sensor", show=False, id="other-sensor"),
        Binding("enter", "begin", "Begin", id="begin"),
        Binding("escape", "leave", "Back", id="leave-check"),
    ]

    app: Any

    def __init__(self, plan: Plan, feeds: Sequence[ImuFeed], clock: Clock) -> None:
        super().__init__()
        hands: list[Hand] = [getattr(plan.parameters, name, "right") for name in ("hand", "hand_b")]
        self.sensors = [
            SensorWatch(feed, clock.now, hand) for feed, hand in zip(feeds, hands, strict=False)
        ]
        for sensor in self.sensors:
            sensor.least_confidence = getattr(plan.parameters, "least_confidence", 0.0)
        self.sensor = self.sensors[0]
        self._unseen = self.sensors[1:]
        self._plan = plan
        self._clock = clock
        self._next: Handle | None = None
        self._notice: tuple[str, Mark, int] = ("", "wait", 0)
        self._shown: dict[str, tuple[str, object]] = {}
        self._asked = self._over = False

    @functools.cached_property
    def tr(self) -> Language:
        """Language of the session that waits."""
        return planned_language(self._plan, self.app.catalogue)

    @property
    def help_text(self) -> str:
        """Help on placing the sensor, on zero and test, and on sessions without a sensor.

        In patient mode it names no way to the settings, as there is none.
        """
        are_two = len(self.sensors) > 1 and not self._has_trunk
        about = _HELP_WITH_TRUNK if self._has_trunk else _HELP_OF_TWO if are_two else _HELP
        paragraphs = [self.tr(paragraph) for paragraph in about]
        if not self.app.patient:
            paragraphs.append(self.tr(_WITHOUT_BOTH if are_two else _WITHOUT))
        return "\n\n".join(paragraphs) + "\n"

    @property
    def active_bindings(self) -> dict[str, ActiveBinding]:
        return keys_in_mode(self.app, translated(super().active_bindings, self.tr))

    def compose(self) -> ComposeResult:
        with Horizontal(id="top"):
            yield Static(self.tr("Check the sensor"), id="task", markup=False)
            codes = ", ".join(self._plan.participants)
            yield Static(f"{codes} · {self.tr(self._plan.task.title)}", id="where", markup=False)
        if len(self.sensors) > 1:
            yield Static(id="sides")
        yield Static(self.tr(_PLACE), id="place", markup=False)
        with Horizontal(id="placing"):
            yield Static(id="hand")
            with Vertical(id="known"):
                yield Static(id="facts")
                yield Static(id="axes")
        with Vertical(id="reach") as reach:
            reach.border_title = self.tr("Test reach")
            yield Static(id="result")
            yield SpeedTrace(id="trace")
        if self.app.switch:
            yield KeyLine()
        yield KeyFooter(optional=("zero", "quit"))

    def on_mount(self) -> None:
        if isinstance(self._clock, LiveClock):
            self.run_worker(self._clock.run(), name="sensor check", group="sensor check")
        self._look()

    def on_unmount(self) -> None:
        self._stop_looking()

    @property
    def switch_choices(self) -> tuple[Choice, ...]:
        """Everything that can be done with a switch."""
        tr = self.tr
        begin = tr("Other sensor") if self._unseen else tr("Begin")
        found = [Choice(begin, ("enter",)), Choice(tr("Test"), ("t",)), Choice(tr("Zero"), ("z",))]
        if self._is_on_trunk:
            del found[1]
        if self._can_calibrate:
            found.append(Choice(tr("Calibrate"), ("c",)))
        return (*found, Choice(tr("Back"), ("escape",)))

    # --- actions

    def action_test(self) -> None:
        """Begin a test reach, or begin it again."""
        if self._is_on_trunk:
            return
        self._set_notice("")
        self.sensor.begin_test()
        self._show()

    def action_calibrate(self) -> None:
        """Begin the reaches that set the person's least turn, or begin them again."""
        self._set_notice("")
        self.sensor.begin_calibration()
        self._show()

    def action_zero(self) -> None:
        """Take the present rate as zero."""
        if self.sensor.keeps_bias:
            self._set_notice(self.tr(_KEEPS_BIAS), "wrong", ZEROING)
        elif self.sensor.attached:
            self.sensor.zero()
            self._set_notice(
                self.tr(_ZEROED_TRUNK if self._is_on_trunk else _ZEROED), "wait", ZEROING
            )
        else:
            self._set_notice(self.tr(_NOTHING_TO_ZERO), "wrong", ZEROING)
        self._show()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Offer the other sensor if there is one, and a test reach of a hand."""
        if action == "test" and self._is_on_trunk:
            return False
        if action == "calibrate":
            return self._can_calibrate
        return (
            len(self.sensors) > 1 if action == "other" else super().check_action(action, parameters)
        )

    def action_other(self) -> None:
        """Show the next sensor, or the first again."""
        number = (self.sensors.index(self.sensor) + 1) % len(self.sensors)
        self.sensor = self.sensors[number]
        self._unseen = [sensor for sensor in self._unseen if sensor is not self.sensor]
        self._set_notice("")
        self.refresh_bindings()
        self._show()
        self.app.look_for_choices()

    @property
    def _can_calibrate(self) -> bool:
        """True if the session has a least turn that may be set for the person: a study has its own,
        and in patient mode nobody changes settings.
        """
        has_limit = hasattr(self._plan.parameters, "least_turn_deg") and not self._plan.study
        return has_limit and not self.app.patient and not self._is_on_trunk

    @property
    def calibration(self) -> Calibration | None:
        """A calibration of the hand's sensor that is over; None without one."""
        return self.sensors[0].calibrated

    @property
    def _is_on_trunk(self) -> bool:
        """True while the sensor on the trunk is shown."""
        return self.sensor.feed.part == "trunk"

    @property
    def _has_trunk(self) -> bool:
        return any(sensor.feed.part == "trunk" for sensor in self.sensors)

    @property
    def _missing(self) -> list[SensorWatch]:
        return [sensor for sensor in self.sensors if sensor.state not in ("attached", "ended")]

    def action_begin(self) -> None:
        """Go to a sensor that was not checked yet, or begin the session; without a sensor, only at
        the second press.
        """
        if self._unseen:
            self.action_other()
        elif not self._missing or self._asked:
            self._stop_looking()
            self.dismiss(True)
        else:
            self._asked = True
            self._show()

    def action_leave(self) -> None:
        """Forget a calibration, or else go back without a session."""
        if self.sensor.calibration or self.sensor.calibrated:
            self.sensor.forget_calibration()
            self._show()
            return
        self._stop_looking()
        self.dismiss(False)

    # --- contents

    def _stop_looking(self) -> None:
        """Leave all further data to the session."""
        self._over = True
        if self._next:
            self._next.cancel()

    def _look(self) -> None:
        if self._over:
            return
        for sensor in self.sensors:
            sensor.look()
        self._show()
        self._next = self._clock.call_at(self._clock.now() + LOOK, self._look)

    def _show(self) -> None:
        """Update what has changed on the screen."""
        if all(sensor.attached for sensor in self.sensors):
            self._asked = False
        if self._is_new("hand", self.sensor):
            self.query_one("#hand", Static).update(
                draw_trunk() if self._is_on_trunk else draw_hand(self.sensor.hand)
            )
            self.query_one("#place", Static).update(
                self.tr(_PLACE_TRUNK if self._is_on_trunk else _PLACE)
            )
            self.query_one("#reach").border_title = self.tr(
                _PARTS[1] if self._is_on_trunk else "Test reach"
            )
        for sides in self.query("#sides").results(Static):
            sides.update(self._sides())
        known, words = facts(self.sensor, self.tr), self._words()
        if self._is_new("facts", known):
            self.query_one("#facts", Static).update(self._facts(known))
        if self._is_new("result", words):
            self.query_one("#result", Static).update(self._marked(words))
            self.app.aloud.read(self, self.sensor)
        self.query_one("#axes", Static).update(self._axes(), layout=False)
        trace = self.sensor.test.trace if self.sensor.test else None
        if self._is_new("trace", trace):
            self.query_one(SpeedTrace).show([trace] if trace else [])

    @property
    def sentences(self) -> list[str]:
        """The place of the sensor, and what to do, in sentences."""
        place = self.tr(_PLACE_TRUNK if self._is_on_trunk else _PLACE)
        return sentences(self.tr("Check the sensor"), place, *(text for _, text in self._words()))

    def _is_new(self, where: str, what: object) -> bool:
        """True if the content or its colours have changed."""
        before, self._shown[where] = self._shown.get(where), (self.app.theme, what)
        return before != self._shown[where]

    def _set_notice(self, words: str, mark: Mark = "wait", lasting: int = 0) -> None:
        self._notice = (words, mark, self._clock.now() + lasting)

    def _words(self) -> list[tuple[Mark, str]]:
        """Return the text of the test reach's box, the most urgent first."""
        words, mark, until = self._notice
        if self._asked:
            return [("wrong", self._missing_text())]
        if words and self._clock.now() < until:
            return [(mark, words)]
        test, hand = self.sensor.test, self.sensor.hand
        if test and self.sensor.calibration:
            return calibration_text(self.sensor.calibration, test, hand, self.tr)
        said = reach_test_text(test, hand, self.tr) if test else []
        if (made := self.sensor.calibrated) and not (test and test.is_running):
            said.append(("right", calibrated_text(made, self._plan.participant, self.tr)))
        if said:
            return said
        idle = _IDLE_FIRST if self._unseen else _IDLE_PERSON if self._can_calibrate else _IDLE
        idle = self.tr(_IDLE_TRUNK if self._is_on_trunk else idle)
        return [("wait", idle)] if self.sensor.attached and not self.app.switch else []

    def _missing_text(self) -> str:
        if self._has_trunk:
            is_trunk = all(sensor.feed.part == "trunk" for sensor in self._missing)
            return self.tr(_NO_TRUNK if is_trunk else _NONE)
        return self.tr(_NONE if len(self.sensors) == 1 else _NOT_BOTH)

    def _sides(self) -> Text:
        """Return a line with the participant and the state of each sensor; an arrow points to the
        one shown.
        """
        codes = ("", "") if self._has_trunk else (self._plan.participant, self._plan.partner)
        text = Text()
        for number, (sensor, code) in enumerate(zip(self.sensors, codes, strict=True)):
            title = self.tr(_PARTS[number]) if self._has_trunk else self.tr(_SIDES[number])
            is_shown = sensor is self.sensor
            text.append("▸ " if is_shown else "  ", f"bold {self._color('accent')}")
            color = self._color("accent" if is_shown else "text-muted")
            text.append(f"{title}: {code} " if code else f"{title} ", f"bold {color}")
            text.append_text(self._mark(worst(facts(sensor, self.tr)))).append("     ")
        return text.append(self.tr("Tab: the other one"), self._color("text-muted"))

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
        """Return a line for each axis: the rate of turning as a bar and a number, and its bias at
        rest.
        """
        tr, rate, bias = self.tr, self.sensor.rate, self.sensor.bias
        text = Text(
            f"{tr('turning'):>{_BAR + 6}}{'rad/s':>{_BAR + 5}}{tr('bias deg/s'):>12}{'rad/s':>8}"
        )
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


# --- where the sensor is placed


FULL_RAD_S = 4.0
"""Angular rate of a full bar."""

_RIGHT = """\
       ╭─╮╭─╮
    ╭─╮│ ││ │╭─╮
    │ ││ ││ ││ │
    │ ╰╯ ╰╯ ╰╯ │
╭─╮ │    ↑ y   │
│ ╰╮│  ╭─┴─╮   │
╰╮ ╰╯  │ ⊙ ├→ x│
 ╰╮    ╰─z─╯   │
  ╰─╮         ╭╯
    │         │"""
_LEFT = """\
   ╭─╮╭─╮
╭─╮│ ││ │╭─╮
│ ││ ││ ││ │
│ ╰╯ ╰╯ ╰╯ │
│    ↑ y   │ ╭─╮
│  ╭─┴─╮   │╭╯ │
│  │ ⊙ ├→ x╰╯ ╭╯
│  ╰─z─╯     ╭╯
╰╮         ╭─╯
 │         │"""
_TRUNK = """\
      ╭───╮
      │   │
      ╰╮ ╭╯
   ╭───╯ ╰───╮
  ╭╯  ╭───╮  ╰╮
  │ │ │ ⊙ │ │ │
  │ │ ╰───╯ │ │
  │ │       │ │
  │ ╰╮     ╭╯ │
  ╰──┤     ├──╯"""
DRAWN: dict[Hand, str] = {"right": _RIGHT, "left": _LEFT}
"""Hands from above, palm down: y along the fingers, z out of the back of the hand, towards the
viewer.
"""


def draw_hand(hand: Hand) -> Content:
    """Draw a hand with the sensor on it, its axes in the theme's accent colour."""
    return Content(DRAWN[hand]).highlight_regex("[xyz⊙↑→┴├]", style="bold $accent")


def draw_trunk() -> Content:
    """Draw a trunk from the front with the sensor on the breastbone, in the theme's accent
    colour.
    """
    return Content(_TRUNK).highlight_regex("⊙", style="bold $accent")


def bar(value: float, half: int) -> str:
    """Draw a signed value as a bar from the middle, ``half`` cells on either side, in steps of half
    a cell.
    """
    steps = min(2 * half, round(abs(value) / FULL_RAD_S * 2 * half)) if math.isfinite(value) else 0
    whole, rest = divmod(steps, 2)
    empty = "─" * (half - whole - rest)
    if value > 0:
        return "─" * half + "┼" + "━" * whole + "╾" * rest + empty
    return empty + "╼" * rest + "━" * whole + "┼" + "─" * half
