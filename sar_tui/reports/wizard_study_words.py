"""The report on the operators of several sessions in words."""

from collections.abc import Iterator
from string import ascii_uppercase

from sar_tui.reports.protocol_words import section as protocol_section
from sar_tui.reports.sections import Section, Table
from sar_tui.reports.wizard_study import FEWEST, Drift, Trend, WizardStudy
from sar_tui.reports.wizard_words import (
    LATENCY_COLUMNS,
    NOT_RECORDED,
    agreement_sentences,
    count,
    deviation_counts,
    figures,
    percent,
)

_ID = 6
"""Characters of a session's id that are shown."""
_GROUP = ("n", "median", "IQR", "95 %")


def sections(found: WizardStudy) -> list[Section]:
    """Return the report in words."""
    made = [Section("Sessions", list(_sessions(found)))]
    if found.sessions:
        made += [
            Section("Agreement", list(_agreement(found))),
            *([protocol_section(found.protocol)] if found.protocol else []),
            Section("Latencies", list(_latencies(found))),
            Section("Drift", list(_drifts(found))),
            Section("Deviations", [_deviations(found)]),
        ]
    if found.excluded:
        rows = [(each.session, each.why) for each in found.excluded]
        made.append(
            Section(
                "Exclusions",
                [Table(("session", "why it does not count"), rows, whole=("session",))],
            )
        )
    return [*made, Section("To add", [NOT_RECORDED])] if found.sessions else made


def _sessions(found: WizardStudy) -> Iterator[str | Table]:
    if not found.sessions:
        yield "No operator took part in any of these sessions."
        return
    persons = len({each.participant for each in found.sessions})
    simulated = sum(each.mode != "live" for each in found.sessions)
    modes = (
        ""
        if not simulated
        else " (simulated)"
        if simulated == len(found.sessions)
        else f" ({simulated} simulated)"
    )
    share = (
        f" ({found.operated_s / found.duration_s:.0%} of their time)" if found.duration_s else ""
    )
    yield (
        f"{count(len(found.sessions), 'session')} of {count(persons, 'participant')}{modes}, with "
        f"{count(len(found.operators), 'operator')}: {', '.join(map(_person, found.operators))}. "
        f"There was an operator for {found.operated_s / 60:.1f} min{share}. "
        f"{count(len(found.excluded), 'session')} excluded."
    )
    letters = _letters(found)
    if len(letters) > 1:
        yield "Conditions:\n" + "\n".join(
            f"{letter}  {condition}" for condition, letter in letters.items()
        )
    rows = [
        (
            each.session[:_ID],
            each.participant,
            ", ".join(map(_person, each.operators)),
            letters[each.condition],
            str(each.decided),
            percent(each.accepted_share),
            "" if each.decision_ms is None else f"{each.decision_ms:.0f}",
            ", ".join(each.remarks),
        )
        for each in found.sessions
    ]
    numbers = ("decided", "accepted", "ms")
    heads = ("session", "code", "operator", "in", *numbers, "remarks")
    yield Table(
        heads, rows, numbers, ("session", "operator", *numbers), "ms: median time to decide."
    )


def _letters(found: WizardStudy) -> dict[str, str]:
    """Return a short name for each condition: A, B, …, or 1, 2, … if there are many."""
    conditions = list(dict.fromkeys(each.condition for each in found.sessions))
    names = (
        ascii_uppercase
        if len(conditions) <= len(ascii_uppercase)
        else map(str, range(1, len(conditions) + 1))
    )
    return dict(zip(conditions, names, strict=False))


def _person(operator: str) -> str:
    """Return an operator's own name, without the role that it begins with in the record."""
    return operator.partition(".")[2] or operator


def _agreement(found: WizardStudy) -> Iterator[str | Table]:
    yield " ".join(agreement_sentences(found.agreement))
    if found.accepted_shares:
        least, middle, most = map(percent, found.accepted_shares)
        yield f"Accepted unchanged, by session: median {middle}, from {least} to {most}."
    rows = [
        (
            kind,
            str(each.decided),
            percent(each.accepted_share),
            str(each.edited),
            str(each.vetoed),
            _kappa(each),
        )
        for kind, each in found.agreement_by_kind.items()
    ]
    numbers = ("decided", "accepted", "edited", "vetoed", "kappa of valence")
    if rows:
        yield Table(("proposals", *numbers), rows, numbers)


def _kappa(each: object) -> str:
    kappa = getattr(each, "valence_kappa", None)
    return "" if kappa is None else f"{kappa:.2f}"


def _latencies(found: WizardStudy) -> Iterator[str | Table]:
    rows = [
        ("on screen → operator's key", *figures(found.decision_ms)),
        ("pending → decided by anyone", *figures(found.waiting_ms)),
        ("operator's key → session", *figures(found.link_ms)),
    ]
    yield Table(("latency, ms", *LATENCY_COLUMNS), rows, LATENCY_COLUMNS)
    letters = _letters(found)
    groups = [
        (
            _person(each.operator),
            letters[each.condition],
            str(each.sessions),
            percent(each.accepted_share),
            _kappa(each),
            *(
                cell
                for head, cell in zip(LATENCY_COLUMNS, figures(each.decision_ms), strict=True)
                if head in _GROUP
            ),
        )
        for each in found.groups
    ]
    numbers = ("sessions", "accepted", "kappa", *_GROUP)
    if groups:
        yield "From an operator's screen to the key (ms), by operator and condition:"
        yield Table(("operator", "in", *numbers), groups, numbers, ("operator", *numbers))


def _drifts(found: WizardStudy) -> Iterator[str]:
    if not found.drift:
        yield "No operator decided on a proposal."
    for each in found.drift:
        yield " ".join(_drift(each))


def _drift(each: Drift) -> Iterator[str]:
    if each.decision_ms is None or each.accepted_share is None:
        yield (
            f"{_person(each.operator)} decided in {count(each.sessions, 'session')}: too few for a "
            f"trend from session to session, which needs {FEWEST}."
        )
    else:
        time, share = each.decision_ms, each.accepted_share
        yield (
            f"{_person(each.operator)}, {count(each.sessions, 'session')}: the median time to "
            f"decide changed by {time.slope:+.0f} ms a session (95 % interval {time.low:+.0f} to "
            f"{time.high:+.0f}: {_said(time)}); the share accepted by {share.slope * 100:+.1f} "
            f"points (95 % interval {share.low * 100:+.1f} to {share.high * 100:+.1f}: "
            f"{_said(share)})."
        )
    if each.first_half_ms is not None and each.second_half_ms is not None:
        yield (
            f"Within a session: median {each.first_half_ms:.0f} ms in the first half of the "
            f"decisions, {each.second_half_ms:.0f} ms in the second."
        )


def _said(found: Trend) -> str:
    return "no change is shown" if found.low <= 0 <= found.high else "a change"


def _deviations(found: WizardStudy) -> str:
    if not found.counts:
        return "There was no deviation from the sessions' plans."
    return (
        f"Deviations from the sessions' plans: {deviation_counts(found.counts)}. `sar-tui report "
        "wizard SESSION` lists those of a session."
    )
