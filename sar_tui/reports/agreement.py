"""Agreement of operators with the agent. Pure."""

from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from statistics import median

import msgspec

from sar_tui.reports.proposals import ProposalRecord


class Agreement(msgspec.Struct, frozen=True):
    """Agreement over the proposals on which an operator decided.

    Attributes:
        decided: number of proposals, of which ``accepted`` unchanged, ``edited`` and ``vetoed``.
        accepted_share: of those decided.
        edits_of_words: number of edits that changed words.
        words_changed_median, words_changed_most: share of words that these edits changed (see
            `word_distance`).
        valences: number of decided proposals that were said and have a valence.
        valences_overridden: of these, number with another valence than proposed.
        valence_kappa: Cohen's kappa of proposed and said; None if both have only one and the same
            value.
        valence_table: counts by proposed, then said valence.
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


def agreement(records: Iterable[ProposalRecord]) -> Agreement:
    """Compare proposals with the operators' decisions."""
    decided = [record for record in records if record.verdict]
    counts = Counter(record.verdict for record in decided)
    edits = [
        word_distance(record.text, record.said)
        for record in decided
        if record.verdict == "edited" and record.said is not None and record.said != record.text
    ]
    pairs = [
        (each.valence, each.said_valence) for each in decided if each.valence and each.said_valence
    ]
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
    """Return Cohen's kappa (1960) of two ratings of the same items: agreement beyond chance, at
    most 1.

    None if it is not defined: without items, or if all ratings are the same.
    """
    if not pairs:
        return None
    n = len(pairs)
    first, second = Counter(one for one, _ in pairs), Counter(other for _, other in pairs)
    observed = sum(one == other for one, other in pairs) / n
    by_chance = sum(first[each] * second[each] for each in first) / n**2
    return None if by_chance == 1 else round((observed - by_chance) / (1 - by_chance), 4)


def word_distance(before: str, after: str) -> float:
    """Return the share of words that differ, 0 to 1.

    Levenshtein distance (1966) in words, divided by the number of words of the longer text.
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
