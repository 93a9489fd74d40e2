"""Questions that therapists can choose on the settings form, without declaring a step."""

from msgspec.structs import replace

from sar_tui.model.step import Step
from sar_tui.rules.wellbeing import PAIN_ENDS

_AGREE = ("not at all true", "a little true", "somewhat true", "rather true", "very true")
PAIN = "pain"
"""Name of the question about pain now: too much leads to the advice to stop, whoever declares a
question like it.
"""
QUESTIONS: dict[str, Step] = {
    step.name: step
    for step in (
        Step(name="effort", text="How hard was that for you?", kind="borg"),
        Step(
            name=PAIN,
            text="How strong is your pain now?",
            kind="number",
            labels=PAIN_ENDS,
        ),
        Step(
            name="tiredness",
            text="How tired are you now?",
            kind="number",
            labels=("not tired at all", "as tired as can be"),
        ),
        Step(
            name="enjoyment",
            text="I enjoyed this exercise very much.",
            kind="likert",
            labels=_AGREE,
        ),
        Step(
            name="difficulty",
            text="How was the exercise for you?",
            kind="likert",
            labels=("much too easy", "too easy", "just right", "too hard", "much too hard"),
        ),
        Step(name="remark", text="Is there anything you would like to tell us?", kind="text"),
    )
}
"""Questions by name. ``effort`` is Borg's CR10; ``enjoyment`` an item of the Intrinsic Motivation
Inventory (Ryan 1982, J Pers Soc Psychol 43:450-461), with five points instead of seven.
"""


def chosen(names: tuple[str, ...], every: int) -> tuple[Step, ...]:
    """Return the questions of these names, each after so many attempts; 0: after the last.

    Raises KeyError for an unknown name.
    """
    return tuple(replace(QUESTIONS[name], every=every) for name in names)
