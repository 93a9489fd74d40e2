"""Settings of the questions between attempts."""

from typing import Annotated

from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.questions import QUESTIONS


class QuestionSettings(Settings, frozen=True, kw_only=True):
    """Questions that the participant answers between attempts, or after the last."""

    questions: Annotated[
        tuple[str, ...],
        meta(
            "Questions",
            help=f"What to ask the participant: {', '.join(QUESTIONS)}. Empty: nothing.",
            max_length=len(QUESTIONS),
            group="Session",
        ),
    ] = ()
    questions_every: Annotated[
        int,
        meta(
            "Ask every",
            "attempts",
            "The questions come after each so many attempts; 0: after the last.",
            ge=0,
            le=200,
            group="Session",
        ),
    ] = 0

    def problems(self) -> dict[str, str]:
        """Return why the questions cannot be asked, by parameter."""
        for name in self.questions:
            if name not in QUESTIONS:
                return {
                    "questions": f'There is no question "{name}". Choose from: '
                    f"{', '.join(QUESTIONS)}."
                }
        if len(set(self.questions)) < len(self.questions):
            return {"questions": "Each question can be asked once: name it once."}
        return {}
