"""The keyboard reaction task: press the key that appears, as fast as you can (thesis 4.2.1)."""

import math
from typing import Annotated, Any, Literal

import msgspec

from sar_tui.api.task import (
    Act,
    Axis,
    Details,
    Metric,
    Performance,
    RandomStreams,
    Result,
    Sentence,
    Situation,
    Stimulus,
    Task,
    TaskParameters,
    Trial,
    goal_text,
    meta,
)

from .layouts import ARROWS, Level, levels, needs_shift

_GLYPHS = {"left": "←", "right": "→", "up": "↑", "down": "↓"}


class KeyboardParameters(TaskParameters, frozen=True, kw_only=True):
    """Parameters of the keyboard task."""

    prompts_per_attempt: Annotated[
        int, meta("Prompts per attempt", help="Number of keys in an attempt.", ge=1, le=200)
    ] = 20
    threshold: Annotated[
        float,
        meta(
            "Goal",
            "ms",
            "The mean reaction time of an attempt must be below this; equal is not enough.",
            ge=100,
            le=60_000,
        ),
    ] = 1000.0
    neutral_band: Annotated[
        float,
        meta(
            "Neutral band",
            "ms",
            "A result this close to the goal, on either side, is called neither good nor bad.",
            ge=0,
            le=5000,
        ),
    ] = 10.0
    choice_set: Annotated[
        Literal["both hands", "left hand", "right hand", "arrow keys"],
        meta(
            "Keys",
            help="The keys that prompts are drawn from. One hand never needs Shift.",
            personal=True,
        ),
    ] = "both hands"
    layout: Annotated[
        Literal["qwerty", "azerty", "qwertz"],
        meta(
            "Keyboard layout",
            help="The six letters at the top left of the keyboard.",
            personal=True,
        ),
    ] = "qwerty"
    levels: Annotated[
        tuple[str, ...],
        meta(
            "Own levels",
            help="Your own sets of keys, easiest first, one word each (fj dfjk asdfjkl). Empty: "
            "those of Keys.",
        ),
    ] = ()
    max_level: Annotated[
        int,
        meta(
            "Highest level",
            help="The level never rises above this or the last set of keys.",
            ge=1,
            le=100,
        ),
    ] = 20
    sequence: Annotated[
        Literal["random", "repeating"],
        meta("Sequence", help="Random prompts, or the same sequence again and again."),
    ] = "random"
    sequence_length: Annotated[
        int, meta("Sequence length", "prompts", "Length of a repeating sequence.", ge=2, le=100)
    ] = 10

    def problems(self) -> dict[str, str]:
        problems = super().problems()
        for word in self.levels:
            if not word or len(set(word)) != len(word) or not word.isprintable():
                problems["levels"] = Sentence(
                    "Own level {word} names no key, a key twice, or one that cannot be typed.",
                    word=repr(word),
                )
        count = len(self.chosen_levels())
        if self.start_level > count or self.min_level > count:
            name = "start_level" if self.start_level > count else "min_level"
            problems[name] = Sentence(
                "There are only {count} levels in this choice of keys, so there is no level {level}.",
                count=count,
                level=getattr(self, name),
            )
        return problems

    def chosen_levels(self) -> tuple[Level, ...]:
        """Return the levels: custom ones, else those of the choice set and layout."""
        if self.levels:
            return tuple(
                Level(tuple(word), any(key.isupper() for key in word)) for word in self.levels
            )
        return levels(self.choice_set, self.layout)


class KeyboardDetails(Details, frozen=True):
    """Details stored with a keyboard trial."""

    choices: Annotated[
        int, msgspec.Meta(description="Number of keys that the prompt was drawn from.")
    ]
    key_gap_ms: Annotated[
        float | None, msgspec.Meta(description="Time since the key before this response, in ms.")
    ]


class KeyboardTask(Task):
    """Each prompt takes one key. The metric is the mean reaction time of correct responses."""

    name = "keyboard"
    title = "Keyboard reaction"
    version = "2"
    summary = "Press the key that appears, as fast as you can."
    trains = "Reaction"
    trials = "Keys"
    metric = Metric(
        "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
    )
    Parameters = KeyboardParameters
    Details = KeyboardDetails
    parameters: KeyboardParameters

    def __init__(self, parameters: TaskParameters) -> None:
        super().__init__(parameters)
        self._levels = self.parameters.chosen_levels()

    @property
    def levels(self) -> int:
        return len(self._levels)

    def level_name(self, level: int) -> str:
        return "".join(_GLYPHS.get(key, key) for key in self._levels[level - 1].keys)

    @property
    def axis(self) -> Axis:
        """The information in the choice (Hick 1952; Hyman 1953)."""
        return Axis("choice", self.tr("keys"), is_log2=True)

    def difficulty(self, level: int) -> float:
        return math.log2(len(self._levels[level - 1].keys))

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    def instructions(self) -> str:
        tr, prompts = self.tr, self.parameters.prompts_per_attempt
        asks = tr("An attempt asks for {count} keys.", count=prompts)
        if prompts == 1:
            asks = tr("An attempt asks for 1 key.")
        return (
            f"{tr('A key appears in the middle of the screen.')}\n"
            f"{tr('Press that key as fast as you can, and then wait for the next one.')}\n\n"
            f"{asks} {tr('You may rest between attempts.')}\n"
            f"{tr('To pause at any time, press Escape.')}"
        )

    def goal(self, level: int) -> str:
        tr, prompts = self.tr, self.parameters.prompts_per_attempt
        time = goal_text(self.metric, self.goal_value(level) or 0.0, tr)
        enough = math.ceil(self.parameters.min_accuracy * prompts - 1e-9)
        if not enough:
            return tr("Your goal: press the right key in less than {time} on average.", time=time)
        if enough == prompts:
            return tr(
                "Your goal: press the right key in less than {time} on average, with {enough} of "
                "{prompts} right.",
                time=time,
                enough=enough,
                prompts=prompts,
            )
        return tr(
            "Your goal: press the right key in less than {time} on average, with at least "
            "{enough} of {prompts} right.",
            time=time,
            enough=enough,
            prompts=prompts,
        )

    def notice(self, level: int, before: int) -> str:
        if not before:
            return ""
        more = len(self._levels[level - 1].keys) - len(self._levels[before - 1].keys)
        if not more:
            return super().notice(level, before)
        how = {
            1: self.tr("one more key"),
            2: self.tr("two more keys"),
            -1: self.tr("one key fewer"),
            -2: self.tr("two keys fewer"),
        }.get(more)
        if how is None:
            how = self.tr(
                "{count} more keys" if more > 0 else "{count} keys fewer", count=abs(more)
            )
        return self.tr("Now level {level}: {how}.", level=level, how=how)

    def when_to_respond(self) -> str:
        return self.tr("Press the key as soon as you see it.")

    def stimulus(self, situation: Situation) -> Stimulus:
        level = self._levels[situation.level - 1]
        if self.parameters.sequence == "repeating":
            place = (situation.trial - 1) % self.parameters.sequence_length
            key = situation.session.choice(level.keys, "sequence", situation.level, place)
        else:
            key = situation.streams.choice(level.keys, "order")
        return Stimulus(
            name=key,
            expected=key,
            text=self.tr("Press: {key}", key=self._key_name(key)),
            glyph=_GLYPHS.get(key, key),
            hint=self._hint(level, key),
            choices=len(level.keys),
        )

    def _key_name(self, key: str) -> str:
        """Return the name of a key: the character it types, if any."""
        tr = self.tr
        return {"left": tr("left"), "right": tr("right"), "up": tr("up"), "down": tr("down")}.get(
            key, key
        )

    def _hint(self, level: Level, key: str) -> str:
        if key in ARROWS:
            return self.tr("arrow key")
        return (
            self.tr("with Shift")
            if level.needs_shift and needs_shift(key, self.parameters.layout)
            else ""
        )

    def perceived(self, trial: Trial, percept: Any) -> Result:
        level = self._levels[trial.situation.level - 1]
        return Result(
            response=percept.key,
            correct=_same(percept.key, trial.stimulus.expected, case=level.needs_shift),
            response_at=percept.at,
            value=trial.latency_ms(percept.at),
            details={
                "choices": trial.stimulus.choices,
                "key_gap_ms": None if percept.gap is None else percept.gap / 1_000_000,
            },
        )

    def timed_out(self, trial: Trial) -> Result:
        return Result(
            correct=False, details={"choices": trial.stimulus.choices, "key_gap_ms": None}
        )

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Press the key, or after a slip another letter or arrow."""
        if not performance.slips:
            return [(performance.reaction_ms, stimulus.expected)]
        others = [
            key
            for key in (ARROWS if stimulus.expected in ARROWS else "asdfjkl")
            if key != stimulus.expected.lower()
        ]
        return [(performance.reaction_ms, streams.choice(others, "slip"))]


def _same(pressed: str, expected: str, *, case: bool) -> bool:
    return pressed == expected if case else pressed.casefold() == expected.casefold()
