"""A task whose trials the participant starts: press Space, lift a weight, put it down. Keys replace
the sensor.

``k`` takes the weight off the table, ``u`` puts it back, ``d`` drops it, ``?`` is a lift that
cannot be measured.
"""

from typing import Annotated, Any, Literal

from sar_tui.loop.attempt_state import AttemptScore
from sar_tui.loop.attempts import Attempts
from sar_tui.loop.task import Task
from sar_tui.model.messages import Prompt
from sar_tui.model.trial_types import (
    Again,
    Details,
    Mark,
    Metric,
    Quality,
    Result,
    Results,
    Situation,
    Stimulus,
    Target,
    Trial,
)
from sar_tui.model.units import MS
from sar_tui.plugins import Catalogue
from sar_tui.rules.declaration import meta
from sar_tui.rules.parameters import TaskParameters
from tests.loop_driver import LoopDriver

SLIPPED = "The weight slipped. Please lift it once more."


class LiftParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the lifting task."""

    lifts: Annotated[int, meta("Lifts", ge=1, le=50)] = 2
    signal: Annotated[bool, meta("Signal")] = False
    by_itself: Annotated[bool, meta("Lifts follow each other by themselves")] = False
    about: Annotated[Literal["results", "performance", "both"], meta("Content of feedback")] = (
        "results"
    )


class LiftDetails(Details, frozen=True):
    """Details stored with a lift."""

    sway: float | None = None
    grip: float | None = None
    mark: str | None = None


class Lift(Task):
    """The metric is the duration of the lift; each level is a weight with its own goal."""

    name = "lift"
    title = "Lift"
    metric = Metric("lift_time", "ms", "lower", improved="faster", worsened="slower")
    Parameters = LiftParameters
    Details = LiftDetails
    qualities = (
        Quality("sway", "lower", "steadier", "with a steady arm", 2.0),
        Quality("grip", "higher", "firmer", "with a firm grip", 5.0),
    )
    marks = (
        Mark("caught", "f7", "Caught", counts=False),
        Mark("leaned", "f8", "Leaned", counts=True),
    )
    parameters: LiftParameters

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.lifts

    @property
    def start_key(self) -> str:
        return "" if self.parameters.by_itself else "space"

    @property
    def has_foreperiod(self) -> bool:
        return self.parameters.signal

    @property
    def feedback_on(self) -> Literal["results", "performance", "both"]:
        return self.parameters.about

    def target(self, level: int) -> Target:
        return Target(self.parameters.threshold + 100.0 * (level - 1), 10.0)

    def instructions(self) -> str:
        return "Press Space, and lift."

    def notice(self, level: int, before: int) -> str:
        return f"Weight {level} after {before}"

    def start(self, level: int) -> str:
        return f"Weight {level}. Stand still."

    def stimulus(self, situation: Situation) -> Stimulus:
        name = f"{situation.level} kg"
        return Stimulus(name, "u", f"Lift: {name}", signals=self.parameters.signal)

    def perceived(self, trial: Trial, percept: Any) -> Result | Again | None:
        taken = next((earlier.at for earlier in trial.percepts if earlier.key == "k"), None)
        match percept.key:
            case "u" if taken is not None:
                time_ms = (percept.at - taken) / MS
                details = {"sway": time_ms / 100, "grip": 50.0}
                return Result(
                    correct=True,
                    response="lift",
                    onset_at=taken,
                    response_at=percept.at,
                    value=time_ms,
                    details=details,
                )
            case "d":
                return Result(correct=False, response="drop", response_at=percept.at)
            case "?":
                return Again("slipped", SLIPPED)
            case _:
                return None


class SensedLift(Lift):
    """The same task with a sensor."""

    sensors = ("imu",)


class LiftDriver(LoopDriver):
    """Drives a session of the lifting task."""

    def begin_lifts(self) -> None:
        """Continue from the instructions until the first lift can be started."""
        self.enter()
        self.press("enter")
        self.wait(300)

    def to_lift(self) -> Prompt:
        """Start a lift, and wait until its prompt is on the screen."""
        self.press("space")
        return self.to_prompt()

    def lift(self, time_ms: float = 400, end: str = "u") -> None:
        """Start a lift and do it."""
        assert self.waiting.what == "start", self.waiting
        self.to_lift()
        self.wait(200)
        self.press("k")
        self.wait(time_ms)
        self.press(end)
        self.wait(300)


def lifting(at: str = "start", task: type[Task] = Lift, **settings: Any) -> LiftDriver:
    """Start a session, by default of two attempts, and go on to its first ``attempt``, the
    ``start`` of the first lift, or its ``prompt``.
    """
    driver = LiftDriver(task, Catalogue().theme("calm"), **{"attempts": 2, **settings})
    if at == "attempt":
        driver.enter()
    elif at in ("start", "prompt"):
        driver.begin_lifts()
    if at == "prompt":
        driver.to_lift()
    return driver


def attempt(under_way: Attempts, *trials: Results) -> AttemptScore:
    """Do an attempt with these results of its trials, and score it."""
    under_way.begin(now=1000)
    for results in trials:
        under_way.add(results)
    scored = under_way.score(now=2000)
    under_way.advance()
    return scored
