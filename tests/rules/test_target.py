"""The level moves until a share of the prompts, or of the attempts, reaches the goal."""

from hypothesis import given
from hypothesis import strategies as st

from sar_tui.rules import level_choice
from sar_tui.rules.difficulty import Bounds, Difficulty, Place, ScoredAttempt, TargetSettings
from sar_tui.rules.difficulty import step_to_target as step
from sar_tui.rules.parameters import TaskParameters, build

BOUNDS = Bounds(1, 10)
SHARES = st.lists(st.integers(0, 20), max_size=60)


def after(
    state: Difficulty, reached: int, settings: TargetSettings | None = None, prompts: int = 20
) -> Difficulty:
    scored = ScoredAttempt(1, "success", 500.0, reached, prompts)
    return step(state, scored, settings or TargetSettings(), BOUNDS)


@given(SHARES, st.floats(10, 95), st.floats(0.1, 20))
def test_the_level_never_leaves_its_bounds_and_moves_against_the_distance_from_the_target(
    counts: list[int], share: float, floor: float
) -> None:
    settings, state = TargetSettings(target_share=share, target_step=floor), Difficulty(5)
    for reached in counts:
        moved = after(state, reached, settings)
        assert 1 <= moved.level <= 10
        assert (moved.level - state.level) * (reached / 20 - share / 100) >= 0
        assert bool(moved.why) == (moved.level != state.level)
        state = moved


def test_a_person_for_whom_all_is_easy_is_at_the_highest_level_after_six_attempts() -> None:
    state = Difficulty(1)
    found = []
    for _ in range(6):
        state = after(state, 20)
        found.append(state.level)
    assert found == [3, 5, 6, 8, 10, 10]


def test_the_step_shrinks_when_the_direction_turns_but_not_below_its_floor() -> None:
    state, places = Difficulty(5, Place(5.0)), []
    for reached in (20, 8, 20, 8, 20):
        state = after(state, reached)
        places.append(round(state.memory.place, 6))
    moves = [round(b - a, 6) for a, b in zip([5.0, *places], places, strict=False)]
    assert moves == [1.8, -0.9, 0.6, -0.6, 0.6], (
        "steps of 6, 3, 2, 2 and 2 levels, times a distance of 30 %"
    )


def test_at_the_target_nothing_moves_and_the_direction_is_kept() -> None:
    state = after(Difficulty(5, Place(5.2, 1, 3)), 14)
    assert (state.level, state.memory, state.why) == (5, Place(5.2, 1, 3), "")


def test_the_reason_names_what_was_reached_and_the_target() -> None:
    assert after(Difficulty(5), 19).why == "19 of 20 prompts reached the goal; the target is 70 %."
    of_attempts = TargetSettings(target_of="attempts", target_share=50)
    assert (
        after(Difficulty(5), 0, of_attempts).why == "Goal reached; the target is 50 % of attempts."
    )


def test_after_a_level_set_by_hand_it_goes_on_from_there() -> None:
    assert after(Difficulty(8), 14).level == 8
    assert after(Difficulty(8), 8).level == 6


def test_it_is_chosen_by_its_name() -> None:
    parameters = build(TaskParameters, {"difficulty_policy": "target", "start_level": 3})
    moved = level_choice.step(
        level_choice.start(parameters, 10), ScoredAttempt(1, "failure", None, 4, 20), parameters, 10
    )
    assert moved.level == 1
