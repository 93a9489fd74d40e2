"""The levels of a therapist's list, one for each attempt."""

from typing import Annotated

from msgspec import Meta

from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.difficulty.policy import Bounds, Difficulty, DifficultyPolicy, ScoredAttempt


class SequenceSettings(Settings, frozen=True, kw_only=True):
    """Settings of the difficulty policy ``sequence``."""

    level_sequence: Annotated[
        tuple[Annotated[int, Meta(ge=1, le=99)], ...],
        meta(
            "List of levels",
            help="For sequence: the level of each attempt, such as 1 1 2 2 3. The last one stays.",
            group="Difficulty",
        ),
    ] = ()

    def problems(self) -> dict[str, str]:
        """Return an error if the policy is chosen, and the list is empty."""
        if getattr(self, "difficulty_policy", "") == "sequence" and not self.level_sequence:
            return {"level_sequence": "Name the levels of the sequence, such as 1 1 2 2 3."}
        return {}


def start(level: int, settings: SequenceSettings, bounds: Bounds) -> int:
    """Return the first level of the list."""
    return bounds.nearest(settings.level_sequence[0])


def step(
    state: Difficulty, attempt: ScoredAttempt, settings: SequenceSettings, bounds: Bounds
) -> Difficulty:
    """Return the difficulty of the next place in the list; after its end, of the last."""
    levels = settings.level_sequence
    place = min(attempt.number, len(levels) - 1)
    level = bounds.nearest(levels[place])
    return Difficulty(
        level,
        why=f"Number {place + 1} of {len(levels)} in the list." if level != state.level else "",
    )


POLICY = DifficultyPolicy(
    "The levels of your own list, one for each attempt.", SequenceSettings, step, start=start
)
