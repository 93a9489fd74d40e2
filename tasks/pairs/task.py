"""The pairs task: two people at one computer, each with a half of the screen, and of the keyboard
or a sensor.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import msgspec

from sar_tui.api.task import (
    MS,
    Act,
    Again,
    Cue,
    Json,
    KeyPerceived,
    Metric,
    Node,
    Performance,
    RandomStreams,
    ReachPerceived,
    Result,
    Results,
    Score,
    Situation,
    Stimulus,
    Target,
    Task,
    TaskParameters,
    Trial,
    goal_text,
)

from . import reaches
from .parameters import PairsDetails, PairsParameters

_SIDES: tuple[Literal["left"], Literal["right"]] = ("left", "right")
_GAZE_EFFECT = 0.06
"""Relative slowing of a simulated participant after a look to the other side: about 25 ms (Friesen
& Kingstone 1998; Driver et al. 1999).
"""
_AGAIN = {
    "samples": "A sensor sent nothing during that reach, so it does not count.",
    "gap": "A sensor missed a part of that reach, so it does not count.",
    "rate": "A sensor is too slow to see a reach. Please fetch the experimenter.",
    "analysis": "That reach could not be measured, so it does not count.",
}
_NO_REACH = "I saw no whole reach. Wait for the signal, then reach out and come all the way back."
ROWS: dict[str, tuple[str, str, str, str]] = {
    "qwerty": ("1234567890", "qwertyuiop", "asdfghjkl;", "zxcvbnm,./"),
    "azerty": ("&é\"'(-è_çà", "azertyuiop", "qsdfghjklm", "wxcvbn,;:!"),
    "qwertz": ("1234567890", "qwertzuiop", "asdfghjklö", "yxcvbnm,.-"),
}
"""Character of each place without Shift: digits, top, home and bottom row, ten columns from the
left.
"""
_HALF = 5
_OUTWARDS = (3, 2, 1, 0, 4)
"""Columns of the left hand from the index finger outwards, then the column between the hands."""
_PAIRS = (2, 3, 4, 6, 8, 11)
"""Number of keys for each seat, by level."""
Pair = tuple[str, str]


class Response(NamedTuple):
    """The response of one seat.

    Args:
        asked: the response asked for: a key's name, or a reach.
        is_over: True if no more is expected: the seat responded, or its sensor saw no whole reach.
        done: the response; None for none.
        at: time stamp of the key press or the movement onset (ns).
        latency_ms: time from the prompt's onset.
        is_real: False for an anticipation.
        details: stored with the trial.
        flags: added to ``trials.timing``.
        remark: said to the participant if the attempt fails.
    """

    asked: str
    is_over: bool = False
    done: str | None = None
    at: int | None = None
    latency_ms: float | None = None
    is_real: bool = False
    details: Json = {}
    flags: tuple[str, ...] = ()
    remark: str = ""

    @property
    def is_right(self) -> bool:
        """True if it is the response asked for."""
        return self.done is not None and self.done.casefold() == self.asked.casefold()

    def result(self, details: Json) -> Result:
        """Return the result of this response alone, with its own reaction time."""
        return Result(
            correct=self.is_right,
            response=self.done,
            response_at=self.at,
            value=self.latency_ms,
            details={**details, "asked": self.asked, "right": self.is_right, **self.details},
            flags=self.flags,
            remark=self.remark,
        )


class PairsTask(Task):
    """Seat A has the left half of the keyboard and of the screen, seat B the right. The metric is
    the reaction time.

    With reaches, each seat has a sensor on a hand instead of a half of the keyboard, and the
    response is the movement onset.
    """

    name = "pairs"
    title = "Pairs"
    summary = "Two people at one keyboard: in turn, against each other, or together."
    trains = "Together"
    metric = Metric(
        "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
    )
    Parameters = PairsParameters
    Details = PairsDetails
    sensors = ("imu",)
    seats = ("A", "B")
    parameters: PairsParameters

    @classmethod
    def sensor_seats(cls, parameters: TaskParameters) -> tuple[str, ...]:
        reaching = isinstance(parameters, PairsParameters) and parameters.respond_with == "reaches"
        return cls.seats if reaching else ()

    def __init__(self, parameters: TaskParameters) -> None:
        super().__init__(parameters)
        self._levels = levels(self.parameters.layout)
        self._owners = owners(self.parameters.layout)
        self._reaching = bool(self.sensor_seats(parameters))

    @property
    def levels(self) -> int:
        return len(reaches.GOAL_SHARES if self._reaching else self._levels)

    @property
    def trials_per_attempt(self) -> int:
        return self.parameters.prompts_per_attempt

    @property
    def address(self) -> Literal["seat", "code"]:
        return self.parameters.address

    def seat_of(self, key: str) -> str:
        return "" if self._reaching else self._owners.get(key.casefold(), "")

    def nodes(self) -> tuple[Node, ...]:
        return reaches.perception_nodes(self.parameters) if self._reaching else ()

    def target(self, level: int) -> Target:
        """Return the target. With reaches, higher levels have a shorter goal; with keys, more keys
        to choose from.
        """
        share = reaches.GOAL_SHARES[level - 1] if self._reaching else 1.0
        return Target(round(self.parameters.threshold * share, 3), self.parameters.neutral_band)

    # --- words

    def instructions(self) -> str:
        rest = self.tr("You may rest between attempts. To pause at any time, press Escape.")
        return (
            f"{self._reaches_explained() if self._reaching else self._keys_explained()}\n\n{rest}"
        )

    def _keys_explained(self) -> str:
        tr = self.tr
        does = {
            "alternate": tr(
                "A letter appears in one half of the screen: it is that person's turn."
            ),
            "race": tr(
                "A letter appears in each half of the screen. The first to press theirs wins."
            ),
            "cooperative": tr(
                "A letter appears in each half of the screen. Press yours at the same time as the "
                "other."
            ),
            "joint attention": tr(
                "I look to one side. Then a letter appears on one side, the same or the other."
            ),
        }
        halves = tr(
            "Two people take part. Each has one half of the screen, and that half of the keyboard."
        )
        press = tr("Press the letter in your half as fast as you can. Leave the other half alone.")
        return f"{halves}\n{does[self.parameters.policy]}\n{press}"

    def _reaches_explained(self) -> str:
        tr = self.tr
        does = {
            "alternate": tr("GO appears in one half of the screen: it is that person's turn."),
            "race": tr("GO appears in each half of the screen. The first to set off wins."),
            "cooperative": tr(
                "GO appears in each half of the screen. Set off at the same time as the other."
            ),
            "joint attention": tr(
                "I look to one side. Then GO appears on one side, the same or the other."
            ),
        }
        halves = tr(
            "Two people take part. Each has one half of the screen, and a sensor on one hand."
        )
        rest = tr("Rest that hand on the table, and keep it still until it is your turn.")
        reach = tr(
            "At GO in your half reach out and come back, as fast as you can. Then keep still."
        )
        return f"{halves}\n{rest}\n{does[self.parameters.policy]}\n{reach}"

    def goal(self, level: int) -> str:
        tr = self.tr
        time = goal_text(self.metric, self.target(level).threshold, tr)
        match self.parameters.policy:
            case "race":
                first = (
                    tr("Be the first to set off.")
                    if self._reaching
                    else tr("Be the first to press your letter.")
                )
                return f"{first}\n{tr('The goal of each: less than {time} on average.', time=time)}"
            case "cooperative" if self._reaching:
                return tr(
                    "The goal together: both set off at once, in less than {time} on average.",
                    time=time,
                )
            case "cooperative":
                return tr(
                    "The goal together: both letters at once, in less than {time} on average.",
                    time=time,
                )
        if self._reaching:
            return tr("The goal of each: to set off in less than {time} on average.", time=time)
        return tr("The goal of each: the right letter in less than {time} on average.", time=time)

    def when_to_respond(self) -> str:
        if self._reaching:
            return self.tr("Set off as soon as GO appears.")
        return self.tr("Press your letter as soon as it appears.")

    # --- prompts

    def stimulus(self, situation: Situation) -> Stimulus:
        pairs = self._levels[situation.level - 1]
        pair = situation.streams.choice(pairs, "order")
        asked = (
            Stimulus(reaches.REACH, "", "")
            if self._reaching
            else Stimulus("", "", "", choices=len(pairs))
        )
        halves = (self.tr("GO"), self.tr("GO")) if self._reaching else pair
        match self.parameters.policy:
            case "alternate":
                return self._for_one(asked, halves, (situation.attempt + situation.trial) % 2)
            case "joint attention":
                side = self._side(situation)
                return msgspec.structs.replace(
                    self._for_one(asked, halves, side), cue=self._cue(situation, side)
                )
        return msgspec.structs.replace(
            asked,
            name=asked.name or " ".join(halves),
            text="  ".join(
                self._line(seat, half) for seat, half in zip(self.seats, halves, strict=True)
            ),
            halves=halves,
        )

    def _for_one(self, asked: Stimulus, pair: Pair, side: int) -> Stimulus:
        seat, half = self.seats[side], pair[side]
        return msgspec.structs.replace(
            asked,
            name=asked.name or half,
            expected="" if self._reaching else half,
            text=self._line(seat, half),
            seat=seat,
            halves=("", half) if side else (half, ""),
        )

    def _line(self, seat: str, half: str) -> str:
        """Return the response asked of a seat, as plain text."""
        return (
            f"{self.display_name(seat)}: "
            f"{self.tr('reach out and back') if self._reaching else half}"
        )

    def _side(self, situation: Situation) -> int:
        """Return the side of a prompt: each side equally often in an attempt, in random order."""
        sides = [number % 2 for number in range(self.trials_per_attempt)]
        situation.session.generator("side", situation.attempt).shuffle(sides)
        return sides[situation.trial - 1]

    def _cue(self, situation: Situation, side: int) -> Cue:
        congruent = situation.streams.uniform("congruent") < self.parameters.congruent_share
        return Cue(
            _SIDES[side if congruent else 1 - side],
            self.parameters.cue_lead_ms,
            self.parameters.cue_by,
        )

    # --- responses

    def perceived(self, trial: Trial, percept: Any) -> Result | Results | Again | None:
        if isinstance(percept, ReachPerceived) and percept.invalid:
            return Again(percept.invalid, self.tr(_AGAIN[percept.invalid]))
        responses = self._responses(trial, (*trial.percepts, percept))
        if not all(response.is_over for response in responses.values()):
            return None
        return self._judge(trial, responses)

    def timed_out(self, trial: Trial) -> Results:
        return self._judge(trial, self._responses(trial, trial.percepts))

    def _responses(self, trial: Trial, percepts: Sequence[Any]) -> dict[str, Response]:
        """Return the first response of each seat that is asked; a second one does not count."""
        stimulus = trial.stimulus
        halves = dict(zip(self.seats, stimulus.halves, strict=True))
        asked = {seat: half for seat, half in halves.items() if stimulus.seat in ("", seat)}
        respond = self._reach if self._reaching else self._press
        return {
            seat: respond(trial, half, next((one for one in percepts if one.seat == seat), None))
            for seat, half in asked.items()
        }

    def _press(self, trial: Trial, asked: str, press: KeyPerceived | None) -> Response:
        if press is None:
            return Response(asked, details={"key_gap_ms": None})
        gap = None if press.gap is None else press.gap / MS
        return self._timed(
            trial, Response(asked, True, press.key, press.at, details={"key_gap_ms": gap})
        )

    def _reach(self, trial: Trial, _: str, reach: ReachPerceived | None) -> Response:
        """Return a reach as a response, made at its movement onset. Half a reach is none."""
        if reach is None or reach.onset is None:
            flags = (*reach.flags, "no_reach") if reach else ()
            return Response(
                reaches.REACH, reach is not None, flags=flags, remark=self.tr(_NO_REACH)
            )
        kept, flags = reaches.details(reach), reach.flags
        return self._timed(
            trial,
            Response(reaches.REACH, True, reaches.REACH, reach.onset, details=kept, flags=flags),
        )

    def _timed(self, trial: Trial, response: Response) -> Response:
        """Return a response with its latency from the prompt's onset."""
        assert response.at is not None
        latency = trial.latency_ms(response.at)
        return response._replace(latency_ms=latency, is_real=latency >= self.parameters.min_rt_ms)

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

    # --- attempts

    def score(self, results: Sequence[Result]) -> Score:
        score = super().score(results)
        if self.parameters.policy != "race":
            return score
        return msgspec.structs.replace(
            score, won=sum(result.details.get("won") is True for result in results)
        )

    def measures(self, results: Sequence[Result]) -> dict[str, float]:
        match self.parameters.policy:
            case "race":
                return {"won": float(sum(result.details.get("won") is True for result in results))}
            case "cooperative":
                return {
                    "together": float(
                        sum(result.details.get("together") is True for result in results)
                    )
                }
            case "joint attention":
                slow, fast = (_mean(results, congruent) for congruent in (False, True))
                return {} if slow is None or fast is None else {"congruency_effect_ms": slow - fast}
        return {}

    # --- simulated participants

    def rehearse(
        self, stimulus: Stimulus, performance: Performance, streams: RandomStreams
    ) -> list[Act]:
        """Respond, later after a look to the other side. A slip is another key of the same half, or
        no reach.
        """
        side = self.seats.index(stimulus.seat)
        at = performance.reaction_ms
        if stimulus.cue and stimulus.cue.side != _SIDES[side]:
            at *= 1 + _GAZE_EFFECT
        if self._reaching:
            return reaches.rehearsed(at, performance, streams)
        key = stimulus.halves[side]
        if performance.slips:
            key = streams.choice(
                [pair[side] for pair in self._levels[-1] if pair[side] != key], "slip"
            )
        return [(at, key)]


def _cued(trial: Trial) -> Json:
    """Return the side that the agent looked to, and how long before the prompt."""
    cue = trial.stimulus.cue
    assert cue
    lead = None if trial.cued is None else (trial.onset - trial.cued) / MS
    side = _SIDES["AB".index(trial.stimulus.seat)]
    return {"cue": cue.side, "congruent": cue.side == side, "cue_lead_ms": lead}


def _mean(results: Sequence[Result], congruent: bool) -> float | None:
    values = [
        result.value
        for result in results
        if result.counts
        and result.value is not None
        and result.details.get("congruent") is congruent
    ]
    return math.fsum(values) / len(values) if values else None


def owners(layout: str) -> dict[str, str]:
    """Return the seat of each key, by the character it types: ``A`` or ``B``."""
    return {
        key: "A" if column < _HALF else "B"
        for row in ROWS[layout]
        for column, key in enumerate(row)
    }


def levels(layout: str) -> tuple[tuple[Pair, ...], ...]:
    """Return the levels, easiest first: pairs of letters at mirrored places, for the same finger of
    either hand.

    The home row comes first, then the top, then the bottom row. Places without a plain letter on
    both sides are left out.
    """
    _, top, home, bottom = ROWS[layout]
    mirrored = [
        (row[column], row[9 - column]) for row in (home, top, bottom) for column in _OUTWARDS
    ]
    letters = tuple(
        pair for pair in mirrored if all(key.isascii() and key.isalpha() for key in pair)
    )
    return tuple(letters[:count] for count in _PAIRS)


def race(responses: Mapping[str, Response], details: Json) -> Results:
    """Return the results of a race: the fastest right response wins, or both if equal. Each keeps
    its own time.
    """
    fair = {seat: one.latency_ms for seat, one in responses.items() if one.is_right and one.is_real}
    fastest = min((latency for latency in fair.values() if latency is not None), default=None)
    return {
        seat: one.result({**details, "won": fastest is not None and fair.get(seat) == fastest})
        for seat, one in responses.items()
    }


def cooperate(responses: Mapping[str, Response], details: Json, window_ms: float) -> Results:
    """Return the results of cooperation: right if both are right within the window; both get the
    later time.
    """
    latencies = [one.latency_ms for one in responses.values() if one.latency_ms is not None]
    both = len(latencies) == len(responses)
    gap = max(latencies) - min(latencies) if both else None
    together = (
        gap is not None
        and gap <= window_ms
        and all(one.is_right and one.is_real for one in responses.values())
    )
    shared: Json = {**details, "together": together, "between_ms": gap}
    return {
        seat: msgspec.structs.replace(
            one.result(shared), correct=together, value=max(latencies) if together else None
        )
        for seat, one in responses.items()
    }
