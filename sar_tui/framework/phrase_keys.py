"""What the agent can be asked to say: the situations a theme has wordings for, and the slots those may use."""

import string

from sar_tui.framework.number_words import holds_number

FIGURES = frozenset({"value", "goal", "difference", "percent", "correct", "trials", "reached", "attempts"})
"""The slots that hold a number."""
_VALENCES = ("positive", "neutral", "negative")

SITUATIONS: dict[str, set[str]] = {
    # what has no result in it
    "greeting": set(),
    "welcome_back": set(),
    "encouragement": set(),
    "rest": set(),
    "filler": set(),
    "goodbye": set(),
    "goodbye_early": set(),
    # the same to two people at once
    "greeting_both": set(),
    "welcome_back_both": set(),
    "encouragement_both": set(),
    "rest_both": set(),
    "goodbye_both": set(),
    "goodbye_early_both": set(),
    # what came of a race
    "won": set(),
    "lost": set(),
    "drawn": set(),
    "race_figures": {"reached", "trials"},
    # knowledge of results, in words; how far from the goal sets the degree
    "positive_slight": set(),
    "positive": set(),
    "positive_strong": set(),
    "neutral": set(),
    "negative_slight": set(),
    "negative": set(),
    "negative_strong": set(),
    "accuracy": set(),
    "empty": set(),
    **{f"summary_{valence}": set() for valence in _VALENCES},
    # knowledge of results, in figures
    **{f"{valence}_first": {"value", "goal"} for valence in _VALENCES},
    **{
        f"{valence}_{change}": {"value", "goal", "difference", "change", "reference"}
        for valence in _VALENCES
        for change in ("improved", "worsened")
    },
    **{f"{valence}_same": {"value", "goal", "reference"} for valence in _VALENCES},
    "accuracy_figures": {"correct", "trials"},
    "empty_figures": {"correct", "trials"},
    "summary_figures": {"reached", "attempts", "value", "goal"},
    "summary_empty_figures": {"reached", "attempts"},
    # knowledge of performance, in words and in figures
    "performance_first": {"aim"},
    "performance_improved": {"change", "reference"},
    "performance_worsened": {"aim", "reference"},
    "performance_same": {"aim", "reference"},
    "performance_first_figures": {"aim", "value", "goal"},
    "performance_improved_figures": {"change", "percent", "reference"},
    "performance_worsened_figures": {"aim", "percent", "reference"},
    "performance_same_figures": {"aim", "percent", "reference"},
}
"""By name: the slots a wording may use."""

PERFORMANCE = tuple(name for name in SITUATIONS if name.startswith("performance_"))
QUANTITATIVE = tuple(name for name, slots in SITUATIONS.items() if slots & FIGURES)
QUALITATIVE = tuple(name for name in SITUATIONS if name not in QUANTITATIVE)

VOCABULARY = ("last_attempt", "last_at_level", "best_attempt", "session_mean", "goal")
"""What the slot ``reference`` is filled with."""


def wording_problems(situation: str, wording: str, language: str) -> list[str]:
    """What is wrong with a wording for a situation, a sentence each."""
    slots = SITUATIONS[situation]
    where = f"A wording for {situation} ({language})"
    try:
        parts = [part[1:] for part in string.Formatter().parse(wording) if part[1] is not None]
    except ValueError as error:
        return [f"{where} has broken slots ({error}): {wording!r}."]
    used = {name or "" for name, _, _ in parts}
    found = [f"{where} uses the slot {{{name}}}, which it does not have." for name in sorted(used - slots)]
    if any(form or conversion for _, form, conversion in parts):
        found.append(f"{where} has more than a name in a slot: {wording!r}.")
    if not wording.strip():
        found.append(f"{where} is empty.")
    if situation in QUALITATIVE and holds_number(wording, language):
        found.append(f"{where} holds a number: {wording!r}.")
    if situation in QUANTITATIVE and not used & FIGURES:
        found.append(f"{where} gives no figure: {wording!r}.")
    return found
