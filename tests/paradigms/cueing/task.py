"""Posner's cueing, written from docs/write-your-own-task.md: the agent looks to a side, then a
target appears.
"""

from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Cue, Metric, Result, Stimulus

SIDES = ("left", "right")
VALID = 0.8
LEAD_MS = 200


class Cueing(Task):
    name = "cueing"
    title = "Where it appears"
    metric = Metric(
        "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
    )

    @property
    def trials_per_attempt(self):
        return 6

    def instructions(self):
        return "Look at the middle. When a star appears, press the arrow key of its side."

    def stimulus(self, situation):
        side = situation.streams.choice(SIDES, "side")
        is_valid = situation.streams.uniform("cue") < VALID
        cued = side if is_valid else SIDES[side == "left"]
        return Stimulus(
            name=side,
            expected=side,
            text=f"Star: {side}",
            halves=("*", "") if side == "left" else ("", "*"),
            cue=Cue(cued, LEAD_MS),
            choices=2,
            data={"valid": is_valid},
        )

    def perceived(self, trial, percept):
        if percept.key not in SIDES:
            return None
        return Result(
            response=percept.key,
            correct=percept.key == trial.stimulus.expected,
            response_at=percept.at,
            value=trial.latency_ms(percept.at),
        )

    def rehearse(self, stimulus, performance, streams):
        is_cued = stimulus.cue is None or stimulus.cue.side == stimulus.expected
        late = 0 if is_cued else 25
        key = SIDES[stimulus.expected == "left"] if performance.slips else stimulus.expected
        return [(performance.reaction_ms + late, key)]
