"""Wordings that do not repeat what was just said. Pure."""

import re
from collections.abc import Mapping, Sequence
from typing import Literal

from sar_tui.model.messages import AttemptEnded

_SHORTEST, _STEM = 3, 5
"""Letters of the shortest word that is compared, and how many are: "reaches" repeats "reached"."""
_EVERYWHERE = frozenset(
    """the and you that this was are for with than had have your
    der die das des dem den und ist ein eine einen mit von für auf als wie war waren sie ihr ihre ihnen
    dir dich dein deine hat haben bei sehr noch nicht jetzt diesmal
    que los las una con por para como pero del esta este eso sus usted muy hecho sido""".split()
)
"""Words that nobody notices when they come again, in the bundled languages."""


def repeated(text: str, other: str) -> int:
    """Return how many words of a text are in another, whatever their endings."""
    return len(_stems(text) & _stems(other))


def least_repeating(wordings: Mapping[str, str], beside: str, before: str) -> list[str]:
    """Return the wordings that repeat least of the text beside them, and among these, of the text
    before.

    Args:
        wordings: the texts that are said, by wording.
        beside: said in the same breath; empty for nothing.
        before: said the last time.
    """
    repeats = {
        wording: (repeated(text, beside), repeated(text, before))
        for wording, text in wordings.items()
    }
    least = min(repeats.values())
    return [wording for wording, found in repeats.items() if found == least]


def _stems(text: str) -> set[str]:
    words = re.findall(r"[^\W\d_]+", text.lower())
    return {word[:_STEM] for word in words if len(word) >= _SHORTEST and word not in _EVERYWHERE}


# --- encouragement


def why_hard(attempts: Sequence[AttemptEnded], level: int) -> Literal["", "failures", "new level"]:
    """Return why the next attempt is hard: after two failures in a row, or at a new highest level;
    empty if it is not.

    Args:
        attempts: scored so far, oldest first.
        level: of the next attempt.
    """
    if [attempt.outcome for attempt in attempts[-2:]] == ["failure", "failure"]:
        return "failures"
    if attempts and level > max(attempt.level for attempt in attempts):
        return "new level"
    return ""


def rest_due(attempts: int, every: int) -> bool:
    """Return True if a reminder of rest is due after ``attempts`` attempts; with ``every`` 0,
    never.
    """
    return bool(every) and attempts > 0 and attempts % every == 0
