"""The view of the pairs task: a screen in two halves, each headed with its participant, turn and
score.
"""

from collections import Counter
from collections.abc import Sequence
from statistics import fmean

from sar_tui.api.view import (
    ATTEMPT_STARTED,
    PROMPT,
    TRIAL,
    WAITING,
    AttemptEnded,
    AttemptStarted,
    Language,
    Line,
    Metric,
    Prompt,
    Task,
    TaskView,
    TrialEnded,
    Waiting,
    halves,
    on,
    result_text,
)

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
        """Draw a name at the top of each half, its prompt below it, and the plain line at the
        bottom.
        """
        names = [self._name(seat, width) for seat in self.task.seats]
        return halves(
            prompt.halves if prompt else (), prompt.text if prompt else "", width, height, names
        )

    def _name(self, seat: str, width: int) -> str:
        """Return the heading of a half: the seat's place, with its participant's code if both
        fit.
        """
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
        """Return how often this seat was ahead, how often both were together, and the congruency
        effect.
        """
        trials = sum(a.trials for a in attempts)
        facts = []
        if won := _measured(attempts, "won"):
            facts.append(tr("Ahead in {won} of {trials}.", won=round(sum(won)), trials=trials))
        if both := _measured(attempts, "together"):
            facts.append(
                tr("Together in {count} of {trials}.", count=round(sum(both)), trials=trials)
            )
        if effects := _measured(attempts, "congruency_effect_ms"):
            effect = result_text(metric, fmean(effects), tr)
            slower = (
                "Reaction time when I looked to the other side, minus when I looked to "
                "yours: {effect}."
            )
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


def _measured(attempts: Sequence[AttemptEnded], name: str) -> list[float]:
    return [a.qualities[name] for a in attempts if name in a.qualities]
