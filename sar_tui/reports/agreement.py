"""How far an operator agreed with the agent. Pure."""

from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from statistics import median

import msgspec

from sar_tui.reports.proposals import Case


class Agreement(msgspec.Struct, frozen=True):
    """Over the proposals on which an operator decided.

    ``decided``, and of those ``accepted`` as they were, ``edited``, ``vetoed``; ``accepted_share``.
    ``words_changed_…``: which share of its words an edit changed (`word_distance`): the median over ``edits_of_words``,
    and the largest.
    ``valences``: so many of those decided have a valence and were to be said; in ``valences_overridden`` of them it was
    another. ``valence_kappa``: Cohen's, of proposed and said, None where both are the same one throughout.
    ``valence_table`` counts them: proposed, then said.
    """

    decided: int
    accepted: int
    edited: int
    vetoed: int
    accepted_share: float | None
    edits_of_words: int
    words_changed_median: float | None
    words_changed_most: float | None
    valences: int
    valences_overridden: int
    valence_kappa: float | None
    valence_table: dict[str, dict[str, int]]


def agreement(cases: Iterable[Case]) -> Agreement:
    """Compare what was proposed with what operators made of it."""
    decided = [case for case in cases if case.verdict]
    counts = Counter(case.verdict for case in decided)
    edits = [
        word_distance(case.text, case.said)
        for case in decided
        if case.verdict == "edited" and case.said is not None and case.said != case.text
    ]
    pairs = [(case.valence, case.said_valence) for case in decided if case.valence and case.said_valence]
    table: dict[str, dict[str, int]] = {}
    for (proposed, said), n in sorted(Counter(pairs).items()):
        table.setdefault(str(proposed), {})[str(said)] = n
    return Agreement(
        decided=len(decided),
        accepted=counts["accepted"],
        edited=counts["edited"],
        vetoed=counts["vetoed"],
        accepted_share=round(counts["accepted"] / len(decided), 4) if decided else None,
        edits_of_words=len(edits),
        words_changed_median=round(median(edits), 4) if edits else None,
        words_changed_most=round(max(edits), 4) if edits else None,
        valences=len(pairs),
        valences_overridden=sum(proposed != said for proposed, said in pairs),
        valence_kappa=kappa(pairs),
        valence_table=table,
    )


def kappa(pairs: Sequence[tuple[Hashable, Hashable]]) -> float | None:
    """Cohen's kappa (1960) of two judgments of the same things: agreement beyond that of chance, 1 at most.

    None where it is not defined: without any, or where both are the same one throughout.
    """
    if not pairs:
        return None
    n = len(pairs)
    first, second = Counter(one for one, _ in pairs), Counter(other for _, other in pairs)
    observed = sum(one == other for one, other in pairs) / n
    by_chance = sum(first[each] * second[each] for each in first) / n**2
    return None if by_chance == 1 else round((observed - by_chance) / (1 - by_chance), 4)


def word_distance(before: str, after: str) -> float:
    """Which share of the words is another, 0 to 1.

    The fewest words to be put in, taken out or replaced (Levenshtein 1966), over the number of words of the longer.
    """
    one, other = before.split(), after.split()
    if not one and not other:
        return 0.0
    row = list(range(len(other) + 1))
    for i, word in enumerate(one, 1):
        above, row = row, [i]
        for j, against in enumerate(other, 1):
            row.append(min(above[j] + 1, row[j - 1] + 1, above[j - 1] + (word != against)))
    return row[-1] / max(len(one), len(other))
