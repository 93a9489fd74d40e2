"""Explanations of the figures of progress: declared once, for the screen, the page and the
documentation (`docs/progress.md`).
"""

import msgspec

from sar_tui.model.language import Language


class Entry(msgspec.Struct, frozen=True):
    """The explanation of a figure.

    Args:
        title: its name.
        what: says what it is, and what it does not say.
        how: says how it is computed.
        source: the paper, or the page of the documentation.
    """

    title: str
    what: str
    how: str
    source: str


GLOSSARY: dict[str, Entry] = {
    "verdict": Entry(
        "Verdict",
        "The last session with a known value, set against the baseline: sessions 2, 3 and 4. "
        "Steady does not mean that there is no change: of people who become 20 % faster, about "
        "one in three is not found.",
        "Improving: the gain is larger than the MDC95 and the rise within the baseline together. "
        "Behind: the loss is larger than the MDC95. If nothing but practice happens, at most 5 of "
        "100 last sessions are called a change.",
        "docs/progress.md#one-verdict",
    ),
    "level": Entry(
        "Level at goal",
        "The level at which this person would just reach the goal. The task gets harder when it "
        "goes well, so progress shows here, and not in the result.",
        "Results grow in a straight line with the difficulty of the level, as reaction times do "
        "with the information in a choice. The estimate is where the line of a session crosses "
        "the goal.",
        "Hick 1952, doi:10.1080/17470215208416600; docs/progress.md#the-level-at-goal",
    ),
    "band": Entry(
        "95 % range",
        "How well the level at goal of a session is known. In simulated sessions, 95 of 100 ranges "
        "hold the true place.",
        "From the scatter of the attempts about the line of the session, by the theorem of Fieller.",
        "Fieller 1954, J R Stat Soc B 16:175-185; docs/validation.md",
    ),
    "noise": Entry(
        "Noise and practice",
        "The shaded area, between thin lines where colours are missing: sessions inside it do not "
        "differ from the baseline by more than noise and practice. Its size is the MDC95, the "
        "smallest change between two sessions that is more than noise.",
        "The mean of sessions 2, 3 and 4, and to either side t · √2 · SD of these sessions (t of "
        "Student: 4.30). Upwards, their rise is added, as practice may bring as much again.",
        "Weir 2005, doi:10.1519/15184.1; docs/progress.md#noise-and-change",
    ),
    "practice": Entry(
        "Practice",
        "The gain from the first session to the next three. It comes with repeating any test, and "
        "is no recovery.",
        "The mean of sessions 2, 3 and 4 minus the first session.",
        "Scharfen 2018, doi:10.3390/jintelligence6010006; docs/progress.md#practice-is-not-recovery",
    ),
    "result": Entry(
        "Mean result",
        "The mean result of a session, and the SD between its attempts. It stays near the goal "
        "while the person improves, as the level follows. Better is always up.",
        "The result of an attempt is what the task measures, such as the mean reaction time of "
        "its right responses. Practice attempts are left out.",
        "docs/task-reference.md#metric",
    ),
    "correct": Entry(
        "Correct",
        "The share of right responses in a session.",
        "Right responses of all prompts or reaches, without practice attempts.",
        "docs/data-dictionary.md",
    ),
    "quality": Entry(
        "Measures of how it was done",
        "Such as smoothness, where the task measures them. Values of different sensors or "
        "detectors cannot be compared.",
        "The mean of the attempts of a session.",
        "Balasubramanian 2015, doi:10.1186/s12984-015-0090-9 (SPARC); docs/movement-measures.md",
    ),
    "goals": Entry(
        "Goals",
        "The attempts that reached their goal, of those that were done. The difficulty follows "
        "the person, so it says little of progress.",
        "An attempt reaches its goal if its result is better than the goal, and enough of its "
        "responses were right.",
        "docs/choose-difficulty.md",
    ),
    "dose": Entry(
        "Minutes",
        "The dose: time on task in each session. Bars begin at 0.",
        "From the beginning to the end of each attempt, without the rests between them.",
        "docs/progress.md#dose",
    ),
    "pain": Entry(
        "Pain",
        "The worst pain that the person told of, from 0 (no pain) to 10; · if nothing is known.",
        "The highest rating before, in a pause and after. Pain that was told in a pause without "
        "a number counts as 1.",
        "docs/pain-and-tiredness.md",
    ),
    "tired": Entry(
        "Tiredness",
        "The greatest tiredness that the person told of, from 0 to 10; · if nothing is known.",
        "The higher of the ratings before and after. It is no score of a fatigue scale.",
        "docs/pain-and-tiredness.md",
    ),
    "look": Entry(
        "Needs a look",
        "A session with pain above the limits, or one in which an adverse event began, or after "
        "which it began.",
        "Pain is above the limits if it is more than the pain limit, or if it rose by the pain "
        "rise or more. Both are settings of the person; no numeric rule to stop is known for "
        "stroke.",
        "docs/pain-and-tiredness.md#limits-of-pain",
    ),
    "sessions": Entry(
        "Sessions",
        "The sessions with the same settings. ± is the SD between the attempts of a session.",
        "Sessions are in one list only if they measured the same: task, version, goal, own "
        "settings of the task, and timing.",
        "docs/progress.md#what-is-compared",
    ),
    "days": Entry(
        "Days",
        "What was done of what was planned on each day with live sessions, in all charts of this "
        "task.",
        "Planned are the attempts that the programme plans for a day, otherwise those of the "
        "sessions begun. Repetitions are prompts or reaches.",
        "docs/progress.md#dose",
    ),
    "records": Entry(
        "Records",
        "Adverse events, scores of other tests, and what else was entered by hand.",
        "The change from the first to the last score is set beside published changes: a "
        "detectable one must be exceeded, an important one reached. Judge whether this person is "
        "like the people of the study.",
        "docs/progress.md#other-instruments",
    ),
}
"""Explanations by the names of the figures, in the order in which they are read."""


def explained(name: str, tr: Language) -> list[str]:
    """Return the explanation of a figure in a language: what it is, how it is computed, and its
    source.
    """
    entry = GLOSSARY[name]
    return [
        tr(entry.what),
        f"{tr('How it is computed')}: {tr(entry.how)}",
        f"{tr('Source')}: {entry.source}",
    ]
