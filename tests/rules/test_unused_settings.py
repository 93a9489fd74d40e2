"""Settings of policies that are not chosen are known to have no effect."""

from sar_tui.rules.unused_settings import without_effect

CHOSEN = {"difficulty_policy": "target", "feedback_schedule": "every"}


def test_settings_of_policies_that_are_not_chosen_have_no_effect() -> None:
    found = without_effect(CHOSEN)
    assert found["percentile_rank"] == "percentile"
    assert found["consecutive_successes"] == "one-up-one-down"
    assert found["feedback_tolerance"] == "bandwidth"


def test_settings_of_the_chosen_policies_and_of_none_have_an_effect() -> None:
    assert (
        not {"target_share", "target_of", "feedback_every", "threshold", "start_level"}
        & without_effect(CHOSEN).keys()
    )


def test_a_setting_that_two_policies_share_names_both() -> None:
    assert without_effect({"feedback_schedule": "none"})["feedback_every"] == "every or summary"


def test_with_a_policy_that_is_not_known_nothing_is_without_effect() -> None:
    assert not without_effect({"difficulty_policy": "mine", "feedback_schedule": "mine"})
