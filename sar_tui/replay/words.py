"""The result of a replay in sentences."""

from collections.abc import Iterator
from typing import Any

from sar_tui.loop.replay_comparison import WORDING
from sar_tui.replay.fork import Forked
from sar_tui.replay.replay import FirstDifference, Replayed, Versions
from sar_tui.replay.rescore import Rescored

_LONGEST = 60
"""Longest value that is quoted, in characters."""


def sentences(replayed: Replayed) -> list[str]:
    """Return the sentences that tell the result of a replay: what came out, and what has changed
    since.
    """
    return [*_result(replayed), *_versions(replayed)]


def _result(replayed: Replayed) -> list[str]:
    name, count = replayed.session, replayed.events
    if difference := replayed.first_difference:
        return [
            f"Session {name} differs from its record after {_messages(count)}.",
            *_difference(difference),
        ]
    if not count:
        return [f"Session {name} has no messages: there is nothing to compare."]
    return [f"Session {name} is identical: {_messages(count)} came out as recorded."]


def _messages(count: int) -> str:
    return f"{count} message{'' if count == 1 else 's'}"


def _difference(difference: FirstDifference) -> list[str]:
    where = f"Message {difference.seq} ({difference.topic})"
    if difference.recorded is None:
        return [f"{where} follows from the inputs, but was not recorded."]
    if difference.derived is None:
        return [f"{where} was recorded, but does not follow from the inputs."]
    if difference.derived_topic != difference.topic:
        return [f"{where} was recorded; in its place follows {difference.derived_topic}."]
    return [
        f"{where}:",
        *(f"  {line}" for line in _changed(difference.recorded, difference.derived)),
    ]


def _changed(was: dict[str, Any], now: dict[str, Any], above: str = "") -> Iterator[str]:
    """Yield a line for each value that differs, also for those inside of values."""
    for name in (
        name for name in was | now if name not in WORDING and was.get(name) != now.get(name)
    ):
        match was.get(name), now.get(name):
            case dict() as inside, dict() as inside_now:
                yield from _changed(inside, inside_now, f"{above}{name}.")
            case old, new:
                yield f"{above}{name}: {_short(old)} recorded, {_short(new)} now"


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"


def _versions(replayed: Replayed) -> list[str]:
    now = replayed.replayed_with
    found = {run.run: _changes(run, now) for run in replayed.recorded_with}
    version = f"sar-tui {now.sar_tui}, {now.task} {now.task_version}, theme {now.theme}"
    if not any(found.values()):
        return [f"Recorded and replayed with {version}."]
    several = len(found) > 1
    return [
        f"Replayed with {version}.",
        *(
            f"Run {run}: {text}" if several else text
            for run, texts in found.items()
            for text in texts
        ),
    ]


def _changes(then: Versions, now: Versions) -> list[str]:
    """Return a sentence for each part that is another one now than in a run."""
    found = []
    if then.sar_tui != now.sar_tui:
        found.append(
            f"sar-tui was {then.sar_tui or 'of an unknown version'}, and is {now.sar_tui}."
        )
    if then.task_version != now.task_version:
        found.append(
            f"The task {now.task} was version {then.task_version}, and is version "
            f"{now.task_version}."
        )
    elif then.task_hash != now.task_hash:
        found.append(f"The files of the task {now.task} have changed.")
    if now.theme_hash is None:
        found.append(f"The theme {now.theme} is not installed.")
    elif then.theme != now.theme:
        found.append(f"The theme was {then.theme}, and not {now.theme}.")
    elif then.theme_hash != now.theme_hash:
        found.append(f"The files of the theme {now.theme} have changed.")
    return found


def rescored_sentences(rescored: Rescored) -> list[str]:
    """Return the sentences that tell how far a session could be scored by other parameters, and
    what that means.
    """
    settings = ", ".join(f"{name} = {value}" for name, value in rescored.what_if.items())
    changed = sum(one.recorded != one.rescored for one in rescored.attempts)
    found = [f"With {settings}. Attempts scored otherwise: {changed} of {len(rescored.attempts)}."]
    if rescored.ends_at_attempt is not None:
        found.append(
            f"It ends before attempt {rescored.ends_at_attempt}, which would have been another "
            "one: there is no record "
            "of what the participant would have done in it."
        )
    if rescored.other_feedback_from is not None:
        found.append(
            f"After attempt {rescored.other_feedback_from} the participant would have had other "
            "feedback: later "
            "responses might have been others."
        )
    return found


def forked_sentences(forked: Forked) -> tuple[str, list[str]]:
    """Return the heading of a fork, and sentences that tell what it is made of and what it leaves
    out.
    """
    settings = ", ".join(f"{name} = {value}" for name, value in forked.what_if.items())
    first = forked.record_ends_at_attempt
    fit = forked.model
    if first is None or fit is None:
        return "From the record alone", [
            f"With {settings} all prompts would have been those of the record."
        ]
    kept = (
        f"The record ends before attempt {first}. From there on"
        if first > 1
        else "From the first attempt on"
    )
    found = [
        f"With {settings}. {kept}, responses are drawn from a model of this participant, in "
        f"{forked.runs} runs.",
        f"The interval is the shortest that holds {forked.coverage:.0%} of the runs or more.",
        f"The model was fitted to {fit.responses} correct responses of {fit.attempts} attempts: "
        f"{fit.base_ms:.0f} ms and {fit.per_bit_ms:.0f} ms for each bit of choice, "
        f"{fit.per_attempt_ms:+.1f} ms from "
        f"attempt to attempt, scatter {fit.spread:.0%}, {fit.wrong:.1%} wrong, {fit.missed:.1%} "
        "missed.",
    ]
    if fit.fewest_choices == fit.most_choices:
        found.append(
            f"All responses were to one of {fit.most_choices} prompts: how other levels change "
            "them is an assumption."
        )
    else:
        found.append(
            f"They were to one of {fit.fewest_choices} to {fit.most_choices} prompts; beyond "
            "that, the model "
            "extrapolates."
        )
    found.append("How other feedback would have changed the participant is not in it.")
    return "Model, not data", found
