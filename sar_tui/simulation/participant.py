"""A simulated participant: an output that sees prompts and an input that presses keys, on the bus like any other."""

from sar_tui.framework.chance import Chance
from sar_tui.framework.clock import MS, Handle
from sar_tui.framework.messages import Action, KeyPressed, OutputReport, Prompt, Shown, Waiting
from sar_tui.framework.node import Node, on
from sar_tui.framework.task import Stimulus, Task
from sar_tui.framework.topics import ACTION, KEY, PROMPT, REPORT, SHOWN, WAITING
from sar_tui.simulation.person import Person

SHOWING = 4 * MS
"""From a prompt's publication to its being seen."""
READING = 1200 * MS
"""From a screen that waits for Enter to the Enter."""


class SimulatedParticipant(Node):
    """Sits down, presses Enter when asked to, and answers each prompt as its person would."""

    name = "participant"
    emits = (KEY, SHOWN, REPORT)

    def __init__(self, person: Person, task: Task, seed: int) -> None:
        super().__init__()
        self._person = person
        self._task = task
        self._seed = seed
        self._enter: Handle | None = None

    @on(WAITING)
    def waiting(self, waiting: Waiting) -> None:
        """Press Enter for the screen that is up, not for one that has gone."""
        if self._enter:
            self._enter.cancel()
        self._enter = self._press("enter", self.now + READING) if waiting.what == "enter" else None

    @on(PROMPT)
    def prompted(self, prompt: Prompt) -> None:
        onset = self.now + SHOWING
        shown = Shown(
            attempt=prompt.attempt,
            trial=prompt.trial,
            presentation=prompt.presentation,
            at=onset,
            source="virtual",
        )
        self.bus.clock.call_at(onset, lambda: self.emit(SHOWN, shown))
        for delay_ms, key in self._answer(prompt):
            self._press(key, onset + round(delay_ms * MS))

    def _answer(self, prompt: Prompt) -> list[tuple[float, str]]:
        chance = Chance(self._seed, "person", prompt.attempt, prompt.trial)
        if self._person.misses_it(chance):
            return []
        stimulus = Stimulus(prompt.stimulus, prompt.expected, prompt.text, choices=prompt.choices)
        reaction = self._person.reaction_ms(prompt.choices, prompt.attempt, chance)
        return self._task.rehearse(stimulus, reaction, self._person.slips(chance), chance)

    @on(ACTION)
    def answered(self, action: Action) -> None:
        """Words appear at once."""
        for state in ("started", "done"):
            self.emit(REPORT, OutputReport(action=action.id, output="screen", state=state, at=self.now))

    def _press(self, key: str, at: int) -> Handle:
        return self.bus.clock.call_at(at, lambda: self.emit(KEY, KeyPressed(key=key, at=at)))
