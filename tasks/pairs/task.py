"""The pairs task: two people at one keyboard, each with a half of it and of the screen."""

import math
from collections.abc import Sequence
from typing import Any, Literal

import msgspec

from sar_tui.framework.chance import Chance
from sar_tui.framework.clock import MS
from sar_tui.framework.messages import Json, KeyPerceived
from sar_tui.framework.parameters import TaskParameters
from sar_tui.framework.task import (
    Act,
    Cue,
    Metric,
    Performance,
    Result,
    Results,
    Score,
    Situation,
    Stimulus,
    Task,
    Trial,
)

from .details import PairsDetails
from .layouts import Pair, levels, owners
from .parameters import PairsParameters
from .policies import Response, cooperate, race

_SIDES: tuple[Literal["left"], Literal["right"]] = ("left", "right")
_GAZE_EFFECT = 0.06
"""By what share a simulated participant is slower where the agent looked to the other side: some 25 ms (Friesen &
Kingstone 1998; Driver et al. 1999)."""


class PairsTask(Task):
    """Seat A has the left half of the keyboard and of the screen, seat B the right. The metric is the reaction time."""

    name = "pairs"
    title = "Pairs"
    summary = "Two people at one keyboard: in turn, against each other, or together."
    metric = Metric("reaction_time", unit="ms", better="lower", improved="faster", worsened="slower")
    Parameters = PairsParameters
    Details = PairsDetails
    seats = ("A", "B")
    parameters: PairsParameters

    def __init__(self, parameters: TaskParameters) -> None:
        super().__init__(parameters)
        self._levels = levels(self.parameters.layout)
        self._owners = owners(self.parameters.layout)

    @property
    def levels(self) -> int:
        return len(self._levels)

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    @property
    def address(self) -> Literal["seat", "code"]:
        return self.parameters.address

    def seat_of(self, key: str) -> str:
        return self._owners.get(key.casefold(), "")

    # --- words ----------------------------------------------------------------------------------------------

    def instructions(self) -> str:
        tr = self.tr
        does = {
            "alternate": tr("A letter appears in one half of the screen: it is that person's turn."),
            "race": tr("A letter appears in each half of the screen. Who is first to press theirs wins."),
            "cooperative": tr(
                "A letter appears in each half of the screen. Press yours at the same time as the other."
            ),
            "joint attention": tr("I look to one side. Then a letter appears on one side, the same or the other."),
        }
        return (
            f"{tr('Two take part. Each has one half of the screen, and that half of the keyboard.')}\n"
            f"{does[self.parameters.policy]}\n"
            f"{tr('Press the letter in your half as fast as you can. Leave the other half alone.')}\n\n"
            f"{tr('You may rest between attempts. To pause at any time, press Escape.')}"
        )

    def goal(self, level: int) -> str:
        tr, seconds = self.tr, self.parameters.threshold / 1000
        time = tr("1 second") if seconds == 1 else tr("{count} seconds", count=f"{seconds:g}")
        match self.parameters.policy:
            case "race":
                first = tr("Be the first to press your letter.")
                return f"{first}\n{tr('The goal of each: less than {time} on average.', time=time)}"
            case "cooperative":
                return tr("The goal together: both letters at once, in less than {time} on average.", time=time)
        return tr("The goal of each: the right letter in less than {time} on average.", time=time)

    # --- prompts --------------------------------------------------------------------------------------------

    def stimulus(self, situation: Situation) -> Stimulus:
        pairs = self._levels[situation.level - 1]
        pair = situation.chance.choice(pairs, "order")
        match self.parameters.policy:
            case "alternate":
                return self._for_one(pair, (situation.attempt + situation.trial) % 2, len(pairs))
            case "joint attention":
                side = self._side(situation)
                return msgspec.structs.replace(self._for_one(pair, side, len(pairs)), cue=self._cue(situation, side))
        left, right = pair
        names = {"left": self.seat_name("A"), "right": self.seat_name("B")}
        return Stimulus(
            name=f"{left} {right}",
            expected="",
            text=f"{names['left']}: {left}  {names['right']}: {right}",
            halves=pair,
            choices=len(pairs),
        )

    def _for_one(self, pair: Pair, side: int, choices: int) -> Stimulus:
        seat, key = self.seats[side], pair[side]
        return Stimulus(
            name=key,
            expected=key,
            text=f"{self.seat_name(seat)}: {key}",
            seat=seat,
            halves=("", key) if side else (key, ""),
            choices=choices,
        )

    def _side(self, situation: Situation) -> int:
        """Each side as often as the other in an attempt, in an order of its own."""
        sides = [number % 2 for number in range(self.trials_per_attempt)]
        situation.session.generator("side", situation.attempt).shuffle(sides)
        return sides[situation.trial - 1]

    def _cue(self, situation: Situation, side: int) -> Cue:
        congruent = situation.chance.uniform("congruent") < self.parameters.congruent_share
        return Cue(_SIDES[side if congruent else 1 - side], self.parameters.cue_lead_ms, self.parameters.cue_by)

    # --- responses ------------------------------------------------------------------------------------------

    def perceived(self, trial: Trial, percept: Any) -> Result | Results | None:
        responses = self._responses(trial, (*trial.percepts, percept))
        if any(response.percept is None for response in responses.values()):
            return None
        return self._judge(trial, responses)

    def timed_out(self, trial: Trial) -> Results:
        return self._judge(trial, self._responses(trial, trial.percepts))

    def _responses(self, trial: Trial, percepts: Sequence[KeyPerceived]) -> dict[str, Response]:
        """What each did first of those who are asked; a second key mends nothing."""
        stimulus = trial.stimulus
        keys = dict(zip(self.seats, stimulus.halves, strict=True))
        asked = {seat: key for seat, key in keys.items() if stimulus.seat in ("", seat)}
        return {seat: self._response(trial, seat, key, percepts) for seat, key in asked.items()}

    def _response(self, trial: Trial, seat: str, asked: str, percepts: Sequence[KeyPerceived]) -> Response:
        press = next((percept for percept in percepts if percept.seat == seat), None)
        latency = trial.latency_ms(press.at) if press else None
        return Response(asked, press, latency, latency is not None and latency >= self.parameters.min_rt_ms)

    def _judge(self, trial: Trial, responses: dict[str, Response]) -> Results:
        details: Json = {"policy": self.parameters.policy, "choices": trial.stimulus.choices}
        match self.parameters.policy:
            case "race":
                return race(responses, details)
            case "cooperative":
                return cooperate(responses, details, self.parameters.window_ms)
            case "joint attention":
                details |= _cued(trial)
        return {seat: response.result(details) for seat, response in responses.items()}

    # --- attempts -------------------------------------------------------------------------------------------

    def score(self, results: Sequence[Result]) -> Score:
        score = super().score(results)
        if self.parameters.policy != "race":
            return score
        return msgspec.structs.replace(score, won=sum(result.details.get("won") is True for result in results))

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        match self.parameters.policy:
            case "race":
                return {"won": float(sum(result.details.get("won") is True for result in results))}
            case "joint attention":
                slow, fast = (_mean(results, congruent) for congruent in (False, True))
                return {} if slow is None or fast is None else {"congruency_effect_ms": slow - fast}
        return {}

    # --- simulated participants -----------------------------------------------------------------------------

    def rehearse(self, stimulus: Stimulus, performance: Performance, chance: Chance) -> list[Act]:
        """A slip hits another key of one's own half. A look to the other side costs a moment."""
        side = self.seats.index(stimulus.seat)
        key = stimulus.halves[side]
        at = performance.reaction_ms
        if stimulus.cue and stimulus.cue.side != _SIDES[side]:
            at *= 1 + _GAZE_EFFECT
        if performance.slips:
            key = chance.choice([pair[side] for pair in self._levels[-1] if pair[side] != key], "slip")
        return [(at, key)]


def _cued(trial: Trial) -> Json:
    """Where the agent looked, and how long before."""
    cue = trial.stimulus.cue
    assert cue
    lead = None if trial.cued is None else (trial.onset - trial.cued) / MS
    side = _SIDES["AB".index(trial.stimulus.seat)]
    return {"cue": cue.side, "congruent": cue.side == side, "cue_lead_ms": lead}


def _mean(results: Sequence[Result], congruent: bool) -> float | None:
    values = [
        result.value
        for result in results
        if result.counts and result.value is not None and result.details.get("congruent") is congruent
    ]
    return math.fsum(values) / len(values) if values else None
