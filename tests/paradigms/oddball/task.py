"""An auditory oddball, written from docs/write-your-own-task.md: respond to the rare high tone, not
to the low one.
"""

from sar_tui.loop.task import Task
from sar_tui.model.trial_types import Frame, Metric, Result, Stimulus, Tone

RARE, FREQUENT = Tone(1000, 60), Tone(500, 60)


class Oddball(Task):
    name = "oddball"
    title = "Oddball"
    metric = Metric(
        "reaction_time", unit="ms", better="lower", improved="faster", worsened="slower"
    )

    @property
    def trials_per_attempt(self):
        return 6

    def instructions(self):
        return "Press the space bar when the tone is high."

    def stimulus(self, situation):
        is_rare = situation.streams.uniform("tone") < 0.35
        frames = (
            Frame("·", 250, text="Listen."),
            Frame(
                "·",
                text="Listen now.",
                tone=RARE if is_rare else FREQUENT,
                timed=True,
                awaited=True,
            ),
        )
        name, expected = ("rare", "space") if is_rare else ("frequent", "")
        return Stimulus(name, expected, "Listen", frames=frames, timeout_ms=400)

    def perceived(self, trial, percept):
        at = percept.at
        since_tone = (at - trial.tones[0]) / 1e6 if trial.tones else None
        is_right = percept.key == trial.stimulus.expected
        return Result(correct=is_right, response=percept.key, response_at=at, value=since_tone)

    def timed_out(self, trial):
        return Result(correct=not trial.stimulus.expected)

    def rehearse(self, stimulus, performance, streams):
        is_pressed = (stimulus.name == "rare") != performance.slips
        return [(min(performance.reaction_ms, 380), "space")] if is_pressed else []
