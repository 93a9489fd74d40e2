"""The view of the pairs task: a screen in two halves, each headed with its participant, turn and score."""

from collections import Counter
from collections.abc import Sequence
from statistics import fmean

from sar_tui.framework.language import Language
from sar_tui.framework.messages import AttemptEnded, AttemptStarted, Prompt, TrialEnded, Waiting
from sar_tui.framework.node import on
from sar_tui.framework.task import Task
from sar_tui.framework.topics import ATTEMPT_STARTED, PROMPT, TRIAL, WAITING
from sar_tui.framework.trial_types import Metric
from sar_tui.widgets.large_characters import draw
from sar_tui.widgets.prompt_lines import FIXATION, Line, centred
from sar_tui.widgets.task_view import TaskView

_WALL = "│"
_TURN_KNOWN = ("foreperiod", "storage", "response")
"""Waits during which the announced turn stays: nothing may change on the screen."""


class PairsView(TaskView):
    """Draws the prompt of each seat in its half."""

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self._turn = ""
        self._won: Counter[str] = Counter()

    @on(ATTEMPT_STARTED)
    def attempt_started(self, _: AttemptStarted) -> None:
        self._won.clear()

    @on(WAITING)
    def waiting(self, waiting: Waiting) -> None:
        if waiting.stage == "trial" and waiting.what not in _TURN_KNOWN:
            self._turn = waiting.seat

    @on(PROMPT)
    def prompted(self, prompt: Prompt) -> None:
        self._turn = prompt.seat

    @on(TRIAL)
    def trial_ended(self, trial: TrialEnded) -> None:
        self._won[trial.seat] += trial.details.get("won") is True

    def prompt_lines(self, prompt: Prompt | None, width: int, height: int) -> list[Line]:
        """Draw a name at the top of each half, its prompt below it, and the plain line at the bottom."""
        names = [self._name(seat, width) for seat in self.task.seats]
        return halves(names, prompt.halves if prompt else (), prompt.text if prompt else "", width, height)

    def _name(self, seat: str, width: int) -> str:
        """Return the heading of a half: the seat's place, with its participant's code if both fit."""
        place, name = self.task.seat_name(seat), self.task.display_name(seat)
        words = "{who}"
        if seat == self._turn:
            words = self.tr("[ {who}: your turn ]")
        elif self._won[seat]:
            words = self.tr("{who}, ahead: {count}")
        in_full = words.format(who=f"{place} · {name}", count=self._won[seat])
        if name != place and len(in_full) < width // 2:
            return in_full
        return words.format(who=name, count=self._won[seat])

    @classmethod
    def facts(cls, attempts: Sequence[AttemptEnded], metric: Metric, tr: Language) -> list[str]:
        """Return how often this seat was ahead, how often both were together, and the congruency effect."""
        trials = sum(a.trials for a in attempts)
        facts = []
        if won := _measured(attempts, "won"):
            facts.append(tr("Ahead in {won} of {trials}.", won=round(sum(won)), trials=trials))
        if both := _measured(attempts, "together"):
            facts.append(tr("Together in {count} of {trials}.", count=round(sum(both)), trials=trials))
        if effects := _measured(attempts, "congruency_effect_ms"):
            effect = metric.show(fmean(effects))
            slower = "Reaction time when I looked to the other side, minus when I looked to yours: {effect}."
            facts.append(tr(slower, effect=effect))
        return facts

    @classmethod
    def findings(cls, attempts: Sequence[AttemptEnded], metric: Metric) -> list[str]:
        """Return the same, with the congruency effect by its name."""
        facts = cls.facts(attempts, metric, Language())
        if effects := _measured(attempts, "congruency_effect_ms"):
            facts[-1] = (
                f"Congruency effect {metric.show(fmean(effects))}: incongruent minus congruent, "
                f"mean of {len(effects)} attempts."
            )
        return facts


def halves(names: Sequence[str], glyphs: Sequence[str], text: str, width: int, height: int) -> list[Line]:
    """Draw two halves with a wall between them; without glyphs, the fixation point is on the wall."""
    half = max(0, (width - 1) // 2)
    room = max(1, height - 4)
    bodies = [draw(glyph, max(1, half - 2), room) if glyph else () for glyph in glyphs or ("", "")]
    body = []
    for row in range(room):
        left, right = (_row(lines, row, room) for lines in bodies)
        wall = FIXATION if row == room // 2 and not glyphs else _WALL
        body.append((_beside(left, wall, right, half), True))
    named = (_beside(names[0], _WALL, names[1], half), True)
    return [named, (_beside("", _WALL, "", half), False), *body, ("", False), (centred(text, width), True)]


def _row(lines: Sequence[str], row: int, room: int) -> str:
    """Return the text in a row if ``lines`` are in the middle of ``room`` rows."""
    at = row - (room - len(lines)) // 2
    return lines[at] if 0 <= at < len(lines) else ""


def _beside(left: str, wall: str, right: str, half: int) -> str:
    """Put two texts beside each other, each in the middle of its half."""
    return f"{centred(left[:half], half):<{half}}{wall}{centred(right[:half], half)}"


def _measured(attempts: Sequence[AttemptEnded], name: str) -> list[float]:
    return [a.qualities[name] for a in attempts if name in a.qualities]
