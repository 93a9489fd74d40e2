"""Scanning: a mark moves through the choices of a screen, and one switch takes the marked one.

With two switches, one moves the mark and the other takes. A choice with a question is taken after a
second choice, Yes or No. The mark goes round until something is taken: no time limit loses anything
(WCAG 2.2.1).
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

from sar_tui.model.step import Entry
from sar_tui.model.units import MS
from sar_tui.rules.keys import GuardedPress, KeyGuard

SHARE = 0.65
"""Press time as a share of the scan interval that suits it: about the mean and two standard
deviations (Simpson, Koester & LoPresti 2007, the ".65 rule", Assist Technol,
doi:10.1080/10400435.2007.10131865).
"""
FIRST_MS = 1500
"""Scan interval before enough presses are known."""
FASTEST_MS, SLOWEST_MS = 500, 10_000
LEAST, MOST = 3, 10
"""Presses that are needed, and the last ones that are averaged."""
ANTICIPATED = 150 * MS
"""Nobody sees the mark move and presses within this time: such a press is meant for the choice
before.
"""
SWITCHES = ("space", "enter")
"""Keys of a switch. With two switches the first moves, and the second takes."""


def interval_ms(press_times_ms: Sequence[float], fixed_ms: int = 0) -> int:
    """Return the scan interval: as it is set, else as it follows from press times.

    Args:
        press_times_ms: from the mark's move to the press, of a person, in order.
        fixed_ms: the interval that is set; 0 if it follows the person.
    """
    if fixed_ms:
        return fixed_ms
    if len(press_times_ms) < LEAST:
        return FIRST_MS
    last = press_times_ms[-MOST:]
    suited = sum(last) / len(last) / SHARE
    return round(min(max(suited, FASTEST_MS), SLOWEST_MS))


class Choice(NamedTuple):
    """A choice of a screen.

    Attributes:
        label: its words.
        keys: keys that take it on this screen.
        question: asked before it is taken; empty to take it at once.
        entry: what is drawn while it is marked, if it is an answer.
        rounds: number of intervals for which it is marked.
    """

    label: str
    keys: tuple[str, ...]
    question: str = ""
    entry: Entry | None = None
    rounds: int = 1


Outcome = Literal["taken", "asked", "moved", "held", "early"]
"""Effect of a press. ``asked``: it leads to Yes and No. ``held``: it repeats or bounces. ``early``:
what is on the screen was not read yet.
"""


class Pressed(NamedTuple):
    """A press of a switch.

    Attributes:
        outcome: its effect.
        choice: the words that it is meant for.
        keys: those of the choice that is taken; none after No.
        press_ms: from the mark's move; None if it tells nothing about the person.
        place: of the choice.
    """

    outcome: Outcome
    choice: str
    keys: tuple[str, ...] = ()
    press_ms: float | None = None
    place: int = 0


class Scan:
    """The mark on one screen after the other. All times are stamps of one clock, in ns.

    Args:
        switches: 1 or 2.
        fixed_ms: the interval that is set; 0 if it follows the person.
        bounce: as of `rules.keys.HeldKey`.
        answers: the words for Yes and No.
        press_times_ms: of the person, from earlier sessions.

    Attributes:
        choices: of the screen.
        asked: the choice that is to be confirmed; None if there is none.
        at: place of the marked one; during a question, 0 for Yes and 1 for No.
        due: when the mark moves; None if it stays.
    """

    def __init__(
        self,
        switches: Literal[1, 2],
        fixed_ms: int = 0,
        bounce: int = 0,
        answers: tuple[str, str] = ("Yes", "No"),
        press_times_ms: Sequence[float] = (),
    ) -> None:
        self._has_two = switches == 2
        self._fixed_ms = fixed_ms
        self._guard = KeyGuard(bounce)
        self.answers = answers
        self.choices: tuple[Choice, ...] = ()
        self.asked: Choice | None = None
        self.at = 0
        self.due: int | None = None
        self._moved = 0
        self._moves = 0
        self._times = list(press_times_ms)

    @property
    def interval_ms(self) -> int:
        """The interval in use."""
        return interval_ms(self._times, self._fixed_ms)

    @property
    def labels(self) -> tuple[str, ...]:
        """The words to choose from now."""
        return self.answers if self.asked else tuple(choice.label for choice in self.choices)

    @property
    def marked(self) -> Choice | None:
        """The choice that is marked, or asked about; None if there is none."""
        return self.asked or (self.choices[self.at] if self.choices else None)

    def show(self, choices: Sequence[Choice], at: int) -> None:
        """Note that these choices are on the screen now. Those with the same words are nothing
        new.
        """
        before, self.choices = self.choices, tuple(choices)
        if [choice.label for choice in before] != [choice.label for choice in choices]:
            self.asked = None
            self._appear(at)

    def _appear(self, at: int) -> None:
        self._guard.appeared(at)
        self._mark(0, at)
        self._moves = 0
        if self.due is not None:
            self.due += self.interval_ms * MS  # time to read

    def _mark(self, place: int, at: int) -> None:
        self.at, self._moved = place, at
        moves = len(self.labels) > 1 and not self._has_two
        self.due = at + self._rounds * self.interval_ms * MS if moves else None

    @property
    def _rounds(self) -> int:
        """Intervals for which the present mark stays."""
        return 1 if self.asked or not self.choices else self.choices[self.at].rounds

    def move(self, at: int) -> None:
        """Mark the next choice; after the last one, the first."""
        self._moves += 1
        self._mark((self.at + 1) % len(self.labels), at)

    def note(self, key: str, at: int) -> GuardedPress:
        """Note a press, also one that takes no choice, so that its repeats take none."""
        return self._guard.press(key if self._has_two else "switch", at)

    def press(self, key: str, at: int) -> Pressed:
        """Take a press of a switch, while there are choices."""
        guarded = self.note(key, at)
        is_mover = self._has_two and key == SWITCHES[0] and len(self.labels) > 1
        is_quiet = guarded.after_quiet or self._has_two
        if not guarded.is_new:
            return Pressed("held", self.labels[self.at])
        if not (guarded.counts and is_quiet):
            return Pressed("early", self.labels[self.at])
        if is_mover:
            self.move(at)
            return Pressed("moved", self.labels[self.at])
        return self._take(at)

    def _take(self, at: int) -> Pressed:
        since, press_ms = at - self._moved, None
        if self._moves and not self._has_two:
            if since < ANTICIPATED:
                self.at = (self.at - 1) % len(self.labels)
                since += self.interval_ms * MS
            if self._rounds == 1:  # else there is no hurry to press
                press_ms = since / MS
                self._times.append(press_ms)
        label, place, asked = self.labels[self.at], self.at, self.asked
        if asked:
            is_yes = self.at == 0
            self.asked = None
            self._appear(at)
            return Pressed("taken", label, asked.keys if is_yes else (), press_ms, place)
        choice = self.choices[self.at]
        if choice.question:
            self.asked = choice
            self._appear(at)
            return Pressed("asked", label, (), press_ms, place)
        self._appear(at)
        return Pressed("taken", label, choice.keys, press_ms, place)
