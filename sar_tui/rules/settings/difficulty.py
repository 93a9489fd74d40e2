"""Settings of difficulty that every policy shares."""

from typing import TYPE_CHECKING, Annotated, Literal

from sar_tui.rules.declaration import Settings, meta
from sar_tui.rules.difficulty import BY_OUTCOME, POLICIES

if TYPE_CHECKING:
    PolicyName = str
else:
    PolicyName = Literal[tuple(POLICIES)]


class DifficultySettings(Settings, frozen=True, kw_only=True):
    """Levels of a session, and the policy that chooses among them."""

    start_level: Annotated[
        int,
        meta(
            "Start level",
            help="The level of the first attempt; of the first session only, unless it starts "
            "from fixed.",
            ge=1,
            le=100,
            group="Difficulty",
        ),
    ] = 1
    start_from: Annotated[
        Literal["estimate", "last level", "fixed"],
        meta(
            "Start from",
            help="estimate: the level at which the last session's times just reached the goal. "
            "last level: the one it "
            "ended at. fixed: the start level, as it is.",
            group="Difficulty",
        ),
    ] = "estimate"
    min_level: Annotated[
        int,
        meta(
            "Lowest level",
            help="The level never falls below this.",
            ge=1,
            le=100,
            group="Difficulty",
        ),
    ] = 1
    max_level: Annotated[
        int,
        meta(
            "Highest level",
            help="The level never rises above this or the last level of the task.",
            ge=1,
            le=100,
            group="Difficulty",
        ),
    ] = 10
    difficulty_policy: Annotated[
        PolicyName,
        meta(
            "Difficulty",
            help=" ".join(f"{name}: {policy.summary}" for name, policy in POLICIES.items()),
            group="Difficulty",
        ),
    ] = BY_OUTCOME

    def problems(self) -> dict[str, str]:
        """Return why the levels do not fit together, by parameter."""
        if self.min_level > self.max_level:
            return {
                "min_level": f"Lowest level ({self.min_level}) is above the highest "
                f"({self.max_level})."
            }
        if not self.min_level <= self.start_level <= self.max_level:
            problem = (
                f"Start level ({self.start_level}) must be between {self.min_level} and "
                f"{self.max_level}."
            )
            return {"start_level": problem}
        return {}
